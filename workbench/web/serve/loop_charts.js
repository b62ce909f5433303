// SPDX-License-Identifier: Apache-2.0
// Pre-sliding loops: force over the displacement from the middle of the loop. Their points lie closer than the rows do; row[i] is
// the row that is nearest to point i.
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
      if (value === null || !store.selected[loop.row[i]]) return;
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

// The equivalent damping ratio at resonance over the amplitude of the loop.
function dampingSpec() {
  const found = store.charts.damping;
  const along = unitFor('m', found.amplitude_m);
  const percents = (values) => values.map((value) => 100 * value);
  const series = [{name: 'measured', role: 'measured', width: 2, points: true, values: percents(found.measured)},
    ...(store.beside ? [{name: 'modelled before', role: 'before', points: true, values: percents(found.model)}, {name: 'modelled', role: 'after', points: true, values: percents(found.after)}]
                     : [{name: 'modelled', role: 'after', points: true, values: percents(found.model)}])];
  const first = found.amplitude_m[0] * along.perSi;
  const last = found.amplitude_m[found.amplitude_m.length - 1] * along.perSi;
  const range = [first / 1.1, last * 1.1];
  return {
    title: 'Damping ratio of the loops', height: 240, x: {name: 'Amplitude', label: `Amplitude of the loop (${along.label})`, unit: along.label, log: true},
    y: {name: 'Damping ratio', label: 'Damping ratio ζᵣ (%)', unit: '%'}, series: series.map(({values, ...rest}) => rest),
    data: [found.amplitude_m.map((value) => value * along.perSi), ...series.map(({values}) => values)],
    xRange: range, whole: () => range, yExtent: () => [0, extentOf(series.flatMap(({values}) => values))[1]],
    over: (u) => clipped(u, (ctx) => {
      // One standard deviation of the loops that were averaged, each way.
      if (!u.series[1].show) return;
      ctx.strokeStyle = colour('measured');
      ctx.lineWidth = devicePixelRatio;
      found.deviation.forEach((deviation, i) => {
        const x = u.valToPos(found.amplitude_m[i] * along.perSi, 'x', true);
        ctx.beginPath();
        for (const [sign, act] of [[-1, 'moveTo'], [1, 'lineTo']]) ctx[act](x, u.valToPos(100 * (found.measured[i] + sign * deviation), 'y', true));
        ctx.stroke();
      });
    }),
  };
}

export function drawLoops(host) {
  if (store.charts.damping) place('damping', host, dampingSpec());
  for (const loop of store.charts.loops) place(`loop ${loop.title}`, host, loopSpec(loop));
}
