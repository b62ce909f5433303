// SPDX-License-Identifier: Apache-2.0
// The report in a real browser: node report.test.mjs SYNTHETIC_REPORT REPORT_FROM_JSON FOLDER SLIPSTACK [--long]
// With --long those tests that open many pages, or long ones; without, the others.
// Exit 0: all passed; 1: something failed; 77: no browser here, nothing tested.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import {pathToFileURL} from 'node:url';
import {contrast, difference, kVision, rgb} from './colours.mjs';
import {pdfPages} from './pdf_text.mjs';
import {launch} from './workbench_page.mjs';

const [, , synthesize, render, folder, slipstack, which] = process.argv;
const kSeed = '7';

fs.mkdirSync(folder, {recursive: true});
const browser = await launch();

const made = new Map();

// The data of a synthetic report, every eighth sample of its series: most tests want charts, and a browser that draws
// without a graphics card takes seconds to read 40 000 samples.
function report(kind, whole) {
  const name = whole ? `${kind}-whole` : kind;
  if (!made.has(name)) {
    const json = path.join(folder, `${name}.json`);
    execFileSync(synthesize, [kind, kSeed, json]);
    const data = JSON.parse(fs.readFileSync(json, 'utf8'));
    if (!whole && data.series) {
      for (const column of Object.keys(data.series)) data.series[column] = data.series[column].filter((_, i) => i % 8 === 0);
      data.samples /= 8;
      data.sample_rate_Hz /= 8;
    }
    made.set(name, rendered(name, data));
  }
  return made.get(name);
}

function rendered(name, data) {
  const json = path.join(folder, `${name}.json`);
  const html = path.join(folder, `${name}.html`);
  fs.writeFileSync(json, JSON.stringify(data));
  execFileSync(render, [json, html]);
  return {data, html};
}

// Opens a synthetic report offline and keeps account of everything that it must not do.
async function open(kind, {width = 1400, height = 900, colorScheme = 'light', whole = false, edit} = {}) {
  let {data, html} = report(kind, whole);
  if (edit) {
    data = structuredClone(data);
    edit(data);
    ({html} = rendered(`${kind}-edited`, data));
  }
  return {data, ...await openPage(html, {width, height, colorScheme})};
}

async function openPage(html, {width = 1400, height = 900, colorScheme = 'light'} = {}) {
  const context = await browser.newContext({viewport: {width, height}, colorScheme, offline: true});
  const page = await context.newPage();
  const seen = {console: [], requests: []};
  page.on('console', (message) => seen.console.push(`${message.type()}: ${message.text()}`));
  page.on('pageerror', (error) => seen.console.push(error.stack));
  page.on('request', (request) => seen.requests.push(request.url()));
  await page.addInitScript(() => {
    window.drawnTexts = [];
    const fillText = CanvasRenderingContext2D.prototype.fillText;
    CanvasRenderingContext2D.prototype.fillText = function (text, ...rest) {
      window.drawnTexts.push({text, canvas: this.canvas});
      return fillText.call(this, text, ...rest);
    };
  });
  const url = pathToFileURL(path.resolve(html)).href;
  await page.goto(url);
  await settled(page);
  return {page, seen, url, close: () => context.close()};
}

const settled = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 30))));

const ranges = (page, figure) => page.evaluate((index) => window.slipstackReport.figures[index].plots.map(({u}) => (
  {x: [u.scales.x.min, u.scales.x.max], y: [u.scales.y.min, u.scales.y.max]})), figure);

// Drags across the drawing area of one plot, given in shares of its width and height.
async function drag(page, figure, plot, [x0, y0], [x1, y1]) {
  const area = page.locator('figure[data-chart]').nth(figure).locator('.plot').nth(plot).locator('.u-over');
  await area.scrollIntoViewIfNeeded();
  const box = await area.boundingBox();
  await page.mouse.move(box.x + x0 * box.width, box.y + y0 * box.height);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.5 * (x0 + x1) * box.width, box.y + 0.5 * (y0 + y1) * box.height);
  await page.mouse.move(box.x + x1 * box.width, box.y + y1 * box.height);
  await page.mouse.up();
  await settled(page);
  return box;
}

async function doubleClick(page, figure, plot) {
  await page.locator('figure[data-chart]').nth(figure).locator('.plot').nth(plot).locator('.u-over').dblclick();
  await settled(page);
}

function near(actual, expected, tolerance, what) {
  assert.ok(Math.abs(actual - expected) <= tolerance, `${what}: ${actual}, expected ${expected} ± ${tolerance}`);
}

const share = ([low, high], at) => low + at * (high - low);
const tests = [];
const test = (name, run) => { if (which !== '--long') tests.push({name, run}); };
const longTest = (name, run) => { if (which === '--long') tests.push({name, run}); };

test('opens offline: no request but the file, no message on the console', async () => {
  for (const kind of ['missing_effect', 'complete', 'unexplained', 'comparison', 'bare']) {
    const {seen, url, close} = await open(kind);
    assert.deepEqual(seen.console, [], kind);
    assert.deepEqual(seen.requests, [url], kind);
    await close();
  }
});

test('the verdict comes first and says what it costs', async () => {
  const {page, data, close} = await open('missing_effect');
  assert.equal(await page.locator('h1').textContent(), data.verdict.headline);
  assert.equal((await page.locator('.detail').textContent()).replace(/\u00a0/g, ' '), data.verdict.detail);
  const keys = await page.locator('.key dd').allTextContents();
  assert.deepEqual(keys.slice(0, 3).map((text) => text.replace(/\u00a0/g, ' ')),
                   [data.figures.holdout_rmse_N, data.figures.after_rmse_N, 0.33].map((value) => `${value.toFixed(2)} N`));
  const order = await page.locator('h1, h2').allTextContents();
  assert.deepEqual(order.map((text) => text.replace('drag to zoom, double-click to reset', '')), [
    'Missing: force ripple', 'Why', 'Every effect of the catalogue, each tried alone on this log', 'Force over time', 'Hysteresis',
    'What is left, and where', 'Parameters', 'How it was measured']);
  const why = (await page.locator('.why').textContent()).replace(/\u00a0/g, ' ');
  for (const text of [data.candidates[0].evidence, data.candidates[0].cause, data.candidates[0].confirm_with]) assert.ok(why.includes(text));
  assert.ok(why.includes('cannot tell it from') && why.includes('motor constant ripple'));
  await close();
});

test('every chart draws every one of its lines, in its own colour', async () => {
  const {page, close} = await open('missing_effect');
  // Each line alone, so that none can hide behind another; a pixel counts if it lies between paper and the line's colour.
  const lines = await page.evaluate(async () => {
    const style = getComputedStyle(document.documentElement);
    const channels = (name) => [1, 3, 5].map((at) => parseInt(style.getPropertyValue('--' + name).trim().slice(at, at + 2), 16));
    const page = channels('page');
    const wait = () => new Promise((done) => setTimeout(done, 0));
    const found = [];
    for (const {figure, plots} of window.slipstackReport.figures) {
      for (const {u, plot} of plots) {
        for (const [i, series] of plot.series.entries()) {
          if (series.edge) continue;
          plot.series.forEach((other, k) => { u.series[k + 1].show = k === i; });
          u.redraw(true);
          await wait();
          const colour = channels({velocity: 'forward'}[series.role] ?? series.role);
          const {left, top, width, height} = u.bbox;
          const {data} = u.ctx.getImageData(left, top, width, height);
          const span = colour.map((value, c) => value - page[c]);
          const length = span.reduce((sum, value) => sum + value * value, 0);
          let count = 0;
          for (let p = 0; p < data.length; p += 4) {
            if (data[p + 3] < 60) continue;
            const alpha = data[p + 3] / 255;
            const off = [0, 1, 2].map((c) => data[p + c] * alpha + page[c] * (1 - alpha) - page[c]);
            const along = off.reduce((sum, value, c) => sum + value * span[c], 0) / length;
            const rest = Math.hypot(...off.map((value, c) => value - along * span[c]));
            if (along > 0.35 && rest < 14) ++count;
          }
          found.push({chart: figure.dataset.chart + figure.dataset.index, name: series.name, count, width});
        }
        plot.series.forEach((other, k) => { u.series[k + 1].show = true; });
        u.redraw(true);
      }
    }
    return found;
  });
  assert.equal(lines.length, 6 + 6 + (4 + 3 * 2) + 2);
  for (const {chart, name, count, width} of lines) assert.ok(count > 0.5 * width, `${chart} ${name}: ${count} pixels over ${width} columns`);
  await close();
});

test('every axis names its quantity and unit, and the numbers are in that unit', async () => {
  const {page, data, close} = await open('missing_effect');
  const axes = await page.evaluate(() => window.slipstackReport.figures.map(({figure, plots}) => plots.map(({u}) => ({
    canvas: window.drawnTexts.filter((entry) => entry.canvas === u.ctx.canvas).map((entry) => entry.text),
    labels: u.axes.map((axis) => axis.label ?? ''), aria: u.ctx.canvas.getAttribute('aria-label')}))));
  const expected = [
    [['', 'Force (N)'], ['', 'Residual (N)'], ['Time (s)', 'Position (mm)', 'Velocity (mm/s)']],
    [['Displacement (µm)', 'Force (N)']], [['Displacement (mm)', 'Force (N)']],
    [['Position (mm)', 'Residual (N)']], [['Velocity (mm/s)', 'Residual (N)']], [['Acceleration (m/s²)', 'Residual (N)']],
    [['Time (s)', 'Residual (N)']], [['Frequency (Hz)', 'Residual density (N/√Hz)']]];
  assert.deepEqual(axes.map((figure) => figure.map(({labels}) => labels)), expected);
  for (const {canvas, labels, aria} of axes.flat()) {
    for (const label of labels.filter(Boolean)) {
      assert.ok(canvas.includes(label), `"${label}" is drawn`);
      assert.ok(aria.includes(label), `"${label}" is read aloud`);
    }
    assert.ok(canvas.filter((text) => /^−?[\d.]+$/.test(text)).length >= 3, `ticks of ${aria}: ${canvas.join(' ')}`);
  }
  const middle = Math.floor(0.525 * data.samples);
  const shown = await page.evaluate((at) => {
    const [force, , , , velocity] = window.slipstackReport.figures;
    return {force: force.plots[0].u.data[1][at], position: force.plots[2].u.data[1][at], speed: force.plots[2].u.data[2][at],
            loop: window.slipstackReport.figures[1].plots[0].u.data[1][0][100], x: velocity.plots[0].u.data[0][10]};
  }, middle);
  near(shown.force, data.series.measured_N[middle], 1e-4, 'force in N');
  near(shown.position, data.series.position_m[middle] * 1e3, 1e-4, 'position in mm');
  near(shown.speed, data.series.velocity_mps[middle] * 1e3, 1e-3, 'velocity in mm/s');
  near(shown.loop, data.loops[0].displacement_m[100] * 1e6, 1e-4, 'displacement in µm');
  near(shown.x, data.profiles[1].x[10] * 1e3, 1e-3, 'velocity bin in mm/s');
  await close();
});

test('dragging zooms all panels over time together; a double click brings them back', async () => {
  const {page, close} = await open('missing_effect');
  const home = await ranges(page, 0);
  const reset = page.locator('figure[data-chart=force] .reset');
  assert.equal(await reset.isVisible(), false);

  for (const plot of [0, 1, 2]) {  // from whichever panel the drag starts
    const box = await drag(page, 0, plot, [0.3, 0.5], [0.45, 0.5]);
    const zoomed = await ranges(page, 0);
    const pixel = (home[0].x[1] - home[0].x[0]) / box.width;
    for (const {x} of zoomed) {
      near(x[0], share(home[0].x, 0.3), 2 * pixel, 'left edge');
      near(x[1], share(home[0].x, 0.45), 2 * pixel, 'right edge');
      assert.deepEqual(x, zoomed[0].x);
    }
    assert.equal(await reset.isVisible(), true);
    await doubleClick(page, 0, (plot + 1) % 3);
    assert.deepEqual(await ranges(page, 0), home);
    assert.equal(await reset.isVisible(), false);
  }

  // The force axis follows what is visible: the small loops at the end are ±20 N, the fast moves ±260 N.
  await drag(page, 0, 0, [0.75, 0.5], [0.95, 0.5]);
  const [{y}] = await ranges(page, 0);
  assert.ok(y[1] < 30 && y[0] > -40, `force axis ${y}`);
  // Zoom into the zoom, then the button.
  await drag(page, 0, 1, [0.2, 0.5], [0.3, 0.5]);
  const [{x}] = await ranges(page, 0);
  near(x[1] - x[0], 0.1 * 0.2 * 20, 0.01, 'twice zoomed');
  await reset.click();
  await settled(page);
  assert.deepEqual(await ranges(page, 0), home);
  await close();
});

test('other charts zoom alone: profile along x, spectrum along its logarithm, loop in both directions', async () => {
  const {page, close} = await open('missing_effect');
  const others = await ranges(page, 0);
  for (const [figure, what] of [[3, 'profile'], [7, 'spectrum']]) {
    const [home] = await ranges(page, figure);
    await drag(page, figure, 0, [0.4, 0.3], [0.6, 0.7]);
    const [zoomed] = await ranges(page, figure);
    const at = (part) => (what === 'spectrum' ? 10 ** share(home.x.map(Math.log10), part) : share(home.x, part));
    near(zoomed.x[0] / at(0.4), 1, 0.02, `${what} left`);
    near(zoomed.x[1] / at(0.6), 1, 0.02, `${what} right`);
    await doubleClick(page, figure, 0);
    assert.deepEqual(await ranges(page, figure), [home]);
  }
  const [home] = await ranges(page, 1);
  await drag(page, 1, 0, [0.2, 0.25], [0.6, 0.75]);
  const [zoomed] = await ranges(page, 1);
  const tolerance = 0.01;
  near((zoomed.x[0] - home.x[0]) / (home.x[1] - home.x[0]), 0.2, tolerance, 'loop left');
  near((zoomed.x[1] - home.x[0]) / (home.x[1] - home.x[0]), 0.6, tolerance, 'loop right');
  near((home.y[1] - zoomed.y[1]) / (home.y[1] - home.y[0]), 0.25, tolerance, 'loop top');
  near((home.y[1] - zoomed.y[0]) / (home.y[1] - home.y[0]), 0.75, tolerance, 'loop bottom');
  await page.locator('figure[data-chart=loop]').first().locator('.keyline button').first().click();  // hiding a line keeps the zoom
  await settled(page);
  assert.deepEqual(await ranges(page, 1), [zoomed]);
  await doubleClick(page, 1, 0);
  assert.deepEqual(await ranges(page, 1), [home]);
  assert.deepEqual(await ranges(page, 0), others);
  await close();
});

longTest('a logarithmic axis may begin anywhere, and zoom to anywhere', async () => {
  for (const start of [0.09765625, 3.3]) {
    const {page, seen, close} = await open('missing_effect', {edit: (data) => {
      data.spectrum.frequency_Hz = data.spectrum.frequency_Hz.map((_, i) => start * (i + 1));
    }});
    assert.deepEqual(seen.console, [], `from ${start}`);
    const spectrum = await page.locator('figure[data-chart=spectrum] canvas').count();
    assert.equal(spectrum, 1);
    for (const [from, to] of [[0.111, 0.37], [0.6, 0.61], [0.013, 0.9]]) {
      await drag(page, 7, 0, [from, 0.5], [to, 0.5]);
      const splits = await page.evaluate(() => {
        const {u} = window.slipstackReport.figures[7].plots[0];
        return u.axes[0]._splits.filter((value) => value !== null);
      });
      assert.ok(splits.length >= 2 && splits.length < 60, `${splits.length} ticks from ${from} to ${to}`);
      await doubleClick(page, 7, 0);
    }
    assert.deepEqual(seen.console, [], `from ${start}, zoomed`);
    await close();
  }
});

test('the cursor reads values, and a click on the key hides a line', async () => {
  const {page, data, close} = await open('missing_effect');
  const figure = page.locator('figure[data-chart=force]');
  const area = figure.locator('.plot').first().locator('.u-over');
  await area.scrollIntoViewIfNeeded();
  const box = await area.boundingBox();
  await page.mouse.move(box.x + 0.25 * box.width, box.y + 0.5 * box.height);
  await settled(page);
  const index = await page.evaluate(() => window.slipstackReport.figures[0].plots[1].u.cursor.idx);  // the linked panel follows
  near(data.series.time_s[index], 0.25 * 19.9995, 0.03, 'time under the cursor');
  const outputs = await figure.locator('.keyline').first().locator('output').allTextContents();
  near(Number(outputs[0].replace('−', '-')), data.series.measured_N[index], 0.01 * Math.abs(data.series.measured_N[index]), 'measured');
  assert.match(await figure.locator('.where').textContent(), /^Time [\d.]+ s$/);
  const model = figure.locator('.keyline').first().locator('button').nth(1);
  await model.click();
  await settled(page);
  assert.equal(await model.getAttribute('aria-pressed'), 'false');
  assert.equal(await page.evaluate(() => window.slipstackReport.figures[0].plots[0].u.series[2].show), false);
  await close();
});

longTest('40 000 samples stay fluid', async () => {
  const {page, close} = await open('missing_effect', {whole: true});
  const times = await page.evaluate(async () => {
    const out = [];
    const {plots} = window.slipstackReport.figures[0];
    for (let i = 0; i < 15; ++i) {
      const start = performance.now();
      plots[0].u.setScale('x', {min: 0.3 * i, max: 20 - 0.3 * i});
      await null;
      await null;
      plots.forEach(({u}) => u.ctx.getImageData(0, 0, 1, 1));  // waits for the drawing
      out.push(performance.now() - start);
    }
    return out.sort((a, b) => a - b);
  });
  console.log(`      three linked panels, 40 000 samples: ${times[0].toFixed(0)} ms a redraw at best, ${times[7].toFixed(0)} ms in the middle of 15`);
  // The best of them, because other work on the machine only ever adds; drawn in software, here without a GPU.
  assert.ok(times[0] < 150, `${times[0]} ms`);
  await close();
});

test('the ranking stands in the given order, folded after six', async () => {
  const {page, data, close} = await open('missing_effect');
  const rows = page.locator('.ranking tr[data-effect]');
  assert.deepEqual(await rows.evaluateAll((all) => all.map((row) => row.dataset.effect)), data.candidates.map(({effect}) => effect));
  const visible = async () => (await rows.evaluateAll((all) => all.filter((row) => row.checkVisibility()).length));
  assert.equal(await visible(), 6);
  await page.locator('.more button').click();
  assert.equal(await visible(), data.candidates.length);
  const cells = await rows.nth(1).locator('td').allTextContents();
  assert.equal(cells[2], data.candidates[1].holdout_rmse_N.toFixed(3));
  assert.equal(cells[4].replace(/\s/g, ''), '41.0%');
  near(Number(cells[6].replaceAll('−', '-').replace(/[^-\d.]/g, '')), data.candidates[1].criterion_difference, 0.051, 'criterion');
  assert.equal(cells[7], 'Force ripple');
  assert.equal(await page.locator('.ranking .legend').textContent(), data.criterion_note);
  const headings = await page.locator('.ranking th').allTextContents();
  assert.deepEqual(headings.slice(-2), ['Criterion', 'Cannot be told from']);
  await rows.nth(0).locator('summary').click();
  assert.equal(await rows.nth(0).locator('details p').nth(1).isVisible(), true);
  // Bars in proportion, negative ones left of zero.
  const bars = await page.locator('.ranking .bar').evaluateAll((all) => all.map((bar) => {
    const [rect, zero] = [bar.querySelector('rect'), bar.querySelector('.zero')].map((node) => node.getBoundingClientRect());
    return {length: rect.width, from: rect.left - zero.left, to: rect.right - zero.left};
  }));
  near(bars[1].length / bars[0].length, data.candidates[1].error_reduction / data.candidates[0].error_reduction, 0.01, 'bar lengths');
  assert.ok(bars[0].to > 100 && Math.abs(bars[0].from) < 2);
  assert.ok(bars.at(-1).from < -1 && Math.abs(bars.at(-1).to) < 2);
  await close();
});

test('the waterfall falls as the numbers do', async () => {
  const {page, data, close} = await open('missing_effect');
  assert.deepEqual(await page.locator('.waterfall .name').allTextContents(), ['Baseline', '+ Force ripple', '+ Cable chain stiffness', '']);
  // Name, bar, error and criterion of each step; the baseline has no criterion.
  const criteria = await page.locator('.waterfall .steps').evaluate((steps) => [...steps.querySelectorAll('.name')].slice(0, 3).map((name) => name.nextElementSibling.nextElementSibling.nextElementSibling.textContent));
  assert.deepEqual(criteria.map((text) => text.replaceAll('\u202f', '')), ['', '−8512.3', '−31.0']);
  assert.equal(await page.locator('.waterfall .head').textContent(), 'Criterion');
  const widths = await page.locator('.waterfall').evaluate((figure) => [...figure.querySelectorAll('rect.before, rect.after')].map((bar) => bar.getBoundingClientRect().width));
  data.steps.forEach((step, i) => near(widths[i] / widths[0], step.holdout_rmse_N / data.steps[0].holdout_rmse_N, 0.005, step.effect));
  const floor = await page.locator('.waterfall').evaluate((figure) => {
    const [bar, line] = [figure.querySelector('rect.before'), figure.querySelector('line.floor')].map((node) => node.getBoundingClientRect());
    return (line.left - bar.left) / bar.width;
  });
  near(floor, 0.33 / data.steps[0].holdout_rmse_N, 0.01, 'noise floor');
  await close();
});

test('hostile strings are shown, not run', async () => {
  const {page, seen, url, data, close} = await open('hostile');
  assert.equal(await page.evaluate(() => window.pwned), undefined);
  assert.deepEqual(seen.console, []);
  assert.deepEqual(seen.requests, [url]);
  assert.equal(await page.locator('h1').textContent(), data.verdict.headline);
  assert.equal(await page.title(), `${data.title} – ${data.log}`.replace(/\s+/g, ' ').trim());
  assert.equal(await page.locator('img, iframe, object, embed, [onmouseover], [onload], [onerror]').count(), 0);
  assert.equal(await page.locator('script').count(), 2);
  assert.equal(await page.locator('figure[data-chart] canvas').count(), 10);
  assert.deepEqual(await page.locator('.ranking tr[data-effect]').evaluateAll((all) => all.map((row) => row.dataset.effect)), data.candidates.map(({effect}) => effect));
  await page.mouse.move(200, 60);
  await page.locator('.ranking summary').first().hover();
  assert.equal(await page.evaluate(() => window.pwned), undefined);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), 'long words must not widen the page');
  await close();
});

longTest('missing parts are left out', async () => {
  const bare = await open('bare');
  assert.equal(await bare.page.locator('section').count(), 1);
  assert.equal(await bare.page.locator('figure, table, canvas').count(), 0);
  await bare.close();
  const comparison = await open('comparison');
  assert.equal(await comparison.page.locator('.ranking, .waterfall, .why, .parameters').count(), 0);
  assert.equal(await comparison.page.locator('canvas').count(), 10);
  const names = await comparison.page.locator('.keyline').allTextContents();
  assert.ok(names.every((text) => !text.includes('after') && !text.includes('added')));
  await comparison.close();
  // Holes, an axis without data, one sample, unsorted and missing times: nothing may throw.
  const torn = await open('missing_effect', {edit: (data) => {
    data.series.time_s[5] = null;
    data.series.time_s[7] = 0;
    delete data.series.position_m;
    data.series.velocity_mps = data.series.velocity_mps.map(() => null);
    data.loops[0] = {title: 'one point', displacement_m: [1e-6], measured_N: [1]};
    data.loops[1] = {title: 'empty'};
    data.profiles[0].spread_N = null;
    data.profiles[1].x = [];
    data.spectrum.residual_N[3] = 0;
    data.candidates[0].error_reduction = null;
    data.parameters[0].parameters[0].value = null;
    data.figures = {};
    data.steps = [];
  }});
  assert.deepEqual(torn.seen.console, []);
  assert.equal(await torn.page.locator('.waterfall').count(), 0);
  assert.equal(await torn.page.locator('figure[data-chart=force] canvas').count(), 2);
  await torn.close();
});

// Every experiment of the program, small, as it is: roles and columns that the page does not know would show here.
const kExperiments = {
  loops: [], step: [], free: [], characterize: [], transducer: [], models: [],
  guideway: [path.join(folder, 'loops.csv'), '--to-load-N', '20'],
  'stepped-sine': ['--points', '5', '--forces-N', '3.75,9.75', '--direction', 'both'],
  'describing-function': ['--points', '5', '--forces-N', '3.75,9.75'],
  sensitivity: ['--points', '5', '--forces-N', '3.75,12.75'],
};

// Twelve cosines of 5 µm with the force of Masing's rules on a rational virgin curve.
function writeLoops(file) {
  const virgin = (x) => 0.35 * (1 - (3e-6 / (x + 3e-6)) ** 2);
  const lines = ['# load_per_ball_N: 54', '# groove_angle_deg: 90', '# ball_diameter_m: 0.006', '# balls: 2', 'time_s,position_m,force_N'];
  for (let i = 0; i < 4800; ++i) {
    const phase = 2 * Math.PI * i / 400;
    const x = -5e-6 * Math.cos(phase);
    const sign = Math.sin(phase) >= 0 ? 1 : -1;
    lines.push(`${i * 1e-3},${x},${sign * (2 * virgin((5e-6 + sign * x) / 2) - virgin(5e-6))}`);
  }
  fs.writeFileSync(file, lines.join('\n') + '\n');
}

// The page of one experiment.
function experimentReport(name) {
  writeLoops(path.join(folder, 'loops.csv'));
  const html = path.join(folder, `experiment-${name}.html`);
  execFileSync(slipstack, ['experiment', name, ...kExperiments[name], '--report', html], {stdio: 'pipe'});
  return html;
}

longTest('the report of every experiment draws all its curves, and one name stands once in the key', async () => {
  for (const name of Object.keys(kExperiments)) {
    const {page, seen, close} = await openPage(experimentReport(name));
    assert.deepEqual(seen.console, [], name);
    const figures = page.locator('figure[data-chart]');
    assert.ok(await figures.count() > 0, name);
    assert.equal(await figures.locator('canvas').count(), await figures.count(), name);
    for (const line of await page.locator('.keyline').all()) {
      const names = await line.locator('button span').allTextContents();
      assert.equal(new Set(names).size, names.length, `${name}: ${names}`);
    }
    if (name === 'sensitivity') {
      // The map: the darker the cell, the larger its number.
      const cells = await page.locator('td[style]').evaluateAll((all) => all.map((cell) => (
        {value: Number(cell.textContent), shade: Number(cell.style.getPropertyValue('--shade'))})));
      assert.equal(cells.length, 10);
      cells.sort((a, b) => a.value - b.value);
      assert.ok(cells.every((cell, i) => i === 0 || cell.shade >= cells[i - 1].shade), JSON.stringify(cells));
      assert.ok(cells.at(-1).shade > cells[0].shade);
    }
    await close();
  }
});

test('a key that stands for several curves hides and shows them all', async () => {
  const {page, close} = await openPage(experimentReport('characterize'));
  const shown = () => page.evaluate(() => window.slipstackReport.figures[0].plots[0].u.series.slice(1).map((series) => series.show));
  assert.ok((await shown()).length > 8 && (await shown()).every((one) => one));
  const first = page.locator('figure[data-chart]').first().locator('.keyline button').first();
  await first.click();
  const hidden = (await shown()).filter((one) => !one).length;
  assert.ok(hidden > 1 && hidden < (await shown()).length);
  await first.click();
  assert.ok((await shown()).every((one) => one));
  await close();
});

longTest('prints on A4: every chart whole, on one page, with its caption and axes', async () => {
  for (const colorScheme of ['light', 'dark']) {
    const {page, seen, close} = await open('missing_effect', {colorScheme, width: colorScheme === 'dark' ? 900 : 1400});
    const file = path.join(folder, `print-${colorScheme}.pdf`);
    await page.pdf({path: file, preferCSSPageSize: true});
    const pages = pdfPages(fs.readFileSync(file));
    assert.ok(pages.length >= 3 && pages.length <= 5, `${pages.length} pages`);
    for (const {width, height} of pages) {
      near(width, 595.3, 1, 'A4 width');
      near(height, 841.9, 1, 'A4 height');
    }
    // Chromium keeps no-break spaces from 156 on; before, it wrote plain ones.
    const plain = (text) => text.replaceAll('\u00a0', ' ');
    const where = (text) => pages.flatMap(({runs}, number) => runs.filter((run) => plain(run.text) === text).map((run) => ({...run, number})));
    const charts = [['Force (N)', 'Residual (N)', 'Position (mm)', 'Velocity (mm/s)', 'Time (s)'], ['Force (N)', 'Displacement (µm)'],
                    ['Force (N)', 'Displacement (mm)'], ['Residual (N)', 'Position (mm)'], ['Residual (N)', 'Velocity (mm/s)'],
                    ['Residual (N)', 'Acceleration (m/s²)'], ['Residual (N)', 'Time (s)'], ['Residual density (N/√Hz)', 'Frequency (Hz)']];
    const used = new Set();
    charts.forEach((labels, i) => {
      const [caption, ...again] = where(`Fig. ${i + 2}`);
      assert.ok(caption && again.length === 0, `caption of figure ${i + 2}`);
      for (const label of labels) {  // the next one below the caption, on the same page, within the margins
        const found = where(label).filter((run) => run.number === caption.number && run.y > caption.y && run.x >= caption.x && !used.has(`${run.number} ${run.x} ${run.y}`))
            .sort((a, b) => (a.y - b.y) + 2 * (a.x - b.x))[0];
        assert.ok(found, `"${label}" of figure ${i + 2} on page ${caption.number + 1}`);
        used.add(`${found.number} ${found.x} ${found.y}`);
        assert.ok(found.x > 36 && found.x < 556 && found.y > 36 && found.y < 806, `"${label}" within the margins`);
      }
    });
    assert.equal(where('Payload mass').length, 1, 'the folded rows of the ranking are printed');
    // After printing, the screen is as before; on paper all charts were wide and dark ink on white.
    assert.equal(await page.locator('.paper canvas').count(), 0);
    assert.deepEqual(seen.console, []);
    await close();
  }
});

longTest('paper has white ground and fits between the margins, whatever the screen shows', async () => {
  const {page, close} = await open('missing_effect', {colorScheme: 'dark'});
  await page.evaluate(() => window.dispatchEvent(new Event('beforeprint')));
  await page.emulateMedia({media: 'print', colorScheme: 'dark'});
  await page.setViewportSize({width: 688, height: 1000});
  await settled(page);
  const paper = await page.evaluate(() => ({
    ground: getComputedStyle(document.body).backgroundColor, ink: getComputedStyle(document.body).color,
    scroll: document.documentElement.scrollWidth,
    charts: [...document.querySelectorAll('.paper canvas')].map((canvas) => {
      const {left, right, width} = canvas.getBoundingClientRect();
      return {left, right, ratio: canvas.width / width};
    }),
    figures: [...document.querySelectorAll('figure')].map((figure) => figure.getBoundingClientRect().height),
  }));
  assert.equal(paper.ground, 'rgb(255, 255, 255)');
  assert.equal(paper.ink, 'rgb(21, 25, 30)');
  assert.equal(paper.charts.length, 10);
  for (const {left, right, ratio} of paper.charts) assert.ok(left >= 0 && right <= 688 && ratio > 2.9, `${left}…${right} at ${ratio}`);
  for (const height of paper.figures) assert.ok(height > 20 && height < 1017, `figure of ${height} pixels`);  // A4 less margins
  assert.ok(paper.scroll <= 688);
  await close();
});

longTest('narrow and wide windows: nothing sticks out, charts follow the width', async () => {
  for (const width of [420, 800, 1400, 2200]) {
    const {page, close} = await open('missing_effect', {width});
    const sizes = await page.evaluate(() => ({scroll: document.documentElement.scrollWidth,
      charts: window.slipstackReport.figures.flatMap(({plots}) => plots.map(({u, host}) => u.width - host.clientWidth))}));
    assert.ok(sizes.scroll <= width, `page ${sizes.scroll} wide in a window of ${width}`);
    assert.ok(sizes.charts.every((difference) => difference === 0));
    await page.setViewportSize({width: width - 60, height: 900});
    await settled(page);
    assert.ok(await page.evaluate(() => window.slipstackReport.figures.every(({plots}) => plots.every(({u, host}) => u.width === host.clientWidth))));
    await close();
  }
});

test('text and lines stand out, and lines differ for colour-blind eyes too', async () => {
  for (const colorScheme of ['light', 'dark']) {
    const {page, close} = await open('unexplained', {colorScheme});
    const colours = await page.evaluate(() => Object.fromEntries(
      ['page', 'ink', 'soft', 'warn', 'measured', 'before', 'after', 'forward', 'backward', 'floor', 'motion'].map((name) => [name,
        getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim()])));
    const c = Object.fromEntries(Object.entries(colours).map(([name, hex]) => [name, rgb(hex)]));
    for (const text of ['ink', 'soft', 'warn']) assert.ok(contrast(c[text], c.page) >= 4.5, `${colorScheme} ${text}`);
    for (const line of ['measured', 'before', 'after', 'forward', 'backward', 'floor', 'motion']) {
      assert.ok(contrast(c[line], c.page) >= 3, `${colorScheme} ${line}: ${contrast(c[line], c.page).toFixed(2)}`);
    }
    // Lines of one chart. Just noticeable is 2.3; two thin lines want far more.
    const together = [['measured', 'before'], ['measured', 'after'], ['before', 'after'], ['before', 'forward'], ['before', 'backward'],
                      ['after', 'forward'], ['after', 'backward'], ['forward', 'backward'], ['motion', 'forward'], ['before', 'floor']];
    for (const [vision, matrix] of Object.entries(kVision)) {
      for (const [a, b] of together) {
        const apart = difference(c[a], c[b], matrix);
        assert.ok(apart >= 11, `${colorScheme}, ${vision}: ${a} and ${b} are ${apart.toFixed(1)} apart`);
      }
    }
    // What the browser computed, not only what the variables say.
    const shown = await page.evaluate(() => [...document.querySelectorAll('p, dt, dd, td, th, h1, h2, h3, figcaption, summary, code, .weak, .keyline span')]
      .filter((node) => node.textContent.trim()).map((node) => getComputedStyle(node).color));
    for (const colour of new Set(shown)) assert.ok(contrast(colour.match(/\d+/g).map(Number), c.page) >= 4.5, `${colorScheme} text in ${colour}`);
    await close();
  }
});

let failed = 0;
const only = process.env.ONLY;
for (const {name, run} of tests) {
  if (only && !name.includes(only)) continue;
  const start = performance.now();
  try {
    await run();
    console.log(`ok    ${name} (${((performance.now() - start) / 1000).toFixed(1)} s)`);
  } catch (error) {
    ++failed;
    console.log(`FAIL  ${name}\n      ${error.stack}`);
  }
}
await browser.close();
console.log(failed ? `${failed} of ${tests.length} failed` : `all ${tests.length} passed with Chromium ${browser.version()}`);
process.exit(failed ? 1 : 0);
