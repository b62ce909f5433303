// SPDX-License-Identifier: Apache-2.0
// One chart on uPlot: zoom by drag, wheel and keys, pan, y-zoom, reset, brush, cursors, export (chart_export.js). Units and
// number texts are those of units.js.
import {csvOf, pngOf, showTable, svgOf} from '/chart_export.js';
import {attempt, h, save} from '/dom.js';
import {store} from '/store.js';

const kFont = '11px "Noto Sans", "Liberation Sans", Arial, sans-serif';

export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();

// On a logarithmic axis: out to the next 1, 2 or 5, which are labelled where the axis has few decades.
const kLabelled = [1, 2, 5, 10];

function outwards(low, high) {
  const decade = (value) => 10 ** Math.floor(Math.log10(value) + 1e-9);
  const from = decade(low) * kLabelled.findLast((one) => one * decade(low) <= low * (1 + 1e-9));
  const to = decade(high) * kLabelled.find((one) => one * decade(high) >= high * (1 - 1e-9));
  return from < to ? [from, to] : [from / 2, to * 2];
}

function labelled(u, splits) {
  const [low, high] = [splits[0], splits[splits.length - 1]];
  const wanted = high / low > 500 ? [1] : kLabelled;
  return splits.map((value) => (wanted.some((one) => Math.abs(value / 10 ** Math.floor(Math.log10(value) + 1e-9) - one) < 1e-6) ? value : null));
}

export function padded(low, high) {
  if (!(low < high)) return [low - (Math.abs(low) || 1) * 0.5, high + (Math.abs(high) || 1) * 0.5];
  const pad = 0.05 * (high - low);
  return [low - pad, high + pad];
}

// `spec`: {title, x: {name, label, log}, y: {name, label, log}, series: [{name, role, width, dash, points}], data: [[x], [y]...],
// height, xRange: [low, high], yExtent: (u) => [low, high], rows: () => [[x, y...]...] where data holds no lines,
// under: (u) => drawing below the lines, over: (u) => above, onRange, onBrush, onCursor}
export class Chart {
  constructor(host, spec) {
    this.host = host;
    this.spec = spec;
    this.yRange = null;
    this.readout = h('output', {class: 'readout', 'aria-live': 'off'});
    this.box = h('div', {class: 'plot', tabindex: 0, role: 'group', 'aria-label': this.description(), onkeydown: (event) => this.key(event)});
    this.menu = h('details', {class: 'menu'}, h('summary', {'aria-label': `Export and table of ${spec.title}`}, '⋯'),
      h('div', {class: 'choices'},
        ['Table', 'PNG', 'SVG', 'CSV'].map((kind) => h('button', {type: 'button', onclick: () => attempt(() => this.give(kind))}, kind))));
    this.keys = h('div', {class: 'keyline'});
    host.replaceChildren(h('figcaption', {}, h('h3', {}, spec.title), this.keys, this.readout, this.menu), this.box);
    this.make();
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(this.box);
  }

  remove() {
    this.observer.disconnect();
    this.u.destroy();
    this.host.remove();
  }

  description() {
    const {title, x, y, series} = this.spec;
    return `${title}: ${y.label} over ${x.label}; ${series.map((one) => one.name).join(', ')}. Arrow keys move, plus and minus zoom, 0 resets.`;
  }

  options() {
    const {spec} = this;
    const axis = (of, side) => ({
      label: of.label, font: kFont, labelFont: kFont, stroke: () => colour('soft'), labelGap: 0, labelSize: 17, gap: 3, side,
      grid: {stroke: () => colour('hair'), width: 1}, ticks: {stroke: () => colour('rule'), width: 1, size: 4},
      ...(of.log ? {filter: labelled, values: (u, splits) => splits.map(logTickText)} : {values: (u, splits, index, space, increment) => splits.map((value) => (value === null ? '' : tickText(value, increment)))}),
    });
    return {
      width: Math.max(120, this.box.clientWidth || 400), height: spec.height, pxAlign: 0, padding: [6, 14, 0, 0], legend: {show: false},
      scales: {
        x: {time: false, distr: spec.x.log ? 3 : 1, range: (u, low, high) => (low === high ? padded(low, high) : [low, high])},
        y: {distr: spec.y.log ? 3 : 1, range: (u, low, high) => this.yRange ?? (this.spec.yExtent ? padded(...this.spec.yExtent(u)) : spec.y.log ? outwards(low ?? 1, high ?? 10) : padded(low ?? 0, high ?? 1))},
      },
      axes: [{...axis(spec.x, 2), size: 24, space: 60}, {...axis(spec.y, 3), space: spec.height < 150 ? 18 : 28, size: (u, values) => Math.max(44, 14 + 6.3 * Math.max(1, ...(values ?? []).map((text) => String(text ?? '').length)))}],
      series: [{}, ...spec.series.map((one) => ({
        label: one.name, width: one.width ?? 1.25, dash: one.dash, stroke: () => colour(one.role), points: {show: one.points ?? false, size: 6, fill: () => colour('page')}, spanGaps: false}))],
      cursor: {drag: {x: true, y: false, setScale: false}, y: false, points: {size: 5}, bind: {dblclick: () => () => { this.reset(); return null; }}},
      hooks: {
        drawAxes: [(u) => this.spec.under?.(u)],
        draw: [(u) => this.spec.over?.(u)],
        setSelect: [(u) => this.selected(u)],
        setCursor: [(u) => this.cursor(u)],
        ready: [(u) => this.ready(u)],
      },
    };
  }

  make() {
    this.u?.destroy();
    this.u = new uPlot(this.options(), this.spec.data, this.box);
    if (this.spec.xRange) this.u.setScale('x', {min: this.spec.xRange[0], max: this.spec.xRange[1]});
    this.drawKeys();
  }

  drawKeys() {
    this.keys.replaceChildren(...this.spec.series.map((one, i) => h('button', {
      type: 'button', 'aria-pressed': String(this.u.series[i + 1].show), class: 'key',
      onclick: (event) => {
        const show = event.currentTarget.getAttribute('aria-pressed') !== 'true';
        event.currentTarget.setAttribute('aria-pressed', String(show));
        this.u.setSeries(i + 1, {show});
      }}, h('span', {class: `line ${one.dash ? 'dashed' : ''}`, style: `--line: var(--${one.role})`}), one.name)));
  }

  // New numbers, same chart.
  update(spec) {
    const same = this.spec.series.length === spec.series.length && this.spec.x.label === spec.x.label && this.spec.y.label === spec.y.label;
    const shown = this.shownRange();
    this.spec = {...this.spec, ...spec};
    this.box.setAttribute('aria-label', this.description());
    if (!same) { this.make(); return; }
    this.u.setData(this.spec.data, false);
    this.drawKeys();
    const [low, high] = this.spec.xRange ?? shown;
    this.u.setScale('x', {min: low, max: high});
  }

  // Newer values of the same lines, many times a second: nothing but the canvas is drawn.
  feed(data, [low, high]) {
    this.spec.data = data;
    this.u.setData(data, false);
    this.u.setScale('x', {min: low, max: high});
  }

  resize() {
    const width = this.box.clientWidth;
    if (width > 0 && Math.abs(width - this.u.width) > 1) this.u.setSize({width, height: this.spec.height});
  }

  // At once: no frame is drawn before the page is on paper.
  print(width) {
    this.u.batch(() => { this.u.setSize({width, height: this.spec.height}); });
    this.redraw();
  }

  redraw() { this.u.redraw(false, true); }

  shownRange() { return [this.u.scales.x.min, this.u.scales.x.max]; }

  wholeRange() {
    const xs = this.spec.data[0];
    return this.spec.whole?.() ?? [xs[0], xs[xs.length - 1]];
  }

  show(low, high) {
    const [first, last] = this.wholeRange();
    const width = Math.min(high - low, last - first);
    const from = Math.max(first, Math.min(low, last - width));
    if (this.spec.onRange) this.spec.onRange(from, from + width);
    else this.u.setScale('x', {min: from, max: from + width});
  }

  reset() {
    this.yRange = null;
    this.show(...this.wholeRange());
    this.u.redraw();
  }

  selected(u) {
    const {left, width} = u.select;
    if (width < 3) return;
    const low = u.posToVal(left, 'x');
    const high = u.posToVal(left + width, 'x');
    u.setSelect({left: 0, top: 0, width: 0, height: 0}, false);
    if (store.tool === 'brush' && this.spec.onBrush) this.spec.onBrush(low, high);
    else if (store.tool === 'zoom') this.show(low, high);
  }

  ready(u) {
    u.over.addEventListener('wheel', (event) => this.wheel(u, event), {passive: false});
    u.over.addEventListener('mousedown', (event) => {
      if (event.button === 1 || event.altKey || store.tool === 'pan') this.drag(u, event);
    }, true);
    u.over.addEventListener('click', () => {
      if (store.tool === 'cursors' && u.cursor.left >= 0) this.spec.onCursor?.(u.posToVal(u.cursor.left, 'x'));
    });
  }

  wheel(u, event) {
    event.preventDefault();
    const factor = Math.exp(0.0015 * (event.deltaY || event.deltaX));
    const rect = u.over.getBoundingClientRect();
    if (event.shiftKey) {
      const at = u.posToVal(event.clientY - rect.top, 'y');
      const {min, max} = u.scales.y;
      this.yRange = [at - (at - min) * factor, at + (max - at) * factor];
      u.redraw();
      return;
    }
    const at = u.posToVal(event.clientX - rect.left, 'x');
    const [low, high] = this.shownRange();
    this.show(at - (at - low) * factor, at + (high - at) * factor);
  }

  drag(u, event) {
    event.preventDefault();
    event.stopImmediatePropagation();
    const [low, high] = this.shownRange();
    const perPixel = (high - low) / u.over.clientWidth;
    const move = (now) => this.show(low - (now.clientX - event.clientX) * perPixel, high - (now.clientX - event.clientX) * perPixel);
    const end = () => { removeEventListener('mousemove', move); removeEventListener('mouseup', end); };
    addEventListener('mousemove', move);
    addEventListener('mouseup', end);
  }

  key(event) {
    const [low, high] = this.shownRange();
    const width = high - low;
    const middle = 0.5 * (low + high);
    const acts = {
      ArrowLeft: () => this.show(low - 0.2 * width, high - 0.2 * width),
      ArrowRight: () => this.show(low + 0.2 * width, high + 0.2 * width),
      '+': () => this.show(middle - 0.3 * width, middle + 0.3 * width),
      '-': () => this.show(middle - 0.8 * width, middle + 0.8 * width),
      0: () => this.reset(),
      c: () => this.spec.onCursor?.(middle),
      t: () => this.give('Table'),
    };
    const act = acts[event.key === '=' ? '+' : event.key];
    if (!act || event.target !== this.box || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();  // c connects to a controller elsewhere
    act();
  }

  cursor(u) {
    const index = u.cursor.idx;
    if (u.cursor.left < 0 || index === null || index === undefined) { this.readout.textContent = ''; return; }
    const {x, y, series, data} = this.spec;
    const values = series.map((one, i) => (u.series[i + 1].show && data[i + 1][index] !== null ? `${one.name} ${readout(data[i + 1][index])}` : null)).filter(Boolean);
    this.readout.textContent = `${x.name} ${readout(data[0][index])} ${x.unit}: ${values.join(', ')} ${y.unit}`.trimEnd();
  }

  async give(kind) {
    this.menu.open = false;
    const name = this.spec.title.toLowerCase().replaceAll(/[^a-z0-9]+/g, '-');
    if (kind === 'Table') await showTable(this);
    else if (kind === 'CSV') save(csvOf(this), `${name}.csv`);
    else if (kind === 'PNG') save(await pngOf(this, colour('page')), `${name}.png`);
    else save(svgOf(this, colour), `${name}.svg`);
  }
}
