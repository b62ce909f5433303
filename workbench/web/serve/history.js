// SPDX-License-Identifier: Apache-2.0
// All versions as a tree, with branches; what is drawn beside the current one; notes; what can be saved.
import {download, get, post} from '/api.js';
import {attempt, byId, fill, h, quantity, save} from '/dom.js';
import {currentVersion, on, store, tell} from '/store.js';

function branch(parent) {
  const children = store.state.versions.filter((version) => version.parent === parent);
  if (!children.length) return null;
  return h('ul', {class: 'tree'}, children.map((version) => h('li', {},
    h('div', {class: `row ${version.id === store.state.current ? 'now' : ''}`},
      h('button', {type: 'button', class: 'version', 'aria-current': version.id === store.state.current ? 'true' : undefined, onclick: () => attempt(() => post('select', {version: version.id}))},
        h('b', {}, `${version.id}. ${version.what.replaceAll('_', ' ')}`), h('span', {}, quantity(version.after_N, 'N')), h('span', {class: 'soft'}, version.date.replace('T', ' ').replace('Z', ''))),
      version.id !== store.state.current ? h('button', {type: 'button', class: 'small', 'aria-pressed': String(store.besideId === version.id),
        onclick: () => { store.besideId = store.besideId === version.id ? null : version.id; tell('beside'); draw(); }}, 'Beside') : null),
    branch(version.id))));
}

const kFiles = [['report', 'Report (HTML)'], ['toml', 'Model (TOML)'], ['header', 'Model (C header)'], ['json', 'Model (JSON)'], ['csv', 'Visible data (CSV)'], ['mat', 'Visible data (MAT)']];

export async function give(what) {
  const version = currentVersion();
  if (!version) return;
  const query = {what, version: version.id};
  if ((what === 'csv' || what === 'mat') && store.range) Object.assign(query, {from: store.range.min, to: store.range.max});
  const {name, blob} = await download(query);
  save(blob, name);
}

async function draw() {
  const host = byId('history');
  if (!store.state.versions.length) { host.replaceChildren(h('p', {class: 'empty'}, 'Every model that you make is kept here.')); return; }
  fill(host, h('h2', {}, 'Versions'), h('p', {class: 'soft'}, 'Select one to go there; add to an older one to branch. Beside: draw it as the model before.'), branch(0),
    h('h2', {}, 'Save'), h('div', {class: 'buttons wrap'}, kFiles.map(([what, label]) => h('button', {type: 'button', 'data-save': what, onclick: () => attempt(() => give(what))}, label)),
      h('button', {type: 'button', onclick: () => print()}, 'Print or PDF')),
    h('h2', {}, 'Notes'), notes, h('p', {class: 'soft'}, `Kept as plain files in ${store.state.folder}; the command line reads and writes them.`));
}

const notes = h('textarea', {rows: 6, 'aria-label': 'Notes', onchange: () => attempt(() => post('notes', {text: notes.value}))});

export function startHistory() {
  on('version', draw);
  get('notes').then(({text}) => { notes.value = text; }).catch(() => {});
}
