// SPDX-License-Identifier: Apache-2.0
// The linked charts: force, residual and position over time; the residual against what it may depend on; loops; spectrum.
// A brush in one shows the same samples in all.
import {bytes} from '/api.js';
import {Chart, colour, padded} from '/chart.js';
import {byId, h, quantity} from '/dom.js';
import {on, store, tell} from '/store.js';

const kRawBelow = 6000;   // rows in view below which the samples themselves are drawn too
const kScatter = 9000;    // points of a cloud at most; more only hide each other
let time = {};
let against = [];
let loops = [];
let spectrum = null;
let raw = null;           // recorded force as it was sampled: {time: [low...], picture}

const unitFor = (unit, ...arrays) => displayUnit(unit, magnitudeOf(...arrays));

function magnitudeOf(...arrays) {
  let largest = 0;
  for (const array of arrays) {
    if (!array) continue;
    for (const value of array) if (value !== null && Math.abs(value) > largest) largest = Math.abs(value);
  }
  return largest;
}

// Not a number becomes a gap; so does the step from one part of an excerpt to the next.
function plotted(values, factor, starts) {
  const out = new Array(values.length);
  for (let i = 0; i < values.length; ++i) out[i] = Number.isNaN(values[i]) ? null : values[i] * factor;
  for (const start of starts.slice(1)) if (start > 0 && start < out.length) out[start - 1] = null;
  return out;
}

const empty = (count) => new Array(count).fill(null);
const forceWord = () => (report.units ? 'Torque' : 'Force');

// --- over time ---

function timeSpecs() {
  const {rows, current, beside, bent} = store;
  const seconds = {name: 'Time', label: 'Time (s)', unit: 's'};
  const starts = rows.header.starts;
  const ts = Array.from(rows.time_s);
  const force = unitFor('N', rows.measured_N);
  const after = bent?.residual_N ?? current?.residual_N;
  const left = unitFor('N', after ?? [], beside?.residual_N ?? []);
  const length = unitFor('m', rows.position_m);
  const y = (unit, word) => ({name: word, label: `${word} (${unit.label})`, unit: unit.label, perSi: unit.perSi});
  const forceSeries = [{name: 'measured', role: 'measured', width: 2, values: rows.measured_N}];
  const residualSeries = [];
  if (beside) {
    forceSeries.push({name: 'modelled before', role: 'before', values: beside.model_N});
    residualSeries.push({name: 'before', role: 'before', values: beside.residual_N});
  }
  if (current) {
    const model = bent ? current.measured_N.map((value, i) => value - bent.residual_N[i]) : current.model_N;
    forceSeries.push({name: bent ? 'set by hand' : 'modelled', role: 'after', dash: [7, 3], values: model});
    residualSeries.push({name: bent ? 'set by hand' : beside ? 'now' : 'measured − modelled', role: 'after', values: after});
  }
  const spec = (title, height, unit, word, series) => ({
    title, height, x: seconds, y: y(unit, word), series: series.map(({values, ...rest}) => rest),
    data: [ts, ...series.map(({values}) => plotted(values, unit.perSi, starts))]});
  const specs = {force: spec(`${forceWord()} over time`, 230, force, forceWord(), forceSeries),
                 position: spec('Position over time', 130, length, 'Position', [{name: 'position', role: 'motion', values: rows.position_m}])};
  if (residualSeries.length) specs.residual = spec('Residual over time', 190, left, 'Residual', residualSeries);
  return specs;
}

function drawSelected(series) {
  return (u) => {
    if (!store.selected || u.series.length <= series) return;
    const {ctx, bbox} = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.fillStyle = colour('curve5');
    const xs = u.data[0];
    const ys = u.data[series];
    const size = 3 * devicePixelRatio;
    const {min, max} = u.scales.x;
    for (let i = 0; i < xs.length; ++i) {
      if (!store.selected[i] || ys[i] === null || xs[i] < min || xs[i] > max) continue;
      ctx.fillRect(u.valToPos(xs[i], 'x', true) - size / 2, u.valToPos(ys[i], 'y', true) - size / 2, size, size);
    }
    ctx.restore();
  };
}

function drawCursors(u) {
  const {ctx, bbox} = u;
  ctx.save();
  ctx.font = `${11 * devicePixelRatio}px sans-serif`;
  store.cursors.forEach((at, i) => {
    if (at < u.scales.x.min || at > u.scales.x.max) return;
    const x = u.valToPos(at, 'x', true);
    ctx.strokeStyle = ctx.fillStyle = colour('ink');
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash(i === 0 ? [] : [4 * devicePixelRatio, 3 * devicePixelRatio]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.fillText('AB'[i], x + 3 * devicePixelRatio, bbox.top + 11 * devicePixelRatio);
  });
  ctx.restore();
}

// The force as it was recorded: single samples as a line, else the extremes of each point as a band.
function drawRaw(u) {
  if (!raw || !time.force) return;
  const {ctx, bbox} = u;
  const {perSi} = time.force.spec.y;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.beginPath();
  const {low, high, header} = raw;
  const px = (i) => u.valToPos(raw.offset + header.first_s + (i + (header.samples_per_point > 1 ? 0.5 : 0)) * header.step_s, 'x', true);
  if (header.samples_per_point === 1) {
    for (let i = 0; i < low.length; ++i) ctx[i ? 'lineTo' : 'moveTo'](px(i), u.valToPos(low[i] * perSi, 'y', true));
    ctx.strokeStyle = colour('curve8');
    ctx.globalAlpha = 0.7;
    ctx.lineWidth = devicePixelRatio;
    ctx.stroke();
  } else {
    for (let i = 0; i < low.length; ++i) ctx[i ? 'lineTo' : 'moveTo'](px(i), u.valToPos(high[i] * perSi, 'y', true));
    for (let i = low.length - 1; i >= 0; --i) ctx.lineTo(px(i), u.valToPos(low[i] * perSi, 'y', true));
    ctx.fillStyle = colour('curve8');
    ctx.globalAlpha = 0.25;
    ctx.fill();
  }
  ctx.restore();
}

function drawFloor(u) {
  const floor = store.state?.versions.find((version) => version.id === store.state.current)?.floor_N;
  if (!floor || !time.residual) return;
  const {ctx, bbox} = u;
  ctx.save();
  ctx.strokeStyle = colour('floor');
  ctx.setLineDash([4 * devicePixelRatio, 3 * devicePixelRatio]);
  ctx.lineWidth = devicePixelRatio;
  for (const sign of [-1, 1]) {
    const y = u.valToPos(sign * floor * time.residual.spec.y.perSi, 'y', true);
    if (y < bbox.top || y > bbox.top + bbox.height) continue;
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
  }
  ctx.restore();
}

function setRange(low, high) {
  store.range = {min: low, max: high};
  for (const chart of Object.values(time)) chart.u.setScale('x', {min: low, max: high});
  fetchRaw();
  tell('range');
}

let fetching = null;

async function fetchRaw() {
  fetching?.abort();
  fetching = new AbortController();
  const {signal} = fetching;
  const logs = store.rows?.header.logs ?? [{start_s: 0, duration_s: store.state.logs[0].duration_s}];
  const {min, max} = store.range;
  const index = Math.max(0, logs.findIndex((log) => min < log.start_s + log.duration_s));
  const offset = logs[index].start_s;
  try {
    performance.mark('zoom-begin');
    const picture = await bytes('picture', {log: index, signal: 'force', from: min - offset, to: max - offset,
                                           points: Math.round(2 * (time.force?.u.width ?? 800))}, signal);
    picture.offset = offset;
    raw = picture;
    time.force?.redraw();
    performance.mark('zoom-end');
    performance.measure('zoom', 'zoom-begin', 'zoom-end');
  } catch (error) {
    if (error.name !== 'AbortError') raw = null;
  }
}

function brushTime(low, high) {
  const {time_s: ts} = store.rows;
  const mask = new Uint8Array(ts.length);
  for (let i = 0; i < ts.length; ++i) mask[i] = ts[i] >= low && ts[i] <= high ? 1 : 0;
  select(mask);
}

export function select(mask) {
  store.selected = mask && mask.some((one) => one) ? mask : null;
  for (const chart of [...Object.values(time), ...against, ...loops]) chart.redraw();
  tell('selected');
}

function placeCursor(at) {
  store.cursors = store.cursors.length >= 2 ? [at] : [...store.cursors, at];
  for (const chart of Object.values(time)) chart.redraw();
  showCursors();
}

export function clearCursors() {
  store.cursors = [];
  for (const chart of Object.values(time)) chart.redraw();
  showCursors();
}

function nearestRow(at) {
  const {time_s: ts} = store.rows;
  let low = 0;
  let high = ts.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (ts[middle] > at) high = middle; else low = middle;
  }
  return at - ts[low] < ts[high] - at ? low : high;
}

function showCursors() {
  const host = byId('cursors');
  host.hidden = store.cursors.length === 0;
  if (host.hidden || !store.rows) return;
  const rows = store.cursors.map(nearestRow);
  const quantities = [['Time', 's', store.rows.time_s], [forceWord(), 'N', store.rows.measured_N],
    ['Position', 'm', store.rows.position_m], ['Velocity', 'm/s', store.rows.velocity_mps],
    ...(store.current ? [['Residual', 'N', (store.bent ?? store.current).residual_N]] : [])];
  host.replaceChildren(h('table', {}, h('caption', {}, 'Cursors'),
    h('thead', {}, h('tr', {}, h('td'), ['A', 'B', 'B − A'].map((text) => h('th', {scope: 'col'}, text)))),
    h('tbody', {}, quantities.map(([name, unit, values]) => {
      const at = rows.map((row) => values[row]);
      return h('tr', {}, h('th', {scope: 'row'}, name), h('td', {}, quantity(at[0], unit, 5)), h('td', {}, at.length > 1 ? quantity(at[1], unit, 5) : '–'),
        h('td', {}, at.length > 1 ? quantity(at[1] - at[0], unit, 4) : '–'));
    }))), h('button', {type: 'button', onclick: clearCursors}, 'Remove cursors'));
}

// --- against a coordinate ---

const kCoordinates = [['position', 'position_m', 'm'], ['velocity', 'velocity_mps', 'm/s'], ['acceleration', 'acceleration_mps2', 'm/s²'], ['time since reversal', 'since_reversal_s', 's']];

function againstSpec([name, key, unit], profile) {
  const {rows, current, beside, bent} = store;
  const along = unitFor(unit, rows[key]);
  const residual = bent?.residual_N ?? current.residual_N;
  const left = unitFor('N', residual, beside?.residual_N ?? []);
  const [low, high] = extentOf(rows[key]);
  const means = profile ? {x: profile.x, lines: [
    {name: 'mean', role: 'after', width: 2, values: beside ? profile.after_mean_N : profile.mean_N},
    ...(beside ? [{name: 'mean before', role: 'before', width: 1.5, values: profile.mean_N}] : [])]} : meansOf(rows[key], residual, low, high, beside?.residual_N);
  const expected = profile && store.expected?.[profile.coordinate];
  if (expected) means.lines.push({name: `as ${store.expected.title} would leave it`, role: 'curve7', dash: [8, 3, 2, 3], width: 1.75, values: expected});
  return {
    title: `Residual against ${name}`, height: 220, x: {name: name.replace(/^./, (c) => c.toUpperCase()), label: `${name.replace(/^./, (c) => c.toUpperCase())} (${along.label})`, unit: along.label},
    y: {name: 'Residual', label: `Residual (${left.label})`, unit: left.label, perSi: left.perSi}, series: means.lines.map(({values, ...rest}) => rest),
    data: [means.x.map((value) => value * along.perSi), ...means.lines.map(({values}) => (values ?? empty(means.x.length)).map((value) => (value === null ? null : value * left.perSi)))],
    whole: () => [low * along.perSi, high * along.perSi], xRange: padded(low * along.perSi, high * along.perSi),
    yExtent: () => { const m = 1.05 * robustLimit(residual, beside?.residual_N) * left.perSi; return [-m, m]; },
    under: (u) => drawCloud(u, rows[key], along.perSi, residual, left.perSi),
    onBrush: (from, to) => {
      const mask = new Uint8Array(residual.length);
      for (let i = 0; i < mask.length; ++i) { const at = rows[key][i] * along.perSi; mask[i] = at >= from && at <= to ? 1 : 0; }
      select(mask);
    },
  };
}

function robustLimit(...arrays) {
  let largest = 0;
  for (const array of arrays) {
    if (!array) continue;
    const sizes = [];
    for (let i = 0; i < array.length; i += 7) if (!Number.isNaN(array[i])) sizes.push(Math.abs(array[i]));
    sizes.sort((a, b) => a - b);
    largest = Math.max(largest, sizes[Math.floor(0.998 * (sizes.length - 1))] ?? 0);
  }
  return largest || 1;
}

function extentOf(values) {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}

// Where the server has no means: of a residual set by hand, and over the time since the reversal.
function meansOf(coordinate, residual, low, high, before) {
  const bins = 60;
  const x = Array.from({length: bins}, (_, i) => low + (i + 0.5) / bins * (high - low));
  const line = (values) => {
    const sum = new Float64Array(bins);
    const count = new Float64Array(bins);
    for (let i = 0; i < values.length; ++i) {
      if (Number.isNaN(values[i])) continue;
      const bin = Math.min(bins - 1, Math.max(0, Math.floor((coordinate[i] - low) / (high - low) * bins)));
      sum[bin] += values[i];
      count[bin] += 1;
    }
    return Array.from(sum, (value, i) => (count[i] < 3 ? null : value / count[i]));
  };
  return {x, lines: [{name: 'mean', role: 'after', width: 2, values: line(residual)},
    ...(before ? [{name: 'mean before', role: 'before', width: 1.5, values: line(before)}] : [])]};
}

function drawCloud(u, xs, xPerSi, ys, yPerSi) {
  const {ctx, bbox} = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  const size = 1.5 * devicePixelRatio;
  const step = Math.max(1, Math.ceil(xs.length / kScatter));
  const {min: x0, max: x1} = u.scales.x;
  const {min: y0, max: y1} = u.scales.y;
  const sx = bbox.width / (x1 - x0) * xPerSi;
  const sy = bbox.height / (y1 - y0) * yPerSi;
  const bx = bbox.left - x0 / xPerSi * sx;
  const by = bbox.top + bbox.height + y0 / yPerSi * sy;
  const dots = (chosen, fill, alpha, by_step, side) => {
    ctx.fillStyle = fill;
    ctx.globalAlpha = alpha;
    for (let i = 0; i < xs.length; i += by_step) {
      if (Number.isNaN(ys[i]) || (chosen && !chosen[i])) continue;
      ctx.fillRect(bx + xs[i] * sx - side / 2, by - ys[i] * sy - side / 2, side, side);
    }
  };
  dots(null, colour('measured'), store.selected ? 0.18 : 0.35, step, size);
  if (store.selected) dots(store.selected, colour('curve5'), 0.9, 1, 2 * size);
  ctx.restore();
}

// --- loops and spectrum ---

function spectrumSpec() {
  const {spectrum: found} = store.charts;
  const density = unitFor('N/√Hz', found.residual_N);
  const line = (values) => (values ?? []).map((value) => (value > 0 ? value * density.perSi : null));
  const series = store.beside ? [{name: 'before', role: 'before', values: line(found.residual_N)}, {name: 'now', role: 'after', values: line(found.after_N)}]
                              : [{name: 'residual', role: 'after', values: line(found.residual_N)}];
  const floor = found.frequency_Hz.map(() => found.floor_N * density.perSi);
  series.push({name: 'noise floor', role: 'floor', dash: [4, 3], values: floor});
  return {title: 'Residual against frequency', height: 220, x: {name: 'Frequency', label: 'Frequency (Hz)', unit: 'Hz', log: true},
          y: {name: 'Density', label: `Residual density (${density.label})`, unit: density.label, log: true},
          series: series.map(({values, ...rest}) => rest), data: [found.frequency_Hz, ...series.map(({values}) => values)]};
}

// A loop over the displacement has no rising x: it is drawn as a path below an empty chart of the same scales.
function loopSpec(loop) {
  const along = unitFor('m', loop.displacement_m);
  const force = unitFor('N', loop.measured_N);
  const [low, high] = extentOf(loop.displacement_m);
  const lines = [['measured', 'measured', 2, loop.measured_N], ...(store.beside ? [['modelled before', 'before', 1.25, loop.model_N], ['modelled', 'after', 1.5, loop.after_N]] : [['modelled', 'after', 1.5, loop.model_N]])];
  const [f0, f1] = extentOf(loop.measured_N);
  return {
    title: loop.title, height: 240, x: {name: 'Displacement', label: `Displacement (${along.label})`, unit: along.label},
    y: {name: forceWord(), label: `${forceWord()} (${force.label})`, unit: force.label},
    series: lines.map(([name, role, width]) => ({name, role, width})), data: [[low * along.perSi, high * along.perSi], ...lines.map(() => [null, null])],
    xRange: padded(low * along.perSi, high * along.perSi), whole: () => padded(low * along.perSi, high * along.perSi), yExtent: () => [f0 * force.perSi, f1 * force.perSi],
    over: (u) => {
      const {ctx, bbox} = u;
      ctx.save();
      ctx.beginPath();
      ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
      ctx.clip();
      lines.forEach(([, role, width, values], k) => {
        if (!values || !u.series[k + 1].show) return;
        ctx.beginPath();
        values.forEach((value, i) => ctx[i ? 'lineTo' : 'moveTo'](u.valToPos(loop.displacement_m[i] * along.perSi, 'x', true), u.valToPos(value * force.perSi, 'y', true)));
        ctx.strokeStyle = colour(role);
        ctx.lineWidth = width * devicePixelRatio;
        ctx.stroke();
      });
      ctx.restore();
    },
  };
}

// --- putting them on the page ---

function place(existing, host, spec) {
  if (existing) { existing.update(spec); return existing; }
  const figure = h('figure', {class: 'chart'});
  host.append(figure);
  return new Chart(figure, spec);
}

function drawTime() {
  const specs = timeSpecs();
  const host = byId('time-charts');
  const first = store.rows.time_s[0];
  const last = store.rows.time_s[store.rows.time_s.length - 1];
  const range = store.range ?? (store.range = {min: first, max: last});
  for (const name of ['force', 'residual', 'position']) {
    if (!specs[name]) continue;
    const number = {force: 1, residual: specs.residual?.series.length ?? 1, position: 1}[name];
    time[name] = place(time[name], host, {
      ...specs[name], xRange: [range.min, range.max], whole: () => [first, last], onRange: setRange, onBrush: brushTime, onCursor: placeCursor,
      under: (u) => { if (name === 'force') drawRaw(u); if (name === 'residual') drawFloor(u); },
      over: (u) => { drawSelected(number)(u); drawCursors(u); }});
  }
  // Residual between force and position, whenever it came.
  if (time.residual) host.insertBefore(time.residual.host, time.position.host);
  fetchRaw();
}

function drawAgainst() {
  const host = byId('against-charts');
  if (!store.current) { host.replaceChildren(); against = []; loops = []; spectrum = null; return; }
  kCoordinates.forEach((coordinate, i) => {
    const profile = store.bent ? null : store.charts?.profiles.find((one) => one.coordinate === coordinate[0]);
    against[i] = place(against[i], host, againstSpec(coordinate, profile ?? null));
  });
  if (!store.charts || store.bent) return;
  spectrum = place(spectrum, host, spectrumSpec());
  store.charts.loops.forEach((loop, i) => {
    loops[i]?.host.remove();
    loops[i] = place(null, host, loopSpec(loop));
  });
}

// The first picture, before anything is computed: the force as it was recorded.
function drawRecorded() {
  const log = store.state.logs[0];
  if (store.rows || !log?.samples || !store.state.traces) return;
  const host = byId('time-charts');
  const unit = displayUnit('N', 1);
  store.range ??= {min: 0, max: log.duration_s};
  time.force = place(time.force, host, {
    title: `${forceWord()} over time, as recorded`, height: 230, x: {name: 'Time', label: 'Time (s)', unit: 's'},
    y: {name: forceWord(), label: `${forceWord()} (${unit.label})`, unit: unit.label, perSi: unit.perSi}, series: [{name: 'recorded', role: 'curve8'}], data: [[0, log.duration_s], [null, null]],
    xRange: [store.range.min, store.range.max], whole: () => [0, log.duration_s], onRange: setRange,
    yExtent: () => (raw ? [Math.min(...raw.low) * unit.perSi, Math.max(...raw.high) * unit.perSi] : [-1, 1]), under: drawRaw});
  fetchRaw().then(() => time.force?.u.redraw());
}

export function forgetCharts() {
  time = {};
  against = [];
  loops = [];
  spectrum = null;
  raw = null;
  store.range = null;
  store.cursors = [];
  store.selected = null;
  byId('time-charts').replaceChildren();
  byId('against-charts').replaceChildren();
  byId('cursors').hidden = true;
}

export function showInterval(from, to) {
  const margin = 0.5 * (to - from);
  setRange(from - margin, to + margin);
  brushTime(from, to);
  byId('time-charts').scrollIntoView({block: 'nearest'});
}

export function startCharts() {
  on('recorded', drawRecorded);
  on('model', () => { if (store.rows) { if (time.force && !time.position) forgetCharts(); drawTime(); drawAgainst(); showCursors(); } });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { for (const chart of [...Object.values(time), ...against, ...loops, spectrum]) chart?.u.redraw(); });
}
