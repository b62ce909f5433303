// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstring>
#include <span>

#include "firmware/canopen/telemetry/trace.h"
#include "firmware/control/controller.h"

namespace slipstack::canopen {

/// The trace (2300h) and its domain (2310h): what of each tick is recorded, when, and its upload.
class TraceObjects {
 public:
  TraceObjects(const Controller& controller, TraceBuffer& trace) : controller_(controller), trace_(trace) {}

  /// From the tick's interrupt, behind the tick.
  ///
  /// What is recorded beside the counts is the force that acted when they were read: a command is held from
  /// this tick to the next, so about this instant the current was the mean of the last command and this one.
  /// The command alone would be half a tick early, at a jerk of 100 m/s3 and 35 kg 0.18 N.
  void after_tick() {
    const float command_A = controller_.output().current_A;
    mean_command_A_ = 0.5F * (last_command_A_ + command_A);
    last_command_A_ = command_A;
    const PositionReference& position = controller_.position();
    const std::int32_t second = excitation_ ? std::bit_cast<std::int32_t>(controller_.excitation().value())
                                            : position.position_of(controller_.output().reference_counts);
    trace_.sample({position.position_of(controller_.measured_counts()), second, mean_command_A_},
                  controller_.ticks());
  }
  /// Current about the instant at which the last counts were read.
  float mean_command_A() const { return mean_command_A_; }

  bool recording() const {
    return trace_.state() == TraceState::kArmed || trace_.state() == TraceState::kTriggered;
  }

  std::uint32_t read(const Dictionary& dictionary, std::uint8_t sub) const {
    switch (sub) {
      case 2:
        return static_cast<std::uint32_t>(trace_.state());
      case 8:
        return trace_.samples();
      case 9:
        return trace_.capacity();
      default:
        return dictionary.value(kRow<kTraceIndex, 1>);
    }
  }
  /// While it records, its settings stay.
  Abort check(std::uint8_t sub) const { return sub != 1 && recording() ? Abort::kDeviceState : Abort::kNone; }
  /// 2300h:01. 0 stops, else it is armed with the settings of the dictionary.
  void command(const Dictionary& dictionary, std::uint32_t value) {
    if (value == 0) return trace_.stop();
    trace_.stop();
    excitation_ = dictionary.value(kRow<kTraceIndex, 10>) != 0;
    trace_.arm({dictionary.value(kRow<kTraceIndex, 3>),
                static_cast<TraceTrigger>(dictionary.value(kRow<kTraceIndex, 4>)),
                static_cast<std::uint8_t>(dictionary.value(kRow<kTraceIndex, 5>)),
                dictionary.real(kRow<kTraceIndex, 6>), dictionary.value(kRow<kTraceIndex, 7>)});
  }

  Abort begin_upload(std::uint32_t& size) {
    if (recording() || trace_.samples() == 0) return Abort::kDeviceState;
    const ControlSet& set = controller_.parameters();
    head_ = {};
    head_.samples = trace_.samples();
    head_.decimation = trace_.decimation();
    head_.tick_s = set.axis.tick_s;
    head_.encoder_resolution_m = set.axis.encoder_resolution_m;
    head_.motor_constant_N_per_A = set.axis.motor_constant_N_per_A;
    head_.mass_kg = set.mass_kg;
    head_.model_hash = set.hash;
    head_.trigger_place = trace_.trigger_place();
    head_.last_tick = trace_.last_tick();
    head_.second_channel = excitation_ ? 1 : 0;
    size = static_cast<std::uint32_t>(sizeof(TraceHead) + sizeof(TraceSample) * head_.samples);
    return Abort::kNone;
  }
  void upload(std::uint32_t offset, std::span<std::uint8_t> out) const {
    for (std::uint8_t& byte : out) byte = byte_at(offset++);
  }

 private:
  std::uint8_t byte_at(std::uint32_t offset) const {
    if (offset < sizeof(TraceHead)) return byte_of(head_, offset);
    const std::uint32_t at = offset - static_cast<std::uint32_t>(sizeof(TraceHead));
    return byte_of(trace_[at / sizeof(TraceSample)], at % sizeof(TraceSample));
  }
  template <class T>
  static std::uint8_t byte_of(const T& object, std::size_t at) {
    std::uint8_t byte = 0;
    std::memcpy(&byte, reinterpret_cast<const std::uint8_t*>(&object) + at, 1);
    return byte;
  }

  const Controller& controller_;
  TraceBuffer& trace_;
  TraceHead head_;
  bool excitation_ = false;  // in the place of the reference
  float last_command_A_ = 0.0F;
  float mean_command_A_ = 0.0F;
};

}  // namespace slipstack::canopen
