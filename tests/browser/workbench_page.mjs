// SPDX-License-Identifier: Apache-2.0
// A server of the workbench and a page of it, for the tests.
import {spawn} from 'node:child_process';
import fs from 'node:fs';

const kJobs_ms = 120000;  // a fit on a slow machine with sanitizers of others beside it
// First the one without windows and tabs of its own, which starts and draws faster.
const kBrowsers = [process.env.CHROMIUM, '/usr/bin/chromium-headless-shell', '/usr/bin/chromium',
  '/usr/bin/chromium-browser', '/usr/bin/google-chrome'];

export function skip(reason) {
  console.log(`SKIP: ${reason}`);
  process.exit(77);
}

// A browser; ends the test with SKIP where there is none.
export async function launch() {
  const executablePath = kBrowsers.find((file) => file && fs.existsSync(file));
  if (!executablePath) skip('no Chromium on this machine (Debian package: chromium-headless-shell)');
  let chromium;
  try {
    ({chromium} = await import('playwright-core'));
  } catch {
    skip("playwright-core is missing (toolchain/install)");
  }
  return chromium.launch({executablePath, args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync']});
}

// Servers that a failed test has left: they would hold its output open, and whoever reads it would wait.
const started = new Set();
process.on('exit', () => { for (const child of started) child.kill('SIGKILL'); });

// A server of its own for each test.
export async function serve(slipstack, session, ...logs) {
  const child = spawn(slipstack, ['serve', ...logs, '--session', session], {stdio: ['ignore', 'pipe', 'inherit']});
  started.add(child);
  child.on('close', () => started.delete(child));
  let out = '';
  const url = await new Promise((done, fail) => {
    child.stdout.on('data', (data) => { out += data; const found = /http:\S+/.exec(out); if (found) done(found[0]); });
    child.on('exit', (code) => fail(new Error(`slipstack serve ended with status ${code}`)));
  });
  const origin = new URL(url).origin;
  const token = new URL(url).hash.slice('#token='.length);
  const ask = (what, options = {}) => fetch(`${origin}/api/${what}`, {...options, headers: {Authorization: `Bearer ${token}`, ...options.headers}});
  const stop = () => new Promise((done) => { child.removeAllListeners('exit'); child.on('exit', done); child.kill('SIGTERM'); });
  return {url, origin, token, ask, stop, child};
}

// While `run` runs, the server works a tenth of the time: what the page shows in the middle of a job then does not depend on how fast the
// server is, or how busy the machine.
export async function slowly(server, run) {
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  let ends = false;
  const throttle = async () => {
    while (!ends) {
      server.child.kill('SIGSTOP');
      await wait(45);
      server.child.kill('SIGCONT');
      await wait(5);
    }
  };
  const throttled = throttle();
  try {
    return await run();
  } finally {
    ends = true;
    await throttled;
  }
}

export async function openPage(browser, url, options = {}) {
  const context = await browser.newContext({viewport: {width: 1500, height: 1000}, acceptDownloads: true, ...options});
  const page = await context.newPage();
  page.faults = [];
  page.on('console', (message) => { if (message.type() === 'error') page.faults.push(`${message.text()} ${message.location().url}`); });
  page.on('pageerror', (error) => page.faults.push(error.stack));
  await page.goto(url);
  return page;
}

export const idle = (page) => page.waitForFunction(() => window.slipstackWorkbench?.store.state?.job.running === false, null, {timeout: kJobs_ms});
export const drawn = (page, version) => page.waitForFunction((id) => document.body.dataset.drawn === String(id), version, {timeout: kJobs_ms});
export const state = (page) => page.evaluate(() => window.slipstackWorkbench.store.state);
export const current = async (page) => { const now = await state(page); return now.versions.find((version) => version.id === now.current); };

// Processor time of everything that this test has started, ms: what other work on the machine does not change.
export function processorTime_ms() {
  const processes = fs.readdirSync('/proc').filter((name) => /^\d+$/.test(name)).map((pid) => {
    try {
      const fields = fs.readFileSync(`/proc/${pid}/stat`, 'utf8').replace(/^.*\) /s, '').split(' ');
      return {pid: Number(pid), parent: Number(fields[1]), ticks: Number(fields[11]) + Number(fields[12])};
    } catch {
      return null;  // it has ended
    }
  }).filter(Boolean);
  const ours = new Set([process.pid]);
  for (let before = 0; before !== ours.size;) {
    before = ours.size;
    for (const one of processes) if (ours.has(one.parent)) ours.add(one.pid);
  }
  const kTick_ms = 10;  // USER_HZ of Linux
  return processes.filter((one) => ours.has(one.pid) && one.pid !== process.pid).reduce((sum, one) => sum + kTick_ms * one.ticks, 0);
}

export {kJobs_ms};
