// SPDX-License-Identifier: Apache-2.0
// One chart on uPlot: zoom by drag, wheel and keys, pan, y-zoom, reset, brush, two cursors, a table of what is visible,
// and its export as PNG, SVG or CSV. Units and number texts are those of units.js.
import {attempt, dialog, h, save} from '/dom.js';
import {store} from '/store.js';

const kFont = '11px "Noto Sans", "Liberation Sans", Arial, sans-serif';
const kMostTableRows = 200;

export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();

export function padded(low, high) {
  if (!(low < high)) return [low - (Math.abs(low) || 1) * 0.5, high + (Math.abs(high) || 1) * 0.5];
  const pad = 0.05 * (high - low);
  return [low - pad, high + pad];
}

// `spec`: {title, x: {name, label, log}, y: {name, label, log}, series: [{name, role, width, dash}], data: [[x], [y]...],
// height, xRange: [low, high], under: (u) => drawing below the lines, over: (u) => above, onRange, onBrush, onCursor}
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
    new ResizeObserver(() => this.resize()).observe(this.box);
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
      ...(of.log ? {} : {values: (u, splits, index, space, increment) => splits.map((value) => (value === null ? '' : tickText(value, increment)))}),
    });
    return {
      width: Math.max(120, this.box.clientWidth || 400), height: spec.height, pxAlign: 0, padding: [6, 14, 0, 0], legend: {show: false},
      scales: {
        x: {time: false, distr: spec.x.log ? 3 : 1, range: (u, low, high) => (low === high ? padded(low, high) : [low, high])},
        y: {distr: spec.y.log ? 3 : 1, range: (u, low, high) => this.yRange ?? (this.spec.yExtent ? padded(...this.spec.yExtent(u)) : spec.y.log ? [low, high] : padded(low ?? 0, high ?? 1))},
      },
      axes: [{...axis(spec.x, 2), size: 24, space: 60}, {...axis(spec.y, 3), space: spec.height < 150 ? 18 : 28, size: (u, values) => Math.max(44, 14 + 6.3 * Math.max(1, ...(values ?? []).map((text) => String(text ?? '').length)))}],
      series: [{}, ...spec.series.map((one) => ({
        label: one.name, width: one.width ?? 1.25, dash: one.dash, stroke: () => colour(one.role), points: {show: false}, spanGaps: false}))],
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
      type: 'button', 'aria-pressed': 'true', class: 'key',
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

  resize() {
    const width = this.box.clientWidth;
    if (width > 0 && Math.abs(width - this.u.width) > 1) this.u.setSize({width, height: this.spec.height});
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
    act();
  }

  cursor(u) {
    const index = u.cursor.idx;
    if (u.cursor.left < 0 || index === null || index === undefined) { this.readout.textContent = ''; return; }
    const {x, y, series, data} = this.spec;
    const values = series.map((one, i) => (u.series[i + 1].show && data[i + 1][index] !== null ? `${one.name} ${readout(data[i + 1][index])}` : null)).filter(Boolean);
    this.readout.textContent = `${x.name} ${readout(data[0][index])} ${x.unit}: ${values.join(', ')} ${y.unit}`;
  }

  // Indices of what is visible.
  visible() {
    const xs = this.spec.data[0];
    const [low, high] = this.shownRange();
    const indices = [];
    for (let i = 0; i < xs.length; ++i) if (xs[i] >= low && xs[i] <= high) indices.push(i);
    return indices;
  }

  rowsOfTable(most) {
    const indices = this.visible();
    const step = Math.max(1, Math.ceil(indices.length / most));
    return indices.filter((_, i) => i % step === 0).map((i) => this.spec.data.map((column) => column[i]));
  }

  headings() { return [this.spec.x.label, ...this.spec.series.map((one) => `${one.name} (${this.spec.y.unit})`)]; }

  async give(kind) {
    this.menu.open = false;
    const name = this.spec.title.toLowerCase().replaceAll(/[^a-z0-9]+/g, '-');
    if (kind === 'Table') {
      const rows = this.rowsOfTable(kMostTableRows);
      const total = this.visible().length;
      await dialog(this.spec.title, h('div', {class: 'scroll', tabindex: 0},
        h('table', {}, h('caption', {}, rows.length < total ? `${rows.length} of the ${total} visible samples` : `${total} visible samples`),
          h('thead', {}, h('tr', {}, this.headings().map((text) => h('th', {scope: 'col'}, text)))),
          h('tbody', {}, rows.map((row) => h('tr', {}, row.map((value) => h('td', {}, readout(value)))))))));
    } else if (kind === 'CSV') {
      const text = [this.headings().join(','), ...this.rowsOfTable(Infinity).map((row) => row.map((value) => value ?? '').join(','))].join('\n');
      save(new Blob([text + '\n'], {type: 'text/csv'}), `${name}.csv`);
    } else if (kind === 'PNG') {
      save(await this.png(), `${name}.png`);
    } else {
      save(new Blob([this.svg()], {type: 'image/svg+xml'}), `${name}.svg`);
    }
  }

  png() {
    const from = this.box.querySelector('canvas');
    const canvas = document.createElement('canvas');
    canvas.width = from.width;
    canvas.height = from.height;
    const context = canvas.getContext('2d');
    context.fillStyle = colour('page');
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.drawImage(from, 0, 0);
    return new Promise((done) => canvas.toBlob(done, 'image/png'));
  }

  // The lines of what is visible as vectors, with axes and their ends.
  svg() {
    const width = this.u.width;
    const height = this.spec.height;
    const box = {left: 60, top: 10, width: width - 80, height: height - 50};
    const {min: x0, max: x1} = this.u.scales.x;
    const {min: y0, max: y1} = this.u.scales.y;
    const place = (value, low, high, log) => (log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low));
    const px = (x) => (box.left + box.width * place(x, x0, x1, this.spec.x.log)).toFixed(2);
    const py = (y) => (box.top + box.height * (1 - place(y, y0, y1, this.spec.y.log))).toFixed(2);
    const escape = (text) => text.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);
    const indices = this.visible();
    const path = (column) => {
      let text = '';
      let down = false;
      for (const i of indices) {
        const y = column[i];
        if (y === null || y === undefined || Number.isNaN(y)) { down = false; continue; }
        text += `${down ? 'L' : 'M'}${px(this.spec.data[0][i])} ${py(y)}`;
        down = true;
      }
      return text;
    };
    const lines = this.spec.series.map((one, i) => (this.u.series[i + 1].show
      ? `<path d="${path(this.spec.data[i + 1])}" fill="none" stroke="${colour(one.role)}" stroke-width="${one.width ?? 1.25}"${one.dash ? ` stroke-dasharray="${one.dash.join(' ')}"` : ''}><title>${escape(one.name)}</title></path>` : '')).join('\n');
    const text = (x, y, anchor, what) => `<text x="${x}" y="${y}" text-anchor="${anchor}">${escape(what)}</text>`;
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" font-family="Arial, sans-serif" font-size="11" fill="${colour('ink')}">
<title>${escape(this.spec.title)}</title><rect width="100%" height="100%" fill="${colour('page')}"/>
<clipPath id="plot"><rect x="${box.left}" y="${box.top}" width="${box.width}" height="${box.height}"/></clipPath>
<rect x="${box.left}" y="${box.top}" width="${box.width}" height="${box.height}" fill="none" stroke="${colour('rule')}"/>
<g clip-path="url(#plot)">${lines}</g>
${text(box.left, height - 26, 'middle', readout(x0))}${text(box.left + box.width, height - 26, 'middle', readout(x1))}
${text(box.left + box.width / 2, height - 10, 'middle', this.spec.x.label)}
${text(box.left - 6, box.top + box.height, 'end', readout(y0))}${text(box.left - 6, box.top + 10, 'end', readout(y1))}
<text transform="translate(14 ${box.top + box.height / 2}) rotate(-90)" text-anchor="middle">${escape(this.spec.y.label)}</text>
</svg>
`;
  }
}
