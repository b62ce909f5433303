// SPDX-License-Identifier: Apache-2.0
// The main states of the workbench and the reports of the tutorial as pictures: compared with those of the pages, or made anew:
//   node pictures.test.mjs SLIPSTACK SLIPSTACK_SIM FOLDER docs/pictures [--renew]
// Compared are means of blocks of pixels, not pixels: what a reader would see, not how a letter is smoothed. Another font moves
// every line, so where the browser draws texts with other widths than those of the references nothing can be said.
// Exit 0: all as in the references; 1: something differs (FOLDER has the new picture, and where it differs); 77: no browser
// here, or other fonts.
import {execFileSync} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import {drawn, idle, kJobs_ms, launch, openPage, serve, skip} from './workbench_page.mjs';

const [, , slipstack, simulator, folder, references, renew] = process.argv;
const kSize = {width: 1360, height: 860};
const kBlock = 8;             // pixels: about a letter
const kBlockDiffers = 24;     // of 255, in any colour: a line of one pixel across a block changes it by about as much
const kMostDiffering = 0.01;  // share of the blocks. Two runs on one machine differ in none; a moved heading in about 0.02

fs.rmSync(folder, {recursive: true, force: true});
fs.mkdirSync(folder, {recursive: true});
const browser = await launch();
const signs = path.join(references, 'serve.json');
const log = path.join(folder, 'log.csv');
execFileSync(simulator, ['log', '--setup', 'pick_and_place', '--seed', '11', '--effects', 'viscous', '--strength', '5', '--seconds', '20', '--out', log]);

// --- comparing ---

// Widths of a text in the fonts of the page: the same only where the fonts are.
const widths = (page) => page.evaluate(() => {
  const context = document.createElement('canvas').getContext('2d');
  return ['14px', '600 20px', '11px', '12px monospace'].map((font) => {
    context.font = font.includes('mono') ? font : `${font} ${getComputedStyle(document.body).fontFamily}`;
    return Math.round(10 * context.measureText('Pre-sliding hysteresis 0123456789 µm, WMil').width) / 10;
  });
});

// Share of the blocks that differ, and a picture of them. `ignored`: rectangles that show what no two runs have alike.
const compare = (page, one, other, ignored) => page.evaluate(async ([sources, rectangles, block, least]) => {
  const images = await Promise.all(sources.map(async (source) => createImageBitmap(await (await fetch(source)).blob())));
  if (images[0].width !== images[1].width || images[0].height !== images[1].height) return {share: 1, why: `${images[0].width} × ${images[0].height} pixels instead of ${images[1].width} × ${images[1].height}`};
  const [first, second] = images.map((image) => {
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    return context.getImageData(0, 0, image.width, image.height);
  });
  const {width, height} = first;
  const canvas = document.createElement('canvas');
  Object.assign(canvas, {width, height});
  const context = canvas.getContext('2d');
  context.drawImage(images[0], 0, 0);
  context.fillStyle = 'rgb(255 0 255 / 45%)';
  let differing = 0;
  let all = 0;
  for (let y = 0; y + block <= height; y += block) {
    for (let x = 0; x + block <= width; x += block) {
      if (rectangles.some((r) => x + block > r.x && x < r.x + r.width && y + block > r.y && y < r.y + r.height)) continue;
      const sums = [0, 0, 0];
      for (let v = y; v < y + block; ++v) {
        for (let u = x; u < x + block; ++u) {
          const at = 4 * (v * width + u);
          for (let c = 0; c < 3; ++c) sums[c] += first.data[at + c] - second.data[at + c];
        }
      }
      ++all;
      if (Math.max(...sums.map(Math.abs)) / (block * block) < least) continue;
      ++differing;
      context.fillRect(x, y, block, block);
    }
  }
  return {share: differing / all, picture: canvas.toDataURL('image/png')};
}, [[one, other].map((bytes) => `data:image/png;base64,${bytes.toString('base64')}`), ignored, kBlock, kBlockDiffers]);

const judge = await (await browser.newContext()).newPage();
const made = [];
let failed = 0;

// `clip`: the rectangle of the whole page that is shown; else what the window shows.
async function picture(page, name, ignored = [], clip = undefined) {
  await page.mouse.move(0, 0);
  await page.waitForTimeout(600);  // a transition has ended
  const rectangles = [];
  for (const one of ignored) rectangles.push(await page.locator(one).boundingBox());
  const bytes = await page.screenshot({animations: 'disabled', caret: 'hide', fullPage: clip !== undefined, clip});
  made.push(name);
  const file = path.join(references, `${name}.png`);
  if (renew) { fs.writeFileSync(file, bytes); return; }
  if (!fs.existsSync(file)) { ++failed; console.log(`FAILED  ${name}: there is no reference; --renew makes it`); return; }
  const {share, why, picture: marked} = await compare(judge, bytes, fs.readFileSync(file), rectangles);
  const bad = share > kMostDiffering;
  console.log(`${bad ? 'FAILED' : 'ok    '}  ${name}: ${(100 * share).toFixed(2)} % of the blocks differ${why ? `, ${why}` : ''}`);
  if (!bad) return;
  ++failed;
  fs.writeFileSync(path.join(folder, `${name}.png`), bytes);
  if (marked) fs.writeFileSync(path.join(folder, `${name}-differs.png`), Buffer.from(marked.split(',')[1], 'base64'));
}

// --- the states ---

const open = (url, options) => openPage(browser, url, {viewport: kSize, ...options});
const fitted = async (page, version = 1) => { await page.locator('#fit').waitFor({timeout: kJobs_ms}); await idle(page); await page.locator('#fit').click(); await drawn(page, version); await idle(page); };

async function working() {
  const server = await serve(slipstack, path.join(folder, 'work'), log);
  const page = await open(server.url);
  const now = {browser: browser.version().split('.')[0], widths: await widths(page)};
  if (renew) fs.writeFileSync(signs, JSON.stringify(now) + '\n');
  else {
    const then = JSON.parse(fs.readFileSync(signs, 'utf8'));
    if (JSON.stringify(then.widths) !== JSON.stringify(now.widths)) {
      await browser.close();
      await server.stop();
      skip(`this browser (Chromium ${now.browser}) has other fonts than that of the references (${then.browser}): widths ${now.widths} instead of ${then.widths}`);
    }
  }
  await page.locator('#fit').waitFor({timeout: kJobs_ms});
  await idle(page);
  await picture(page, 'serve-loaded');
  await fitted(page);
  await picture(page, 'serve-compare');
  await page.locator('#tab-missing').click();
  await page.locator('#diagnose').click();
  await page.locator('.card.best').waitFor({timeout: kJobs_ms});
  await idle(page);
  await picture(page, 'serve-missing');
  await page.locator('.card.best .buttons button.main').click();
  await drawn(page, 2);
  await idle(page);
  await page.locator('#tab-model').click();
  await picture(page, 'serve');
  await page.emulateMedia({colorScheme: 'dark'});
  await picture(page, 'serve-dark');
  await page.emulateMedia({colorScheme: 'light'});
  await page.locator('[data-chart=density]').scrollIntoViewIfNeeded();
  await page.evaluate(() => document.querySelector('[data-chart=density]').scrollIntoView({block: 'start'}));
  await picture(page, 'serve-frequency');
  await page.setViewportSize({width: 390, height: 800});
  await page.evaluate(() => scrollTo(0, 0));
  await picture(page, 'serve-phone');
  await page.setViewportSize(kSize);
  server.child.removeAllListeners('exit');
  server.child.kill('SIGKILL');
  await page.getByText('The server does not answer').waitFor({timeout: 20000});
  await picture(page, 'serve-error');
  await page.context().close();
}

async function live() {
  const server = await serve(slipstack, path.join(folder, 'live'));
  const page = await open(server.url);
  await page.locator('#empty').waitFor();
  await picture(page, 'serve-empty');
  await page.locator('[data-simulate]').click();
  await page.locator('#seed').fill('11');
  await page.locator('#hidden').fill('viscous');
  await page.getByRole('button', {name: 'Start it'}).click();
  await fitted(page);
  await page.locator('#connect').click();
  await page.locator('#live-rate').fill('500');
  await page.locator('dialog').getByRole('button', {name: 'Connect'}).click();
  const move = async () => {
    await page.locator('#live-move').click();
    await page.locator('#move-times').fill('3');
    await page.locator('dialog').getByRole('button', {name: 'Move'}).click();
    await page.waitForFunction(() => window.slipstackWorkbench.store.state.job.what === 'move the axis');
    await idle(page);
  };
  await page.locator('#live-move').waitFor({timeout: kJobs_ms});
  await move();
  await page.locator('#tab-experiment').click();
  await page.locator('#travel').fill('0');
  await page.locator('#deploy').click();
  await page.waitForFunction(() => window.slipstackWorkbench.store.state.deployed, null, {timeout: kJobs_ms});
  await idle(page);
  await move();
  await page.locator('#tab-model').click();
  await page.evaluate(() => scrollTo(0, 0));
  await page.locator('#live-hold').click();
  await picture(page, 'serve-live', ['#live-charts', '#live-parts tbody', '#live-happened']);
  await page.context().close();
  await server.stop();
}

// The pictures of docs/tutorial, by the commands of its pages.
async function tutorial() {
  const run = (...command) => execFileSync(slipstack, command, {cwd: folder});
  run('experiment', 'loops', '--setup', 'pick_and_place', '--report', 'loops.html');
  run('loop', '--seed', '11', '--effects', 'stribeck', '--strength', '8', '--out', 'raw.csv');
  run('fit', 'raw.csv', '--effects', 'inertia,coulomb,viscous', '--report', 'velocity.html');
  run('fit', 'raw.csv', '--effects', 'inertia,presliding_hysteresis', '--model', 'first.toml', '--report', 'hysteresis.html');
  run('diagnose', 'raw.csv', '--model', 'first.toml', '--report', 'missing.html');
  const shown = async (name, selector, height) => {
    const page = await (await browser.newContext({viewport: {width: 1100, height: 860}})).newPage();
    await page.goto(`file://${path.resolve(folder, `${name}.html`)}`);
    await page.locator('canvas').first().waitFor();
    const box = await page.locator(selector).first().boundingBox();
    await picture(page, `tutorial-${name}`, [], {x: 0, y: Math.max(0, box.y - 12), width: 1100, height: Math.min(height, box.height + 24)});
    await page.context().close();
  };
  const hysteresis = 'section:has(h2:text-is("Hysteresis"))';
  await shown('loops', 'section:has(h2:text-is("Pictures"))', 440);
  await shown('velocity', hysteresis, 430);
  await shown('hysteresis', hysteresis, 430);
  await shown('missing', 'section.verdict', 860);
}

try {
  await working();
  await tutorial();
  await live();
} catch (error) {
  ++failed;
  console.log(`FAILED  ${error.stack}`);
}
await browser.close();
console.log(failed ? `${failed} failed; where the change is meant: add --renew, and look at the pictures` : renew ? `made ${made.join(', ')}` : 'all as in the references');
process.exit(failed ? 1 : 0);
