// SPDX-License-Identifier: Apache-2.0
// What the model lacks: the verdict, and a card for each candidate.
import {get, post} from '/api.js';
import {attempt, byId, fill, h, inSentence, percent, quantity, readable, sentence, shortTitle} from '/dom.js';
import {fingerprint} from '/figures.js';
import {currentVersion, on, store, tell} from '/store.js';

const kCards = 6;      // at most; the others are listed in a line each
const kShown = 0.01;   // least error reduction of a card, but for the first

function titleOf(id) { return store.state.diagnosis?.candidates.find((one) => one.effect === id)?.title ?? readable(id); }

// A text of the server with the titles of effects in place of their ids.
const named = (text) => text.replace(/[a-z]+(_[a-z]+)*/g, (word) => (store.state.diagnosis.candidates.some((one) => one.effect === word) ? inSentence(shortTitle(titleOf(word))) : word));

function add(effect) {
  store.asked = performance.now();
  return attempt(() => post('add', {effect}));
}

// What the residual charts draw beside the means.
function showExpected(card) {
  const profiles = store.charts?.profiles ?? [];
  store.expected = {};
  profiles.forEach((profile, i) => { store.expected[profile.coordinate] = {title: inSentence(shortTitle(card.title)), values: card.expected[i]}; });
  for (const [coordinate, one] of Object.entries(store.expected)) store.expected[coordinate] = Object.assign([...one.values], {title: one.title});
  tell('model');
  byId('against').scrollIntoView({block: 'start'});
}

// The error that adding it would leave, at once; the fit in the background says it exactly.
async function preview(card, output) {
  const begin = performance.now();
  const answer = await get('with', {version: currentVersion().id, effect: card.effect}).catch(() => null);
  performance.measure('preview', {start: begin});
  if (answer) output.textContent = `Added as it is now: ${quantity(answer.before_N, 'N')} → ${quantity(answer.after_N, 'N')}`;
}

// How far it lowers the error, with its standard error where it is known.
function gain(card) {
  const reduction = card.error_reduction ?? 0;
  const deviation = card.error_reduction_se;
  return h('div', {class: 'gain', role: 'img', 'aria-label': `lowers the error by ${percent(reduction)}${deviation ? `, standard error ${percent(deviation)}` : ''}`},
    h('span', {class: 'track'}, h('span', {class: 'bar', style: `width:${Math.max(0, 100 * reduction)}%`}),
      deviation ? h('span', {class: 'interval', style: `left:${Math.max(0, 100 * (reduction - deviation))}%;width:${Math.min(100, 200 * deviation)}%`}) : null),
    h('span', {}, `−${percent(Math.max(0, reduction))} → ${quantity(card.holdout_rmse_N, 'N')}`),
    Number.isFinite(card.criterion_difference) ? h('span', {class: 'criterion soft'}, criterion(card.criterion_difference)) : null);
}

// The change of the information criterion, as the report shows it.
function criterion(difference) {
  return `criterion ${difference > 0 ? '+' : difference < 0 ? '−' : ''}${Math.abs(difference).toFixed(1)}`;
}

function candidate(card, best) {
  const output = h('output', {class: 'soft'});
  const profiles = store.charts?.profiles;
  const residualKey = store.beside ? 'after_mean_N' : 'mean_N';
  return h('li', {class: `card ${best ? 'best' : ''}`},
    h('h3', {}, card.title), h('p', {class: 'formula soft'}, card.formula),
    gain(card),
    profiles ? fingerprint(card, profiles, residualKey) : null,
    h('p', {}, sentence(card.evidence || card.look)),
    card.confounded_with?.length ? h('p', {class: 'warn'}, `This log cannot tell it from ${card.confounded_with.map((id) => inSentence(shortTitle(titleOf(id)))).join(', ')}.`) : null,
    h('details', {open: best}, h('summary', {}, 'Cause and experiment'),
      h('dl', {}, [['Usual cause', card.cause], ['The experiment that decides', card.confirm_with], ['In the residual', card.look]].filter(([, text]) => text).map(([term, text]) => [h('dt', {}, term), h('dd', {}, sentence(text))]).flat())),
    output,
    h('div', {class: 'buttons'}, h('button', {type: 'button', class: best ? 'main' : '', 'data-add': card.effect, 'data-job': true, onclick: () => add(card.definition ?? card.effect)}, `Add ${inSentence(shortTitle(card.title))}`),
      h('button', {type: 'button', onclick: () => preview(card, output)}, 'What would it do?'),
      h('button', {type: 'button', onclick: () => showExpected(card)}, 'Show in the charts')));
}

function others(rest) {
  if (!rest.length) return null;
  return h('details', {class: 'others'}, h('summary', {}, rest.length === 1 ? 'Another effect was tried' : `${rest.length} other effects were tried`),
    h('ul', {}, rest.map((card) => h('li', {class: 'row'}, h('span', {}, shortTitle(card.title)), h('span', {class: 'soft'}, `−${percent(Math.max(0, card.error_reduction ?? 0))}`)))));
}

function limits(found) {
  const parts = [];
  if (found.cannot_separate.length) {
    parts.push(h('p', {}, 'This log cannot tell ', found.cannot_separate.map((pair) => `${inSentence(shortTitle(titleOf(pair.effect)))} from ${inSentence(shortTitle(titleOf(pair.other)))}`).join('; '), '.'));
  }
  if (found.cannot_show.length) {
    parts.push(h('details', {}, h('summary', {}, found.cannot_show.length === 1 ? 'An effect that this log would not show' : `${found.cannot_show.length} effects that this log would not show`),
      h('ul', {}, found.cannot_show.map((one) => h('li', {}, `${shortTitle(titleOf(one.effect))}: seen only from ${quantity(one.least_visible_N, 'N')} on`)))));
  }
  if (found.next_experiment) {
    parts.push(h('p', {}, sentence(`Next experiment: ${named(found.next_experiment.why)}`)),
      h('div', {class: 'buttons'}, h('button', {type: 'button', onclick: () => { store.planFor = found.next_experiment.for; tell('plan-for'); byId('tab-experiment').click(); }}, 'Plan it')));
  }
  return parts.length ? h('section', {class: 'limits'}, h('h3', {}, 'What this log does not say'), parts) : null;
}

function own() {
  const error = h('div', {class: 'warn', id: 'own-error', role: 'alert', hidden: true});
  const input = h('input', {type: 'text', id: 'own', spellcheck: false, placeholder: 'snag = A*exp(-((x-x0)/w)^2)*sign(v); A: N; x0: m; w: m in [1e-4, 1e-2]'});
  const run = async (work) => {
    error.hidden = true;
    try { await work(); } catch (problem) {
      // What is wrong, and, where the server knows it, the expression with a mark below the place.
      const [what, ...marked] = problem.message.split('\n');
      fill(error, h('p', {}, what), marked.length ? h('pre', {tabindex: 0}, marked.join('\n')) : null);
      error.hidden = false;
      input.focus();
      const place = (marked[1] ?? '').indexOf('^') - marked[0]?.indexOf(input.value.trim().slice(0, 8));
      if (place >= 0) input.setSelectionRange(place, place + 1);
    }
  };
  input.setAttribute('aria-describedby', 'own-error');
  return h('section', {class: 'own'}, h('h3', {}, 'Your own suspicion'), h('label', {for: 'own'}, 'An expression of x, v, a, t, with its units'), input, error,
    h('div', {class: 'buttons'}, h('button', {type: 'button', 'data-job': true, onclick: () => run(() => post('diagnose', {user_effects: [input.value]}))}, 'Try it beside the others'),
      h('button', {type: 'button', 'data-job': true, onclick: () => run(() => post('add', {effect: input.value}))}, 'Add it')));
}

// While the diagnosis runs: what has been tried so far, best first.
function drawTried() {
  const host = document.getElementById('tried');
  const {tried, job} = store.state;
  if (!host) return;
  if (!job.running || !tried.length) { host.replaceChildren(); return; }
  fill(host, h('h3', {}, `Tried so far: ${tried.length}`), h('p', {class: 'soft'}, 'Each alone, gains to first order. The others are still being tried; then sets of effects are, and all are judged.'),
    h('ol', {class: 'cards'}, tried.slice(0, kCards).map((card) => h('li', {class: 'card'}, h('h3', {}, card.title), h('p', {class: 'formula soft'}, card.formula), gain(card),
      card.evidence ? h('p', {}, sentence(card.evidence)) : null))));
}

function draw() {
  const host = byId('missing');
  const version = currentVersion();
  if (!version) { host.replaceChildren(h('p', {class: 'empty'}, 'Fit a first model; then ask here what it lacks.')); return; }
  const found = store.state.diagnosis;
  const ask = h('button', {type: 'button', class: found ? '' : 'main', id: 'diagnose', 'data-job': true, onclick: () => attempt(() => post('diagnose'))}, found ? 'Ask again' : 'What is missing?');
  if (!found) {
    host.replaceChildren(h('h2', {}, 'What is missing?'), h('p', {}, 'Every effect of the catalogue is tried on top of the model and judged on data that the fit has not seen.'), h('div', {class: 'buttons'}, ask), h('section', {id: 'tried', 'aria-label': 'Tried so far'}), own());
    drawTried();
    return;
  }
  const missing = found.verdict === 'missing_effect';
  const cards = found.candidates.filter((card, i) => i === 0 || card.error_reduction >= kShown).slice(0, kCards);
  fill(host, h('section', {id: 'tried', 'aria-label': 'Tried so far'}), h('h2', {class: `verdict ${found.verdict}`}, sentence(found.headline)), h('p', {}, sentence(found.detail)),
    found.unexplained && !found.detail.includes(found.unexplained.description) ? h('p', {class: 'warn'}, sentence(found.unexplained.description)) : null,
    found.input_warnings.length ? h('ul', {class: 'warn'}, found.input_warnings.map((one) => h('li', {}, one.what))) : null,
    h('ol', {class: 'cards'}, cards.map((card, i) => candidate(card, missing && i === 0))), h('p', {class: 'soft'}, found.criterion_note), others(found.candidates.filter((card) => !cards.includes(card))),
    limits(found), h('div', {class: 'buttons'}, ask), own(), h('p', {class: 'soft'}, 'The same on the command line: ', h('code', {}, found.command)));
  drawTried();
}

export function startMissing() {
  on('diagnosis', draw);
  on('tried', drawTried);
  on('charts', draw);
}
