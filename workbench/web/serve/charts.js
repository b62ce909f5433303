// SPDX-License-Identifier: Apache-2.0
// Which charts are on the page, and when they are drawn anew. A brush in one shows the same samples in all.
import {drawAgainst} from '/against_charts.js';
import {showCursors} from '/cursors.js';
import {byId} from '/dom.js';
import {drawFrequency} from '/frequency_charts.js';
import {allCharts, chartOf, drop} from '/linked.js';
import {drawLoops} from '/loop_charts.js';
import {on, store, tell} from '/store.js';
import {drawRecorded, drawTime, forgetTime, kTimeCharts} from '/time_charts.js';

const kPaperWidth = 680;  // pixels of CSS: A4 less margins of 15 mm
const kPaperGap = 20;

export function forgetCharts() {
  drop(() => true);
  forgetTime();
  store.cursors = [];
  store.selected = null;
  showCursors();
  tell('selected');
  byId('against').hidden = true;
}

function draw() {
  if (!store.rows) return;
  if (chartOf('force') && !chartOf('position')) forgetCharts();  // the first picture has other axes
  drawTime();
  showCursors();
  const host = byId('against-charts');
  byId('against').hidden = !store.current;
  if (!store.current) { drop((key) => !kTimeCharts.includes(key)); return; }
  drawAgainst(host);
  if (!store.charts || store.bent) return;
  drawFrequency(host);
  drawLoops(host);
}

// On paper: the colours of paper, one chart over time a line, two of the others.
function drawOnPaper() {
  document.documentElement.classList.add('printing');
  for (const chart of allCharts()) chart.print(chart.host.closest('#against-charts') ? (kPaperWidth - kPaperGap) / 2 : kPaperWidth);
}

function drawOnScreen() {
  document.documentElement.classList.remove('printing');
  for (const chart of allCharts()) { chart.resize(); chart.redraw(); }
}

export function startCharts() {
  addEventListener('beforeprint', drawOnPaper);
  addEventListener('afterprint', drawOnScreen);
  on('recorded', drawRecorded);
  on('model', draw);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { for (const chart of allCharts()) chart.u.redraw(); });
}
