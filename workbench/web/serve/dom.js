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

export const percent = (share) => (share === null || share === undefined ? '–' : `${withMinus((100 * share).toPrecision(3))}\u00a0%`);

// A question or a table over the page; returns when it is closed, with the value of the button.
export function dialog(title, content, buttons = [{label: 'Close', value: ''}]) {
  return new Promise((done) => {
    const box = h('dialog', {'aria-labelledby': 'dialog-title'},
      h('form', {method: 'dialog'}, h('h2', {id: 'dialog-title'}, title), content,
        h('div', {class: 'buttons'}, buttons.map(({label, value, main}) => h('button', {value, class: main ? 'main' : ''}, label)))));
    box.addEventListener('close', () => { box.remove(); done(box.returnValue); });
    document.body.append(box);
    box.showModal();
  });
}
