// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>

#include "firmware/canopen/drive.h"
#include "hal/host/board.h"
#include "sim_host/log/draw.h"
#include "sim_host/plant/plant.h"
#include "sim_host/rng.h"
#include "sim_host/sensors/encoder.h"
#include "sim_host/sensors/reference_marks.h"
#include "sim_host/sensors/switches.h"
#include "workbench/loop/loop_parameters.h"

namespace slipstack::workbench {

/// The firmware's controller and CANopen node around a simulated axis, in this process, 10 000 ticks a second
/// of its own time.
class SimulatedDrive {
 public:
  static constexpr double kTick_s = 1e-4;

  SimulatedDrive(const sim::Axis& axis, CanPort& port, Nonvolatile& flash, std::uint8_t node,
                 std::uint64_t seed)
      : plant_(axis, 0.5 * axis.stroke_m),
        switches_(sim::switches_of(axis)),
        last_m_(plant_.position_m()),
        encoder_(axis.encoder_resolution_m, 0.37),
        noise_N_(axis.force_noise_N),
        rng_(seed, "node"),
        tick_(board_encoder_, motor_, clock_, watchdog_, io_),
        trace_(memory_),
        log_(flash),
        drive_(tick_.controller(), tick_.timing(), trace_, 1),
        node_(port, log_, drive_) {
    clock_.rate_Hz = 10'000'000;
    tick_.set_period(1000);
    sense();
    node_.start(node, 0);
    if (log_.sequence() == 0) commission(axis);
  }

  /// One tick, and one pass of the main loop.
  void step() {
    sense();
    tick_.run();
    drive_.after_tick();
    plant_.step(motor_.enabled ? static_cast<double>(motor_.set_point_A) : 0.0, kTick_s,
                noise_N_ > 0.0 ? noise_N_ * rng_.normal() : 0.0);
    clock_.advance(1000);
    now_us_ += 100;
    node_.poll(now_us_);
    tick_.main_loop_ran();
  }

  Controller& controller() { return tick_.controller(); }
  canopen::Node& node() { return node_; }

 private:
  void sense() {
    board_encoder_.next.counts = static_cast<std::int32_t>(encoder_.counts(plant_.position_m()));
    io_.inputs = switches_.levels(plant_.position_m());
    if (const auto mark = marks_.passed(encoder_, last_m_, plant_.position_m())) {
      board_encoder_.index_passed = true;
      board_encoder_.index_counts = *mark;
    }
    last_m_ = plant_.position_m();
  }

  // The parameters known at commissioning, applied and stored: data sheet and mass of the axis.
  void commission(const sim::Axis& axis) {
    canopen::Dictionary& dictionary = node_.dictionary();
    const AxisParameters parameters = loop_parameters(axis, kTick_s);
    for (std::size_t i = 0; i < canopen::kAxisObjects.size(); ++i) {
      dictionary.set(canopen::kRow<canopen::kAxisIndex> + 1 + i,
                     std::bit_cast<std::uint32_t>(parameters.*canopen::kAxisObjects[i].member));
    }
    for (std::size_t sub = 1; sub < sim::Switches::kWiring.size(); ++sub) {
      dictionary.set(canopen::kRow<canopen::kIoIndex> + sub, sim::Switches::kWiring[sub]);
    }
    dictionary.set(canopen::kRow<canopen::kReferenceIndex, 1>, parameters.reference.absolute_encoder ? 1 : 0);
    canopen::model_words(mass_only_model(axis),
                         [&](std::size_t row, std::uint32_t word) { dictionary.set(row, word); });
    drive_.reset(dictionary);
    constexpr std::uint32_t kSave = 0x65766173;  // "save"
    static_cast<void>(dictionary.write(canopen::kRow<0x1010, 1>, kSave));
  }

  sim::Plant plant_;
  sim::Switches switches_;
  sim::ReferenceMarks marks_ = sim::kMarks;
  double last_m_;
  sim::Encoder encoder_;
  double noise_N_;
  sim::Rng rng_;
  host::HostEncoder board_encoder_;
  host::HostMotorCurrent motor_;
  host::HostClock clock_;
  host::HostWatchdog watchdog_;
  host::HostDigitalIo io_;
  Tick<host::HostEncoder, host::HostMotorCurrent, host::HostClock, host::HostWatchdog, host::HostDigitalIo>
      tick_;
  std::array<canopen::TraceSample, 4096> memory_{};
  canopen::TraceBuffer trace_;
  SlotLog log_;
  canopen::Drive drive_;
  canopen::Node node_;
  std::uint32_t now_us_ = 0;
};

}  // namespace slipstack::workbench
