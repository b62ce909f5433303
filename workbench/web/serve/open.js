// SPDX-License-Identifier: Apache-2.0
// Opening logs: file picker, drag and drop, a simulated axis; and the confirmation of how a foreign table is read.
import {post, upload} from '/api.js';
import {attempt, byId, dialog, h, say} from '/dom.js';
import {on, store} from '/store.js';

const kTargets = ['', 'time_s', 'position_m', 'position_mm', 'position_um', 'position_counts', 'force_N', 'force_mN', 'current_A', 'reference_position_m', 'velocity_mps', 'normal_force_N',
  'temperature_C', 'position_rad', 'position_deg', 'position_rev', 'torque_Nm', 'torque_mNm', 'velocity_radps', 'reference_position_rad'];

// A profile as TOML, as workbench/log/import/import_profile.cpp reads it. JSON strings are TOML strings.
function profileText(guess, columns, header) {
  const lines = ["format = 'slipstack import 1'", `encoding = ${JSON.stringify(guess.encoding)}`, `separator = ${JSON.stringify(guess.separator)}`, `decimal = ${JSON.stringify(guess.decimal)}`,
    `skip_lines = ${guess.skip_lines}`, `units_row = ${guess.units_row}`];
  if (header.sample_rate_Hz) lines.push(`sample_rate_Hz = ${Number(header.sample_rate_Hz)}`);
  lines.push('[header]');
  for (const [key, value] of Object.entries(header)) if (value && key !== 'sample_rate_Hz') lines.push(`${key} = ${JSON.stringify(String(value))}`);
  for (const column of columns) {
    lines.push('[[column]]', `source = ${JSON.stringify(column.source)}`, `target = ${JSON.stringify(column.target)}`, `factor = ${Number.isInteger(column.factor) ? column.factor + '.0' : column.factor}`, `iso_time = ${column.iso_time}`,
      `same_time = ${column.same_time && !column.target}`);
  }
  return lines.join('\n');
}

const kKnown = {mass_kg: 'Mass (kg)', motor_constant_N_per_A: 'Motor constant (N/A)', encoder_resolution_m: 'Encoder resolution (m)', sample_rate_Hz: 'Sampling rate (Hz)'};

async function confirm(name, guess) {
  const columns = guess.columns.map((column) => ({...column}));
  const header = {mass_kg: '', motor_constant_N_per_A: '', encoder_resolution_m: '', sample_rate_Hz: ''};
  const picks = columns.map((column) => {
    const list = kTargets.includes(column.target) ? kTargets : [...kTargets, column.target];
    const select = h('select', {'aria-label': `${column.source} is`, onchange: () => { column.target = select.value; }}, list.map((target) => h('option', {value: target, selected: target === column.target}, target || 'left out')));
    const factor = h('input', {type: 'number', step: 'any', value: String(column.factor), 'aria-label': `Factor of ${column.source}`, onchange: () => { column.factor = Number(factor.value) || 1; }});
    return h('th', {scope: 'col'}, column.source, select, h('label', {class: 'soft'}, '× ', factor));
  });
  const fields = Object.keys(header).map((key) => h('label', {}, kKnown[key], h('input', {type: 'text', inputmode: 'decimal', onchange: (event) => { header[key] = event.currentTarget.value; }})));
  const content = h('div', {}, h('p', {}, `${name} is no log of slipstack's own format. It would be read so: ${guess.encoding}, separated by ${guess.separator === '\t' ? 'tabs' : `“${guess.separator}”`}, decimal “${guess.decimal}”.`),
    guess.fault ? h('p', {class: 'warn'}, `Missing: ${guess.fault}.`) : null,
    h('div', {class: 'scroll', tabindex: 0}, h('table', {class: 'import'}, h('thead', {}, h('tr', {}, picks)), h('tbody', {}, guess.rows.map((row) => h('tr', {}, row.map((text) => h('td', {}, text))))))),
    h('fieldset', {class: 'form'}, h('legend', {}, 'What is known besides (may be empty)'), fields));
  const answer = await dialog('How is this file read?', content, [{label: 'Cancel', value: ''}, {label: 'Import it so', value: 'import', main: true}]);
  return answer === 'import' ? profileText(guess, columns, header) : null;
}

export async function open(files) {
  for (const file of files) {
    await attempt(async () => {
      say(`Sending ${file.name} …`, 'note');
      const answer = await upload(file.name, file);
      say('');
      if (answer.opened) return;
      const profile = await confirm(file.name, answer);
      if (profile) await upload(file.name, file, profile);
    });
  }
}

async function simulate() {
  const seed = h('input', {type: 'number', id: 'seed', min: '0', value: String(1 + Math.floor(Math.random() * 9999))});
  const effects = h('input', {type: 'text', id: 'hidden', value: 'random', spellcheck: false});
  const setup = h('select', {id: 'setup'}, [['pick_and_place', 'a pick-and-place axis'], ['random', 'any axis: mass, encoder, stroke and friction are drawn']].map(([value, label]) => h('option', {value}, label)));
  const answer = await dialog('A simulated axis', h('div', {class: 'form'}, h('label', {for: 'setup'}, 'Set-up'), setup, h('label', {for: 'seed'}, 'Seed: everything random follows from it'), seed,
    h('label', {for: 'hidden'}, 'Hidden in it (names with commas, none, or random)'), effects), [{label: 'Cancel', value: ''}, {label: 'Start it', value: 'start', main: true}]);
  if (answer === 'start') await attempt(() => post('simulate', {setup: setup.value, seed: Number(seed.value), effects: effects.value.trim() || 'random'}));
}

function drawLogs() {
  const {logs} = store.state;
  byId('logs').replaceChildren(...logs.map((log, i) => h('li', {}, h('span', {title: log.path}, log.name), log.samples ? h('span', {class: 'soft'}, ` ${log.samples.toLocaleString('en')} samples, ${Math.round(log.duration_s)} s`) : null,
    h('button', {type: 'button', class: 'small', 'aria-label': `Close ${log.name}`, onclick: () => attempt(() => post('close', {log: i}))}, '×'))));
  const empty = byId('empty');
  empty.hidden = logs.length > 0;
}

export function startOpen() {
  const picker = byId('file');
  picker.addEventListener('change', () => { open(picker.files).then(() => { picker.value = ''; }); });
  for (const button of document.querySelectorAll('[data-open]')) button.addEventListener('click', () => picker.click());
  for (const button of document.querySelectorAll('[data-simulate]')) button.addEventListener('click', simulate);
  addEventListener('dragover', (event) => { event.preventDefault(); document.body.classList.add('dropping'); });
  addEventListener('dragleave', (event) => { if (!event.relatedTarget) document.body.classList.remove('dropping'); });
  addEventListener('drop', (event) => {
    event.preventDefault();
    document.body.classList.remove('dropping');
    open(event.dataTransfer.files);
  });
  on('state', drawLogs);
}
