// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>

#include "firmware/canopen/drive.h"
#include "hal/host/board.h"
#include "hal/include/signal_scaling.h"
#include "sim_host/log/draw.h"
#include "sim_host/plant/plant.h"
#include "sim_host/rng.h"
#include "sim_host/sensors/captured_switch.h"
#include "sim_host/sensors/encoder.h"
#include "sim_host/sensors/reference_marks.h"
#include "sim_host/sensors/switches.h"
#include "workbench/loop/loop_parameters.h"

namespace slipstack::workbench {

/// How a machine is connected; the drive's 2500h should say the same.
struct Wiring {
  bool encoder_reversed = false;
  bool motor_reversed = false;
  bool checked = true;  ///< commissioned with the check of the direction passed (2501h:05)
};

/// Between the drive and the machine: the encoder's counts and the amplifier's command, each by the scales of
/// the drive and those of the machine. A machine whose scales the drive knows is one without any.
class Signals final : public SignalScaling {
 public:
  explicit Signals(const Wiring& wiring) { machine_ = {wiring.encoder_reversed, wiring.motor_reversed}; }

  void set_scales(const SignalScales& scales) override {
    // The count goes on from where it is.
    const std::int32_t before = last_counts_;
    drive_ = scales;
    zero_counts_ = 0;
    zero_counts_ = before - counts(last_raw_);
    last_counts_ = before;
  }
  float largest_A(const SignalScales& scales) const override { return largest_of_10_V(scales); }
  /// The machine's amplifier: A/V.
  void set_amplifier(float command_A_per_V) {
    machine_.command_A_per_V = drive_.command_A_per_V = command_A_per_V;
  }

  std::int32_t counts(std::int32_t raw) {
    last_raw_ = raw;
    last_counts_ = counts_at(raw);
    return last_counts_;
  }
  /// Of another place than the last one.
  std::int32_t counts_at(std::int32_t raw) const {
    return zero_counts_ + (machine_.encoder_reversed != drive_.encoder_reversed ? -raw : raw);
  }
  double current_A(float set_point_A) const {
    const float ratio = machine_.command_A_per_V / drive_.command_A_per_V;  // 1 where the drive knows it
    const float offset_V = drive_.command_zero_V - machine_.command_zero_V;
    const float current_A = set_point_A * ratio + offset_V * machine_.command_A_per_V;
    return static_cast<double>(machine_.motor_reversed != drive_.motor_reversed ? -current_A : current_A);
  }

 private:
  SignalScales machine_;
  SignalScales drive_;
  std::int32_t zero_counts_ = 0;
  std::int32_t last_raw_ = 0;
  std::int32_t last_counts_ = 0;
};

/// The firmware's controller and CANopen node around a simulated axis, in this process, 10 000 ticks a second
/// of its own time.
class SimulatedDrive {
 public:
  static constexpr double kTick_s = 1e-4;

  SimulatedDrive(const sim::Axis& axis, CanPort& port, Nonvolatile& flash, std::uint8_t node,
                 std::uint64_t seed, const Wiring& wiring = {}, ProgramMemory* programs = nullptr)
      : plant_(axis, 0.5 * axis.stroke_m),
        switches_(sim::switches_of(axis)),
        captured_(sim::captured_switch_of(axis)),
        last_m_(plant_.position_m()),
        encoder_(axis.encoder_resolution_m, 0.37),
        noise_N_(axis.force_noise_N),
        rng_(seed, "node"),
        signals_(wiring),
        tick_(board_encoder_, motor_, clock_, watchdog_, io_),
        trace_(memory_),
        log_(flash),
        drive_(tick_.controller(), tick_.timing(), trace_, 1, &signals_, programs, nullptr, &analogue_,
               &edges_),
        node_(port, log_, drive_) {
    clock_.rate_Hz = 10'000'000;
    tick_.set_period(1000);
    edges_.wired = sim::CapturedSwitch::kTerminal;
    signals_.set_amplifier(0.1F * static_cast<float>(axis.current_limit_A));
    sense();
    node_.start(node, 0);
    if (log_.sequence() == 0) commission(axis, wiring.checked);
  }

  /// One tick, and one pass of the main loop.
  void step() {
    sense();
    tick_.run();
    drive_.after_tick();
    plant_.step(motor_.enabled ? signals_.current_A(motor_.set_point_A) : 0.0, kTick_s,
                noise_N_ > 0.0 ? noise_N_ * rng_.normal() : 0.0);
    clock_.advance(1000);
    now_us_ += 100;
    node_.poll(now_us_);
    drive_.watch_trial(now_us_, node_.takes_part());
    tick_.main_loop_ran();
  }

  Controller& controller() { return tick_.controller(); }
  canopen::Node& node() { return node_; }

 private:
  void sense() {
    board_encoder_.next.counts =
        signals_.counts(static_cast<std::int32_t>(encoder_.counts(plant_.position_m())));
    io_.inputs = switches_.levels(plant_.position_m()) | captured_.levels(plant_.position_m());
    captured_.passed(encoder_, last_m_, plant_.position_m(), [this](std::int32_t counts, bool high) {
      edges_.caught.push_back({signals_.counts_at(counts), high});
    });
    if (const auto mark = marks_.passed(encoder_, last_m_, plant_.position_m())) {
      board_encoder_.index_passed = true;
      board_encoder_.index_counts = signals_.counts_at(*mark);
    }
    last_m_ = plant_.position_m();
  }

  // The parameters known at commissioning, applied and stored: data sheet and mass of the axis, and that the
  // push of the first enabling has moved it the right way.
  void commission(const sim::Axis& axis, bool checked) {
    canopen::Dictionary& dictionary = node_.dictionary();
    const AxisParameters parameters = loop_parameters(axis, kTick_s);
    for (std::size_t i = 0; i < canopen::kAxisObjects.size(); ++i) {
      set_real(dictionary, canopen::kRow<canopen::kAxisIndex> + 1 + i,
               parameters.*canopen::kAxisObjects[i].member);
    }
    for (std::size_t sub = 1; sub < sim::Switches::kWiring.size(); ++sub) {
      dictionary.set(canopen::kRow<canopen::kIoIndex> + sub, sim::Switches::kWiring[sub]);
    }
    dictionary.set(canopen::kRow<canopen::kReferenceIndex, 1>, parameters.reference.absolute_encoder ? 1 : 0);
    canopen::model_words(mass_only_model(axis.mass_kg),
                         [&](std::size_t row, std::uint32_t word) { dictionary.set(row, word); });
    set_real(dictionary, canopen::kRow<canopen::kScalesIndex, 3>, 0.1F * parameters.current_limit_A);
    dictionary.set(canopen::kRow<canopen::kDirectionIndex, 5>,
                   checked ? canopen::scales_hash(dictionary) : 0U);
    drive_.reset(dictionary);
    constexpr std::uint32_t kSave = 0x65766173;  // "save"
    static_cast<void>(dictionary.write(canopen::kRow<0x1010, 1>, kSave));
  }

  static void set_real(canopen::Dictionary& dictionary, std::size_t row, float value) {
    dictionary.set(row, std::bit_cast<std::uint32_t>(value));
  }

  sim::Plant plant_;
  sim::Switches switches_;
  sim::CapturedSwitch captured_;
  sim::ReferenceMarks marks_ = sim::kMarks;
  double last_m_;
  sim::Encoder encoder_;
  double noise_N_;
  sim::Rng rng_;
  Signals signals_;
  host::HostEncoder board_encoder_;
  host::HostMotorCurrent motor_;
  host::HostClock clock_;
  host::HostWatchdog watchdog_;
  host::HostDigitalIo io_;
  host::HostAnalogueInputs analogue_;
  host::HostEdgeCapture edges_;
  Tick<host::HostEncoder, host::HostMotorCurrent, host::HostClock, host::HostWatchdog, host::HostDigitalIo>
      tick_;
  std::array<canopen::TraceSample, 4096> memory_{};
  canopen::TraceBuffer trace_;
  RecordSlots log_;
  canopen::Drive drive_;
  canopen::Node node_;
  std::uint32_t now_us_ = 0;
};

}  // namespace slipstack::workbench
