// SPDX-License-Identifier: Apache-2.0
// The page: follows the server's state and fetches what changed.
import {bytes, follow, get, post} from '/api.js';
import {forgetCharts, startCharts} from '/charts.js';
import {clearCursors} from '/cursors.js';
import {attempt, byId, dialog, h, say} from '/dom.js';
import {startExperiment} from '/experiment.js';
import {startHistory} from '/history.js';
import {chartOf, select} from '/linked.js';
import {connect, liveCharts, liveSignals, startLive, takeSignals} from '/live.js';
import {startMissing} from '/missing.js';
import {startModel} from '/model.js';
import {startOpen} from '/open.js';
import {on, shownVersion, store, tell, versionOf} from '/store.js';

let logsSeen = '';
let recordedSeen = false;
let measuredSeen = false;
let versionSeen = null;
let diagnosisSeen = null;
let experimentSeen = null;
let triedSeen = null;

const logsOf = (state) => state.logs.map((log) => log.path).join('\n');

// Fetches rows and models; an answer that is no longer wanted is dropped.
async function fetchModels() {
  const version = shownVersion();
  const beside = versionOf(store.besideId) ?? (version ? versionOf(version.parent) : null);
  const wanted = `${logsSeen}|${version?.id}|${beside?.id}`;
  store.wanted = wanted;
  store.bent = null;
  store.expected = null;
  try {
    store.rows ??= await bytes('rows');
    const [current, other] = await Promise.all([version ? bytes('model', {version: version.id}) : null, beside ? bytes('model', {version: beside.id}) : null]);
    if (store.wanted !== wanted) return;
    store.current = current;
    store.beside = other;
    store.charts = null;  // those of the models before
    tell('model');
    tell('version');
    showAnswered(version);
    store.charts = version ? await get('charts', beside ? {version: beside.id, other: version.id} : {version: version.id}) : null;
    if (store.wanted !== wanted) return;
    tell('model');
    tell('charts');
    document.body.dataset.drawn = String(version?.id ?? 0);
  } catch (error) {
    if (store.wanted === wanted) say(error.message);
  }
}

// In the trace: how long after the click the first answer and the refined one are drawn.
function showAnswered(version) {
  if (store.asked === null) return;
  performance.measure(version.note ? 'first answer' : 'refined answer', {start: store.asked});
  if (!version.note) store.asked = null;
}

// One job at a time: what would start another keeps the focus, and says why it does not.
function startBusy() {
  document.addEventListener('click', (event) => {
    if (!store.state?.job.running || !event.target.closest?.('[data-job]')) return;
    event.preventDefault();
    event.stopPropagation();
    say(`One thing at a time: “${store.state.job.what}” is still running. Wait, or cancel it with Esc.`, 'note');
  }, true);
}

function showBusy(running) {
  document.body.classList.toggle('busy', running);
  for (const button of document.querySelectorAll('[data-job]')) {
    if (running) button.setAttribute('aria-disabled', 'true'); else button.removeAttribute('aria-disabled');
  }
}

function showJob({running, what, stage, fraction, elapsed_s: elapsed, outcome, error}) {
  byId('job').hidden = !running;
  showBusy(running);
  if (running) {
    byId('job-text').textContent = `${what.replace(/^./, (first) => first.toUpperCase())}: ${stage || 'starting'}${elapsed > 1 ? `, ${elapsed.toFixed(0)} s` : ''}`;
    const bar = byId('job-progress');
    if (fraction >= 0) bar.value = fraction; else bar.removeAttribute('value');
  }
  const ended = `${running}${what}${outcome}${error}`;
  if (store.jobSeen !== ended) {
    store.jobSeen = ended;
    if (!running && outcome !== 'done') store.asked = null;
    if (error) say(error);
    else if (outcome === 'cancelled') say(`Cancelled: ${what}. Nothing has changed.`, 'note');
    else if (running) say('');
  }
}

function take(state) {
  store.state = state;
  report.units = state.units;
  showJob(state.job);
  document.title = state.logs.length ? `${state.logs[0].name} – slipstack` : 'slipstack workbench';
  byId('undo').disabled = !state.undo_to || state.job.running;
  byId('redo').disabled = !state.redo_to || state.job.running;
  byId('work').hidden = state.logs.length === 0;
  if (logsOf(state) !== logsSeen || (measuredSeen && !state.measured)) {
    logsSeen = logsOf(state);
    recordedSeen = measuredSeen = false;
    versionSeen = null;
    Object.assign(store, {wanted: null, rows: null, current: null, beside: null, bent: null, charts: null});
    forgetCharts();
  }
  tell('state');
  if (!recordedSeen && state.traces > 0) {
    recordedSeen = true;
    tell('recorded');
  }
  const shown = shownVersion()?.id ?? state.current;
  if (state.measured && (!measuredSeen || versionSeen !== shown)) {
    measuredSeen = true;
    if (versionSeen !== shown) store.besideId = null;
    versionSeen = shown;
    fetchModels();
  }
  const diagnosis = JSON.stringify([state.current, state.diagnosis?.headline, state.diagnosis?.noise_floor_N]);
  if (diagnosis !== diagnosisSeen) {
    diagnosisSeen = diagnosis;
    tell('diagnosis');
  }
  const tried = JSON.stringify(state.tried);
  if (tried !== triedSeen) {
    triedSeen = tried;
    tell('tried');
  }
  const experiment = JSON.stringify([state.current, state.plan?.headline, state.deployed, state.simulated, state.live?.bus, state.live?.node, state.live?.state, state.diagnosis?.next_experiment?.for]);
  if (experiment !== experimentSeen) {
    experimentSeen = experiment;
    tell('experiment');
  }
}

// --- tabs, tools, keys ---

function showTab(tab) {
  if (tab.getAttribute('aria-selected') !== 'true') byId('panel').scrollTop = 0;  // the parts share one place to scroll
  for (const other of document.querySelectorAll('[role=tab]')) {
    const chosen = other === tab;
    other.setAttribute('aria-selected', String(chosen));
    other.tabIndex = chosen ? 0 : -1;
    byId(other.getAttribute('aria-controls')).hidden = !chosen;
  }
}

function startTabs() {
  const tabs = [...document.querySelectorAll('[role=tab]')];
  tabs.forEach((tab, i) => {
    tab.addEventListener('click', () => showTab(tab));
    tab.addEventListener('keydown', (event) => {
      const step = {ArrowRight: 1, ArrowLeft: -1}[event.key];
      if (!step) return;
      const next = tabs[(i + step + tabs.length) % tabs.length];
      showTab(next);
      next.focus();
    });
  });
}

const kKeys = [['u', 'undo'], ['r', 'redo'], ['o', 'open a log'], ['c', 'connect to a controller'], ['d', 'ask what is missing'], ['1 to 4', 'Model, Missing, Experiment, History'], ['Esc', 'cancel the job; remove brush and cursors'],
  ['in a chart: ← →', 'move'], ['+ −', 'zoom'], ['0', 'show all'], ['c', 'place a cursor in the middle'], ['t', 'table of what is visible'], ['wheel, Shift+wheel', 'zoom time, zoom the value'], ['Alt+drag', 'move']];

function help() {
  return dialog('Keys', h('table', {}, h('tbody', {}, kKeys.map(([key, what]) => h('tr', {}, h('th', {scope: 'row'}, h('kbd', {}, key)), h('td', {}, what))))));
}

function startKeys() {
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches('input:not([type=range]):not([type=radio]), textarea, select') || document.querySelector('dialog[open]')) return;
    const tabs = ['tab-model', 'tab-missing', 'tab-experiment', 'tab-history'];
    const acts = {
      u: () => byId('undo').click(), r: () => byId('redo').click(), o: () => byId('file').click(), c: connect, '?': help,
      d: () => { byId('tab-missing').click(); byId('diagnose')?.click(); },
      Escape: () => { if (store.state?.job.running) attempt(() => post('cancel')); else { select(null); clearCursors(); } },
    };
    const index = Number(event.key) - 1;
    if (index >= 0 && index < tabs.length && !event.target.closest('.plot')) { byId(tabs[index]).click(); byId(tabs[index]).focus(); return; }
    acts[event.key]?.();
  });
}

function startTools() {
  for (const input of document.querySelectorAll('[name=tool]')) input.addEventListener('change', () => { store.tool = input.value; });
  byId('unbrush').addEventListener('click', () => select(null));
  on('selected', () => {
    const count = store.selected ? store.selected.reduce((sum, one) => sum + one, 0) : 0;
    byId('unbrush').hidden = count === 0;
    byId('brushed').textContent = count ? `${count.toLocaleString('en')} of ${store.selected.length.toLocaleString('en')} rows, shown in all charts` : '';
  });
  on('model', () => {
    const {header} = store.rows;
    byId('excerpt').hidden = !header.excerpt;
    byId('excerpt').textContent = `Models are drawn on an excerpt of ${header.searched_samples.toLocaleString('en')} of ${header.samples.toLocaleString('en')} samples; the recorded force behind them is that of the whole log. Errors of the versions are those of all.`;
  });
}

byId('undo').addEventListener('click', () => attempt(() => post('undo')));
byId('redo').addEventListener('click', () => attempt(() => post('redo')));
byId('cancel').addEventListener('click', () => attempt(() => post('cancel')));
byId('help').addEventListener('click', help);
on('beside', fetchModels);
startTabs();
startTools();
startKeys();
startBusy();
startCharts();
startOpen();
startLive();
startModel();
startMissing();
startExperiment();
startHistory();
window.slipstackWorkbench = {store, chartOf, liveSignals, liveCharts};  // for the tests
follow(take, takeSignals, (fault) => { if (fault) say(fault); else if (byId('message').dataset.kind !== 'note') say(''); });
