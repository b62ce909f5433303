// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <span>
#include <vector>

#include "firmware/canopen/drive.h"
#include "firmware/update/boot_choice.h"
#include "hal/host/board.h"
#include "hal/host/program_memory.h"

// The CANopen node and its controller, driven by bytes: frames, time, ticks, bus-off, power cuts. After every
// step: what must hold whatever comes in.
namespace slipstack::fuzz {

inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "node_fuzz: %s\n", what);
  std::abort();
}

/// The bus: what the input sends comes in, what the node sends is looked at and kept.
class FuzzPort final : public CanPort {
 public:
  bool send(const CanFrame& frame) override {
    if (blocked || bus.state == CanBusState::kOff) return false;
    require(frame.length <= 8 && !frame.extended && !frame.remote && frame.id <= 0x7FF,
            "the node sent what is no frame of its own");
    sent.push_back(frame);
    return true;
  }
  bool receive(CanFrame& frame) override {
    if (read_ == waiting.size()) return false;
    frame = waiting[read_++];
    ++taken;
    return true;
  }
  CanBusStatus status() const override { return bus; }
  void recover() override { bus.state = CanBusState::kActive; }

  CanBusStatus bus;
  bool blocked = false;
  int taken = 0;
  std::vector<CanFrame> waiting;
  std::vector<CanFrame> sent;

 private:
  std::size_t read_ = 0;
};

class FuzzedNode {
 public:
  static constexpr std::uint8_t kId = 5;

  FuzzedNode() : memory_(64) {
    power_on();
    commission();
  }

  /// A new controller and node on the same flash, as after a power cut.
  void power_on() {
    flash.bytes_until_power_fails = static_cast<std::size_t>(-1);
    clock_ = {};
    clock_.rate_Hz = 10'000'000;
    tick_ = std::make_unique<TickOnHost>(encoder_, motor_, clock_, watchdog_, io_);
    tick_->set_period(1000);
    trace_ = std::make_unique<canopen::TraceBuffer>(memory_);
    log_ = std::make_unique<RecordSlots>(flash);
    programs.restarted = false;
    drive_ = std::make_unique<canopen::Drive>(controller(), tick_->timing(), *trace_, 0x12345678, nullptr,
                                              &programs);
    node_ = std::make_unique<canopen::Node>(port, *log_, *drive_);
    node_->start(kId, now_us);
  }

  void send(const CanFrame& frame) { port.waiting.push_back(frame); }
  void send(std::uint32_t id, std::initializer_list<std::uint8_t> data) {
    CanFrame frame;
    frame.id = id;
    for (const std::uint8_t byte : data) frame.data[frame.length++] = byte;
    send(frame);
  }

  void poll(std::uint32_t later_us) {
    now_us += later_us;
    port.taken = 0;
    const std::size_t before = port.sent.size();
    node_->poll(now_us);
    drive_->watch_trial(now_us, node_->takes_part());
    require(port.taken <= canopen::Node::kFramesPerPoll, "a poll took more frames than it may");
    // What waited, then what one poll may add.
    require(port.sent.size() - before <= 2 * canopen::Outbox::kCapacity, "a poll sent without bound");
    check();
    if (!programs.restarted) return;
    require(!controller().state().driving(), "a restart of a driven axis");
    power_on();
  }

  /// The axis follows its reference by a wobble of some counts.
  void ticks(unsigned count) {
    for (unsigned i = 0; i < count; ++i) {
      encoder_.next.counts = controller().output().reference_counts + static_cast<int>(i % 3) - 1;
      clock_.advance(1000);
      tick_->run();
      drive_->after_tick();
    }
    check();
  }

  Controller& controller() { return tick_->controller(); }
  canopen::Node& node() { return *node_; }
  canopen::Drive& drive() { return *drive_; }

  std::uint32_t now_us = 1000;
  FuzzPort port;
  host::HostNonvolatile flash{2, 2048, 8};
  host::HostProgramMemory programs;

 private:
  using TickOnHost = Tick<host::HostEncoder, host::HostMotorCurrent, host::HostClock, host::HostWatchdog,
                          host::HostDigitalIo>;

  // A mass, so that the axis can be enabled: staged, and taken by a reset of the drive.
  void commission() {
    canopen::Dictionary& dictionary = node_->dictionary();
    dictionary.set(canopen::kRow<0x2100, 1>, 1);
    dictionary.set(canopen::kRow<0x2100, 2>, std::bit_cast<std::uint32_t>(35.0F));
    dictionary.set(canopen::kRow<canopen::kDirectionIndex, 1>, 0);  // enabled at once
    drive_->reset(dictionary);
    ticks(4);
    poll(1000);
    require(controller().parameters().valid, "the commissioned axis is not valid");
  }

  void check() {
    const ControlOutput& out = controller().output();
    for (const float value : {out.current_A, out.position_error_m, out.velocity_mps, out.feedforward_N,
                              out.feedback_N, out.residual_N, out.level}) {
      require(std::isfinite(value), "a value of the controller is not finite");
    }
    const ControlSet& set = controller().parameters();
    require(std::fabs(motor_.set_point_A) <= set.axis.current_limit_A, "the current is beyond its limit");
    const bool permitted = controller().state().driving() || controller().direction_unknown();
    require(permitted || motor_.set_point_A == 0.0F, "current without permission");
    check_programs();
  }

  // What a boot loader would start is whole, whatever was sent.
  void check_programs() {
    const update::SlotView view = update::look(programs, 1);
    if (view.state == update::SlotState::kEmpty) return;
    require(update::intact(programs, 1, view.header), "a program was installed that is not whole");
    require(programs.slots[0].bytes[0] == std::byte{0xFF}, "the running slot was written");
  }

  host::HostEncoder encoder_{{0, true}};
  host::HostMotorCurrent motor_;
  host::HostClock clock_;
  host::HostWatchdog watchdog_;
  host::HostDigitalIo io_;
  std::vector<canopen::TraceSample> memory_;
  std::unique_ptr<TickOnHost> tick_;
  std::unique_ptr<canopen::TraceBuffer> trace_;
  std::unique_ptr<RecordSlots> log_;
  std::unique_ptr<canopen::Drive> drive_;
  std::unique_ptr<canopen::Node> node_;
};

/// Values in memory keep their bounds, whoever wrote them.
inline void check_dictionary(const canopen::Dictionary& dictionary) {
  for (std::size_t row = 0; row < canopen::kObjectCount; ++row) {
    const canopen::Object& object = canopen::kObjects[row];
    if (object.type == canopen::Type::kDomain || object.text != nullptr || object.live) continue;
    if (!object.writable()) continue;
    require(canopen::check_bounds(object, dictionary.value(row)) == canopen::Abort::kNone,
            "a value lies beyond the bounds of its object");
  }
}

/// Whatever came before: reset by NMT, the node boots and answers a question for its device type.
inline void check_alive(FuzzedNode& fuzzed) {
  fuzzed.port.blocked = false;
  fuzzed.port.bus.state = CanBusState::kActive;
  // All that waits is taken; a change of bit rate may be in it, and silence for twice 65.5 s at most.
  const std::size_t turns = fuzzed.port.waiting.size() / canopen::Node::kFramesPerPoll + 4;
  for (std::size_t i = 0; i < turns; ++i) fuzzed.poll(5000);
  fuzzed.poll(66'000'000);
  fuzzed.poll(66'000'000);
  fuzzed.send(0x7E5, {0x04, 0, 0, 0, 0, 0, 0, 0});
  fuzzed.send(0, {129, 0});
  for (int i = 0; i < 4; ++i) fuzzed.poll(5000);
  const std::uint8_t id = fuzzed.node().id();
  if (id == canopen::Lss::kUnconfigured) return;
  require(id >= 1 && id <= 127, "a node id that is none");
  fuzzed.port.sent.clear();
  fuzzed.send(0x600U + id, {0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0});
  fuzzed.poll(1000);
  fuzzed.poll(1000);
  CanFrame wanted;
  wanted.id = 0x580U + id;
  wanted.length = 8;
  wanted.data = {0x43, 0x00, 0x10, 0x00, 0x92, 0x01, 0x02, 0x00};
  bool found = false;
  for (const CanFrame& frame : fuzzed.port.sent) found |= frame == wanted;
  require(found, "the node does not answer any more");
}

}  // namespace slipstack::fuzz
