// SPDX-License-Identifier: Apache-2.0
// What the model lacks: the verdict, and a card for each candidate.
import {get, post} from '/api.js';
import {attempt, byId, fill, h, percent, quantity, readable} from '/dom.js';
import {fingerprint} from '/figures.js';
import {currentVersion, on, store, tell} from '/store.js';

const kCards = 6;

function titleOf(id) { return store.state.diagnosis?.candidates.find((one) => one.effect === id)?.title ?? readable(id); }

function add(effect) { return attempt(() => post('add', {effect})); }

// What the residual charts draw beside the means.
function showExpected(card) {
  const profiles = store.charts?.profiles ?? [];
  store.expected = {};
  profiles.forEach((profile, i) => { store.expected[profile.coordinate] = {title: card.title.toLowerCase(), values: card.expected[i]}; });
  for (const [coordinate, one] of Object.entries(store.expected)) store.expected[coordinate] = Object.assign([...one.values], {title: one.title});
  tell('model');
  byId('against-charts').scrollIntoView({block: 'start'});
}

// The error that adding it would leave, at once; the fit in the background says it exactly.
async function preview(card, output) {
  const begin = performance.now();
  const answer = await get('with', {version: currentVersion().id, effect: card.effect}).catch(() => null);
  performance.measure('preview', {start: begin});
  if (answer) output.textContent = `Added as it is now: ${quantity(answer.before_N, 'N')} → ${quantity(answer.after_N, 'N')}`;
}

function candidate(card, best) {
  const reduction = card.error_reduction ?? 0;
  const output = h('output', {class: 'soft'});
  const profiles = store.charts?.profiles;
  const residualKey = store.beside ? 'after_mean_N' : 'mean_N';
  return h('li', {class: `card ${best ? 'best' : ''}`},
    h('h3', {}, card.title), h('p', {class: 'formula soft'}, card.formula),
    h('div', {class: 'gain', role: 'img', 'aria-label': `lowers the error by ${percent(reduction)}, standard error ${percent(card.error_reduction_se)}`},
      h('span', {class: 'track'}, h('span', {class: 'bar', style: `width:${Math.max(0, 100 * reduction)}%`}),
        card.error_reduction_se ? h('span', {class: 'interval', style: `left:${Math.max(0, 100 * (reduction - card.error_reduction_se))}%;width:${Math.min(100, 200 * card.error_reduction_se)}%`}) : null),
      h('span', {}, `−${percent(reduction)} → ${quantity(card.holdout_rmse_N, 'N')}`)),
    profiles ? fingerprint(card, profiles, residualKey) : null,
    h('p', {}, card.evidence || card.look),
    card.confounded_with?.length ? h('p', {class: 'warn'}, `This log cannot tell it from ${card.confounded_with.map(titleOf).join(', ').toLowerCase()}.`) : null,
    h('details', {open: best}, h('summary', {}, 'Cause and experiment'),
      h('dl', {}, h('dt', {}, 'Usual cause'), h('dd', {}, card.cause), h('dt', {}, 'The experiment that decides'), h('dd', {}, card.confirm), h('dt', {}, 'It would look like'), h('dd', {}, card.look))),
    output,
    h('div', {class: 'buttons'}, h('button', {type: 'button', class: best ? 'main' : '', 'data-add': card.effect, onclick: () => add(card.definition ?? card.effect)}, `Add ${card.title.toLowerCase()}`),
      h('button', {type: 'button', onclick: () => preview(card, output)}, 'What would it do?'),
      h('button', {type: 'button', onclick: () => showExpected(card)}, 'Show in the charts')));
}

function limits(found) {
  const parts = [];
  if (found.cannot_separate.length) {
    parts.push(h('p', {}, 'This log cannot separate: ', found.cannot_separate.map((pair) => `${titleOf(pair.effect).toLowerCase()} from ${titleOf(pair.other).toLowerCase()}`).join('; '), '.'));
  }
  if (found.cannot_show.length) {
    parts.push(h('details', {}, h('summary', {}, `${found.cannot_show.length} effects that this log would not show`),
      h('ul', {}, found.cannot_show.map((one) => h('li', {}, `${titleOf(one.effect)}: seen only from ${quantity(one.least_visible_N, 'N')} on`)))));
  }
  if (found.next_experiment) {
    parts.push(h('p', {}, `Next experiment: ${found.next_experiment.why}.`),
      h('div', {class: 'buttons'}, h('button', {type: 'button', onclick: () => { store.planFor = found.next_experiment.for.join(','); tell('plan-for'); byId('tab-experiment').click(); }}, 'Plan it')));
  }
  return parts.length ? h('section', {class: 'limits'}, h('h3', {}, 'What this log does not say'), parts) : null;
}

function own() {
  const error = h('p', {class: 'warn', id: 'own-error', hidden: true});
  const input = h('input', {type: 'text', id: 'own', spellcheck: false, placeholder: 'snag = A*exp(-((x-x0)/w)^2)*sign(v); A: N; x0: m; w: m in [1e-4, 1e-2]'});
  const run = async (work) => {
    error.hidden = true;
    try { await work(); } catch (problem) { error.textContent = problem.message; error.hidden = false; }
  };
  input.setAttribute('aria-describedby', 'own-error');
  return h('section', {class: 'own'}, h('h3', {}, 'Your own suspicion'), h('label', {for: 'own'}, 'An expression of x, v, a, t, with its units'), input, error,
    h('div', {class: 'buttons'}, h('button', {type: 'button', onclick: () => run(() => post('diagnose', {user_effects: [input.value]}))}, 'Try it beside the others'),
      h('button', {type: 'button', onclick: () => run(() => post('add', {effect: input.value}))}, 'Add it')));
}

function draw() {
  const host = byId('missing');
  const version = currentVersion();
  if (!version) { host.replaceChildren(h('p', {class: 'empty'}, 'Fit a first model; then ask here what it lacks.')); return; }
  const found = store.state.diagnosis;
  const ask = h('button', {type: 'button', class: found ? '' : 'main', id: 'diagnose', onclick: () => attempt(() => post('diagnose'))}, found ? 'Ask again' : 'What is missing?');
  if (!found) {
    host.replaceChildren(h('h2', {}, 'What is missing?'), h('p', {}, 'Every effect of the catalogue is tried on top of the model and judged on data that the fit has not seen.'), h('div', {class: 'buttons'}, ask), own());
    return;
  }
  const missing = found.verdict === 'missing_effect';
  fill(host, h('h2', {class: `verdict ${found.verdict}`}, found.headline), h('p', {}, found.detail),
    found.unexplained ? h('p', {class: 'warn'}, found.unexplained.description) : null,
    found.input_warnings.length ? h('ul', {class: 'warn'}, found.input_warnings.map((one) => h('li', {}, one.what))) : null,
    h('ol', {class: 'cards'}, found.candidates.slice(0, kCards).map((card, i) => candidate(card, missing && i === 0))),
    limits(found), h('div', {class: 'buttons'}, ask), own(), h('p', {class: 'soft'}, 'The same on the command line: ', h('code', {}, found.command)));
}

export function startMissing() {
  on('diagnosis', draw);
  on('charts', draw);
}
