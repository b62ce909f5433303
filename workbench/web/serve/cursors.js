// SPDX-License-Identifier: Apache-2.0
// Two cursors over time: lines in the charts, values and differences in a table.
import {colour} from '/chart.js';
import {byId, h, quantity} from '/dom.js';
import {clipped, forceWord, redrawAll} from '/linked.js';
import {store} from '/store.js';

export function drawCursors(u) {
  const {bbox} = u;
  clipped(u, (ctx) => {
    ctx.font = `${11 * devicePixelRatio}px sans-serif`;
    ctx.textAlign = 'left';
    ctx.lineWidth = devicePixelRatio;
    ctx.strokeStyle = ctx.fillStyle = colour('ink');
    store.cursors.forEach((at, i) => {
      const x = u.valToPos(at, 'x', true);
      ctx.setLineDash(i === 0 ? [] : [4 * devicePixelRatio, 3 * devicePixelRatio]);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      ctx.fillText('AB'[i], x + 3 * devicePixelRatio, bbox.top + 11 * devicePixelRatio);
    });
  });
}

export function placeCursor(at) {
  store.cursors = store.cursors.length >= 2 ? [at] : [...store.cursors, at];
  redrawAll();
  showCursors();
}

export function clearCursors() {
  store.cursors = [];
  redrawAll();
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

export function showCursors() {
  const host = byId('cursors');
  host.hidden = store.cursors.length === 0 || !store.rows;
  if (host.hidden) return;
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
