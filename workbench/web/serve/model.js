// SPDX-License-Identifier: Apache-2.0
// The model that is worked on: its falling error, its effects and what each is worth, parameters to bend by hand.
import {catalogue, get, post, postForBytes} from '/api.js';
import {attempt, byId, fill, h, percent, quantity, readable, sentence, shortTitle, span} from '/dom.js';
import {waterfall} from '/figures.js';
import {currentVersion, lineage, on, shownVersion, store, tell} from '/store.js';
import {showInterval} from '/time_charts.js';

let changes = new Map();  // by effect, kind and index: {effect, kind, index, value}
let adjustable = [];
let asking = false;
let again = false;

const key = (one) => `${one.effect} ${one.kind} ${one.index}`;

function pick(id) { return id > 0 ? attempt(() => post('select', {version: id})) : undefined; }

function remove(effect) {
  store.asked = performance.now();
  return attempt(() => post('remove', {effect}));
}

function drawWaterfall() {
  const host = byId('waterfall');
  const version = shownVersion();
  if (!version) { host.replaceChildren(); return; }
  const steps = lineage(version).map((one) => ({id: one.id, what: one.parent ? one.what.replaceAll('_', ' ') : one.effects.map((id) => id.replaceAll('_', ' ')).join(', '), error: one.after_N, now: one.id === version.id}));
  const first = steps[0].error;
  fill(host, h('h2', {}, 'The error'),
    h('p', {class: 'figure'}, h('b', {}, quantity(version.after_N, 'N')), ` on unseen data, ${(version.after_N / version.floor_N).toPrecision(3)} times the noise floor`,
      steps.length > 1 ? `; ${(first / version.after_N).toPrecision(3)} times less than at first` : ''),
    version.note ? h('p', {class: 'soft', id: 'first-answer'}, sentence(version.note)) : null,
    waterfall(steps, version.floor_N, pick));
}

async function drawEffects() {
  const host = byId('effects');
  const version = shownVersion();
  if (!version) { host.replaceChildren(); return; }
  const parameters = store.current?.header.parameters ?? [];
  const title = (id) => parameters.find((one) => one.effect === id)?.title ?? readable(id);
  const worth = version.note ? null : await get('worth', {version: version.id}).catch(() => null);
  if (shownVersion()?.id !== version.id) return;
  const without = (id) => worth?.effects.find((one) => one.effect === id)?.without_N;
  host.replaceChildren(h('h2', {}, 'Its effects'), h('ul', {class: 'effects'}, version.effects.map((id) => {
    const error = without(id);
    return h('li', {}, h('div', {class: 'row'}, h('b', {}, title(id)),
      h('button', {type: 'button', class: 'small', 'data-job': true, disabled: version.effects.length < 2, 'aria-label': `Remove ${title(id)}`,
                   onclick: () => remove(id)}, 'Remove')),
    h('p', {class: 'soft'}, error ? `without it ${quantity(error, 'N')} instead of ${quantity(worth.with_N, 'N')}` : ''),
    h('details', {}, h('summary', {}, 'Parameters'), parameterList(parameters.find((one) => one.effect === id))));
  })));
}

function parameterList(effect) {
  if (!effect) return '';
  return h('div', {}, h('p', {class: 'soft formula'}, effect.formula), h('table', {}, h('tbody', {}, effect.parameters.map((one) =>
    h('tr', {}, h('th', {scope: 'row'}, one.name.replaceAll('_', ' ')), h('td', {}, quantity(one.value, one.unit, 4)),
      h('td', {class: 'soft'}, one.standard_error ? `± ${quantity(one.standard_error, one.unit, 2)}` : one.note))))));
}

function drawWorst() {
  const host = byId('worst');
  const worst = store.current?.header.worst;
  if (!worst?.length) { host.replaceChildren(); return; }
  const unit = displayUnit('N', Math.min(...worst.map((one) => one.rmse_N)));
  host.replaceChildren(h('h2', {}, 'Where it fails most'), h('ol', {class: 'worst'}, worst.map((one) => h('li', {},
    h('button', {type: 'button', onclick: () => showInterval(one.from_s, one.to_s)},
      h('b', {}, `${Number((one.rmse_N * unit.perSi).toPrecision(3))}\u00a0${unit.label}`), h('span', {}, span(one.from_s, one.to_s, 's')),
      h('span', {class: 'soft'}, `${span(one.low_m, one.high_m, 'm')}, up to ${quantity(one.fastest_mps, 'm/s')}`))))),
  h('p', {class: 'soft'}, sentence(`In the whole log, ${store.current.header.left}`)));
}

// --- parameters by hand ---

function scaleOf(one) {
  const value = one.value;
  if (one.kind === 'factor') return {low: 0, high: 2, log: false};
  if (one.kind === 'shape') {
    const low = one.lower ?? 0;
    const high = one.upper ?? 10 * Math.abs(value || 1);
    return low > 0 && high / low > 20 ? {low: Math.max(low, value / 100), high: Math.min(high, value * 100), log: true} : {low, high, log: false};
  }
  const reach = 2.5 * Math.abs(value || 1);
  return {low: Math.max(one.lower ?? -reach, value < 0 ? -reach : 0), high: Math.min(one.upper ?? reach, value < 0 ? 0 : reach), log: false};
}

const toShare = (value, scale) => (scale.log ? Math.log(value / scale.low) / Math.log(scale.high / scale.low) : (value - scale.low) / (scale.high - scale.low || 1));
const fromShare = (share, scale) => (scale.log ? scale.low * (scale.high / scale.low) ** share : scale.low + share * (scale.high - scale.low));

function slider(one, index) {
  const scale = scaleOf(one);
  const id = `slider-${index}`;
  const text = (value) => (one.kind === 'factor' ? `× ${value.toFixed(2)}` : quantity(value, one.unit, 4));
  const output = h('output', {for: id}, text(one.value));
  const input = h('input', {type: 'range', id, min: '0', max: '1000', step: '1', value: String(Math.round(1000 * toShare(one.value, scale))), 'data-effect': one.effect, 'data-kind': one.kind,
    oninput: () => {
      const value = fromShare(Number(input.value) / 1000, scale);
      output.textContent = text(value);
      input.setAttribute('aria-valuetext', text(value));
      changes.set(key(one), {effect: one.effect, kind: one.kind, index: one.index, value});
      bend();
    }});
  input.setAttribute('aria-valuetext', text(one.value));
  return h('div', {class: 'slider'}, h('label', {for: id}, h('span', {class: 'unseen'}, `${one.title}: `), `${readable(one.name)}${one.count ? ` (all ${one.count} together)` : ''}`), output, input);
}

async function drawSliders() {
  const host = byId('sliders');
  const version = currentVersion();
  changes = new Map();
  if (!version || shownVersion().note) { host.replaceChildren(); return; }
  adjustable = await get('adjustable', {version: version.id}).catch(() => []);
  if (currentVersion()?.id !== version.id) return;
  host.replaceChildren(h('h2', {}, 'By hand'), h('p', {class: 'soft', id: 'bent-error'}, 'Move a parameter; the charts follow.'),
    h('div', {class: 'sliders'}, adjustable.map((one, i) => [i === 0 || adjustable[i - 1].effect !== one.effect ? h('h3', {}, shortTitle(one.title)) : null, slider(one, i)]).flat()),
    h('div', {class: 'buttons'}, h('button', {type: 'button', id: 'bent-reset', disabled: true, onclick: forget}, 'Back to the fit'),
      h('button', {type: 'button', id: 'bent-keep', 'data-job': true, disabled: true, onclick: () => attempt(() => post('keep', {version: version.id, changes: [...changes.values()]}))}, 'Keep as a version')));
}

function forget() {
  store.bent = null;
  drawSliders();
  tell('model');
}

// One question at a time; the latest wins.
async function bend() {
  if (asking) { again = true; return; }
  asking = true;
  do {
    again = false;
    const begin = performance.now();
    const version = currentVersion();
    const answer = await attempt(() => postForBytes('bent', {version: version.id, changes: [...changes.values()]}));
    if (!answer || currentVersion()?.id !== version.id) break;
    store.bent = answer;
    tell('model');
    performance.measure('slide', {start: begin});
    byId('bent-error').textContent = `Error ${quantity(answer.header.rmse_N, 'N')} set by hand, ${quantity(store.current.header.rmse_N, 'N')} as fitted (${percent(answer.header.rmse_N / store.current.header.rmse_N - 1)} more).`;
    byId('bent-reset').disabled = byId('bent-keep').disabled = false;
  } while (again);
  asking = false;
}

// --- the first model ---

async function drawFirst() {
  const host = byId('first');
  const wanted = store.state && store.state.logs.length > 0 && store.state.versions.length === 0;
  host.hidden = !wanted;
  if (!wanted) return;
  const effects = await catalogue();
  if (host.childElementCount > 0) return;
  const chosen = new Set(store.state.default_effects);
  host.replaceChildren(h('h2', {}, 'A first model'), h('p', {}, 'Fit what every axis has. What else it has, the residual will say.'),
    h('fieldset', {}, h('legend', {}, 'Effects'), effects.map((effect) => h('label', {class: 'chip', title: effect.formula},
      h('input', {type: 'checkbox', value: effect.id, checked: chosen.has(effect.id),
                  onchange: (event) => (event.currentTarget.checked ? chosen.add(effect.id) : chosen.delete(effect.id))}), effect.title))),
    h('div', {class: 'buttons'}, h('button', {type: 'button', class: 'main', id: 'fit', 'data-job': true, onclick: () => attempt(() => post('fit', {effects: [...chosen]}))}, 'Fit this model')));
}

export function startModel() {
  on('state', drawFirst);
  on('version', () => { drawWaterfall(); drawEffects(); drawSliders(); });
  on('model', drawWorst);
}
