// SPDX-License-Identifier: Apache-2.0
// Building the page. Texts are always text: nothing from a log or a server becomes markup.

export function h(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (name === 'class') node.className = value;
    else if (name in node && typeof value !== 'string') node[name] = value;
    else node.setAttribute(name, value === true ? '' : value);
  }
  node.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return node;
}

export function svg(tag, attributes = {}, ...children) {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children.flat().filter(Boolean));
  return node;
}

// The children of a node, without what is not there.
export const fill = (node, ...children) => node.replaceChildren(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));

export const byId = (id) => document.getElementById(id);

// Runs what a button asks for; what goes wrong is said, not lost.
export async function attempt(work) {
  say('');
  try {
    return await work();
  } catch (error) {
    say(error.message);
    return undefined;
  }
}

export function say(text, kind = 'error') {
  const box = byId('message');
  box.textContent = text;
  box.hidden = !text;
  box.dataset.kind = kind;
}

export function save(blob, name) {
  const link = h('a', {href: URL.createObjectURL(blob), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

export const readable = (id) => id.replaceAll('_', ' ').replace(/^./, (first) => first.toUpperCase());

// A value with a good unit: 0.0123 N -> "12.3 mN".
export function quantity(value, unit, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const {perSi, label} = displayUnit(unit, Math.abs(value));
  const text = withMinus(Number((value * perSi).toPrecision(digits)).toString());
  return label === '1' || label === '' ? text : `${text}\u00a0${label}`;
}

// Two values with one unit, or one where they read the same: "14 to 135 mm".
export function span(low, high, unit) {
  const {perSi, label} = displayUnit(unit, Math.max(Math.abs(low), Math.abs(high)));
  const digits = Math.max(0, 2 - Math.floor(Math.log10(Math.max(Math.abs(low), Math.abs(high)) * perSi || 1)));
  const [from, to] = [low, high].map((value) => withMinus((value * perSi).toFixed(digits)));
  return from === to ? `at ${from}\u00a0${label}` : `${from} to ${to}\u00a0${label}`;
}

// A text of the server as a sentence: a capital, a full stop, signs and units as the page writes them.
export const sentence = (text) => text.replace(/^./, (first) => first.toUpperCase()).replace(/(?<=^|[ (])-(?=\d)/g, '\u2212').replace(/(?<=\d )\+-(?= \d)/g, '±').replace(/(?<=\d )u(?=(N|m|s|A|rad)\b)/g, 'µ').replace(/(?<=\d) (?=%|[µmkn]?(N|m|s|A|Hz|kg|rad|deg|rev)\b)/g, '\u00a0').replace(/(?<=\d\u00a0[µmkn]?(N|kg)) (?=(m|s|m2)\b)/g, '\u00a0').replace(/[^.]$/, '$&.');

// "Stribeck effect: friction falls with velocity" is called Stribeck effect where there is little room.
export const shortTitle = (title) => title.split(/: | \(/)[0];

// A title within a sentence: names of people keep their capital.
export const inSentence = (title) => (/^(Stribeck|Coulomb|Maxwell)/.test(title) ? title : title.replace(/^./, (first) => first.toLowerCase()));

export const percent = (share) => (share === null || share === undefined ? '–' : `${withMinus(Math.abs(share) < 0.01 ? (100 * share).toFixed(1) : (100 * share).toPrecision(3))}\u00a0%`);

// A question or a table over the page; returns when it is closed, with the value of the button.
export function dialog(title, content, buttons = [{label: 'Close', value: ''}]) {
  return new Promise((done) => {
    const box = h('dialog', {'aria-labelledby': 'dialog-title'},
      h('form', {method: 'dialog'}, h('h2', {id: 'dialog-title'}, title), content,
        h('div', {class: 'buttons'}, buttons.map(({label, value, main}) => h('button', main || buttons.length === 1 ? {value, class: main ? 'main' : ''}
          : {type: 'button', onclick: () => box.close(value)}, label)))));  // Enter in a field means the main button
    box.addEventListener('close', () => { box.remove(); done(box.returnValue); });
    document.body.append(box);
    box.showModal();
  });
}
