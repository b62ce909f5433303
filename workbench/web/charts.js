// SPDX-License-Identifier: Apache-2.0
// From a description of a plot to a uPlot chart, on the screen or on paper.
//
// A plot: {kind: 'line' | 'xy', height, paperHeight, x: {label, log}, y: [{label, log, side}], data, series: [...],
//          levels: [...], hideX, gutter}. All numbers are in display units, all labels carry their unit.
// A series: {name, role, width, dash, marks, axis, alpha, band}; for 'line' its values are data[i + 1], for 'xy' data[i + 1] is
// [xs, ys]. A band is a series of which `band` is the index of its lower edge. A level is a horizontal line.

// Line style by role: colour from the style sheet, and a dash or marker for readers who cannot distinguish colours.
const kStyles = {
  measured: {width: 2.25},
  before: {width: 1.25},
  after: {width: 1.5, dash: [7, 3]},
  forward: {width: 1.25, marks: 'filled'},
  backward: {width: 1.25, dash: [2, 3], marks: 'hollow'},
  floor: {width: 1.25, dash: [4, 3]},
  motion: {width: 1.25},
  velocity: {width: 1.25, dash: [5, 3], colour: 'forward'},
  reference: {width: 1.5, dash: [7, 3], colour: 'measured'},
};

// The curves of an experiment: eight colours that go on from the palette.
for (let i = 1; i <= 8; ++i) kStyles['curve' + i] = {width: 1.5};

const styleOf = (series) => ({...kStyles[series.role], ...series.style});
const colourOf = (series, theme) => theme[kStyles[series.role].colour ?? series.role];

// Colours as they are computed for `element`, so that one chart can follow the screen and another the paper.
function readTheme(element, into = {}) {
  const style = getComputedStyle(element);
  for (const name of ['page', 'ink', 'soft', 'rule', 'hair', 'measured', 'before', 'after', 'forward', 'backward', 'floor', 'motion',
                      'curve1', 'curve2', 'curve3', 'curve4', 'curve5', 'curve6', 'curve7', 'curve8']) {
    into[name] = style.getPropertyValue('--' + name).trim();
  }
  into.font = style.fontFamily || 'sans-serif';
  return into;
}

// A path through x-y points in the order they were recorded; uPlot's own paths need x rising.
function orbit(u, index) {
  const [xs, ys] = u.data[index];
  const stroke = new Path2D();
  const {min: x0, max: x1} = u.scales.x;
  const {min: y0, max: y1} = u.scales.y;
  const {left, top, width, height} = u.bbox;
  let penDown = false;
  for (let i = 0; i < xs.length; ++i) {
    if (xs[i] === null || ys[i] === null) {
      penDown = false;
      continue;
    }
    const px = left + (xs[i] - x0) / (x1 - x0) * width;
    const py = top + (y1 - ys[i]) / (y1 - y0) * height;
    if (penDown) stroke.lineTo(px, py); else stroke.moveTo(px, py);
    penDown = true;
  }
  return {stroke, fill: null, clip: null, band: null, gaps: null, flags: 0};
}

const everyNth = (count) => (u, index, show) => {
  if (!show) return null;
  const [from, to] = u.series[0].idxs;
  const step = Math.max(1, Math.round((to - from) / count));
  const chosen = [];
  for (let i = from - from % step; i <= to; i += step) if (i >= from && u.data[index][i] !== null) chosen.push(i);
  return chosen;
};

function uplotSeries(plot, series, theme, ratio) {
  if (series.edge) return {scale: 'y', show: true, width: 0, stroke: 'transparent', points: {show: false}};
  const style = styleOf(series);
  const out = {
    label: series.name, width: style.width, alpha: style.alpha ?? 1,
    dash: style.dash?.map((length) => length * ratio),  // uPlot scales widths by itself, dashes it does not
    stroke: () => colourOf(series, theme), points: {show: false},
  };
  if (plot.kind === 'xy') {
    return {...out, facets: [{scale: 'x', auto: false}, {scale: 'y', auto: false}], paths: orbit};
  }
  out.scale = series.axis ?? 'y';
  if (style.marks) {
    out.points = {show: true, size: 5, width: 1.25, filter: everyNth(18), stroke: () => colourOf(series, theme),
                  fill: () => (style.marks === 'filled' ? colourOf(series, theme) : theme.page)};
  }
  return out;
}

function paddedRange(min, max) {
  if (min === null || max === null) return [0, 1];
  if (min === max) return [min - (Math.abs(min) || 1) * 0.5, max + (Math.abs(max) || 1) * 0.5];
  const pad = 0.05 * (max - min);
  return [min - pad, max + pad];
}

function extent(arrays) {
  let low = Infinity;
  let high = -Infinity;
  for (const array of arrays) {
    for (const value of array) {
      if (value === null) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return low <= high ? [low, high] : [null, null];
}

function uplotScales(plot) {
  if (plot.kind === 'xy') {
    const keep = (u, min, max) => [min, max];
    const [x0, x1] = paddedRange(...extent(plot.data.slice(1).map((pair) => pair[0])));
    const [y0, y1] = paddedRange(...extent(plot.data.slice(1).map((pair) => pair[1])));
    return {x: {time: false, auto: false, range: keep, min: x0, max: x1}, y: {auto: false, range: keep, min: y0, max: y1}};
  }
  const scales = {x: {time: false, distr: plot.x.log ? 3 : 1, range: (u, min, max) => (min === max ? paddedRange(min, max) : [min, max])}};
  for (const [i, axis] of plot.y.entries()) {
    scales[i === 0 ? 'y' : 'y' + (i + 1)] = axis.log ? {distr: 3} : {range: (u, min, max) => paddedRange(min, max)};
  }
  return scales;
}

// Ticks of a logarithmic axis. uPlot's own do not end when the axis begins off the ticks, as after a zoom.
function logSplits(u, index, min, max) {
  const splits = [];
  for (let power = Math.floor(Math.log10(min)); power <= Math.ceil(Math.log10(max)); ++power) {
    for (let digit = 1; digit < 10; ++digit) {
      const value = Number(`${digit}e${power}`);
      if (value >= min && value <= max) splits.push(value);
    }
  }
  if (splits.length > 1) return splits;
  const step = (max - min) / 4;
  return [min, min + step, min + 2 * step, min + 3 * step, max].map((value) => Number(value.toPrecision(3)));
}

const decades = (u, splits) => splits.map((value) => (Math.abs(Math.log10(value) % 1) < 1e-9 ? value : null));

function uplotAxes(plot, theme) {
  const font = '11px ' + theme.font;
  const common = (axis) => ({
    label: axis.label, font, labelFont: font, stroke: () => theme.soft, labelGap: 0, labelSize: 17, gap: 3,
    ...(axis.log ? {splits: logSplits} : {}),
    grid: {stroke: () => theme.hair, width: 1, ...(axis.log ? {filter: decades} : {})}, ticks: {stroke: () => theme.rule, width: 1, size: 4},
    border: {show: true, stroke: () => theme.rule, width: 1},
    values: axis.log ? (u, splits) => splits.map(logTickText)
                     : (u, splits, index, space, increment) => splits.map((value) => tickText(value, increment)),
  });
  const widest = (u, values) => plot.gutter ?? Math.max(30, 12 + 6.3 * Math.max(1, ...(values ?? []).map((text) => text.length)));
  const x = {...common(plot.x), scale: 'x', size: 24, space: 55};
  if (plot.hideX) Object.assign(x, {label: undefined, labelSize: 0, size: 6, values: (u, splits) => splits.map(() => '')});
  return [x, ...plot.y.map((axis, i) => ({
    ...common(axis), scale: i === 0 ? 'y' : 'y' + (i + 1), side: axis.side ?? 3, size: widest, space: (u, index, min, max, length) => (length < 110 ? 18 : 28),
    ...(i === 0 ? {} : {grid: {show: false}}),
  }))];
}

// Horizontal lines (the noise floor), and the frame that closes the plot.
function drawLevels(plot, theme, ratio) {
  return (u) => {
    const {ctx, bbox} = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const level of plot.levels ?? []) {
      const style = styleOf(level);
      ctx.strokeStyle = colourOf(level, theme);
      ctx.lineWidth = style.width * ratio;
      ctx.setLineDash((style.dash ?? []).map((length) => length * ratio));
      for (const value of level.values) {
        const y = Math.round(u.valToPos(value, 'y', true));
        ctx.beginPath();
        ctx.moveTo(bbox.left, y);
        ctx.lineTo(bbox.left + bbox.width, y);
        ctx.stroke();
      }
    }
    ctx.restore();
  };
}

function describe(plot) {
  const names = [...new Set(plot.series.filter((series) => !series.edge).map((series) => series.name))].join(', ');
  return `${plot.y.map((axis) => axis.label).join(' and ')} over ${plot.x.label}: ${names}`;
}

// Draws `plot` into `host`. `options`: {width, height, theme, ratio, shown: [bool], interact: {sync, onReady, onScale, onCursor, onReset}}.
function drawPlot(Uplot, host, plot, options) {
  const {theme, ratio, interact} = options;
  const first = plot.kind === 'xy' ? null : {};
  const bands = [];
  plot.series.forEach((series, i) => {
    if (series.band !== undefined) {
      bands.push({series: [i + 1, series.band + 1], fill: () => colourOf(series, theme) + '26'});
    }
  });
  const opts = {
    mode: plot.kind === 'xy' ? 2 : 1, width: options.width, height: options.height, pxAlign: 0,
    padding: [6, plot.right ?? 16, 0, 0], legend: {show: false}, scales: uplotScales(plot), axes: uplotAxes(plot, theme),
    series: [first, ...plot.series.map((series, i) => ({...uplotSeries(plot, series, theme, ratio), show: options.shown?.[i] ?? true}))],
    bands, hooks: {draw: [drawLevels(plot, theme, ratio)]},
    cursor: interact ? {
      drag: plot.kind === 'xy' ? {x: true, y: true, uni: 16, setScale: true} : {x: true, y: false, setScale: true},
      dataIdx: plot.kind === 'xy' ? () => null : undefined, points: {show: plot.kind !== 'xy', size: 5}, y: plot.kind === 'xy',
      sync: interact.sync ? {key: interact.sync.key, setSeries: false, scales: ['x', null]} : undefined,
      bind: {dblclick: () => () => { interact.onReset(); return null; }},
    } : {show: false},
  };
  if (opts.cursor.dataIdx === undefined) delete opts.cursor.dataIdx;
  if (opts.cursor.sync === undefined) delete opts.cursor.sync;
  if (interact) {
    opts.hooks.ready = [(u) => interact.onReady(u)];
    opts.hooks.setScale = [(u, key) => interact.onScale(u, key)];
    opts.hooks.setCursor = [(u) => interact.onCursor(u)];
  }
  const u = new Uplot(opts, plot.data, host);
  const canvas = host.querySelector('canvas');
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', describe(plot));
  return u;
}
