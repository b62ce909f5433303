// SPDX-License-Identifier: Apache-2.0
// From the numbers of the page to descriptions of plots (see charts.js), in display units.

const report = JSON.parse(document.getElementById('report-data').textContent);

const nonEmpty = (array) => Array.isArray(array) && array.some((value) => value !== null);
const capital = (text) => text.slice(0, 1).toUpperCase() + text.slice(1);

// uPlot needs x rising and without nulls. Rows without x are removed; the line breaks where rows were removed.
function withoutNullX(xs, columns) {
  if (xs.every((x, i) => x !== null && (i === 0 || x > xs[i - 1]))) return [xs, ...columns];
  const out = [[], ...columns.map(() => [])];
  let last = -Infinity;
  xs.forEach((x, i) => {
    if (x === null || x <= last) {
      for (const column of out.slice(1)) if (column.length) column[column.length - 1] = null;
      return;
    }
    last = x;
    out[0].push(x);
    columns.forEach((column, k) => out[k + 1].push(column[i] ?? null));
  });
  return out;
}

function linePlot(xs, x, y, entries, more = {}) {
  const present = entries.filter((entry) => nonEmpty(entry.values));
  return {
    kind: 'line', x, y, data: withoutNullX(xs, present.map((entry) => entry.values)),
    series: present.map(({values, ...series}) => series), ...more,
  };
}

function floorLevel(force, both) {
  const floor = report.noise_floor_N;
  if (!(floor > 0)) return [];
  const value = floor * force.perSi;
  return [{name: `noise floor ${both ? '±' : ''}${Number(value.toPrecision(2))} ${force.label}`,
           role: 'floor', values: both ? [-value, value] : [value]}];
}

const thin = (values, role) => (values && values.length > 3000 && role === 'after' ? {dash: undefined, width: 1.25} : {});

function forcePlots(series) {
  const time = displayUnit('s', magnitude(series.time_s));
  const force = displayUnit('N', magnitude(series.measured_N, series.model_N));
  const left = displayUnit('N', magnitude(series.residual_N, series.after_N));
  const xs = scaled(series.time_s, time.perSi);
  const x = {label: `Time (${time.label})`, name: 'Time', unit: time.label};
  const value = (values, unit) => (nonEmpty(values) ? scaled(values, unit.perSi) : []);
  const frame = {gutter: 42, right: 62};
  const plots = [linePlot(xs, x, [{label: `${forceName()} (${force.label})`}], [
    {name: 'measured', role: 'measured', values: value(series.measured_N, force)},
    {name: 'modelled', role: 'before', values: value(series.model_N, force)},
  ], {...frame, height: 250, paperHeight: 185})];
  if (nonEmpty(series.residual_N) || nonEmpty(series.after_N)) {
    plots.push(linePlot(xs, x, [{label: `Residual (${left.label})`}], [
      {name: 'measured − modelled', role: 'before', values: value(series.residual_N, left)},
      {name: report.after_label, role: 'after', values: value(series.after_N, left), style: thin(series.after_N, 'after')},
    ], {...frame, height: 190, paperHeight: 145, levels: floorLevel(left, true)}));
  }
  if (nonEmpty(series.position_m) || nonEmpty(series.velocity_mps)) {
    const length = displayUnit('m', magnitude(series.position_m));
    const speed = displayUnit('m/s', magnitude(series.velocity_mps));
    const axes = [];
    if (nonEmpty(series.position_m)) axes.push({label: `Position (${length.label})`});
    if (nonEmpty(series.velocity_mps)) axes.push({label: `Velocity (${speed.label})`, side: axes.length ? 1 : 3});
    plots.push(linePlot(xs, x, axes, [
      {name: 'position', role: 'motion', values: value(series.position_m, length)},
      {name: 'velocity', role: 'velocity', axis: axes.length > 1 ? 'y2' : 'y', values: value(series.velocity_mps, speed)},
    ], {...frame, right: axes.length > 1 ? 3 : 62, height: 170, paperHeight: 125}));
  }
  const drawn = plots.filter((plot) => plot.series.length > 0);
  drawn.forEach((plot, i) => { plot.hideX = i + 1 < drawn.length; });
  return drawn;
}

function loopPlot(loop) {
  const length = displayUnit('m', magnitude(loop.displacement_m));
  const force = displayUnit('N', magnitude(loop.measured_N, loop.model_N));
  const xs = scaled(loop.displacement_m, length.perSi);
  const entries = [
    {name: 'measured', role: 'measured', values: loop.measured_N},
    {name: 'modelled', role: 'before', values: loop.model_N},
    {name: report.after_label, role: 'after', values: loop.after_N},
  ].filter((entry) => nonEmpty(entry.values));
  return {
    kind: 'xy', height: 330, paperHeight: 240, x: {label: `Displacement (${length.label})`, name: 'Displacement', unit: length.label},
    y: [{label: `${forceName()} (${force.label})`, unit: force.label}], data: [null, ...entries.map((entry) => [xs, scaled(entry.values, force.perSi)])],
    series: entries.map(({values, ...series}) => series),
  };
}

const sumOf = (a, b, sign) => a.map((value, i) => (value === null || b[i] === null || b[i] === undefined ? null : value + sign * b[i]));

function profilePlot(profile) {
  const along = displayUnit(profile.unit, magnitude(profile.x));
  const lines = [profile.mean_N, profile.after_mean_N, profile.forward_mean_N, profile.backward_mean_N, profile.expected_mean_N];
  const force = displayUnit('N', magnitude(...lines, profile.spread_N));
  const [mean, after, forward, backward, expected, spread] = [...lines, profile.spread_N].map((values) => (nonEmpty(values) ? scaled(values, force.perSi) : []));
  const name = capital(profile.coordinate || 'coordinate');
  const entries = [];
  if (mean.length && spread.length) {
    entries.push({name: 'upper', edge: true, role: 'before', band: 1, values: sumOf(mean, spread, 1)},
                 {name: 'lower', edge: true, role: 'before', values: sumOf(mean, spread, -1)});
  }
  entries.push({name: 'mean', role: 'before', style: {width: 1.75}, values: mean}, {name: 'forward', role: 'forward', values: forward},
               {name: 'backward', role: 'backward', values: backward}, {name: profile.expected_name || 'expected', role: 'curve7', style: {width: 1.75, dash: [8, 3, 2, 3]}, values: expected},
               {name: report.after_label, role: 'after', values: after});
  return linePlot(scaled(profile.x, along.perSi), {label: `${name} (${along.label})`, name, unit: along.label},
                  [{label: `Residual (${force.label})`}], entries, {height: 240, paperHeight: 185});
}

function spectrumPlot(spectrum) {
  const values = magnitude(spectrum.residual_N, spectrum.after_N);
  const density = displayUnit('N/√Hz', values);
  const positive = (array) => (nonEmpty(array) ? array.map((value) => (value > 0 ? value * density.perSi : null)) : []);
  const frequency = spectrum.frequency_Hz.map((value) => (value > 0 ? value : null));
  const floor = spectrum.floor_N > 0 ? [{name: 'noise floor', role: 'floor', values: [spectrum.floor_N * density.perSi]}] : [];
  return linePlot(frequency, {label: 'Frequency (Hz)', name: 'Frequency', unit: 'Hz', log: true},
                  [{label: `Residual density (${density.label})`, log: true}], [
    {name: 'residual', role: 'before', values: positive(spectrum.residual_N)},
    {name: report.after_label, role: 'after', values: positive(spectrum.after_N), style: thin(spectrum.after_N, 'after')},
  ], {height: 260, paperHeight: 200, levels: floor});
}

// A chart of an experiment: the data names its axes and curves, in display units.
function curvesPlot(chart) {
  const axis = (of) => ({label: of.unit ? `${of.name} (${of.unit})` : of.name, name: of.name, unit: of.unit, log: of.log});
  const style = (curve) => ({...(curve.dashed ? {dash: [5, 3]} : {})});
  const positive = (values, log) => (log ? values.map((value) => (value > 0 ? value : null)) : values);
  if (chart.orbit) {
    return {
      kind: 'xy', height: 330, paperHeight: 240, x: axis(chart.x_axis), y: [axis(chart.y_axis)],
      data: [null, ...chart.curves.map((curve) => [curve.x, curve.y])],
      series: chart.curves.map((curve) => ({name: curve.name, role: curve.role, style: style(curve)})),
    };
  }
  const entries = chart.curves.map((curve) => ({
    name: curve.name, role: curve.role, style: style(curve), values: positive(curve.y, chart.y_axis.log)}));
  return linePlot(positive(chart.x, chart.x_axis.log), axis(chart.x_axis), [axis(chart.y_axis)], entries, {height: 300, paperHeight: 220});
}

function plotsFor(figure) {
  const index = Number(figure.dataset.index);
  switch (figure.dataset.chart) {
    case 'force': return forcePlots(report.series);
    case 'loop': return [loopPlot(report.loops[index])];
    case 'profile': return [profilePlot(report.profiles[index])];
    case 'spectrum': return [spectrumPlot(report.spectrum)];
    case 'curves': return [curvesPlot(report.charts[index])];
    default: return [];
  }
}
