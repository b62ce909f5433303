// SPDX-License-Identifier: Apache-2.0
// Display units and number texts of the charts; workbench/base/quantity.cpp does the same for the tables.

const kSteps = {
  'N': [[1e4, 1e-3, 'kN'], [0.1, 1, 'N'], [1e-4, 1e3, 'mN'], [0, 1e6, 'µN']],
  'm': [[10, 1, 'm'], [1e-3, 1e3, 'mm'], [1e-6, 1e6, 'µm'], [0, 1e9, 'nm']],
  'm/s': [[10, 1, 'm/s'], [1e-3, 1e3, 'mm/s'], [0, 1e6, 'µm/s']],
  'm/s²': [[0.1, 1, 'm/s²'], [0, 1e3, 'mm/s²']],
  's': [[1, 1, 's'], [1e-3, 1e3, 'ms'], [0, 1e6, 'µs']],
  'N/√Hz': [[0.01, 1, 'N/√Hz'], [0, 1e3, 'mN/√Hz']],
};
// A rotary axis has other units in the places of these: the page gives them.
const kSpellings = {'m/s^2': 'm/s²', 'm/s2': 'm/s²'};

// The unit for values up to `magnitude` (SI), and the factor that takes SI values into it.
function displayUnit(siUnit, magnitude) {
  const unit = kSpellings[siUnit] ?? siUnit ?? '';
  const steps = (report.units ?? kSteps)[unit] ?? kSteps[unit];
  if (!steps) return {perSi: 1, label: unit};
  const [, perSi, label] = steps.find(([smallest]) => (magnitude > 0 ? magnitude : 1) >= smallest);
  return {perSi, label};
}

// Largest absolute value over several arrays that may hold nulls.
function magnitude(...arrays) {
  let largest = 0;
  for (const array of arrays) {
    if (!array) continue;
    for (const value of array) {
      if (value !== null && Math.abs(value) > largest) largest = Math.abs(value);
    }
  }
  return largest;
}

const forceName = () => (report.units ? 'Torque' : 'Force');

const scaled = (array, factor) => array && array.map((value) => (value === null ? null : value * factor));

const withMinus = (text) => text.replace('-', '\u2212');

// Tick text: as many decimals as the distance between ticks has, the same on all ticks.
function tickText(value, increment) {
  const [, fraction = '', exponent = '0'] = /^\d\.?(\d*)e([+-]\d+)$/.exec(Number(increment.toPrecision(6)).toExponential());
  const text = value.toFixed(Math.min(12, Math.max(0, fraction.length - Number(exponent))));
  return withMinus(Number(text) === 0 ? text.replace('-', '') : text);
}

// Tick text on a logarithmic axis: 0.01, 0.1, 1, 10, …
const logTickText = (value) => (value === null ? '' : String(Number(value.toPrecision(3))));

// Value under the cursor, four significant digits.
function readout(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '\u2013';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-4) return withMinus(value.toExponential(3));
  return withMinus(value.toFixed(Math.max(0, 3 - Math.floor(Math.log10(size)))));
}
