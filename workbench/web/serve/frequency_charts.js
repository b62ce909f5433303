// SPDX-License-Identifier: Apache-2.0
// What the residual looks like over frequency and lag: its density, the share that follows the motion, its memory, and
// the response of the axis beside that of the model.
import {place, unitFor} from '/linked.js';
import {store} from '/store.js';

const kHertz = {name: 'Frequency', label: 'Frequency (Hz)', unit: 'Hz', log: true};

const given = (values, factor = 1) => values.map((value) => (value === null ? null : value * factor));
const positive = (values, factor) => values.map((value) => (value > 0 ? value * factor : null));

// The lines of one or two models: before and now, or the residual of the only one.
function lines(found, key, form) {
  return store.beside ? [{name: 'before', role: 'before', values: form(found[key])}, {name: 'now', role: 'after', values: form(found.after)}]
                      : [{name: key, role: 'after', values: form(found[key])}];
}

const spec = (title, x, y, xs, series) => ({title, height: 220, x, y, series: series.map(({values, ...rest}) => rest), data: [xs, ...series.map(({values}) => values)]});

function densitySpec() {
  const found = store.charts.spectrum;
  const density = unitFor('N/√Hz', found.residual_N);
  const series = lines({residual: found.residual_N, after: found.after_N}, 'residual', (values) => positive(values, density.perSi));
  series.push({name: 'noise floor', role: 'floor', dash: [4, 3], values: found.frequency_Hz.map(() => found.floor_N * density.perSi)});
  return spec('Residual against frequency', kHertz, {name: 'Density', label: `Residual density (${density.label})`, unit: density.label, log: true}, found.frequency_Hz, series);
}

function coherenceSpec() {
  const found = store.charts.coherence;
  const series = lines(found, 'residual', given);
  series.push({name: 'by chance (95 %)', role: 'floor', dash: [4, 3], values: found.frequency_Hz.map(() => found.chance)});
  return {...spec('Coherence of the residual with the motion', kHertz, {name: 'Coherence', label: 'Coherence (share of power)', unit: ''}, found.frequency_Hz, series), yExtent: () => [0, 1]};
}

function memorySpec() {
  const found = store.charts.autocorrelation;
  const lag = unitFor('s', found.lag_s);
  const series = lines(found, 'residual', given);
  series.push({name: 'filtered white noise', role: 'floor', dash: [4, 3], values: given(found.white)});
  return {...spec('Autocorrelation of the residual', {name: 'Lag', label: `Lag (${lag.label})`, unit: lag.label}, {name: 'Correlation', label: 'Correlation (1 at lag 0)', unit: ''},
    given(found.lag_s, lag.perSi), series), yExtent: () => [-1, 1]};
}

function responseSpecs() {
  const found = store.charts.response;
  const unit = report.units ? '1/(kg·m²)' : '1/kg';
  const force = report.units ? 'torque' : 'force';
  const series = (key, factor) => [{name: 'measured', role: 'measured', width: 2, values: given(found.measured[key], factor)},
    ...(store.beside ? [{name: 'modelled before', role: 'before', values: given(found.model[key], factor)}, {name: 'modelled', role: 'after', values: given(found.after[key], factor)}]
                     : [{name: 'modelled', role: 'after', values: given(found.model[key], factor)}])];
  const phases = series('phase_rad', 180 / Math.PI);
  const largest = Math.max(45, ...phases.flatMap(({values}) => values.map(Math.abs)));
  return {
    'response size': spec(`Acceleration over ${force}`, kHertz, {name: 'Gain', label: `Acceleration over ${force} (${unit})`, unit, log: true}, found.frequency_Hz, series('gain', 1)),
    'response phase': {...spec(`Phase of acceleration over ${force}`, kHertz, {name: 'Phase', label: 'Phase (°)', unit: '°'}, found.frequency_Hz, phases), yExtent: () => [-largest, largest]},
  };
}

export function drawFrequency(host) {
  const {coherence, autocorrelation, response} = store.charts;
  place('density', host, densitySpec());
  if (coherence) place('coherence', host, coherenceSpec());
  if (autocorrelation) place('memory', host, memorySpec());
  if (response) for (const [key, one] of Object.entries(responseSpecs())) place(key, host, one);
}
