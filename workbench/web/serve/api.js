// SPDX-License-Identifier: Apache-2.0
// Requests to the server. The token comes with the address, behind the #, and stays in this tab.

function takeToken() {
  const given = new URLSearchParams(location.hash.slice(1)).get('token');
  try {
    if (given) sessionStorage.setItem('token', given);
    return given ?? sessionStorage.getItem('token') ?? '';
  } catch {
    return given ?? '';
  }
}

const headers = {Authorization: `Bearer ${takeToken()}`};

class Refused extends Error {}

async function checked(response) {
  if (response.ok) return response;
  let text = `${response.status} ${response.statusText}`;
  let picture = '';
  try {
    ({error: text, picture = ''} = await response.json());
  } catch {
    // No JSON: the status says it.
  }
  throw new Refused(picture ? `${text}\n${picture}` : text);
}

const address = (path, query) => (query ? `/api/${path}?${new URLSearchParams(query)}` : `/api/${path}`);

export async function get(path, query, signal) {
  return (await checked(await fetch(address(path, query), {headers, signal}))).json();
}

let effects = null;

// The effects of the catalogue: they do not change while the server runs.
export async function catalogue() {
  effects ??= await get('catalogue');
  return effects;
}

export async function post(path, body = {}) {
  const response = await fetch(address(path), {
    method: 'POST', headers: {...headers, 'Content-Type': 'application/json'}, body: JSON.stringify(body)});
  return (await checked(response)).json();
}

export async function upload(name, content, profile) {
  const response = await fetch(address('upload', profile ? {name, profile} : {name}), {
    method: 'POST', headers: {...headers, 'Content-Type': 'application/octet-stream'}, body: content});
  return (await checked(response)).json();
}

// Arrays of numbers: {header, time_s: Float64Array, ...}; see workbench/serve/http/bytes.h.
function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const out = {header};
  let at = 4 + length;
  for (const {name, type, length: count} of header.arrays) {
    out[name] = type === 'f8' ? new Float64Array(buffer, at, count) : new Float32Array(buffer, at, count);
    at += Math.ceil(count * (type === 'f8' ? 8 : 4) / 8) * 8;
  }
  return out;
}

export async function bytes(path, query, signal) {
  return unpack(await (await checked(await fetch(address(path, query), {headers, signal}))).arrayBuffer());
}

export async function postForBytes(path, body) {
  const response = await fetch(address(path), {
    method: 'POST', headers: {...headers, 'Content-Type': 'application/json'}, body: JSON.stringify(body)});
  return unpack(await (await checked(response)).arrayBuffer());
}

export async function download(query) {
  const response = await checked(await fetch(address('download', query), {headers}));
  const name = /filename="([^"]*)"/.exec(response.headers.get('Content-Disposition') ?? '')?.[1] ?? 'slipstack';
  return {name, blob: await response.blob()};
}

const payload = (message) => JSON.parse(message.slice(message.indexOf('data: ') + 6));

const kHidden_ms = 2000;  // a tab that is only passed on the way to another keeps its events

// Ends when the tab has been hidden for a while. A browser opens six connections to a server, whatever the tabs: six of them
// that follow would leave none for anything else.
function untilHidden() {
  const end = new AbortController();
  let timer = 0;
  const look = () => {
    clearTimeout(timer);
    if (document.visibilityState === 'hidden') timer = setTimeout(() => end.abort(), kHidden_ms);
  };
  look();
  document.addEventListener('visibilitychange', look);
  end.signal.addEventListener('abort', () => document.removeEventListener('visibilitychange', look));
  return end;
}

const shown = () => new Promise((done) => {
  const look = () => {
    if (document.visibilityState === 'hidden') return;
    document.removeEventListener('visibilitychange', look);
    done();
  };
  document.addEventListener('visibilitychange', look);
  look();
});

// Calls `onState` with every state that the server tells, `onLive` with new signals of a controller, and `onLink` with
// whether the server is there. An EventSource cannot
// send the token in a header.
export async function follow(onState, onLive, onLink) {
  for (;;) {
    await shown();
    const hidden = untilHidden();
    try {
      const response = await checked(await fetch(address('events'), {headers, signal: hidden.signal}));
      onLink('');
      const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
      let text = '';
      for (;;) {
        const {value, done} = await reader.read();
        if (done) break;
        text += value;
        const messages = text.split('\n\n');
        text = messages.pop();
        const last = messages.filter((message) => message.includes('event: state')).pop();
        if (last) onState(payload(last));
        for (const message of messages) if (message.includes('event: live')) onLive(payload(message));
      }
      throw new Error('the server ended');
    } catch (error) {
      if (hidden.signal.aborted) continue;
      hidden.abort();
      onLink(error instanceof Refused ? error.message : 'The server does not answer. Start slipstack serve again and open the address that it prints; the session is kept.');
      if (error instanceof Refused) return;
      await new Promise((done) => setTimeout(done, 1000));
    }
  }
}
