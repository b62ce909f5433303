// SPDX-License-Identifier: Apache-2.0
// The charts that are on the page, by name, and the samples that a brush marks in all of them.
import {Chart} from '/chart.js';
import {h} from '/dom.js';
import {store, tell} from '/store.js';

const shown = new Map();

export const chartOf = (key) => shown.get(key);
export const allCharts = () => [...shown.values()];
export const redrawAll = () => { for (const chart of shown.values()) chart.redraw(); };

// Draws a chart in `host`, or gives the one of this name new numbers.
export function place(key, host, spec) {
  const there = shown.get(key);
  if (there) { there.update(spec); return there; }
  const figure = h('figure', {class: 'chart', 'data-chart': key});
  host.append(figure);
  const chart = new Chart(figure, spec);
  shown.set(key, chart);
  return chart;
}

// Removes the charts whose names `unwanted` accepts.
export function drop(unwanted) {
  for (const [key, chart] of shown) {
    if (!unwanted(key)) continue;
    chart.remove();
    shown.delete(key);
  }
}

// Marks samples in all charts: one byte for each row, or null.
export function select(mask) {
  store.selected = mask && mask.some((one) => one) ? mask : null;
  redrawAll();
  tell('selected');
}

// The mask of the rows whose value lies within [low, high].
export function rowsWithin(values, low, high) {
  const mask = new Uint8Array(values.length);
  for (let i = 0; i < mask.length; ++i) mask[i] = values[i] >= low && values[i] <= high ? 1 : 0;
  return mask;
}

// --- units and numbers of charts ---

export const forceWord = () => (report.units ? 'Torque' : 'Force');

// The display unit that suits the largest of the values.
export const unitFor = (unit, ...arrays) => displayUnit(unit, magnitudeOf(...arrays));

function magnitudeOf(...arrays) {
  let largest = 0;
  for (const array of arrays) {
    if (!array) continue;
    for (const value of array) if (value !== null && Math.abs(value) > largest) largest = Math.abs(value);
  }
  return largest;
}

export function extentOf(values) {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}

// Draws within the box of a chart only.
export function clipped(u, draw) {
  const {ctx, bbox} = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  draw(ctx);
  ctx.restore();
}
