// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/canopen/drive.h"
#include "hal/host/board.h"
#include "tests/loop/axis_loop.h"

// A node with its axis on one end of a cable, the test on the other. What the test sends and expects is
// written from the standards, byte by byte: nothing of the node's own encoding is used.
namespace slipstack::can {

using Data = std::vector<std::uint8_t>;

struct Message {
  std::uint32_t id = 0;
  Data data;
  friend bool operator==(const Message&, const Message&) = default;
};

inline std::ostream& operator<<(std::ostream& out, const Message& message) {
  char text[8];
  std::snprintf(text, sizeof text, "%03X#", message.id);
  out << text;
  for (const std::uint8_t byte : message.data) {
    std::snprintf(text, sizeof text, "%02X", byte);
    out << text;
  }
  return out;
}

inline constexpr std::uint8_t kNode = 5;

class Bench {
 public:
  explicit Bench(bool start = true, std::uint8_t id = kNode)
      : axis(sim::draw_bench(sim::Setup::kPickAndPlace, 3).axis),
        loop(std::make_unique<loop::AxisLoop>(axis)),
        memory(4096),
        trace(memory) {
    master.connect(device);
    power_on();
    if (start) begin(id);
  }

  /// A new controller and node on the same flash, as after a power cut.
  void power_on() {
    loop = std::make_unique<loop::AxisLoop>(axis);
    log = std::make_unique<RecordSlots>(flash);
    drive = std::make_unique<canopen::Drive>(loop->controller(), loop->tick.timing(), trace, 0x12345678,
                                             nullptr, programs, absolute_encoder, analogue, &loop->edges);
    node = std::make_unique<canopen::Node>(device, *log, *drive);
  }
  void begin(std::uint8_t id = kNode) {
    node->start(id, now_us);
    node->poll(now_us);
  }

  void run_ms(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) {
      for (int tick = 0; tick < 10; ++tick) {
        loop->step();
        drive->after_tick();
      }
      now_us += 1000;
      node->poll(now_us);
    }
  }
  void poll() { node->poll(now_us); }

  void send(std::uint32_t id, const Data& data) {
    CanFrame frame;
    frame.id = id;
    frame.length = static_cast<std::uint8_t>(data.size());
    std::copy(data.begin(), data.end(), frame.data.begin());
    ASSERT_TRUE(master.send(frame));
  }
  void request(std::uint32_t id, std::uint8_t length) {
    CanFrame frame;
    frame.id = id;
    frame.length = length;
    frame.remote = true;
    ASSERT_TRUE(master.send(frame));
  }
  /// The next frame that the node sent.
  std::optional<Message> next() {
    CanFrame frame;
    if (!master.receive(frame)) return std::nullopt;
    return Message{frame.id, Data(frame.data.begin(), frame.data.begin() + frame.length)};
  }
  std::vector<Message> all() {
    std::vector<Message> messages;
    while (const auto message = next()) messages.push_back(*message);
    return messages;
  }
  /// The frames with this identifier; the others are dropped.
  std::vector<Data> all_with(std::uint32_t id) {
    std::vector<Data> found;
    for (const Message& message : all()) {
      if (message.id == id) found.push_back(message.data);
    }
    return found;
  }
  void nmt(std::uint8_t command, std::uint8_t id = kNode) {
    send(0, {command, id});
    poll();
  }

  /// One SDO request and its response; empty if there is none. Other frames are dropped.
  Data sdo(const Data& request) {
    all();
    send(0x600 + kNode, request);
    poll();
    const std::vector<Data> answers = all_with(0x580 + kNode);
    EXPECT_LE(answers.size(), 1U);
    return answers.empty() ? Data{} : answers[0];
  }
  static Data address(std::uint8_t command, std::uint16_t index, std::uint8_t sub) {
    return {
        command, static_cast<std::uint8_t>(index & 0xFF), static_cast<std::uint8_t>(index >> 8), sub, 0, 0, 0,
        0};
  }
  static std::uint32_t number(const Data& data, std::size_t at, std::size_t bytes = 4) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value |= static_cast<std::uint32_t>(data.at(at + i)) << (8 * i);
    return value;
  }

  /// Expedited download; the abort code, 0 when taken.
  std::uint32_t write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes) {
    const std::array<std::uint8_t, 5> commands = {0, 0x2F, 0x2B, 0x27, 0x23};
    Data request = address(commands[static_cast<std::size_t>(bytes)], index, sub);
    for (std::size_t i = 0; i < static_cast<std::size_t>(bytes); ++i) {
      request[4 + i] = static_cast<std::uint8_t>(value >> (8 * i));
    }
    const Data answer = sdo(request);
    if (answer.size() != 8) return 0xFFFFFFFF;
    if (answer[0] == 0x80) return number(answer, 4);
    EXPECT_EQ(answer, address(0x60, index, sub));
    return 0;
  }
  std::uint32_t write_real(std::uint16_t index, std::uint8_t sub, float value) {
    return write(index, sub, std::bit_cast<std::uint32_t>(value), 4);
  }
  /// Expedited upload.
  std::uint32_t read(std::uint16_t index, std::uint8_t sub) {
    const Data answer = sdo(address(0x40, index, sub));
    if (answer.size() != 8 || (answer[0] & 0xE3) != 0x43) {
      ADD_FAILURE() << std::hex << index << ':' << int{sub} << " answers "
                    << (answer.empty() ? 0U : unsigned{answer[0]});
      return 0xDEADBEEF;
    }
    return number(answer, 4, 4U - ((answer[0] >> 2) & 3U));
  }
  float read_real(std::uint16_t index, std::uint8_t sub) { return std::bit_cast<float>(read(index, sub)); }
  std::int32_t read_signed(std::uint16_t index, std::uint8_t sub) {
    return static_cast<std::int32_t>(read(index, sub));
  }

  /// Axis and model by SDO, applied, so that the axis can be enabled.
  void configure() {
    const AxisParameters wanted = loop::pick_and_place_parameters(axis);
    ASSERT_EQ(write_real(0x2000, 1, wanted.encoder_resolution_m), 0U);
    ASSERT_EQ(write_real(0x2000, 3, wanted.motor_constant_N_per_A), 0U);
    ASSERT_EQ(write_real(0x2000, 9, wanted.current_limit_A), 0U);
    ASSERT_EQ(write_real(0x2000, 11, 0.3F), 0U);
    ASSERT_EQ(write_real(0x2000, 12, 5.0F), 0U);
    ASSERT_EQ(write_real(0x2000, 13, 200.0F), 0U);
    // A drive whose direction has been checked, as most are; machine_test.cpp has one that has not.
    ASSERT_EQ(write(0x2501, 1, 0, 1), 0U);
    // 2100h is inertia, 2101h the hysteresis: enabled, gains, shapes.
    const ModelParameters model = loop::identified_model(axis, 0.02, 0.01);
    ASSERT_EQ(write(0x2100, 1, 1, 1), 0U);
    ASSERT_EQ(write_real(0x2100, 2, std::get<0>(model).gains[0]), 0U);
    ASSERT_EQ(write(0x2101, 1, 1, 1), 0U);
    for (std::uint8_t i = 0; i < 10; ++i) {
      ASSERT_EQ(write_real(0x2101, static_cast<std::uint8_t>(2 + i), std::get<1>(model).gains[i]), 0U);
      ASSERT_EQ(write_real(0x2101, static_cast<std::uint8_t>(12 + i), std::get<1>(model).shapes[i]), 0U);
    }
    ASSERT_EQ(write(0x2140, 3, model_hash(model), 4), 0U);
    run_ms(2);
    ASSERT_EQ(read(0x2140, 2), model_hash(model));
  }
  /// Through the state machine of CiA 402 by controlword, over SDO.
  void enable(std::uint8_t mode) {
    ASSERT_EQ(write(0x6060, 0, mode, 1), 0U);
    for (const std::uint32_t word : {0x06U, 0x07U, 0x0FU}) {
      ASSERT_EQ(write(0x6040, 0, word, 2), 0U);
      run_ms(1);
    }
    // After some faults not before the axis stands.
    for (int i = 0; i < 30 && (read(0x6041, 0) & 0x6F) == 0x23; ++i) run_ms(1);
    ASSERT_EQ(read(0x6041, 0) & 0x6F, 0x27U);
  }

  sim::Axis axis;
  ProgramMemory* programs = nullptr;            // set before power_on()
  AbsoluteEncoder* absolute_encoder = nullptr;  // likewise
  AnalogueInputs* analogue = nullptr;           // likewise
  std::uint32_t now_us = 1000;
  host::HostNonvolatile flash{2, 2048, 8};
  host::HostCanPort device{4096};
  host::HostCanPort master{4096};
  std::unique_ptr<loop::AxisLoop> loop;
  std::vector<canopen::TraceSample> memory;
  canopen::TraceBuffer trace;
  std::unique_ptr<RecordSlots> log;
  std::unique_ptr<canopen::Drive> drive;
  std::unique_ptr<canopen::Node> node;
};

}  // namespace slipstack::can
