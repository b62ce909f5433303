// SPDX-License-Identifier: Apache-2.0
// A controller that is watched while it runs: what its model does not explain, how closely the axis follows, where it is;
// errors before and after each model that was put on it; a recording that joins the logs.
import {get, post} from '/api.js';
import {Chart, colour} from '/chart.js';
import {attempt, byId, dialog, fill, h, quantity} from '/dom.js';
import {clipped, extentOf, unitFor} from '/linked.js';
import {on, store} from '/store.js';

const kSignals = ['time_s', 'residual_N', 'error_m', 'position_m'];
const kCharts = [
  {key: 'live residual', signal: 'residual_N', title: 'Live residual', name: 'Residual', unit: 'N', role: 'after'},
  {key: 'live error', signal: 'error_m', title: 'Live position error', name: 'Position error', unit: 'm', role: 'after'},
  {key: 'live position', signal: 'position_m', title: 'Live position', name: 'Position', unit: 'm', role: 'motion'}];
const kDrawn_ms = 100;      // between two drawings
const kTravel_mm = '20';
const kRate_Hz = 500;       // where no log is open

let signals = null;         // of this connection: {connection, time_s, residual_N, ..., parts, recorded}
let charts = new Map();
let held = false;
let drawnAt = 0;
let seen = '';

export const liveName = (live) => `node ${live.node} on ${live.bus || 'the simulated axis'}`;

function forget() {
  for (const chart of charts.values()) chart.remove();
  charts = new Map();
  signals = null;
  held = false;
}

// --- connecting ---

export async function connect() {
  const interfaces = await attempt(() => get('live/interfaces'));
  if (!interfaces) return;
  const choices = interfaces.map((name) => [name, name]);
  if (store.state.simulated) choices.push(['', 'the simulated axis of this session']);
  if (!choices.length) {
    await dialog('Connect to a controller', h('p', {}, 'This machine has no CAN interface. Bring one up (ip link set can0 up type can bitrate 1000000), or start a simulated axis: it has the same controller.'));
    return;
  }
  const bus = h('select', {id: 'live-bus'}, choices.map(([value, label]) => h('option', {value}, label)));
  const node = h('input', {type: 'number', id: 'live-node', min: '1', max: '127', value: '5'});
  const ofLog = store.state.logs[0]?.sample_rate_Hz;
  const rate = h('input', {type: 'number', id: 'live-rate', min: '10', max: '2000', value: String(ofLog >= 10 && ofLog <= 2000 ? Math.round(ofLog) : kRate_Hz)});
  const answer = await dialog('Connect to a controller', h('div', {},
    h('p', {}, 'It is watched, not moved. While it is, it sends SYNC itself, and TPDO 3 and 4 with it; afterwards it is as it was.'),
    h('div', {class: 'form'}, h('label', {for: 'live-bus'}, 'CAN interface'), bus, h('label', {for: 'live-node'}, 'Node id'), node,
      h('label', {for: 'live-rate'}, 'Samples per second (each takes 330 bits of the bus)'), rate)), [{label: 'Cancel', value: ''}, {label: 'Connect', value: 'connect', main: true}]);
  if (answer === 'connect') await attempt(() => post('live/connect', {bus: bus.value, node: Number(node.value), rate_Hz: Number(rate.value)}));
}

// A dialog before an axis moves that is not a simulated one. `work` is called where the user agrees.
export async function ifTheWayIsFree(bus, travel_mm, what, work) {
  if (!bus) return work();
  const answer = await dialog('Is the way free?', h('p', {}, `The axis on ${bus} will be enabled and will move ${travel_mm} mm in the direction of its positive positions and back, ${what}. Nobody may stand in its way.`),
    [{label: 'Cancel', value: ''}, {label: 'The way is free', value: 'move', main: true}]);
  return answer === 'move' ? work() : undefined;
}

async function move() {
  const {live} = store.state;
  const travel = h('input', {type: 'number', id: 'move-travel', min: '0.1', max: '1000', step: 'any', value: kTravel_mm});
  const times = h('input', {type: 'number', id: 'move-times', min: '1', max: '1000', value: '5'});
  const answer = await dialog('Move the axis to and fro', h('div', {class: 'form'}, h('label', {for: 'move-travel'}, 'Travel (mm), towards positive positions'), travel,
    h('label', {for: 'move-times'}, 'Times'), times), [{label: 'Cancel', value: ''}, {label: 'Move', value: 'move', main: true}]);
  if (answer !== 'move') return;
  await ifTheWayIsFree(live.bus, travel.value, `${times.value} times`, () => attempt(() => post('live/move', {travel_m: 1e-3 * Number(travel.value), times: Number(times.value)})));
}

// One model is fitted to logs of one sampling rate.
async function keep() {
  const {live, logs} = store.state;
  const others = logs.filter((log) => log.sample_rate_Hz && Math.abs(log.sample_rate_Hz / live.rate_Hz - 1) > 1e-3);
  let alone = false;
  if (others.length) {
    const answer = await dialog('Another sampling rate', h('p', {}, `${others.map((log) => log.name).join(', ')}: ${quantity(others[0].sample_rate_Hz, 'Hz')}; the recording: ${quantity(live.rate_Hz, 'Hz')}. One model is fitted to logs of one rate. The logs that are closed stay where they are.`),
      [{label: 'Go on recording', value: ''}, {label: 'Close them and open the recording', value: 'alone', main: true}]);
    if (!answer) return;
    alone = true;
  }
  await attempt(() => post('live/keep', {alone}));
}

// --- the panel ---

const clock = (at) => new Date(at).toLocaleTimeString('en-GB');

// What the drive says of itself: state and mode of CiA 402, what stops it, its last emergency.
function driveState({drive, emergency, state}) {
  if (!drive) return null;
  const row = (name, id, text, bad = false) => [h('dt', {}, name), h('dd', {id, class: bad ? 'bad' : undefined}, text)];
  const flags = [drive.warning ? 'warning' : '', drive.limited ? 'at a limit' : '', drive.referenced ? '' : 'does not know its positions'].filter(Boolean);
  const now = state === 'live' ? '' : ' (before it was lost)';
  return h('dl', {id: 'live-drive', 'data-state': drive.state, 'aria-label': 'State of the drive'},
    row('State', 'drive-state', drive.state + now, drive.state.startsWith('fault')), row('Mode', 'drive-mode', drive.mode),
    drive.error ? row('Error', 'drive-error', `${drive.error}: ${drive.error_words}`, true) : null,
    flags.length ? row('Also', 'drive-flags', flags.join(', ')) : null,
    row('Last emergency', 'drive-emergency', emergency ? `${emergency.code}: ${emergency.words}, ${emergency.earlier ? 'before it was connected' : clock(emergency.at_ms)}` : 'none'));
}

function happened({happened: entries}) {
  if (!entries.length) return null;
  return h('details', {open: byId('live-happened')?.parentElement.open ?? true}, h('summary', {}, 'What happened'), h('div', {id: 'live-happened', role: 'log', 'aria-label': 'What happened', tabindex: 0}, h('ol', {},
    entries.map((one) => h('li', {'data-kind': one.kind}, h('time', {datetime: new Date(one.at_ms).toISOString()}, clock(one.at_ms)), ` ${one.what}`)))));
}

function draw() {
  const {live} = store.state;
  const host = byId('live');
  host.hidden = !live;
  const now = JSON.stringify([live?.bus, live?.node, live?.state, live?.error, live?.recording, live?.notice, live?.drive, live?.emergency, live?.happened, held]);
  if (now === seen) return;
  seen = now;
  if (!live) { forget(); host.replaceChildren(); return; }
  const focused = host.contains(document.activeElement) ? document.activeElement.id : '';
  const running = live.state === 'live';
  const button = (id, label, act, attributes = {}) => h('button', {type: 'button', id, onclick: act, ...attributes}, label);
  const buttons = h('div', {class: 'buttons'},
    running ? button('live-record', live.recording ? 'Stop and open the log' : 'Record', () => (live.recording ? keep() : attempt(() => post('live/record'))), {class: 'main', 'data-job': live.recording}) : null,
    running ? button('live-move', 'Move to and fro', move, {'data-job': true}) : null,
    running ? button('live-hold', held ? 'Go on' : 'Hold the picture', () => { held = !held; draw(); }, {'aria-pressed': String(held)}) : null,
    running && live.drive?.state === 'fault' ? button('live-reset', 'Reset the fault', () => attempt(() => post('live/reset')), {'data-job': true}) : null,
    button('live-end', 'Disconnect', () => attempt(() => post('live/disconnect')), {'data-job': true}));
  const state = {connecting: 'connecting …', live: live.recording ? 'recording' : 'live', lost: 'lost, tried again each second', paused: 'left to the running job'}[live.state];
  let figures = byId('live-charts');
  if (!figures) figures = h('div', {id: 'live-charts'});
  fill(host, h('div', {class: 'row'}, h('h2', {id: 'live-title'}, `Live: ${liveName(live)}`), h('span', {id: 'live-state', role: 'status', 'data-state': live.state}, state), h('span', {id: 'live-recorded', class: 'soft'})),
    live.error || live.notice ? h('p', {class: 'warn'}, live.error || live.notice) : null, driveState(live), buttons, figures, h('div', {id: 'live-parts'}),
    happened(live),
    live.status ? h('details', {}, h('summary', {}, 'The drive when it was connected'), h('pre', {tabindex: 0}, live.status)) : null);
  if (focused) byId(focused)?.focus();
  drawParts();
}

// A line where a model was changed.
function drawMarks(u) {
  clipped(u, (ctx) => {
    ctx.font = `${11 * devicePixelRatio}px sans-serif`;
    ctx.textAlign = 'left';
    ctx.strokeStyle = ctx.fillStyle = colour('ink');
    ctx.lineWidth = devicePixelRatio;
    for (const part of signals.parts.slice(1)) {
      const x = u.valToPos(part.begin_s, 'x', true);
      ctx.beginPath();
      ctx.moveTo(x, u.bbox.top);
      ctx.lineTo(x, u.bbox.top + u.bbox.height);
      ctx.stroke();
      ctx.fillText(part.label, x + 3 * devicePixelRatio, u.bbox.top + 11 * devicePixelRatio);
    }
  });
}

function drawSignals() {
  if (held || !signals?.time_s.length || !byId('live-charts')) return;
  const now = performance.now();
  if (now - drawnAt < kDrawn_ms || document.hidden) return;
  drawnAt = now;
  const ts = signals.time_s;
  const range = [Math.max(ts[0], ts[ts.length - 1] - store.state.live.shown_s), ts[ts.length - 1]];
  for (const {key, signal, title, name, unit, role} of kCharts) {
    const display = unitFor(unit, extentOf(signals[signal]));
    const data = [ts, signals[signal].map((value) => (value === null ? null : value * display.perSi))];
    const chart = charts.get(key);
    const label = `${name} (${display.label})`;
    if (chart && chart.spec.y.label === label) { chart.feed(data, range); continue; }
    const spec = {title, height: 150, x: {name: 'Time', label: 'Time since it was connected (s)', unit: 's'}, y: {name, label, unit: display.label},
      series: [{name: name.toLowerCase(), role}], data, xRange: range, whole: () => [signals.time_s[0], signals.time_s[signals.time_s.length - 1]], over: drawMarks};
    if (chart) { chart.update(spec); continue; }
    const figure = h('figure', {class: 'chart', 'data-chart': key});
    byId('live-charts').append(figure);
    charts.set(key, new Chart(figure, spec));
  }
  drawParts();
}

// Errors while the axis moved, model by model: before and after.
function drawParts() {
  const host = byId('live-parts');
  const recorded = byId('live-recorded');
  if (!host || !signals) return;
  const {live} = store.state;
  recorded.textContent = live.recording ? `${(signals.recorded / live.rate_Hz).toFixed(1)} s recorded` : '';
  const shown = signals.parts.filter((part, i) => part.moving_s > 0 || i === signals.parts.length - 1);
  if (!shown.some((part) => part.moving_s > 0)) { fill(host, h('p', {class: 'soft'}, 'Errors are summed up here as soon as the axis moves.')); return; }
  fill(host, h('table', {}, h('caption', {}, 'Errors while the axis moved'),
    h('thead', {}, h('tr', {}, ['Model', 'Moved for', 'Residual, rms', 'Position error, rms', 'Largest'].map((text) => h('th', {scope: 'col'}, text)))),
    h('tbody', {}, shown.map((part) => h('tr', {}, h('th', {scope: 'row'}, part.label), h('td', {}, quantity(part.moving_s, 's')), h('td', {}, quantity(part.residual_rms_N, 'N')),
      h('td', {}, quantity(part.error_rms_m, 'm')), h('td', {}, part.moving_s > 0 ? quantity(part.largest_error_m, 'm') : '–'))))));
}

export const liveSignals = () => signals;
export const liveCharts = () => charts;

// New signals of the server; those of another connection begin anew.
export function takeSignals(news) {
  if (signals?.connection !== news.connection) {
    const keep = {connection: news.connection};
    for (const name of kSignals) keep[name] = [];
    signals = keep;
  }
  const most = Math.ceil((store.state?.live?.shown_s ?? 20) * (store.state?.live?.rate_Hz ?? 500));
  for (const name of kSignals) {
    const all = signals[name];
    for (const value of news[name]) all.push(value);
    if (all.length > most) all.splice(0, all.length - most);
  }
  signals.parts = news.parts;
  signals.recorded = news.recorded;
  drawSignals();
}

export function startLive() {
  for (const button of document.querySelectorAll('[data-connect]')) button.addEventListener('click', connect);
  on('state', draw);
}
