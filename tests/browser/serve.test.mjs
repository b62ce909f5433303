// SPDX-License-Identifier: Apache-2.0
// The workbench in a real browser: node serve.test.mjs SLIPSTACK SLIPSTACK_SIM FOLDER
// Exit 0: all passed; 1: something failed; 77: no browser here, nothing tested.
import assert from 'node:assert/strict';
import {execFileSync, spawnSync} from 'node:child_process';
import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import {pdfPages} from './pdf_text.mjs';
import {current, drawn, idle, kJobs_ms, launch, openPage as openIn, serve as start, slowly, state} from './workbench_page.mjs';

const [, , slipstack, simulator, folder] = process.argv;
const kSeed = '11';        // of the simulated axis; any seed must do
const kHidden = 'viscous'; // in it

const browser = await launch();
let axe = '';
try {
  axe = fs.readFileSync(new URL('node_modules/axe-core/axe.min.js', import.meta.url), 'utf8');
} catch {
  console.log("axe-core is missing (toolchain/install): accessibility is not checked");
}

fs.rmSync(folder, {recursive: true, force: true});
fs.mkdirSync(folder, {recursive: true});
const log = path.join(folder, 'log.csv');
execFileSync(simulator, ['log', '--setup', 'pick_and_place', '--seed', kSeed, '--effects', kHidden, '--strength', '5', '--seconds', '20', '--out', log]);

const serve = (session, ...logs) => start(slipstack, path.join(folder, session), ...logs);
const openPage = (url, options) => openIn(browser, url, options);

async function accessible(page, where) {
  if (!axe) return;
  await page.evaluate(axe);
  const {violations} = await page.evaluate(() => window.axe.run(document, {resultTypes: ['violations']}));
  assert.deepEqual(violations.map((one) => `${one.id}: ${one.nodes[0].html.slice(0, 160)} ${one.nodes[0].failureSummary}`), [], where);
}

const tests = [];
const test = (name, run) => tests.push({name, run});

test('open, compare, learn, add, error falls, undo, redo, plan, run, deploy, export', async () => {
  const server = await serve('whole', log);
  const page = await openPage(server.url);
  await page.locator('#fit').waitFor({timeout: kJobs_ms});
  await idle(page);
  assert.ok(await page.locator('#time-charts figure').count() >= 1, 'the first picture is there before any model');
  // Every module is asked for at once, not when the one that imports it has come.
  const late = await page.evaluate(() => {
    const named = new Set([...document.querySelectorAll('link[rel=modulepreload], script[src]')].map((one) => one.href || one.src));
    return performance.getEntriesByType('resource').map((one) => one.name).filter((name) => name.endsWith('.js') && !named.has(name));
  });
  assert.deepEqual(late, []);
  await page.locator('#fit').click();
  await drawn(page, 1);
  const before = await current(page);
  assert.equal(await page.locator('#time-charts figure').count(), 3);
  assert.equal(await page.locator('#against-charts figure').count() >= 5, true);
  for (const chart of ['density', 'coherence', 'memory', 'response size', 'response phase']) {
    const drawnValues = await page.evaluate((key) => {
      const {spec} = window.slipstackWorkbench.chartOf(key);
      return {x: spec.x.label, y: spec.y.label, values: spec.data[1].filter((value) => Number.isFinite(value))};
    }, chart);
    assert.ok(drawnValues.values.length > 10, chart);
    assert.match(drawnValues.x, /\((Hz|s|ms)\)$/);
    if (chart === 'coherence') assert.ok(Math.max(...drawnValues.values) <= 1 && Math.max(...drawnValues.values) > 0.3, 'viscous friction follows the motion');
    if (chart === 'memory') assert.equal(drawnValues.values[0], 1);
  }
  // Damping ratios of the loops, as the log has them and as the model does.
  const damping = await page.evaluate(() => window.slipstackWorkbench.store.charts.damping);
  assert.ok(damping.amplitude_m.length >= 2 && damping.measured.every((ratio, i) => ratio > 0.01 && ratio < 0.64 && Math.abs(ratio - damping.model[i]) < 0.1), JSON.stringify(damping));
  assert.match(await page.evaluate(() => window.slipstackWorkbench.chartOf('damping').spec.x.label), /\((nm|µm|mm)\)$/);
  const loop = page.locator('[data-chart^="loop "]').first();
  await loop.locator('.menu summary').click();
  await loop.getByText('Table').click();
  assert.ok(await page.locator('dialog tbody tr').count() > 10, 'a loop has its values');
  await page.locator('dialog').getByText('Close').click();
  // Loops are as smooth as the samples: points between the rows, near them.
  const polygons = await page.evaluate(() => window.slipstackWorkbench.store.charts.loops.map((one) => {
    const rows = window.slipstackWorkbench.store.current.measured_N.subarray(one.row[0], one.row.at(-1) + 1);
    const range = Math.max(...rows) - Math.min(...rows);
    const far = one.measured_N.map((value, i) => {
      const around = [-1, 0, 1].map((step) => rows[one.row[i] - one.row[0] + step]).filter(Number.isFinite);
      return Math.max(Math.min(...around) - value, value - Math.max(...around)) / range;
    });
    return {points: one.row.length, rows: rows.length, far: Math.max(...far)};
  }));
  for (const one of polygons) assert.ok(one.points > 1.5 * one.rows && one.far < 0.1, JSON.stringify(polygons));
  await page.locator('.worst button').first().click();
  assert.match(await page.locator('#brushed').textContent(), /shown in all charts/);

  await page.locator('#tab-missing').click();
  // An expression with a mistake: the place is selected in it, and nothing is pushed out of the panel.
  await page.locator('#own').fill('snag = A*exp(-((x-x0)/w)^2)*sgn(v); A: N; x0: m; w: m');
  await page.getByText('Try it beside the others').click();
  await page.locator('#own-error').getByText('sgn').first().waitFor();
  assert.equal(await page.evaluate(() => { const input = document.querySelector('#own'); return input.value.slice(input.selectionStart, input.selectionStart + 3); }), 'sgn');
  assert.ok(await page.evaluate(() => { const panel = document.querySelector('#panel'); return panel.scrollWidth <= panel.clientWidth; }), 'the panel has its width');
  assert.match(page.faults.splice(0).join(), /^[^,]*400 \(Bad Request\) \S*\/api\/diagnose$/);  // the browser's own note of the refusal
  await page.locator('#own').fill('');
  // The first candidates show while others are tried, the best of them first.
  await page.evaluate(() => {
    window.seen = [];
    new MutationObserver(() => {
      const {job, tried} = window.slipstackWorkbench.store.state;
      const cards = document.querySelectorAll('#tried .card').length;
      if (job.running && cards) window.seen.push({cards, stage: job.stage, tried: tried.length, first: tried[0].effect});
    }).observe(document.querySelector('#missing'), {childList: true, subtree: true});
  });
  await slowly(server, async () => {
    await page.locator('#diagnose').click();
    await page.waitForFunction(() => window.slipstackWorkbench.store.state.job.running);
    await page.locator('#diagnose').click({force: true});
    await page.locator('#message').getByText(/still running/).waitFor();
    await page.locator('.card.best').waitFor({timeout: kJobs_ms});
  });
  const seen = await page.evaluate(() => window.seen);
  assert.ok(seen.some((one) => one.stage === 'try every effect' && one.tried < 10), JSON.stringify(seen));
  assert.equal(seen[seen.length - 1].first, kHidden);
  await idle(page);
  assert.equal(await page.locator('#tried .card').count(), 0);
  await accessible(page, 'cards');
  const effect = await page.locator('.card.best [data-add]').getAttribute('data-add');
  assert.equal(effect, kHidden);
  assert.ok(await page.locator('.card.best .fingerprint path').count() === 2, 'the expected trace beside the residual');
  const told = await page.locator('.card.best details').textContent();
  for (const term of ['Usual cause', 'The experiment that decides', 'In the residual']) assert.ok(told.includes(term), term);
  await page.locator('.card.best').getByText('What would it do?').click();
  await page.waitForFunction(() => /→/.test(document.querySelector('.card.best output').textContent));
  // The gains answer at once, and say that they are no more than that; then the refined model takes their place.
  await page.evaluate(() => {
    window.answers = [];
    const note = () => {
      const {first_answer: first, versions} = window.slipstackWorkbench.store.state;
      const text = document.querySelector('#first-answer')?.textContent ?? '';
      if (first && text) window.answers.push({id: first.id, effects: first.effects, after_N: first.after_N, versions: versions.length, text, bars: document.querySelectorAll('.waterfall li button').length});
    };
    new MutationObserver(note).observe(document.querySelector('#waterfall'), {childList: true, subtree: true});
  });
  await slowly(server, async () => {
    await page.locator('.card.best [data-add]').click();
    await drawn(page, 2);
  });
  const [first] = await page.evaluate(() => window.answers);
  assert.ok(first && first.id < 0, 'a first answer was shown');
  assert.equal(first.versions, 1, 'it is no version of the session');
  assert.equal(first.bars, 2, 'the error falls by a bar at once');
  assert.equal(first.text, 'Gains only; shapes are being refined.');
  assert.deepEqual(first.effects, [...before.effects, kHidden]);
  assert.ok(Math.abs(first.after_N / (await current(page)).after_N - 1) < 0.05, `${first.after_N} N at first`);
  assert.equal((await state(page)).first_answer, null);
  const [soon, refined] = await page.evaluate(() => ['first answer', 'refined answer'].map((name) => performance.getEntriesByName(name)[0].duration));
  assert.ok(soon < refined, `${soon} ms, then ${refined} ms`);
  const after = await current(page);
  assert.ok(after.after_N < 0.7 * before.after_N, `error ${before.after_N} -> ${after.after_N}`);
  assert.deepEqual(after.effects, [...before.effects, kHidden]);
  await page.locator('#tab-model').click();
  assert.equal(await page.locator('.waterfall li button').count(), 2);
  await accessible(page, 'model');
  // Each part of the panel begins at its top, however far the one before was scrolled.
  await page.evaluate(() => { document.querySelector('#panel').scrollTop = 400; });
  await page.locator('#tab-history').click();
  assert.equal(await page.evaluate(() => document.querySelector('#panel').scrollTop), 0);
  await page.locator('#tab-model').click();

  await page.locator('#undo').click();
  await drawn(page, 1);
  await page.locator('#redo').click();
  await drawn(page, 2);

  // A parameter by hand: charts and error follow.
  const slider = page.locator('#sliders input[data-kind=gain]').first();
  await slider.evaluate((input) => { input.value = String(Number(input.value) + 150); input.dispatchEvent(new Event('input')); });
  await page.waitForFunction(() => /set by hand/.test(document.querySelector('#bent-error').textContent));
  await page.locator('#bent-reset').click();

  // On paper: the colours of paper in a dark room too, and everything within the width of A4.
  await page.emulateMedia({colorScheme: 'dark'});
  await page.evaluate(() => {
    window.paper = null;
    addEventListener('beforeprint', () => {
      const {width} = window.slipstackWorkbench.chartOf('force').u;
      window.paper = {width, colour: getComputedStyle(document.documentElement).getPropertyValue('--page').trim()};
    });
  });
  const pages = pdfPages(await page.pdf({preferCSSPageSize: true}));
  assert.deepEqual(await page.evaluate(() => window.paper), {width: 680, colour: '#ffffff'});
  assert.ok(pages.length >= 2 && pages.length <= 6, `${pages.length} pages`);
  await page.emulateMedia({colorScheme: 'light'});
  await page.waitForFunction(() => window.slipstackWorkbench.chartOf('force').u.width > 700);

  // Remove and branch: the old version stays.
  await page.locator('.effects li').last().getByText('Remove').click();
  await drawn(page, 3);
  assert.equal((await current(page)).parent, 2);
  await page.locator('#tab-history').click();
  await page.locator('.tree .version').nth(1).click();
  await drawn(page, 2);

  for (const [what, sign] of [['toml', 'slipstack model 1'], ['header', '_step('], ['json', '"effects"'], ['csv', 'time_s,position_m'], ['mat', 'MATLAB 5.0'], ['report', '<!doctype html>']]) {
    const [download] = await Promise.all([page.waitForEvent('download'), page.locator(`[data-save=${what}]`).click()]);
    const text = fs.readFileSync(await download.path(), 'latin1');
    assert.ok(text.includes(sign), what);
    if (what === 'toml') fs.writeFileSync(path.join(folder, 'saved.toml'), text);
  }
  // The command line reads what the page saved, and says the same.
  assert.match(execFileSync(slipstack, ['compare', log, '--model', path.join(folder, 'saved.toml')], {encoding: 'utf8'}), /error/);

  // Cancelled: the first answer goes, and nothing of it stays. A fit that ends before the request arrives is taken back.
  const post = async (what, body = {}) => {
    await server.ask(what, {method: 'POST', body: JSON.stringify(body)});
    for (const end = Date.now() + kJobs_ms; ;) {
      const now = await (await server.ask('state')).json();
      if (!now.job.running) return now;
      assert.ok(Date.now() < end, 'the job does not end');
    }
  };
  let cancelled = null, versions = 0;
  for (let tries = 0; tries < 10 && cancelled?.job.outcome !== 'cancelled'; ++tries) {
    if (tries > 0) await post('undo');
    versions = (await (await server.ask('state')).json()).versions.length;
    await server.ask('remove', {method: 'POST', body: JSON.stringify({effect: kHidden})});
    cancelled = await post('cancel');
  }
  assert.equal(cancelled.job.outcome, 'cancelled');
  assert.equal(cancelled.first_answer, null);
  assert.equal(cancelled.versions.length, versions);
  await page.locator('#first-answer').waitFor({state: 'detached'});

  assert.deepEqual(page.faults, []);
  await page.context().close();
  await server.stop();
});

// Starts the simulated axis, whose log opens by itself, and fits the first model.
async function fitSimulatedAxis(page) {
  await page.locator('[data-simulate]').click();
  await page.locator('#seed').fill(kSeed);
  await page.locator('#hidden').fill(kHidden);
  await page.getByRole('button', {name: 'Start it'}).click();
  await page.locator('#fit').waitFor({timeout: kJobs_ms});
  await idle(page);
  await page.locator('#fit').click();
  await drawn(page, 1);
}

test('a simulated axis: record, plan, run, deploy', async () => {
  const server = await serve('axis');
  const page = await openPage(server.url);
  await page.locator('#empty').waitFor();
  await accessible(page, 'empty');
  await fitSimulatedAxis(page);
  await page.locator('#tab-experiment').click();
  // What the log hardly shows: of what it shows well, no plan within its limits tells more.
  await page.locator('#plan').click();
  await page.getByText('Choose at least one effect').waitFor();
  for (const effect of ['stribeck', 'frictional_lag']) await page.locator(`#plan-for input[value=${effect}]`).check();
  await page.locator('#plan-seconds').fill('60');
  await page.locator('#plan').click();
  await page.locator('#run-plan').waitFor({timeout: kJobs_ms});
  await page.locator('#run-plan').click();
  await page.waitForFunction(() => window.slipstackWorkbench.store.state.logs.length === 2 && window.slipstackWorkbench.store.state.measured, null, {timeout: kJobs_ms});
  await idle(page);
  await page.locator('#differ').click();
  await page.locator('#differences tbody tr').first().waitFor({timeout: kJobs_ms});
  await page.locator('#deploy').click();
  await page.locator('#deployed').waitFor({timeout: kJobs_ms});
  assert.match(await page.locator('#deployed').textContent(), /read back the same/);
  // The same move before and after: with the model, the axis follows its reference more closely.
  await page.locator('[data-chart=tracking] canvas').waitFor();
  const tracking = await (await server.ask('tracking')).json();
  assert.equal(tracking.before.error_m.length, 4096);
  assert.ok(Math.max(...tracking.before.reference_m) > 0.015 && Math.min(...tracking.before.reference_m.slice(-100)) < 0.015, 'there and back');
  assert.ok(tracking.after.rms_m < 0.8 * tracking.before.rms_m && tracking.after.rms_m > 1e-8, `${tracking.before.rms_m} m -> ${tracking.after.rms_m} m`);
  await page.locator('#differ').click();
  await page.getByText('The controller has this model already').waitFor({timeout: kJobs_ms});
  await accessible(page, 'experiment');
  assert.deepEqual(page.faults, []);
  await page.context().close();
  await server.stop();
});

test('a simulated axis of another set-up', async () => {
  const server = await serve('set-up');
  const page = await openPage(server.url);
  await page.locator('[data-simulate]').click();
  await page.locator('#setup').selectOption('random');
  await page.locator('#seed').fill('3');
  await page.getByRole('button', {name: 'Start it'}).click();
  await page.locator('#fit').waitFor({timeout: kJobs_ms});
  await idle(page);
  const {logs, simulated} = await state(page);
  assert.equal(simulated.setup, 'random');
  assert.notEqual(Number(logs[0].header.mass_kg), 35.45, 'that of the pick-and-place axis');
  assert.deepEqual(page.faults, []);
  await page.context().close();
  await server.stop();
});

test('a live controller: watch, move, record, deploy, before and after', async () => {
  const server = await serve('live');
  const page = await openPage(server.url);
  await page.locator('#empty').waitFor();
  await page.locator('#empty [data-connect]').click();
  await page.locator('dialog').getByText('This machine has no CAN interface').or(page.locator('#live-bus')).first().waitFor();
  await page.keyboard.press('Escape');
  await fitSimulatedAxis(page);
  await page.locator('body').click({position: {x: 5, y: 5}});
  await page.keyboard.press('c');
  await page.locator('#live-bus').selectOption('');
  assert.equal(await page.locator('#live-rate').inputValue(), '2000', 'as the log that is open');
  await page.locator('#live-rate').fill('500');
  await page.locator('dialog').getByRole('button', {name: 'Connect'}).click();
  await page.locator('#live-state[data-state=live]').waitFor({timeout: kJobs_ms});
  await page.locator('[data-chart="live residual"] canvas').waitFor();
  await page.locator('#live-record').click();
  assert.equal(await page.locator('#drive-state').textContent(), 'switch on disabled');
  assert.equal(await page.locator('#drive-emergency').textContent(), 'none');
  const move = async (times, travel_mm = '20') => {
    await page.locator('#live-move').click();
    await page.locator('#move-travel').fill(travel_mm);
    await page.locator('#move-times').fill(times);
    await page.locator('dialog').getByRole('button', {name: 'Move'}).click();
    await page.waitForFunction(() => {
      const {running, what, stage} = window.slipstackWorkbench.store.state.job;
      return running && what === 'move the axis' && stage.startsWith('move');
    });
  };
  await move('2');
  // State and mode as they change, while the job talks to the drive too.
  await page.waitForFunction(() => document.querySelector('#drive-state').textContent === 'operation enabled' && document.querySelector('#drive-mode').textContent === 'profile position');
  await idle(page);
  await page.waitForFunction(() => document.querySelector('#drive-state').textContent === 'ready to switch on');
  await page.locator('#live-parts tbody tr').waitFor();
  // Cancelled on the way: the axis stops, the drive is disabled and can be deployed to.
  await move('20');
  await page.keyboard.press('Escape');
  await idle(page);
  assert.equal((await state(page)).job.outcome, 'cancelled');
  await page.locator('#tab-experiment').click();
  await page.locator('#deploy').click();
  await page.waitForFunction(() => window.slipstackWorkbench.store.state.deployed, null, {timeout: kJobs_ms});
  await idle(page);
  await page.locator('#live-parts tbody tr').nth(1).waitFor();
  const rows = await page.locator('#live-parts tbody tr').allTextContents();
  assert.match(rows[0], /^the model that was there/);
  assert.match(rows[1], /^version 1/);
  const parts = await page.evaluate(() => window.slipstackWorkbench.liveSignals().parts);
  assert.ok(parts[1].residual_rms_N < 0.3 * parts[0].residual_rms_N && parts[1].residual_rms_N > 0.01, JSON.stringify(parts));
  assert.ok(parts[1].error_rms_m < 0.5 * parts[0].error_rms_m && parts[1].error_rms_m > 1e-8, JSON.stringify(parts));
  assert.doesNotMatch(await page.locator('#live-happened').textContent(), /lost/, 'questions and a deployment share the node');
  await accessible(page, 'live');
  // The picture is held, and goes on.
  await page.locator('#live-hold').click();
  const end = () => page.evaluate(() => window.slipstackWorkbench.liveCharts().get('live residual').u.scales.x.max);
  const heldAt = await end();
  await page.waitForTimeout(400);
  assert.equal(await end(), heldAt);
  await page.locator('#live-hold').click();
  await page.waitForFunction((before) => window.slipstackWorkbench.liveCharts().get('live residual').u.scales.x.max > before, heldAt);
  await page.waitForFunction(() => parseFloat(document.querySelector('#live-recorded').textContent) > 16, null, {timeout: kJobs_ms});  // enough for a fit
  // The recording has another rate than the log that is open.
  await page.locator('#live-record').click();
  await page.locator('dialog').getByText('Another sampling rate').waitFor();
  await page.locator('dialog').getByRole('button', {name: 'Close them'}).click();
  await page.waitForFunction(() => { const {logs, measured} = window.slipstackWorkbench.store.state; return measured && logs.length === 1 && logs[0].name === 'node5.csv'; }, null, {timeout: kJobs_ms});
  await idle(page);
  assert.equal((await state(page)).live.notice, '', 'nothing is lost on this bus, however fast a deployment lets its time pass');
  assert.ok(Math.abs((await state(page)).logs[0].sample_rate_Hz - 500) < 1e-6);
  // A plan, against the limits of the axis, run on it, and its log joins that of the same rate.
  await page.locator('#plan-for input[value=stribeck]').check();
  await page.locator('#plan-seconds').fill('20');
  await page.locator('#plan').click();
  await page.locator('#run-live').waitFor({timeout: kJobs_ms});
  await idle(page);
  await page.locator('#run-live').click();
  await page.locator('#plan-limits-table').waitFor({timeout: kJobs_ms});
  assert.equal(await page.locator('#plan-limits-table tbody tr').count(), 5);
  assert.equal(await page.locator('#plan-limits-table tbody tr.warn').count(), 0, await page.locator('#plan-limits-table').textContent());
  await accessible(page, 'plan on the axis');
  await page.locator('dialog').getByRole('button', {name: 'The way is free'}).click();
  await page.waitForFunction(() => { const {logs, measured} = window.slipstackWorkbench.store.state; return measured && logs.length === 2 && logs[1].name === 'planned-node5.csv'; }, null, {timeout: kJobs_ms});
  await idle(page);
  assert.ok(Math.abs((await state(page)).logs[1].sample_rate_Hz - 500) < 1e-6);
  await page.locator('#live-state[data-state=live]').waitFor({timeout: kJobs_ms});
  // A fault as the server tells it (unit.serve.LiveNode has the drive's own): what stopped the axis, in plain words, and the way out.
  await page.evaluate(async () => {
    const {store, tell} = await import('/store.js');
    const {live} = store.state;
    Object.assign(live.drive, {state: 'fault', error: '8611h', error_words: 'the axis does not follow'});
    live.emergency = {code: '8611h', words: 'the axis does not follow', at_ms: Date.now(), earlier: false};
    live.happened.unshift({at_ms: Date.now(), what: 'EMCY 8611h: the axis does not follow', kind: 'bad'});
    tell('state');
  });
  assert.match(await page.locator('#drive-emergency').textContent(), /^8611h: the axis does not follow, \d\d:\d\d:\d\d$/);
  assert.equal(await page.locator('#drive-error').textContent(), '8611h: the axis does not follow');
  assert.match(await page.locator('#live-happened li').first().textContent(), /EMCY 8611h: /);
  await accessible(page, 'fault');
  await page.locator('#live-reset').click();
  await page.waitForFunction(() => document.querySelector('#drive-state').textContent === 'switch on disabled' && !document.querySelector('#drive-error'), null, {timeout: kJobs_ms});
  await page.locator('#live-end').click();
  await page.locator('#live').waitFor({state: 'hidden'});
  // Logs were replaced, perhaps while charts of those before were asked for: such an answer is not wanted any more.
  assert.deepEqual(page.faults.filter((fault) => !/400 \(Bad Request\) \S*\/api\/(rows|model|charts)\b/.test(fault)), []);
  await page.context().close();
  await server.stop();
});

test('by keyboard alone, and on a phone', async () => {
  const server = await serve('keys', log);
  const page = await openPage(server.url, {viewport: {width: 390, height: 800}, colorScheme: 'dark'});
  await page.locator('#fit').waitFor({timeout: kJobs_ms});
  await idle(page);
  await page.locator('#fit').focus();
  await page.keyboard.press('Enter');
  await drawn(page, 1);
  const width = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(width <= 390, `the page is ${width} pixels wide`);
  await page.locator('.plot').first().focus();
  const shown = () => page.evaluate(() => { const {min, max} = window.slipstackWorkbench.store.range; return max - min; });
  const whole = await shown();
  await page.keyboard.press('+');
  assert.ok(await shown() < 0.7 * whole);
  await page.keyboard.press('0');
  assert.ok(Math.abs(await shown() - whole) < 1e-6 * whole);
  await page.keyboard.press('t');
  await page.locator('dialog table').waitFor();
  await page.keyboard.press('Escape');
  await page.locator('body').click({position: {x: 5, y: 5}});
  await slowly(server, async () => {
    await page.keyboard.press('d');
    await page.waitForFunction(() => window.slipstackWorkbench.store.state.job.running);
    await page.keyboard.press('Escape');
    await idle(page);
  });
  assert.equal((await state(page)).job.outcome, 'cancelled');
  await accessible(page, 'dark, narrow');
  await page.context().close();
  await server.stop();
});

// Goes to an element as somebody without a mouse does, and sees where he is.
async function reach(page, selector) {
  for (let tabs = 0; tabs < 600; ++tabs) {
    const here = await page.evaluate((wanted) => {
      const one = document.activeElement;
      const style = getComputedStyle(one);
      return {there: one.matches(wanted), seen: one === document.body || (style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 1), name: one.outerHTML.slice(0, 120)};
    }, selector);
    assert.ok(here.seen, `the focus is not visible on ${here.name}`);
    if (here.there) return;
    await page.keyboard.press('Tab');
  }
  assert.fail(`${selector} cannot be reached by the keyboard`);
}

test('the whole path by keyboard alone', async () => {
  const server = await serve('keys alone');
  const page = await openPage(server.url);
  await page.evaluate(() => { window.pointed = 0; addEventListener('pointerdown', () => { ++window.pointed; }, true); });
  const press = async (selector, key = 'Enter') => { await reach(page, selector); await page.keyboard.press(key); };
  // Open: a file, which is closed again, and a simulated axis.
  await page.locator('#empty').waitFor();
  page.on('filechooser', (chooser) => chooser.setFiles(log));
  await page.locator('h1').hover();  // a round trip: choosers are caught from here on
  await page.keyboard.press('o');
  await page.locator('#fit').waitFor({timeout: kJobs_ms});
  await idle(page);
  await press('#logs button');
  await press('#empty [data-simulate]');
  await reach(page, '#seed');
  await page.keyboard.press('Control+A');
  await page.keyboard.type(kSeed);
  await reach(page, '#hidden');
  await page.keyboard.press('Control+A');
  await page.keyboard.type(kHidden);
  await page.keyboard.press('Enter');
  await page.locator('#fit').waitFor({timeout: kJobs_ms});
  await idle(page);
  await press('#fit');
  await drawn(page, 1);
  await idle(page);
  // Compare: move, zoom, a cursor, the worst place.
  await press('[data-chart=residual] .plot', '+');
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('c');
  await page.locator('#cursors').waitFor();
  assert.equal(await page.locator('dialog').count(), 0, 'the key means the cursor alone');
  await press('.worst button');
  assert.match(await page.locator('#brushed').textContent(), /shown in all charts/);
  await page.keyboard.press('Escape');
  // Learn, add: the error falls.
  await page.keyboard.press('d');
  await page.locator('.card.best').waitFor({timeout: kJobs_ms});
  await idle(page);
  const before = await current(page);
  await press('.card.best [data-add]');
  await drawn(page, 2);
  await idle(page);
  assert.ok((await current(page)).after_N < 0.7 * before.after_N);
  await page.keyboard.press('u');
  await drawn(page, 1);
  await page.keyboard.press('r');
  await drawn(page, 2);
  // By hand.
  await page.keyboard.press('1');
  await press('#sliders input[data-kind=gain]', 'PageUp');
  await page.waitForFunction(() => /set by hand/.test(document.querySelector('#bent-error').textContent));
  // Plan, run, deploy.
  await page.keyboard.press('3');
  await press('#plan-for input[value=stribeck]', 'Space');
  await press('#plan');
  await page.locator('#run-plan').waitFor({timeout: kJobs_ms});
  await idle(page);
  await press('#run-plan');
  await page.waitForFunction(() => window.slipstackWorkbench.store.state.logs.length === 2 && window.slipstackWorkbench.store.state.measured, null, {timeout: kJobs_ms});
  await idle(page);
  await press('#deploy');
  await page.locator('#deployed').waitFor({timeout: kJobs_ms});
  await idle(page);
  // Export.
  await page.keyboard.press('4');
  await reach(page, '[data-save=toml]');
  const [download] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Enter')]);
  assert.match(fs.readFileSync(await download.path(), 'utf8'), /slipstack model 1/);
  assert.equal(await page.evaluate(() => window.pointed), 0, 'no pointer was used');
  // A log was closed, perhaps while its pictures were asked for.
  assert.deepEqual(page.faults.filter((fault) => !/400 \(Bad Request\) \S*\/api\/(rows|model|charts|picture)\b/.test(fault)), []);
  await page.context().close();
  await server.stop();
});

async function fullDisk(session) {
  const program = path.join(folder, 'full.sh');
  fs.writeFileSync(program, `#!/bin/sh\nexec unshare -rm sh -c 'mount -t tmpfs -o size=64k tmpfs "${session}" && exec "${slipstack}" "$@"' slipstack "$@"\n`, {mode: 0o755});
  const server = await start(program, session, log);
  const seen = path.join('/proc', String(server.child.pid), 'root', session);  // as the server sees it
  const kept = () => ['logs', 'models', 'diagnoses'].flatMap((part) => fs.readdirSync(path.join(seen, part)));
  const page = await openPage(server.url);
  await page.locator('#fit').waitFor({timeout: kJobs_ms});
  await idle(page);
  // Nothing is left but what is written over.
  const filler = path.join(seen, 'filler');
  assert.throws(() => fs.writeFileSync(filler, Buffer.alloc(1 << 20)), {code: 'ENOSPC'});
  const before = fs.readFileSync(path.join(seen, 'session.json'), 'utf8');
  await page.locator('#fit').click();
  await page.locator('#message').getByText(/No space left on device/).waitFor({timeout: kJobs_ms});
  const said = await page.locator('#message').innerText();
  assert.match(said, /full\/models\/1\.toml: No space left on device/);
  assert.ok(!said.trim().includes('\n'), `one line: ${said}`);
  assert.equal((await state(page)).versions.length, 0, 'nothing that was not kept is shown');
  assert.equal((await state(page)).job.outcome, 'failed');
  // Upload a log: said too, and nothing is left of it.
  await page.locator('#file').setInputFiles(log);
  await page.waitForFunction(() => /No space left/.test(document.querySelector('#message').textContent) && window.slipstackWorkbench.store.state.logs.length === 1);
  assert.deepEqual(kept(), [], 'no half of a file is left');
  assert.equal(fs.readFileSync(path.join(seen, 'session.json'), 'utf8'), before, 'the session is what it was');
  assert.equal((await server.ask('rows')).status, 200);
  // With space again the same server does what was asked.
  fs.rmSync(filler);
  await page.locator('#fit').click();
  await drawn(page, 1);
  assert.deepEqual(kept(), ['1.toml']);
  assert.equal(JSON.parse(fs.readFileSync(path.join(seen, 'session.json'), 'utf8')).versions.length, 1);
  await page.context().close();
  await server.stop();
}

test('a full disk and a file that vanishes are said, and the server goes on', async () => {
  // A disk of its own for the session, in a private mount namespace: nobody else sees it, and it ends with the server.
  const session = path.join(folder, 'full');
  fs.mkdirSync(session, {recursive: true});
  const refused = spawnSync('unshare', ['-rm', 'mount', '-t', 'tmpfs', 'tmpfs', session], {encoding: 'utf8'});
  if (refused.error || refused.status !== 0) {
    console.log(`SKIP    a full disk: no private mount is allowed here (${(refused.error?.message ?? refused.stderr).trim()})`);
  } else {
    await fullDisk(session);
  }

  // A log that goes while it is open: what was read stays. When the session is opened again it is missed by name, and the work goes on
  // without it.
  const gone = path.join(folder, 'gone.csv');
  fs.copyFileSync(log, gone);
  const first = await serve('gone', gone);
  const one = await openPage(first.url);
  await one.locator('#fit').waitFor({timeout: kJobs_ms});
  await idle(one);
  fs.rmSync(gone);
  await one.locator('#fit').click();
  await drawn(one, 1);
  assert.equal((await first.ask('picture?log=0&signal=force&from=1&to=1.01&points=800')).status, 200);
  assert.equal((await first.ask('download?what=csv&version=1')).status, 200);
  await one.context().close();
  await first.stop();
  const second = await serve('gone');
  const two = await openPage(second.url);
  await two.locator('#message').getByText(/gone\.csv/).waitFor({timeout: kJobs_ms});
  await two.locator('#logs button').first().click();
  await two.locator('#empty').waitFor({timeout: kJobs_ms});
  await two.locator('#file').setInputFiles(log);
  await drawn(two, 1);
  await two.context().close();
  await second.stop();
});

test('an ugly table is shown before it is read', async () => {
  const rows = fs.readFileSync(log, 'utf8').split('\n').filter((line) => /^[-\d]/.test(line)).map((line) => line.split(','));
  const comma = (value) => String(value).replace('.', ',');
  const text = 'Export;Achse <b>X</b>\n\nZeit [ms];Ist-Position [mm];Kraft [N]\n' + rows.map(([t, x, f]) => `${comma((1e3 * t).toFixed(4))};${comma((1e3 * x).toFixed(6))};${comma(f)}`).join('\n');
  const file = path.join(folder, 'scope.csv');
  fs.writeFileSync(file, Buffer.concat([Buffer.from([0xFF, 0xFE]), Buffer.from(text, 'utf16le')]));
  const server = await serve('import');
  const page = await openPage(server.url);
  await page.locator('#file').setInputFiles(file);
  await page.getByText('How is this file read?').waitFor({timeout: kJobs_ms});
  assert.equal(await page.locator('dialog select').nth(1).inputValue(), 'position_mm');
  // Nothing lies over another: each column's choice and factor within its own head.
  const overlaps = await page.evaluate(() => [...document.querySelectorAll('.import th')].flatMap((head) => {
    const box = head.getBoundingClientRect();
    return [...head.querySelectorAll('select, input')].filter((one) => { const r = one.getBoundingClientRect(); return r.left < box.left || r.right > box.right + 1 || r.width < 40; }).map((one) => one.getAttribute('aria-label'));
  }));
  assert.deepEqual(overlaps, []);
  await accessible(page, 'import');
  await page.locator('dialog input[inputmode=decimal]').first().fill('35.45');
  await page.getByRole('button', {name: 'Import it so'}).click();
  await page.locator('#fit').waitFor({timeout: kJobs_ms});
  await idle(page);
  assert.equal((await state(page)).logs[0].samples, rows.length);
  assert.deepEqual(page.faults, []);
  await page.context().close();
  await server.stop();
});

test('two tabs show the same; a server that dies is said, and the session is there again', async () => {
  const server = await serve('tabs', log);
  const [one, two] = [await openPage(server.url), await openPage(server.url)];
  await one.locator('#fit').waitFor({timeout: kJobs_ms});
  await idle(one);
  await one.locator('#fit').click();
  await drawn(one, 1);
  await drawn(two, 1);
  server.child.removeAllListeners('exit');
  server.child.kill('SIGKILL');
  await two.getByText('The server does not answer').waitFor({timeout: 20000});
  const again = await serve('tabs');
  const page = await openPage(again.url);
  await drawn(page, 1);
  await again.stop();
  for (const each of [one, two, page]) await each.context().close();
});

test('ten tabs of one browser', async () => {
  const server = await serve('many', log);
  const context = await browser.newContext();
  // All tabs of this browser think that they are shown: here, only the last one is.
  await context.addInitScript(() => {
    window.hiddenTab = false;
    Object.defineProperty(document, 'visibilityState', {get: () => (window.hiddenTab ? 'hidden' : 'visible')});
  });
  const turn = (page, hidden) => page.evaluate((value) => { window.hiddenTab = value; document.dispatchEvent(new Event('visibilitychange')); }, hidden);
  const tabs = [];
  for (let i = 0; i < 10; ++i) {
    if (i > 0) await turn(tabs[i - 1], true);
    const page = await context.newPage();
    await page.goto(server.url, {timeout: 20000});
    await page.locator('#fit').waitFor({timeout: 20000});
    tabs.push(page);
  }
  await idle(tabs[9]);
  await tabs[9].locator('#fit').click();
  await drawn(tabs[9], 1);
  assert.equal((await state(tabs[0])).versions.length, 0, 'a hidden tab does not follow');
  await turn(tabs[0], false);
  await drawn(tabs[0], 1);  // it catches up
  await context.close();
  await server.stop();
});

test('nobody else gets in', async () => {
  const server = await serve('safe', log);
  const status = async (what, options) => (await fetch(`${server.origin}/${what}`, options)).status;
  assert.equal(await status('api/state'), 403);
  assert.equal(await status('api/state', {headers: {Authorization: 'Bearer 0'}}), 403);
  const authorized = {Authorization: `Bearer ${server.token}`};
  assert.equal(await status('api/state', {headers: authorized}), 200);
  assert.equal(await status('api/state', {headers: {...authorized, Origin: 'http://evil.example'}}), 403);
  const port = Number(new URL(server.origin).port);
  const rebound = await new Promise((done) => http.get({host: '127.0.0.1', port, path: '/', headers: {Host: `evil.example:${port}`}}, (response) => done(response.statusCode)));
  assert.equal(rebound, 403);
  for (const what of ['../../etc/passwd', '..%2f..%2fetc%2fpasswd', 'session.json']) assert.notEqual(await status(what, {headers: authorized}), 200, what);
  const page = await fetch(server.origin);
  assert.match(page.headers.get('content-security-policy'), /default-src 'none'/);
  // Nothing is compressed on the way to this machine: it took longer than anything else before the first picture.
  for (const what of ['uplot.js', 'api/state']) {
    const answer = await fetch(`${server.origin}/${what}`, {headers: {...authorized, 'Accept-Encoding': 'gzip, deflate, br'}});
    assert.equal(answer.status, 200);
    assert.equal(answer.headers.get('content-encoding'), null, what);
  }
  for (const [what, body] of [['api/select', '{"version": 99}'], ['api/fit', '{"effects": ["<script>"]}'], ['api/fit', 'no json'], ['api/add', '{}'], ['api/download', '']]) {
    const answer = await server.ask(what.slice(4), body ? {method: 'POST', body} : {});
    assert.equal(answer.status, 400, what);
    assert.equal(typeof (await answer.json()).error, 'string');
  }
  // A hostile page on another port of this machine.
  const hostile = http.createServer((request, response) => { response.setHeader('Content-Type', 'text/html'); response.end('<p>hello'); });
  await new Promise((done) => hostile.listen(0, '127.0.0.1', done));
  const evil = await openPage(`http://127.0.0.1:${hostile.address().port}/`);
  const got = await evil.evaluate(async (origin) => {
    const out = [];
    for (const [what, options] of [['api/state', {}], ['api/undo', {method: 'POST', mode: 'no-cors'}], ['', {}]]) {
      try { const answer = await fetch(`${origin}/${what}`, options); out.push(answer.type === 'opaque' ? 'opaque' : answer.status); } catch { out.push('refused'); }
    }
    return out;
  }, server.origin);
  assert.deepEqual(got.filter((one) => one !== 'refused' && one !== 'opaque'), []);
  hostile.close();
  await evil.context().close();
  await server.stop();
});

let failed = 0;
for (const {name, run} of tests) {
  if (process.env.ONLY && !name.includes(process.env.ONLY)) continue;
  const start = Date.now();
  try {
    await run();
    console.log(`ok      ${name} (${((Date.now() - start) / 1000).toFixed(1)} s)`);
  } catch (error) {
    ++failed;
    console.log(`FAILED  ${name}\n${error.stack}`);
  }
}
await browser.close();
console.log(failed ? `${failed} failed` : 'all passed');
process.exit(failed ? 1 : 0);
