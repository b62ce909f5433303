// SPDX-License-Identifier: Apache-2.0
// Clients that stall, without a browser: node stalled_clients.test.mjs SLIPSTACK SLIPSTACK_SIM FOLDER
// Hundreds of connections that send nothing, that send a request byte by byte, that take nothing of their events or of a
// download, with and without the token. Meanwhile others are served, memory, threads and descriptors are bounded, and those
// that stalled are left in the end.
// Exit 0: all passed; 1: something failed.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import fs from 'node:fs';
import net from 'node:net';
import path from 'node:path';
import {kJobs_ms, serve} from './workbench_page.mjs';

const [, , slipstack, simulator, folder] = process.argv;
const kLeft_ms = 10000;      // limits of workbench/serve/http/connections.h: a client that stalls is left after so long
const kAnswer_ms = 1500;     // of a server with nothing to do but this, beside the other work of a machine; a thread that is not free takes 10 s
const kMostMemory_bytes = 60e6;  // beyond what the server takes without them
const kMostThreads = 270;
const kMostDescriptors = 700;

fs.rmSync(folder, {recursive: true, force: true});
fs.mkdirSync(folder, {recursive: true});
const log = path.join(folder, 'log.csv');
execFileSync(simulator, ['log', '--setup', 'pick_and_place', '--seed', '11', '--effects', 'viscous', '--strength', '5', '--seconds', '60', '--out', log]);
const server = await serve(slipstack, path.join(folder, 'session'), log);
const {port} = new URL(server.origin);
for (const end = Date.now() + kJobs_ms; ;) {
  const {measured, job} = await (await server.ask('state')).json();
  if (measured && !job.running) break;
  assert.ok(Date.now() < end, 'the log is not opened');
  await new Promise((done) => setTimeout(done, 50));
}

const status = (name) => Number(new RegExp(`${name}:\\s+(\\d+)`).exec(fs.readFileSync(`/proc/${server.child.pid}/status`, 'utf8'))[1]);
const descriptors = () => fs.readdirSync(`/proc/${server.child.pid}/fd`).length;
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const before = {memory_bytes: 1024 * status('VmRSS'), descriptors: descriptors()};

const stalled = [];
const timers = [];

// A connection that sends `text`, at once or byte by byte, and takes nothing.
function stall(kind, text, byByte = false) {
  const socket = net.connect({host: '127.0.0.1', port: Number(port)});
  const one = {kind, socket, closed: false};
  socket.pause();
  socket.on('error', () => {});
  socket.on('close', () => { one.closed = true; });
  if (byByte) {
    let sent = 0;
    timers.push(setInterval(() => { if (sent < text.length && !one.closed) socket.write(text[sent++]); }, 200));
  } else {
    socket.write(text);
  }
  stalled.push(one);
}

const head = (method, what, fields = '') => `${method} /api/${what} HTTP/1.1\r\nHost: 127.0.0.1:${port}\r\nAuthorization: Bearer ${server.token}\r\n${fields}\r\n`;
const stranger = (method, what, fields = '') => head(method, what, fields).replace(server.token, '0');

for (let i = 0; i < 300; ++i) stall('silent', '');
for (let i = 0; i < 100; ++i) stall('byte by byte', head('GET', 'state', `X: ${'x'.repeat(1000)}\r\n`), true);
for (let i = 0; i < 60; ++i) stall('events', head('GET', 'events'));
for (let i = 0; i < 3; ++i) stall('upload', `${head('POST', 'upload?name=x.csv', 'Content-Length: 1000000000\r\n')}time_s`);
for (let i = 0; i < 100; ++i) stall('note', `${head('POST', 'notes', 'Content-Length: 1000\r\n')}{`);
for (let i = 0; i < 40; ++i) stall('endless', `${head('POST', 'notes', 'Transfer-Encoding: chunked\r\n')}1000000\r\n${'x'.repeat(65536)}`);
for (let i = 0; i < 40; ++i) stall('download', head('GET', 'download?what=csv', 'Connection: close\r\n'));
for (let i = 0; i < 40; ++i) stall('stranger', `${stranger('POST', 'upload?name=x.csv', 'Content-Length: 1000000000\r\n')}time_s`);

// The server closes the connection that was idle longest when there are too many, and may do so just when its client sends: a
// browser then sends a request that changes nothing once more (RFC 9112, 9.3.1), which fetch() of node does not.
let repeated = 0;
async function asBrowser(send) {
  try {
    return await send();
  } catch (error) {
    if (error.cause?.code !== 'UND_ERR_SOCKET') throw error;
    ++repeated;
    return send();
  }
}

// Others are served, throughout.
let slowest_ms = 0;
let asked = 0;
for (const end = Date.now() + 1.3 * kLeft_ms; Date.now() < end; ++asked) {
  for (const what of ['state', 'picture?log=0&signal=force&from=0&to=60&points=800', 'rows']) {
    const begin = performance.now();
    const answer = await asBrowser(() => server.ask(what, {signal: AbortSignal.timeout(2 * kLeft_ms)}));
    await answer.arrayBuffer();
    assert.equal(answer.status, 200, what);
    slowest_ms = Math.max(slowest_ms, performance.now() - begin);
  }
  const page = await asBrowser(() => fetch(server.origin));
  assert.match(await page.text(), /slipstack workbench/);
  await wait(200);
}
const during = {memory_bytes: 1024 * status('VmHWM'), threads: status('Threads')};
// Events come to who follows anew, whatever holds the places of others.
const events = await server.ask('events');
const {value} = await events.body.getReader().read();
assert.match(new TextDecoder().decode(value), /event: state/);

// Whoever stalled is left; a node sees that only when it reads. Of the events the newest are kept: nobody can see whether a page
// looks at them.
for (const {socket} of stalled) socket.resume();
for (const end = Date.now() + 2 * kLeft_ms; stalled.some((one) => !one.closed && one.kind !== 'events') && Date.now() < end;) await wait(100);
const still = {};
for (const one of stalled) if (!one.closed) still[one.kind] = (still[one.kind] ?? 0) + 1;
console.log(`${stalled.length} stalled clients: slowest of ${4 * asked} answers ${slowest_ms.toFixed(0)} ms, ${((during.memory_bytes - before.memory_bytes) / 1e6).toFixed(0)} MB more, ${during.threads} threads, ` +
  `${descriptors()} descriptors at the end (${before.descriptors} before), still open: ${JSON.stringify(still)}`);
assert.deepEqual(Object.keys(still).filter((kind) => kind !== 'events'), []);
assert.ok((still.events ?? 0) <= 32, `${still.events} streams of events are open`);
assert.ok(repeated <= asked / 10, `${repeated} of ${4 * asked} requests had to be sent again`);
assert.ok(slowest_ms < kAnswer_ms, `an answer took ${slowest_ms} ms`);
assert.ok(during.memory_bytes - before.memory_bytes < kMostMemory_bytes, `${during.memory_bytes - before.memory_bytes} bytes more`);
assert.ok(during.threads < kMostThreads, `${during.threads} threads`);
assert.ok(descriptors() < kMostDescriptors, `${descriptors()} descriptors`);
for (const timer of timers) clearInterval(timer);
for (const {socket} of stalled) socket.destroy();
// And it ends when it is told to.
const asked_ms = performance.now();
await Promise.race([server.stop(), wait(5000).then(() => assert.fail('the server does not end'))]);
console.log(`ended after ${(performance.now() - asked_ms).toFixed(0)} ms; all passed`);
process.exit(0);
