// SPDX-License-Identifier: Apache-2.0
// What all parts of the page share, and who wants to know when it changes.

export const store = {
  state: null,        // as the server tells it
  rows: null,         // coordinates of the rows
  current: null,      // the model that is worked on: {version, header, measured_N, model_N, residual_N}
  beside: null,       // the one that it is compared with, or null
  bent: null,         // residual and errors with parameters set by hand
  charts: null,       // residual charts of the two
  range: null,        // time that is shown: {min, max}, s
  selected: null,     // Uint8Array over the rows: brushed samples
  cursors: [],        // up to two times, s
  tool: 'zoom',
  asked: null,        // when an effect was added or removed, while its answers are waited for: ms
};

const listeners = new Map();

export function on(what, listener) {
  if (!listeners.has(what)) listeners.set(what, []);
  listeners.get(what).push(listener);
}

export function tell(what) {
  for (const listener of listeners.get(what) ?? []) listener();
}

export const versionOf = (id) => store.state?.versions.find((version) => version.id === id) ?? null;
export const currentVersion = () => (store.state ? versionOf(store.state.current) : null);
// What is drawn: the version where the work stands, or the first answer of a job that refines it (`note` says so).
export const shownVersion = () => store.state?.first_answer ?? currentVersion();

// From the first version to this one.
export function lineage(version) {
  const chain = [];
  for (let at = version; at; at = versionOf(at.parent)) chain.unshift(at);
  return chain;
}
