// SPDX-License-Identifier: Apache-2.0
// Plan the next experiment, run it, deploy the model.
import {catalogue, get, post} from '/api.js';
import {Chart} from '/chart.js';
import {attempt, byId, dialog, fill, h, quantity, readable, say, sentence, shortTitle, span} from '/dom.js';
import {ifTheWayIsFree, liveName} from '/live.js';
import {currentVersion, on, store} from '/store.js';

let setPoints = null;
let tracking = null;
let effects = [];        // of the catalogue
let wanted = null;       // ids of the effects to show; null: those that the diagnosis asks for
const kept = new Map();  // what was typed, while the panel is drawn anew

function field(id, attributes, otherwise = '') {
  const input = h('input', {id, spellcheck: 'false', value: kept.get(id) ?? otherwise, ...attributes, oninput: () => kept.set(id, input.value)});
  return input;
}

function planForm() {
  const chosen = wanted ?? new Set(store.state.diagnosis?.next_experiment?.for ?? []);
  const chips = effects.map((effect) => h('label', {class: 'chip', title: effect.formula},
    h('input', {type: 'checkbox', value: effect.id, checked: chosen.has(effect.id),
                onchange: (event) => { wanted = chosen; if (event.currentTarget.checked) chosen.add(effect.id); else chosen.delete(effect.id); }}), shortTitle(effect.title)));
  const plan = () => {
    if (!chosen.size) { say('Choose at least one effect that the experiment is to show.'); return; }
    attempt(() => post('plan', {for: [...chosen].join(','), seconds: Number(seconds.value), limits: limits.value}));
  };
  const seconds = field('plan-seconds', {type: 'number', min: '5', max: '3600'}, '30');
  const limits = field('plan-limits', {type: 'text', placeholder: 'as in the log; or stroke=0.02:0.38,velocity=0.5'});
  return h('section', {}, h('h2', {}, 'Plan'), h('p', {}, 'The motion that tells effects apart, within what the axis may do.'),
    h('fieldset', {id: 'plan-for'}, h('legend', {}, 'Effects to show and to tell apart'), chips),
    h('div', {class: 'form'}, h('label', {for: 'plan-seconds'}, 'Longest duration (s)'), seconds,
      h('label', {for: 'plan-limits'}, 'Limits'), limits),
    h('div', {class: 'buttons'}, h('button', {type: 'button', class: 'main', id: 'plan', 'data-job': true, onclick: plan}, 'Plan the experiment')));
}

// A plan beside what the axis behind the live controller may do; it is run where it fits and the user says that the way is
// free.
async function runOnController() {
  const {live, logs} = store.state;
  const found = await get('live/plan');
  const limits = h('table', {id: 'plan-limits-table'}, h('caption', {}, 'The plan against the limits of the axis'),
    h('thead', {}, h('tr', {}, ['Quantity', 'Plan', 'Axis', 'Its limit is from'].map((text) => h('th', {scope: 'col'}, text)))),
    h('tbody', {}, found.limits.map((one) => h('tr', {class: one.fits ? undefined : 'warn'}, h('th', {scope: 'row'}, readable(one.quantity)),
      h('td', {}, quantity(one.planned, one.unit)), h('td', {}, one.allowed === null ? 'not limited' : quantity(one.allowed, one.unit)), h('td', {}, `${one.source}${one.fits ? '' : ': does not fit'}`)))));
  if (found.refused) {
    await dialog('The plan cannot be run on this axis', h('div', {}, h('p', {class: 'warn', id: 'plan-refused'}, sentence(found.refused)), limits));
    return;
  }
  const others = logs.filter((log) => log.sample_rate_Hz && Math.abs(log.sample_rate_Hz / found.rate_Hz - 1) > 1e-3);
  const answer = await dialog('Is the way free?', h('div', {}, limits,
    h('p', {}, `The axis of ${liveName(live)} will be enabled, move from ${quantity(found.now_m, 'm')} to ${quantity(found.begin_m, 'm')}, and follow the plan for ${quantity(found.duration_s, 's')} between ${span(found.low_m, found.high_m, 'm')}. Nobody may stand in its way. Esc stops it.`),
    h('p', {}, 'Its SYNC and PDOs are used meanwhile, and are afterwards as the drive has them stored.'),
    others.length ? h('p', {class: 'warn'}, `The log will have ${quantity(found.rate_Hz, 'Hz')}, and ${others.map((log) => log.name).join(', ')} ${quantity(others[0].sample_rate_Hz, 'Hz')}: one model is fitted to logs of one rate, so the open logs are closed. They stay where they are.`) : null),
  [{label: 'Cancel', value: ''}, {label: 'The way is free: run it', value: 'run', main: true}]);
  if (answer === 'run') await post('live/run', {alone: others.length > 0});
}

function planned() {
  const {plan, live} = store.state;
  if (!plan) return null;
  const runsLive = live?.state === 'live';
  const figure = h('figure', {class: 'chart'});
  const section = h('section', {id: 'planned'}, h('h3', {}, plan.headline.replaceAll('_', ' ')), plan.detail ? h('p', {}, plan.detail) : null, figure,
    h('details', {}, h('summary', {}, 'Limits, evidence, segments'), h('pre', {tabindex: 0}, plan.text)),
    h('div', {class: 'buttons'}, store.state.simulated ? h('button', {type: 'button', class: 'main', id: 'run-plan', 'data-job': true, onclick: () => attempt(() => post('run'))}, 'Run it on the simulated axis') : null,
    runsLive ? h('button', {type: 'button', class: store.state.simulated ? '' : 'main', id: 'run-live', 'data-job': true, onclick: () => attempt(runOnController)}, `Run it on ${liveName(live)} …`) : null),
    runsLive ? null : h('p', {class: 'soft'}, live ? 'The controller is lost; when it is there again, the plan can be run on it.' : 'Connect to a controller (key c) to run it there: the log joins the others. The set points are in plan.csv of the session folder too.'));
  const chart = plan.charts[0];
  queueMicrotask(() => {
    setPoints = new Chart(figure, {title: chart.title, height: 160, x: {name: chart.x_axis.name, label: `${chart.x_axis.name} (${chart.x_axis.unit})`, unit: chart.x_axis.unit},
      y: {name: chart.y_axis.name, label: `${chart.y_axis.name} (${chart.y_axis.unit})`, unit: chart.y_axis.unit}, series: [{name: 'set points', role: 'after'}], data: [chart.x, chart.curves[0].y],
      xRange: [chart.x[0], chart.x[chart.x.length - 1]]});
  });
  return section;
}

async function compareWithDrive(bus, node, host) {
  const version = currentVersion();
  const answer = await attempt(() => get('controller', {version: version.id, bus, node}));
  if (!answer) return;
  const rows = answer.differences;
  fill(host, h('h3', {}, rows.length ? `${rows.length} parameters would change` : 'The controller has this model already'),
    rows.length ? h('div', {class: 'scroll', tabindex: 0}, h('table', {}, h('thead', {}, h('tr', {}, ['Object', 'Controller', 'Model', 'Unit'].map((text) => h('th', {scope: 'col'}, text)))),
      h('tbody', {}, rows.map((one) => h('tr', {}, h('th', {scope: 'row'}, one.object), h('td', {}, readout(one.on_drive)), h('td', {}, readout(one.in_model)), h('td', {}, one.unit)))))) : null,
    h('details', {}, h('summary', {}, 'State of the drive'), h('pre', {}, answer.status)));
}

// What the deployment has changed: the position error in the same move before and after, in one chart.
async function drawTracking() {
  const host = byId('tracking');
  const found = store.state.deployed ? await get('tracking').catch(() => null) : null;
  if (!host?.isConnected || !found?.after) return;
  const {before, after} = found;
  const length = displayUnit('m', Math.max(before.largest_m, after.largest_m));
  const error = (one) => before.time_s.map((_, i) => (i < one.error_m.length ? one.error_m[i] * length.perSi : null));
  const figure = h('figure', {class: 'chart', 'data-chart': 'tracking'});
  fill(host, h('h3', {}, 'Position error in a move to and fro'),
    h('p', {}, h('b', {}, `${quantity(before.rms_m, 'm')} → ${quantity(after.rms_m, 'm')}`), ` rms, largest ${quantity(before.largest_m, 'm')} → ${quantity(after.largest_m, 'm')}, with the model before and with this one`), figure);
  const last = before.time_s[before.time_s.length - 1];
  tracking?.remove();
  tracking = new Chart(figure, {title: 'Position error over time', height: 180, x: {name: 'Time', label: 'Time (s)', unit: 's'}, y: {name: 'Error', label: `Position error (${length.label})`, unit: length.label},
    series: [{name: 'before', role: 'before'}, {name: 'after', role: 'after'}], data: [before.time_s, error(before), error(after)], xRange: [0, last], whole: () => [0, last]});
}

function deployForm() {
  const version = currentVersion();
  if (!version) return null;
  const {live, simulated} = store.state;
  const bus = field('bus', {type: 'text', placeholder: simulated ? 'empty: the simulated axis' : 'such as can0'}, live?.bus ?? '');
  const node = field('node', {type: 'number', min: '1', max: '127'}, String(live?.node ?? 5));
  const travel = field('travel', {type: 'number', min: '0', max: '1000', step: 'any'}, simulated && !live?.bus ? '20' : '0');
  const found = h('div', {id: 'differences'});
  const name = () => bus.value.trim();
  const named = (work) => (name() || simulated ? work() : say('Name the CAN interface of the controller, such as can0. Without hardware: start a simulated axis in an empty session.'));
  const send = () => attempt(() => post('deploy', {version: version.id, bus: name(), node: Number(node.value), travel_m: 1e-3 * Number(travel.value)}));
  const deploy = () => named(() => (Number(travel.value) > 0 ? ifTheWayIsFree(name(), travel.value, 'once before and once after', send) : send()));
  return h('section', {}, h('h2', {}, 'Deploy'), h('p', {}, `Version ${version.id} to the controller: staged, read back, applied between two ticks, stored.`),
    h('div', {class: 'form'}, h('label', {for: 'bus'}, 'CAN interface'), bus, h('label', {for: 'node'}, 'Node id'), node,
      h('label', {for: 'travel'}, 'Move it to and fro before and after (mm; 0: not at all)'), travel),
    h('div', {class: 'buttons'}, h('button', {type: 'button', id: 'differ', onclick: () => named(() => compareWithDrive(name(), node.value, found))}, 'What would change?'),
      h('button', {type: 'button', class: 'main', id: 'deploy', 'data-job': true, onclick: deploy}, 'Deploy')),
    found, store.state.deployed ? h('pre', {id: 'deployed', tabindex: 0}, store.state.deployed) : null, h('section', {id: 'tracking'}));
}

function draw() {
  const host = byId('experiment');
  if (!currentVersion()) { host.replaceChildren(h('p', {class: 'empty'}, 'Fit a first model; then plan here what would say more.')); return; }
  const axis = store.state.simulated;
  queueMicrotask(drawTracking);
  fill(host, planForm(), planned(), deployForm(), axis ? h('p', {class: 'soft'}, `Simulated axis: seed ${axis.seed}, ${quantity(axis.seconds, 's')}, hidden: ${axis.effects === 'random' ? 'drawn by the seed' : readable(axis.effects)}.`) : null);
}

export function startExperiment() {
  on('experiment', draw);
  on('plan-for', () => { wanted = new Set(store.planFor); draw(); });
  catalogue().then((list) => { effects = list; if (store.state) draw(); }).catch(() => {});
}
