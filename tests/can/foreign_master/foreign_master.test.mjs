// SPDX-License-Identifier: Apache-2.0
// The firmware in the emulator, driven by a CANopen master that nobody here wrote (npm: canopen, from its own reading of
// CiA 301, 305 and 306): node foreign_master.test.mjs SLIPSTACK IMAGE EDS. The bus is SLCAN on the terminal of the board.
// Exit 0: all passed; 1: something failed; 77: the emulator, the image or the master is missing, nothing tested.
import assert from 'node:assert/strict';
import {spawn, spawnSync} from 'node:child_process';
import {createRequire} from 'node:module';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import {setTimeout as pause} from 'node:timers/promises';
import {SlcanBus} from './slcan_bus.mjs';

const [, , slipstack, image, eds_file] = process.argv;
const kNode = 5;
const kMaster = 0x7E;
const kNoData = 0x08000024;
const kPatience_ms = 60_000;

function skip(reason) {
  console.log(`SKIP: ${reason}`);
  process.exit(77);
}
if (spawnSync('qemu-system-arm', ['--version']).error) skip('qemu-system-arm is not installed');
if (!fs.existsSync(image)) skip('no image of the emulated board; cmake --build --preset cortex-m4');
// canopen takes its CRC from node-crc, which is C++ and would have to be compiled: here it gets that of the crc package.
// It asks for one polynomial only, that of CiA 301 (7.2.4.3.16): x^16 + x^12 + x^5 + 1, begun at zero.
function crc_of(crc16xmodem) {
  return (bits, reflected, polynomial, ...rest) => {
    const data = rest.pop();
    assert.ok(bits === 16 && !reflected && polynomial === 0x1021 && rest.every((value) => value === 0), 'another CRC');
    const result = Buffer.alloc(2);
    result.writeUInt16BE(crc16xmodem(data));
    return result;
  };
}
let canopen;
try {
  const require = createRequire(import.meta.url);
  const place = require.resolve('node-crc');
  require.cache[place] = {id: place, filename: place, loaded: true, exports: {crc: crc_of(require('crc').crc16xmodem)}};
  canopen = require('canopen');
} catch (error) {
  skip(`the npm package canopen is missing: toolchain/install (${error.code ?? error.message})`);
}
const {Device, Eds, DataType, LssMode, NmtState} = canopen;

// The master does not know $NODEID, which CiA 306 has for a data sheet: what it gets is the sheet of this node.
const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'slipstack-foreign-master-'));
const own_eds = path.join(folder, 'node.eds');
fs.writeFileSync(own_eds, fs.readFileSync(eds_file, 'latin1')
  .replace(/\$NODEID\+(0x[0-9A-Fa-f]+)/g, (_, base) => `0x${(Number(base) + kNode).toString(16)}`));
const sheet = Eds.fromFile(own_eds);

const drive = spawn(slipstack, ['node', '--board', 'mps2-an386', '--image', image, '--node', String(kNode), '--flash', path.join(folder, 'flash')],
  {stdio: ['ignore', 'pipe', 'inherit']});
const terminal = await new Promise((found, failed) => {
  let text = '';
  drive.stdout.on('data', (bytes) => {
    text += bytes;
    const place = /SLCAN on (\/dev\/\S+):/.exec(text);
    if (place) found(place[1]);
  });
  drive.on('exit', (status) => failed(new Error(`the node ended with ${status}: ${text}`)));
});

const master = new Device({id: kMaster, enableLss: true});
const seen = {frames: [], emergencies: [], heartbeats: [], boot_ups: 0, positions: []};
const bus = new SlcanBus(terminal, (frame) => {
  seen.frames.push(frame);
  if (frame.id === 0x700 + kNode && frame.data[0] === 0) ++seen.boot_ups;
  master.receive(frame);
});
master.on('message', (frame) => bus.send(frame));

// What the master knows of the drive: the services from its data sheet, and two PDOs as the sheet maps them by default.
master.eds.addSdoClientParameter(kNode, 0x600 + kNode, 0x580 + kNode);
master.eds.addEmcyConsumer(0x80 + kNode);
master.eds.addHeartbeatConsumer(kNode, 1000);
master.eds.setSyncCobId(0x80);
master.eds.setSyncGenerationEnable(true);  // without a period: SYNC comes behind the set-points
const local = (index, name, type) => master.eds.addEntry(index, {parameterName: name, dataType: type});
const control = local(0x2000, 'control word', DataType.UNSIGNED16);
const target = local(0x2001, 'target', DataType.INTEGER32);
const status = local(0x2002, 'status word', DataType.UNSIGNED16);
const position = local(0x2003, 'position', DataType.INTEGER32);
const current = local(0x2004, 'current', DataType.INTEGER16);
master.eds.addTransmitPdo({cobId: 0x300 + kNode, transmissionType: 255, dataObjects: [control, target]});
master.eds.addReceivePdo({cobId: 0x280 + kNode, dataObjects: [status, position, current]});
master.emcy.on('emergency', ({em}) => seen.emergencies.push(em.code));
master.nmt.on('heartbeat', ({state}) => seen.heartbeats.push(state));
master.pdo.on('pdo', ({cobId}) => { if (cobId === 0x280 + kNode) seen.positions.push(position.value); });
master.start();
master.nmt.startNode();  // the master itself: PDOs are exchanged in state operational

const type_of = (index, sub) => {
  const entry = sheet.getEntry(index);
  return (sub === undefined ? entry : entry.at(sub)).dataType;
};
const read = (index, sub, options = {}) => master.sdo.upload(
  {deviceId: kNode, index, subIndex: sub ?? 0, dataType: type_of(index, sub), timeout: 5000, ...options});
const write = (index, sub, data, options = {}) => master.sdo.download(
  {deviceId: kNode, index, subIndex: sub ?? 0, data, dataType: type_of(index, sub), timeout: 5000, ...options});
async function until(condition, what, patience_ms = kPatience_ms) {
  const end = Date.now() + patience_ms;
  while (!(await condition())) {
    assert.ok(Date.now() < end, `${what} did not come within ${patience_ms} ms`);
    await pause(5);
  }
}
const state_word = async (mask, value, what) => until(async () => ((await read(0x6041)) & mask) === value, what);

const tests = [];
const test = (name, run) => tests.push({name, run});

test('the data sheet says what the device answers', async () => {
  for (const [index, sub] of [[0x1000], [0x1018, 1], [0x1018, 2], [0x1018, 3]]) {
    const entry = sheet.getEntry(index);
    const promised = (sub === undefined ? entry : entry.at(sub)).value;
    assert.equal(await read(index, sub), promised, `${index.toString(16)}:${sub ?? 0}`);
  }
  assert.equal(await read(0x1008), sheet.getEntry(0x1008).value, 'a text, in segments');
  let read_of = 0;
  const without = [];
  for (const [key, entry] of sheet.entries()) {
    const index = parseInt(key, 16);
    if (entry.objectType !== 7 || !['ro', 'rw', 'rww', 'rwr', 'const'].includes(entry.accessType)) continue;
    try {
      await read(index);
      ++read_of;
    } catch (error) {
      // A board without such a sensor says so (CiA 301, 7.2.4.3.17).
      assert.equal(error.code, kNoData, `${index.toString(16)}: ${error}`);
      without.push(index);
    }
  }
  assert.ok(read_of > 40, `${read_of} variables of the sheet were read`);
  assert.deepEqual(without, [0x6079], 'without a value on the emulated board: the voltage of the DC link');
});

test('what is not there, and what may not be, is refused with the code of CiA 301', async () => {
  const refused = async (run, code) => assert.rejects(run, (error) => error.code === code || assert.fail(`${error}`));
  await refused(master.sdo.upload({deviceId: kNode, index: 0x5FFF, subIndex: 0, timeout: 5000}), 0x06020000);
  await refused(master.sdo.upload({deviceId: kNode, index: 0x1018, subIndex: 99, timeout: 5000}), 0x06090011);
  await refused(master.sdo.download({deviceId: kNode, index: 0x1000, subIndex: 0, data: 1, dataType: DataType.UNSIGNED32, timeout: 5000}),
    0x06010002);
});

test('heartbeat, NMT states and boot-up', async () => {
  await write(0x1017, undefined, 100);
  await until(() => seen.heartbeats.includes(NmtState.PRE_OPERATIONAL), 'a heartbeat in pre-operational');
  master.nmt.startNode(kNode);
  await until(() => seen.heartbeats.at(-1) === NmtState.OPERATIONAL, 'operational');
  master.nmt.stopNode(kNode);
  await until(() => seen.heartbeats.at(-1) === NmtState.STOPPED, 'stopped');
  const before = seen.boot_ups;
  master.nmt.resetNode(kNode);
  await until(() => seen.boot_ups > before, 'a boot-up message');
  await write(0x1017, undefined, 100);
});

test('the model image by block transfer, both ways, with its CRC', async () => {
  const bytes = await master.sdo.upload({deviceId: kNode, index: 0x2141, subIndex: 0, blockTransfer: true, timeout: 5000});
  assert.ok(bytes.length > 400, `${bytes.length} bytes`);
  const again = await master.sdo.upload({deviceId: kNode, index: 0x2141, subIndex: 0, timeout: 5000});
  assert.deepEqual(again, bytes, 'in segments the same as in blocks');
  await master.sdo.download({deviceId: kNode, index: 0x2141, subIndex: 0, data: bytes, dataType: DataType.DOMAIN, blockTransfer: true,
    timeout: 5000});
  assert.deepEqual(await master.sdo.upload({deviceId: kNode, index: 0x2141, subIndex: 0, timeout: 5000}), bytes);
});

async function enable() {
  for (const [word, mask, value, what] of [[0x06, 0x6F, 0x21, 'ready to switch on'], [0x07, 0x6F, 0x23, 'switched on'],
    [0x0F, 0x6F, 0x27, 'operation enabled']]) {
    await write(0x6040, undefined, word);
    await state_word(mask, value, what);
  }
}

test('profile position by SDO', async () => {
  await write(0x6060, undefined, 1);
  await enable();
  const begin = await read(0x6064);
  await write(0x607A, undefined, begin + 5000);
  await write(0x6040, undefined, 0x1F);
  await state_word(0x1000, 0x1000, 'set-point acknowledge');
  await write(0x6040, undefined, 0x0F);
  await state_word(0x0400, 0x0400, 'target reached');
  const window = await read(0x6067);
  assert.ok(Math.abs(await read(0x6064) - begin - 5000) <= window, 'within its window of the target');
});

test('cyclic position by PDO and SYNC, at the pace of a desktop', async () => {
  await write(0x6040, undefined, 0);
  await state_word(0x4F, 0x40, 'switch on disabled');
  // An emulator that other work has held up catches up: to the drive, the master was silent for as long.
  await write(0x2403, undefined, 500);
  await write(0x60C2, 1, 10);
  await write(0x60C2, 2, -3);
  await write(0x6060, undefined, 8);
  await enable();
  master.nmt.startNode(kNode);
  await until(() => seen.heartbeats.at(-1) === NmtState.OPERATIONAL, 'operational');
  const begin = await read(0x6064);
  const kPeriod_ms = 10, kPeriods = 250, kAway = 8000;
  control.value = 0x0F;
  seen.frames.length = 0;
  seen.positions.length = 0;
  seen.emergencies.length = 0;
  const late = [];
  // Until told to end: a stream that ends is a master that is lost (2403h). The motion begins when the drive's clock has
  // locked to SYNC (bit 12), until then the axis stands.
  let sent = 0, moved = 0, goes_on = true;
  const stream = (async () => {
    const begun = performance.now();
    for (; goes_on; ++sent) {
      const due = begun + sent * kPeriod_ms;
      while (performance.now() < due) await pause(Math.max(0, due - performance.now()));
      late.push(performance.now() - due);
      if (moved > 0 || (status.value & 0x1000) !== 0) ++moved;
      target.value = begin + Math.round(kAway * 0.5 * (1 - Math.cos(Math.PI * Math.min(1, moved / kPeriods))));
      master.pdo.write(0x300 + kNode);
      master.sync.write();
    }
  })();
  let state;
  try {
    const window = await read(0x6067);
    await until(() => moved > kPeriods && Math.abs(position.value - begin - kAway) <= window, 'the end of the motion');
    state = await read(0x6041);
    await write(0x6040, undefined, 0x06);
  } finally {
    goes_on = false;
    await stream;
  }
  late.sort((a, b) => a - b);
  console.log(`  SYNC of the master late by ${late[late.length >> 1].toFixed(2)} ms (median), ${late.at(-1).toFixed(2)} ms (most)`);
  assert.deepEqual(seen.emergencies, [], 'no emergency on the way');
  assert.equal(state & 0x6F, 0x27, 'still enabled');
  // The master tells only of values that changed since it looked last.
  const answers = seen.frames.filter((frame) => frame.id === 0x280 + kNode);
  assert.ok(Math.abs(answers.length - sent) <= 3, `${sent} SYNC, ${answers.length} TPDO 2`);
  const positions = answers.map((frame) => Buffer.from(frame.data).readInt32LE(2));
  assert.ok(positions.some((p) => p > begin + 0.4 * kAway && p < begin + 0.6 * kAway), 'seen on the way');
  assert.equal(seen.positions.at(-1), positions.at(-1), 'the master has the last one');
});

test('a set-point stream that ends: emergency 8100h, and the axis is stopped', async () => {
  await enable();
  seen.emergencies.length = 0;
  target.value = await read(0x6064);
  for (let n = 0; n < 20; ++n) {
    master.pdo.write(0x300 + kNode);
    master.sync.write();
    await pause(10);
  }
  await until(() => seen.emergencies.includes(0x8100), 'emergency 8100h, 500 ms after the last set-point');
  await until(async () => ((await read(0x6041)) & 0x6F) !== 0x27, 'no longer enabled');
  await write(0x6040, undefined, 0x80);  // reset of the fault
  await write(0x6040, undefined, 0);
  await state_word(0x4F, 0x40, 'switch on disabled');
});

test('a master that falls silent: emergency, and the axis stops', async () => {
  await write(0x6060, undefined, 1);
  await enable();
  // The drive watches the master's heartbeat, 300 ms; then none comes.
  master.eds.setHeartbeatProducerTime(100);
  await write(0x1016, 1, (kMaster << 16) | 300);
  await pause(500);
  seen.emergencies.length = 0;
  assert.equal((await read(0x6041)) & 0x6F, 0x27, 'enabled while the heartbeat comes');
  master.eds.setHeartbeatProducerTime(0);
  await until(() => seen.emergencies.includes(0x8130), 'emergency 8130h');
  await until(async () => ((await read(0x6041)) & 0x6F) !== 0x27, 'no longer enabled');
  await write(0x1016, 1, 0);
});

test('LSS: the identity, by the global service', async () => {
  master.nmt.enterPreOperational(kNode);
  master.lss.switchModeGlobal(LssMode.CONFIGURATION);
  await pause(100);
  assert.equal(await master.lss.inquireVendorId(2000), sheet.getEntry(0x1018).at(1).value);
  assert.equal(await master.lss.inquireProductCode(2000), sheet.getEntry(0x1018).at(2).value);
  master.lss.switchModeGlobal(LssMode.OPERATION);
});

let failures = 0;
try {
  await until(() => seen.frames.some((frame) => frame.id === 0x700 + kNode), 'the boot-up message');
  for (const {name, run} of tests) {
    const begun = performance.now();
    try {
      await run();
      console.log(`ok      ${name} (${((performance.now() - begun) / 1000).toFixed(1)} s)`);
    } catch (error) {
      ++failures;
      console.log(`FAILED  ${name}\n${error.stack ?? error}`);
    }
  }
} catch (error) {
  ++failures;
  console.log(`FAILED  ${error.stack ?? error}`);
} finally {
  master.stop();
  bus.close();
  drive.removeAllListeners('exit');
  drive.kill('SIGTERM');
  fs.rmSync(folder, {recursive: true, force: true});
}
console.log(`${tests.length - failures} of ${tests.length} passed`);
process.exit(failures === 0 ? 0 : 1);
