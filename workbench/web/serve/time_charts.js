// SPDX-License-Identifier: Apache-2.0
// Force, residual and position over time: one range of time for all, the force as it was recorded behind them.
import {bytes} from '/api.js';
import {colour} from '/chart.js';
import {drawCursors, placeCursor} from '/cursors.js';
import {byId} from '/dom.js';
import {chartOf, clipped, drop, forceWord, place, rowsWithin, select, unitFor} from '/linked.js';
import {store, tell} from '/store.js';

export const kTimeCharts = ['force', 'residual', 'position'];
const kSeconds = {name: 'Time', label: 'Time (s)', unit: 's'};
let raw = null;       // recorded force as it was sampled: {header, low, high, offset}
let fetching = null;

const timeCharts = () => kTimeCharts.map(chartOf).filter(Boolean);

// Not a number becomes a gap; so does the step from one part of an excerpt to the next.
function plotted(values, factor, starts) {
  const out = new Array(values.length);
  for (let i = 0; i < values.length; ++i) out[i] = Number.isNaN(values[i]) ? null : values[i] * factor;
  for (const start of starts.slice(1)) if (start > 0 && start < out.length) out[start - 1] = null;
  return out;
}

function timeSpecs() {
  const {rows, current, beside, bent} = store;
  const starts = rows.header.starts;
  const ts = Array.from(rows.time_s);
  const force = unitFor('N', rows.measured_N);
  const after = bent?.residual_N ?? current?.residual_N;
  const left = unitFor('N', after ?? [], beside?.residual_N ?? []);
  const length = unitFor('m', rows.position_m);
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
    title, height, x: kSeconds, y: {name: word, label: `${word} (${unit.label})`, unit: unit.label, perSi: unit.perSi}, series: series.map(({values, ...rest}) => rest),
    data: [ts, ...series.map(({values}) => plotted(values, unit.perSi, starts))]});
  const specs = {force: spec(`${forceWord()} over time`, 230, force, forceWord(), forceSeries)};
  if (residualSeries.length) specs.residual = spec('Residual over time', 190, left, 'Residual', residualSeries);
  specs.position = spec('Position over time', 130, length, 'Position', [{name: 'position', role: 'motion', values: rows.position_m}]);
  return specs;
}

function drawSelected(series) {
  return (u) => {
    if (!store.selected || u.series.length <= series) return;
    clipped(u, (ctx) => {
      ctx.fillStyle = colour('curve5');
      const xs = u.data[0];
      const ys = u.data[series];
      const size = 3 * devicePixelRatio;
      const {min, max} = u.scales.x;
      for (let i = 0; i < xs.length; ++i) {
        if (!store.selected[i] || ys[i] === null || xs[i] < min || xs[i] > max) continue;
        ctx.fillRect(u.valToPos(xs[i], 'x', true) - size / 2, u.valToPos(ys[i], 'y', true) - size / 2, size, size);
      }
    });
  };
}

// The force as it was recorded: single samples as a line, else the extremes of each point as a band.
function drawRaw(u) {
  const chart = chartOf('force');
  if (!raw || !chart) return;
  const {perSi} = chart.spec.y;
  const {low, high, header} = raw;
  const px = (i) => u.valToPos(raw.offset + header.first_s + i * header.step_s, 'x', true);
  clipped(u, (ctx) => {
    if (header.samples_per_point === 1) {
      ctx.beginPath();
      for (let i = 0; i < low.length; ++i) ctx[i ? 'lineTo' : 'moveTo'](px(i), u.valToPos(low[i] * perSi, 'y', true));
      ctx.strokeStyle = colour('curve8');
      ctx.globalAlpha = 0.7;
      ctx.lineWidth = devicePixelRatio;
      ctx.stroke();
    } else {
      // Whole pixels: they touch and do not overlap, and a polygon of so many corners takes ten times as long.
      ctx.fillStyle = colour('curve8');
      ctx.globalAlpha = store.rows ? 0.25 : 0.8;
      for (let i = 0; i < low.length; ++i) {
        const left = Math.round(px(i));
        const top = Math.round(u.valToPos(high[i] * perSi, 'y', true));
        ctx.fillRect(left, top, Math.round(px(i + 1)) - left, Math.max(1, Math.round(u.valToPos(low[i] * perSi, 'y', true)) - top));
      }
    }
  });
}

function drawFloor(u) {
  const floor = store.state?.versions.find((version) => version.id === store.state.current)?.floor_N;
  const chart = chartOf('residual');
  if (!floor || !chart) return;
  const {bbox} = u;
  clipped(u, (ctx) => {
    ctx.strokeStyle = colour('floor');
    ctx.setLineDash([4 * devicePixelRatio, 3 * devicePixelRatio]);
    ctx.lineWidth = devicePixelRatio;
    for (const sign of [-1, 1]) {
      const y = u.valToPos(sign * floor * chart.spec.y.perSi, 'y', true);
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
    }
  });
}

function setRange(low, high) {
  store.range = {min: low, max: high};
  for (const chart of timeCharts()) chart.u.setScale('x', {min: low, max: high});
  fetchRaw();
  tell('range');
}

async function fetchRaw() {
  fetching?.abort();
  fetching = new AbortController();
  const {signal} = fetching;
  const logs = store.rows?.header.logs ?? [{start_s: 0, duration_s: store.state.logs[0].duration_s}];
  const {min, max} = store.range;
  const index = Math.max(0, logs.findIndex((log) => min < log.start_s + log.duration_s));
  const offset = logs[index].start_s;
  const begin = performance.now();
  try {
    const picture = await bytes('picture', {log: index, signal: 'force', from: min - offset, to: max - offset,
                                           points: Math.round(devicePixelRatio * (chartOf('force')?.u.width ?? 800))}, signal);
    picture.offset = offset;
    raw = picture;
    chartOf('force')?.redraw();
    performance.measure('zoom', {start: begin});
  } catch (error) {
    if (error.name !== 'AbortError') raw = null;
  }
}

function brushTime(low, high) {
  select(rowsWithin(store.rows.time_s, low, high));
}

export function showInterval(from, to) {
  const margin = 0.5 * (to - from);
  setRange(from - margin, to + margin);
  brushTime(from, to);
  byId('time-charts').scrollIntoView({block: 'nearest'});
}

export function drawTime() {
  const specs = timeSpecs();
  const host = byId('time-charts');
  const first = store.rows.time_s[0];
  const last = store.rows.time_s[store.rows.time_s.length - 1];
  const range = store.range ?? (store.range = {min: first, max: last});
  for (const [name, spec] of Object.entries(specs)) {
    const marked = name === 'residual' ? spec.series.length : 1;
    place(name, host, {
      ...spec, xRange: [range.min, range.max], whole: () => [first, last], onRange: setRange, onBrush: brushTime, onCursor: placeCursor,
      under: (u) => { if (name === 'force') drawRaw(u); if (name === 'residual') drawFloor(u); },
      over: (u) => { drawSelected(marked)(u); drawCursors(u); }});
  }
  if (!specs.residual) drop((key) => key === 'residual');
  // Residual between force and position, whenever it came.
  if (chartOf('residual')) host.insertBefore(chartOf('residual').host, chartOf('position').host);
  fetchRaw();
}

// The first picture, before anything is computed: the force as it was recorded.
export function drawRecorded() {
  const log = store.state.logs[0];
  if (store.rows || !log?.samples || !store.state.traces) return;
  const unit = displayUnit('N', 1);
  store.range ??= {min: 0, max: log.duration_s};
  place('force', byId('time-charts'), {
    title: `${forceWord()} over time, as recorded`, height: 230, x: kSeconds,
    y: {name: forceWord(), label: `${forceWord()} (${unit.label})`, unit: unit.label, perSi: unit.perSi}, series: [{name: 'recorded', role: 'curve8'}], data: [[0, log.duration_s], [null, null]],
    xRange: [store.range.min, store.range.max], whole: () => [0, log.duration_s], onRange: setRange,
    yExtent: () => (raw ? [raw.low.reduce((a, b) => Math.min(a, b)) * unit.perSi, raw.high.reduce((a, b) => Math.max(a, b)) * unit.perSi] : [-1, 1]), under: drawRaw});
  fetchRaw().then(() => chartOf('force')?.u.redraw());
}

export function forgetTime() {
  raw = null;
  store.range = null;
}
