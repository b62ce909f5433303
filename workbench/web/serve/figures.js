// SPDX-License-Identifier: Apache-2.0
// Small figures without axes: the falling error, and the fingerprint of a candidate.
import {h, inSentence, quantity, shortTitle, span, svg} from '/dom.js';

// One bar for each step of the history, the noise floor as a line: watch the error fall.
export function waterfall(steps, floor, pick) {
  const largest = Math.max(...steps.map((step) => step.error), floor || 0) || 1;
  const wide = (value) => `${Math.max(0.5, 100 * value / largest)}%`;
  return h('ol', {class: 'waterfall'}, steps.map((step, i) => h('li', {class: step.now ? 'now' : ''},
    h('button', {type: 'button', 'aria-current': step.now ? 'step' : undefined, onclick: () => pick(step.id),
                 'aria-label': `${step.what}: error ${quantity(step.error, 'N')}${step.now ? ', shown now' : ''}`},
      h('span', {class: 'name'}, step.what), h('span', {class: 'value'}, quantity(step.error, 'N')),
      h('span', {class: 'track'},
        i > 0 && steps[i - 1].error > step.error ? h('span', {class: 'fell', style: `left:${wide(step.error)};width:calc(${wide(steps[i - 1].error)} - ${wide(step.error)})`}) : null,
        h('span', {class: 'bar', style: `width:${wide(step.error)}`}),
        floor > 0 ? h('span', {class: 'floor', style: `left:${wide(floor)}`}) : null)))),
  floor > 0 ? h('li', {class: 'legend'}, h('span', {class: 'dash'}), `noise floor ${quantity(floor, 'N')}: what no model can explain`) : null);
}

// The coordinate over which the expected trace explains most of the mean residual. Over time every effect that acts can be
// seen, whatever it depends on: time is shown where no other coordinate explains half of its mean.
function bestProfile(profiles, expected, residualKey) {
  let best = null;
  profiles.forEach((profile, i) => {
    if (profile.coordinate === 'time' && best && best.share > 0.5) return;
    const mean = profile[residualKey] ?? profile.mean_N;
    const trace = expected?.[i];
    if (!mean || !trace) return;
    let before = 0;
    let after = 0;
    mean.forEach((value, k) => {
      if (value === null || trace[k] === null) return;
      before += value * value;
      after += (value - trace[k]) * (value - trace[k]);
    });
    const gain = before > 0 ? before - after : 0;
    if (!best || gain > best.gain) best = {gain, share: gain / (before || 1), profile, mean, trace};
  });
  return best;
}

// Mean residual (line) and what the effect would leave (dashed), over the coordinate that shows it best.
export function fingerprint(card, profiles, residualKey) {
  const best = bestProfile(profiles, card.expected, residualKey);
  if (!best) return null;
  const values = [...best.mean, ...best.trace].filter((value) => value !== null);
  const low = Math.min(...values);
  const high = Math.max(...values);
  const path = (line) => {
    let text = '';
    let down = false;
    line.forEach((value, i) => {
      if (value === null) { down = false; return; }
      text += `${down ? 'L' : 'M'}${(i / (line.length - 1) * 200).toFixed(1)} ${(4 + (high - value) / (high - low || 1) * 52).toFixed(1)}`;
      down = true;
    });
    return text;
  };
  return h('figure', {class: 'fingerprint'},
    svg('svg', {viewBox: '0 0 200 60', preserveAspectRatio: 'none', role: 'img', 'aria-label': `Mean residual over ${best.profile.coordinate} and the trace that ${card.title} would leave`},
      svg('path', {d: path(best.mean), class: 'residual'}), svg('path', {d: path(best.trace), class: 'expected'})),
    h('figcaption', {}, h('span', {class: 'key'}, h('span', {class: 'line', style: '--line: var(--before)'}), 'mean residual'), ' ',
      h('span', {class: 'key'}, h('span', {class: 'line dashed', style: '--line: var(--curve7)'}), `what ${inSentence(shortTitle(card.title))} would leave`),
      h('br'), `${span(low, high, 'N')} over ${best.profile.coordinate}, ${span(best.profile.x[0], best.profile.x[best.profile.x.length - 1], best.profile.unit)}`));
}
