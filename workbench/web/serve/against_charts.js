// SPDX-License-Identifier: Apache-2.0
// The residual against what it may depend on: a cloud of samples, the mean, and what a candidate would leave.
import {colour, padded} from '/chart.js';
import {clipped, extentOf, place, rowsWithin, select, unitFor} from '/linked.js';
import {store} from '/store.js';

const kScatter = 9000;  // points of a cloud at most; more only hide each other
const kBins = 60;       // of means that the page forms itself
const kCoordinates = [['position', 'position_m', 'm'], ['velocity', 'velocity_mps', 'm/s'], ['acceleration', 'acceleration_mps2', 'm/s²'], ['time since reversal', 'since_reversal_s', 's']];

// Largest size of the residuals but for the 0.2 % of outliers.
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

// Where the server has no means: of a residual set by hand, and over the time since the reversal.
function meansOf(coordinate, residual, low, high, before) {
  const x = Array.from({length: kBins}, (_, i) => low + (i + 0.5) / kBins * (high - low));
  const line = (values) => {
    const sum = new Float64Array(kBins);
    const count = new Float64Array(kBins);
    for (let i = 0; i < values.length; ++i) {
      if (Number.isNaN(values[i])) continue;
      const bin = Math.min(kBins - 1, Math.max(0, Math.floor((coordinate[i] - low) / (high - low) * kBins)));
      sum[bin] += values[i];
      count[bin] += 1;
    }
    return Array.from(sum, (value, i) => (count[i] < 3 ? null : value / count[i]));
  };
  return {x, lines: [{name: 'mean', role: 'after', width: 2, values: line(residual)},
    ...(before ? [{name: 'mean before', role: 'before', width: 1.5, values: line(before)}] : [])]};
}

function drawCloud(u, xs, xPerSi, ys, yPerSi) {
  const {bbox} = u;
  const size = 1.5 * devicePixelRatio;
  const step = Math.max(1, Math.ceil(xs.length / kScatter));
  const {min: x0, max: x1} = u.scales.x;
  const {min: y0, max: y1} = u.scales.y;
  const sx = bbox.width / (x1 - x0) * xPerSi;
  const sy = bbox.height / (y1 - y0) * yPerSi;
  const bx = bbox.left - x0 / xPerSi * sx;
  const by = bbox.top + bbox.height + y0 / yPerSi * sy;
  clipped(u, (ctx) => {
    const dots = (chosen, fill, alpha, every, side) => {
      ctx.fillStyle = fill;
      ctx.globalAlpha = alpha;
      for (let i = 0; i < xs.length; i += every) {
        if (Number.isNaN(ys[i]) || (chosen && !chosen[i])) continue;
        ctx.fillRect(bx + xs[i] * sx - side / 2, by - ys[i] * sy - side / 2, side, side);
      }
    };
    dots(null, colour('measured'), store.selected ? 0.18 : 0.35, step, size);
    if (store.selected) dots(store.selected, colour('curve5'), 0.9, 1, 2 * size);
  });
}

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
  const word = name.replace(/^./, (first) => first.toUpperCase());
  return {
    title: `Residual against ${name}`, height: 220, x: {name: word, label: `${word} (${along.label})`, unit: along.label},
    y: {name: 'Residual', label: `Residual (${left.label})`, unit: left.label, perSi: left.perSi}, series: means.lines.map(({values, ...rest}) => rest),
    data: [means.x.map((value) => value * along.perSi), ...means.lines.map(({values}) => means.x.map((_, i) => (values?.[i] === null || values?.[i] === undefined ? null : values[i] * left.perSi)))],
    whole: () => [low * along.perSi, high * along.perSi], xRange: padded(low * along.perSi, high * along.perSi),
    // Without the line of the model before, the scale is that of what is left now.
    yExtent: (u) => { const limit = 1.05 * robustLimit(residual, u.series[2]?.show ? beside?.residual_N : null) * left.perSi; return [-limit, limit]; },
    under: (u) => drawCloud(u, rows[key], along.perSi, residual, left.perSi),
    onBrush: (from, to) => select(rowsWithin(rows[key], from / along.perSi, to / along.perSi)),
  };
}

export function drawAgainst(host) {
  for (const coordinate of kCoordinates) {
    const profile = store.bent ? null : store.charts?.profiles.find((one) => one.coordinate === coordinate[0]);
    place(`against ${coordinate[0]}`, host, againstSpec(coordinate, profile ?? null));
  }
}
