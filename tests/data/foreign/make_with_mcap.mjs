// SPDX-License-Identifier: Apache-2.0
// Writes mcap_*.mcap by Foxglove's libraries: the same motion as joint states of ROS 2 (zstd), ROS 1 (lz4), and JSON.
//
//     npm install @mcap/core@2.2.2 @foxglove/rosmsg@4.2.2 @foxglove/rosmsg2-serialization@2.0.4
//         @foxglove/rosmsg-serialization@2.0.4 @foxglove/wasm-zstd@1.0.1 lz4js@0.2.0
//     node make_with_mcap.mjs
import { writeFileSync } from "node:fs";

import rosmsg from "@foxglove/rosmsg";
import ros1 from "@foxglove/rosmsg-serialization";
import ros2 from "@foxglove/rosmsg2-serialization";
import zstd from "@foxglove/wasm-zstd";
import { McapWriter, TempBuffer } from "@mcap/core";
import lz4 from "lz4js";

const COUNT = 300, STEP_NS = 2_000_000n, BEGIN_NS = 1_700_000_000_123_456_789n, LATE_NS = 500_000n;
const LINE = "=".repeat(80);
const JOINT_STATE = "# the state of joints\n%HEADER header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n";
const ROS2 = JOINT_STATE.replace("%HEADER", "std_msgs/Header") + `${LINE}\nMSG: std_msgs/Header\n` +
  `builtin_interfaces/Time stamp\nstring frame_id\n${LINE}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n`;
const ROS1 = JOINT_STATE.replace("%HEADER", "Header") + `${LINE}\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n`;
// A message of every kind of number, so that alignment and widths matter.
const MIXED = "uint8 LIMIT=3\nbool on\nint16 small\nfloat32 single\nstring<=8 word\nuint8[3] bytes\nint64 large\nfloat64[<=4] some\nempty nothing\nint8 last\n" +
  `${LINE}\nMSG: test_msgs/empty\n`;

function motion(i) {
  const phase = 2 * Math.PI * 1.5 * i * 0.002;
  return { position: [0.5, 0.0125 + 0.003 * Math.sin(phase)], velocity: [], effort: [0, 3 * Math.tanh(50 * Math.cos(phase))] };
}

async function write(file, { encoding, schemaEncoding, definition, mixed, encode, compressChunk, useChunks = true }) {
  const buffer = new TempBuffer();
  const writer = new McapWriter({ writable: buffer, compressChunk, useChunks, chunkSize: 8 * 1024 });
  await writer.start({ profile: schemaEncoding === "jsonschema" ? "" : schemaEncoding.slice(0, 4), library: "" });
  const text = new TextEncoder();
  const channel = async (topic, name, data) => writer.registerChannel({
    topic, messageEncoding: encoding, metadata: new Map(),
    schemaId: await writer.registerSchema({ name, encoding: schemaEncoding, data: text.encode(data) }),
  });
  const joints = await channel("/joint_states", schemaEncoding === "ros1msg" ? "sensor_msgs/JointState" : "sensor_msgs/msg/JointState", definition);
  const others = mixed && await channel("/mixed", "test_msgs/msg/Mixed", mixed);
  for (let i = 0; i < COUNT; i++) {
    const now = BEGIN_NS + BigInt(i) * STEP_NS, sec = Number(now / 1_000_000_000n), nanosec = Number(now % 1_000_000_000n);
    const header = { seq: i, stamp: { sec, nsec: nanosec, nanosec }, frame_id: "rail".slice(0, i % 5) };
    const add = async (channelId, message, which) => writer.addMessage(
      { channelId, sequence: i, logTime: now + LATE_NS, publishTime: now + LATE_NS, data: encode(message, which) });
    await add(joints, { header, name: ["turn", "slide"], ...motion(i) }, "joints");
    if (mixed && i % 10 === 0) {
      await add(others, { on: true, small: -2, single: 0.5, word: "abc", bytes: new Uint8Array([1, 2, 3]), large: -(2n ** 40n), some: [1.5, i],
        nothing: {}, last: -7 }, "mixed");
    }
  }
  await writer.end();
  writeFileSync(file, buffer.get());
}

await zstd.isLoaded;
const two = { joints: new ros2.MessageWriter(rosmsg.parse(ROS2, { ros2: true })), mixed: new ros2.MessageWriter(rosmsg.parse(MIXED, { ros2: true })) };
const one = new ros1.MessageWriter(rosmsg.parse(ROS1));
await write("mcap_ros2.mcap", { encoding: "cdr", schemaEncoding: "ros2msg", definition: ROS2, mixed: MIXED,
  encode: (message, which) => two[which].writeMessage(message), compressChunk: (data) => ({ compression: "zstd", compressedData: zstd.compress(data) }) });
await write("mcap_ros1.mcap", { encoding: "ros1", schemaEncoding: "ros1msg", definition: ROS1,
  encode: (message) => one.writeMessage(message), compressChunk: (data) => ({ compression: "lz4", compressedData: lz4.compress(data) }) });
await write("mcap_json.mcap", { encoding: "json", schemaEncoding: "jsonschema", definition: '{"type": "object"}', useChunks: false,
  encode: (message) => new TextEncoder().encode(JSON.stringify(message)) });
