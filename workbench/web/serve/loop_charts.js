// SPDX-License-Identifier: Apache-2.0
// Pre-sliding loops: force over the displacement from the middle of the loop.
import {colour, padded} from '/chart.js';
import {clipped, extentOf, forceWord, place, unitFor} from '/linked.js';
import {store} from '/store.js';

// A loop has no rising x: it is drawn as a path above an empty chart of the same scales.
function loopSpec(loop) {
  const along = unitFor('m', loop.displacement_m);
  const force = unitFor('N', loop.measured_N);
  const [low, high] = extentOf(loop.displacement_m);
  const [f0, f1] = extentOf(loop.measured_N);
  const lines = [['measured', 'measured', 2, loop.measured_N], ...(store.beside ? [['modelled before', 'before', 1.25, loop.model_N], ['modelled', 'after', 1.5, loop.after_N]] : [['modelled', 'after', 1.5, loop.model_N]])];
  const path = (u, values, i) => [u.valToPos(loop.displacement_m[i] * along.perSi, 'x', true), u.valToPos(values[i] * force.perSi, 'y', true)];
  const marked = (u, ctx) => {
    if (!store.selected || !u.series[1].show) return;
    const size = 3 * devicePixelRatio;
    ctx.fillStyle = colour('curve5');
    loop.measured_N.forEach((value, i) => {
      if (value === null || !store.selected[loop.first_row + i]) return;
      const [x, y] = path(u, loop.measured_N, i);
      ctx.fillRect(x - size / 2, y - size / 2, size, size);
    });
  };
  return {
    title: loop.title, height: 240, x: {name: 'Displacement', label: `Displacement (${along.label})`, unit: along.label},
    y: {name: forceWord(), label: `${forceWord()} (${force.label})`, unit: force.label},
    series: lines.map(([name, role, width]) => ({name, role, width})), data: [[low * along.perSi, high * along.perSi], ...lines.map(() => [null, null])],
    rows: () => loop.displacement_m.map((value, i) => [value * along.perSi, ...lines.map(([, , , values]) => values[i] * force.perSi)]),
    xRange: padded(low * along.perSi, high * along.perSi), whole: () => padded(low * along.perSi, high * along.perSi), yExtent: () => [f0 * force.perSi, f1 * force.perSi],
    over: (u) => clipped(u, (ctx) => {
      lines.forEach(([, role, width, values], k) => {
        if (!values || !u.series[k + 1].show) return;
        ctx.beginPath();
        values.forEach((_, i) => ctx[i ? 'lineTo' : 'moveTo'](...path(u, values, i)));
        ctx.strokeStyle = colour(role);
        ctx.lineWidth = width * devicePixelRatio;
        ctx.stroke();
      });
      marked(u, ctx);
    }),
  };
}

export function drawLoops(host) {
  for (const loop of store.charts.loops) place(`loop ${loop.title}`, host, loopSpec(loop));
}
