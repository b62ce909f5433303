// SPDX-License-Identifier: Apache-2.0
// Puts the charts into the figures that the page holds: key lines, zoom, cursor, and a second drawing for paper.

const kPaperRatio = 3;
const kPaperWidth = 686;  // CSS pixels between the margins of an A4 page
const kPaperGap = 20;

// --- the key line above a plot: line sample, name, value under the cursor; a click hides the line ---

function element(tag, className, text) {
  const node = document.createElement(tag);
  if (className) node.className = className;
  if (text) node.textContent = text;
  return node;
}

function sample(series) {
  const style = styleOf(series);
  const colour = `var(--${kStyles[series.role].colour ?? series.role})`;
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('width', 26);
  svg.setAttribute('height', 10);
  const add = (tag, attributes) => {
    const node = document.createElementNS(svg.namespaceURI, tag);
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
    svg.append(node);
  };
  if (series.band !== undefined) {
    add('rect', {x: 0, y: 0, width: 26, height: 10, style: `fill: ${colour}; opacity: 0.15`});
    return svg;
  }
  add('line', {x1: 0, x2: 26, y1: 5, y2: 5, style: `stroke: ${colour}`, 'stroke-width': style.width, 'stroke-dasharray': (style.dash ?? []).join(' ')});
  if (style.marks) {
    add('circle', {cx: 13, cy: 5, r: 2.5, style: `stroke: ${colour}; fill: ${style.marks === 'filled' ? colour : 'var(--page)'}`});
  }
  return svg;
}

function keyline(plot, toggle) {
  const line = element('div', 'keyline');
  const outputs = [];
  plot.series.forEach((series, i) => {
    if (series.edge && series.band === undefined) return;
    // Curves of one name share one entry, that of the first.
    if (!series.edge && plot.series.findIndex((other) => other.name === series.name && !other.edge) < i) return;
    const item = element(series.edge ? 'span' : 'button', series.edge ? 'item' : '');
    item.append(sample(series), element('span', '', series.edge ? '± 1 standard deviation' : series.name));
    if (!series.edge) {
      item.type = 'button';
      item.setAttribute('aria-pressed', 'true');
      item.addEventListener('click', () => {
        const show = item.getAttribute('aria-pressed') !== 'true';
        item.setAttribute('aria-pressed', String(show));
        plot.series.forEach((other, k) => { if (k === i || (other.name === series.name && !other.edge)) toggle(k, show); });
      });
      outputs[i] = element('output');
      item.append(outputs[i]);
    }
    line.append(item);
  });
  for (const level of plot.levels ?? []) {
    const item = element('span', 'item');
    item.append(sample(level), element('span', '', level.name));
    line.append(item);
  }
  return {line, outputs, where: element('output', 'where')};
}

function showCursor(u, plot, key) {
  const {left, top, idx} = u.cursor;
  const inside = left >= 0 && (plot.kind === 'xy' ? top >= 0 : idx !== null && idx !== undefined);
  key.outputs.forEach((output, i) => {
    output.value = inside && plot.kind === 'line' ? readout(u.data[i + 1][idx]) : '';
  });
  if (!inside) {
    key.where.value = '';
  } else if (plot.kind === 'xy') {
    key.where.value = `${readout(u.posToVal(left, 'x'))} ${plot.x.unit}, ${readout(u.posToVal(top, 'y'))} ${plot.y[0].unit}`;
  } else {
    key.where.value = `${plot.x.name} ${readout(u.data[0][idx])} ${plot.x.unit}`;
  }
}

// --- one figure: its plots share x ---

const theme = readTheme(document.documentElement);
theme.font = getComputedStyle(document.body).fontFamily;
const figures = [];

function mountFigure(figure, Uplot, number) {
  const plots = plotsFor(figure).filter((plot) => plot.series.length > 0);
  if (!plots.length) {
    figure.append(element('p', 'nothing', 'No values to draw.'));
    return;
  }
  const state = {figure, plots: []};
  const sync = plots.length > 1 ? Uplot.sync('figure-' + number) : null;
  const reset = element('button', 'reset', 'Reset zoom');
  reset.type = 'button';
  reset.hidden = true;
  figure.append(reset);

  const goHome = () => state.plots.forEach(({u, home}) => u.batch(() => {
    u.setScale('x', home.x);
    if (home.y) u.setScale('y', home.y);
  }));
  reset.addEventListener('click', goHome);
  const onScale = (u, key) => {
    const mine = state.plots.find((entry) => entry.u === u);
    if (!mine?.home) return;  // still drawing for the first time
    if (key === 'x' && sync) {
      for (const other of state.plots) {
        const {min, max} = u.scales.x;
        if (other.u !== u && (other.u.scales.x.min !== min || other.u.scales.x.max !== max)) other.u.setScale('x', {min, max});
      }
    }
    const away = (scale, home) => home && (scale.min !== home.min || scale.max !== home.max);
    reset.hidden = !away(u.scales.x, mine.home.x) && !away(u.scales.y, mine.home.y);
  };

  for (const plot of plots) {
    const entry = {plot, shown: plot.series.map(() => true)};
    const key = keyline(plot, (i, show) => {
      entry.shown[i] = show;
      if (plot.kind === 'xy') {
        entry.u.series[i + 1].show = show;  // setSeries() would reset the zoom of an x-y chart
        entry.u.redraw(false);
      } else {
        entry.u.setSeries(i + 1, {show});
      }
    });
    entry.host = element('div', 'plot');
    entry.host.style.height = plot.height + 'px';
    entry.paper = element('div', 'paper');
    if (!plot.hideX) entry.host.append(key.where);  // beside the label of x, where it moves nothing
    figure.append(key.line, entry.host, entry.paper);
    entry.u = drawPlot(Uplot, entry.host, plot, {
      width: entry.host.clientWidth, height: plot.height, theme, ratio: window.devicePixelRatio,
      interact: {
        sync, onScale, onReset: goHome, onCursor: (u) => showCursor(u, plot, key),
        onReady: ({scales: {x, y}}) => {
          entry.home = {x: {min: x.min, max: x.max}, y: plot.kind === 'xy' ? {min: y.min, max: y.max} : null};
        },
      },
    });
    state.plots.push(entry);
    new ResizeObserver(() => {
      const width = entry.host.clientWidth;
      if (width > 0 && width !== entry.u.width) entry.u.setSize({width, height: plot.height});
    }).observe(entry.host);
  }
  figures.push(state);
}

// --- paper: every chart once more, at the size and resolution of an A4 page, in the colours of paper ---

let paperUplot = null;

function drawOnPaper() {
  if (document.body.classList.contains('printing')) return;
  document.body.classList.add('printing');
  paperUplot ??= loadUplot(kPaperRatio);
  for (const {figure, plots} of figures) {
    const full = figure.matches('.force, .spectrum, :only-child');
    const width = full ? kPaperWidth : (kPaperWidth - kPaperGap) / 2;
    for (const {plot, u, paper, shown} of plots) {
      const paperTheme = readTheme(paper);
      paperTheme.font = theme.font;
      const onPaper = drawPlot(paperUplot, paper, plot, {width, height: plot.paperHeight, theme: paperTheme, ratio: kPaperRatio, shown});
      onPaper.batch(() => {  // print what is shown, including the zoom
        onPaper.setScale('x', {min: u.scales.x.min, max: u.scales.x.max});
        if (plot.kind === 'xy') onPaper.setScale('y', {min: u.scales.y.min, max: u.scales.y.max});
      });
    }
  }
}

function clearPaper() {
  document.body.classList.remove('printing');
  for (const {plots} of figures) for (const {paper} of plots) paper.replaceChildren();
}

// --- start ---

function foldRanking() {
  const rest = document.querySelector('.ranking .rest');
  const button = document.querySelector('.ranking .more button');
  if (!rest || !button) return;
  const says = button.textContent.trim();
  const fold = (folded) => {
    rest.classList.toggle('folded', folded);
    button.setAttribute('aria-expanded', String(!folded));
    button.textContent = (folded ? 'Show ' : 'Hide ') + says;
  };
  button.addEventListener('click', () => fold(!rest.classList.contains('folded')));
  fold(true);
}

function start() {
  foldRanking();
  const screenUplot = loadUplot(window.devicePixelRatio);
  document.querySelectorAll('figure[data-chart]').forEach((figure, i) => {
    try {
      mountFigure(figure, screenUplot, i);
    } catch (error) {  // a chart that fails must not prevent the others
      figure.append(element('p', 'nothing', 'This chart could not be drawn.'));
      console.error(error);
    }
  });
  const heading = document.querySelector('figure[data-chart]')?.closest('section').querySelector('h2');
  heading?.append(element('span', 'hint', 'drag to zoom, double-click to reset'));
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
    const {font} = theme;
    readTheme(document.documentElement, theme).font = font;
    figures.forEach(({plots}) => plots.forEach(({u}) => u.redraw(false)));
  });
  window.addEventListener('beforeprint', drawOnPaper);
  window.addEventListener('afterprint', clearPaper);
  // For tests and the console of the browser.
  window.slipstackReport = {figures};
}

start();
