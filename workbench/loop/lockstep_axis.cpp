// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/lockstep_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "firmware/app/lockstep/link_service.h"
#include "firmware/effects/model_hash.h"
#include "sim_host/loop/set_points.h"
#include "sim_host/plant/end_stops.h"
#include "sim_host/plant/plant.h"
#include "sim_host/rng.h"
#include "sim_host/sensors/delay_line.h"
#include "sim_host/sensors/encoder.h"
#include "workbench/loop/loop_parameters.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {
namespace {

constexpr double kAxisTick_s = 1e-4;
constexpr int kTicksPerSample = 5;
constexpr double kLargestVelocity_mps = 1.0;
constexpr int kLongestWait = 100'000;        // ticks, for a state of the drive
constexpr int kRest = 1000;                  // ticks without current, in which friction stops the axis
constexpr double kFarthestShift_m = 0.2e-3;  // of a motion, to begin where the axis is held
constexpr double kAssumed_mps2 = 20.0;       // of the largest force, before the mass is known
constexpr double kPhase = 0.37;              // of the grating at which the axis is switched on, counts
constexpr std::uint32_t kOn = kSwitchOn | kEnableVoltage | kQuickStop | kEnableOperation;

Nameplate nameplate_of(const sim::Axis& axis) {
  return {axis.encoder_resolution_m, axis.motor_constant_N_per_A, axis.current_limit_A, axis.stroke_m,
          kLargestVelocity_mps,      axis.magnet_pitch_m,         kAxisTick_s};
}

/// The delay with which the drive reports its force, as in every record of the simulator: the axis itself is
/// not late.
sim::DelayLine report_of(const sim::Axis& axis) {
  const sim::RecordingDelay late = axis.effects.delay.value_or(sim::RecordingDelay{});
  return {kAxisTick_s, late.delay_s, late.filter_s};
}

/// What a drive has of these settings. The supervision's limits follow from the name plate.
AxisParameters parameters_of(const Nameplate& plate, const DriveSettings& settings) {
  AxisParameters parameters = supervised_axis(plate.encoder_resolution_m, plate.motor_constant_N_per_A,
                                              plate.current_limit_A, plate.tick_s);
  parameters.observer_bandwidth_rad_per_s = static_cast<float>(settings.observer_rad_per_s);
  parameters.position_gain_per_s = static_cast<float>(settings.position_gain_per_s);
  parameters.velocity_gain_N_s_per_m = static_cast<float>(settings.velocity_gain_N_s_per_m);
  parameters.integral_per_s = static_cast<float>(settings.integral_per_s);
  parameters.current_limit_A = static_cast<float>(settings.force_limit_N / plate.motor_constant_N_per_A);
  parameters.stall_current_A = 0.8F * parameters.current_limit_A;
  parameters.following_error_m = static_cast<float>(settings.following_error_m);
  parameters.velocity_limit_mps = static_cast<float>(settings.velocity_limit_mps);
  parameters.acceleration_limit_mps2 = static_cast<float>(settings.acceleration_limit_mps2);
  parameters.quick_stop_mps2 = parameters.acceleration_limit_mps2;
  parameters.jerk_limit_mps3 = static_cast<float>(settings.jerk_limit_mps3);
  return parameters;
}

class LockstepAxis final : public LiveAxis {
 public:
  LockstepAxis(std::unique_ptr<sim::LockstepBoard> board, const LockstepMachine& machine)
      : board_(std::move(board)),
        link_(board_->link()),
        machine_(machine),
        plant_(machine_.axis, 0.5 * machine_.axis.stroke_m),
        encoder_(machine_.axis.encoder_resolution_m, kPhase),
        report_(report_of(machine_.axis)),
        noise_(machine_.seed, "lockstep axis"),
        nameplate_(nameplate_of(machine_.axis)) {
    stops_.positive_m = machine_.end_m > 0.0 ? machine_.end_m : machine_.axis.stroke_m;
    link_.period = static_cast<std::uint32_t>(std::lround(kAxisTick_s * PlantLink::kClockTicks_Hz));
    link_.encoder_valid = 1;
    link_.current_valid = 1;
    // Where the axis stands is known before there are parameters: the hysteresis is relaxed there.
    wait(3);
  }

  const Nameplate& nameplate() const override { return nameplate_; }
  double used_s() const override { return static_cast<double>(ticks_) * kAxisTick_s; }
  double position_m() const override {
    return in(DriveState::kOperationEnabled)
               ? static_cast<double>(link_.reference_counts) * nameplate_.encoder_resolution_m
               : measured_m();
  }

  Direction check_direction() override {
    // Nothing is fed back while the axis is pushed. The mass enters the estimate alone, from which the drive
    // foresees where a stop would end: with a mass far too small it would hold the axis for fear of its
    // range.
    DriveSettings unknown;
    unknown.force_limit_N = nameplate_.force_limit_N();
    unknown.mass_kg = unknown.force_limit_N / kAssumed_mps2;
    unknown.acceleration_limit_mps2 = kAssumed_mps2;
    unknown.jerk_limit_mps3 = kAssumed_mps2 / 0.01;
    AxisParameters pushed = parameters_of(nameplate_, unknown);
    pushed.check_direction = true;
    pushed.check_current_A = 0.5F * pushed.current_limit_A;
    pushed.check_rate_A_per_s = std::max(0.1F, 0.5F * pushed.current_limit_A);
    const std::string refused = configure({pushed, mass_only_model(unknown.mass_kg)});
    if (!refused.empty()) throw DriveLost(refused);
    const bool enabled = enable(false);
    const auto fault = static_cast<Fault>(static_cast<std::uint32_t>(link_.fault));
    switch_off();
    if (enabled) return Direction::kRight;
    return fault == Fault::kDirection ? Direction::kReversed : Direction::kBlocked;
  }

  void reverse_motor() override { drive_reversed_ = !drive_reversed_; }

  AxisRecord pulse(double force_N, double seconds) override {
    AxisRecord record;
    record.rate_Hz = 1.0 / kAxisTick_s;
    link_.target_N = 0.0F;
    if (!enable(true)) return faulted(std::move(record));
    const auto half = static_cast<int>(seconds / kAxisTick_s);
    double before_m = measured_m();
    for (int i = 0; i < 2 * half; ++i) {
      link_.target_N = static_cast<float>(i < half ? force_N : -force_N);
      note(record, step());
      if (link_.fault != 0) return faulted(std::move(record));
      const double moved_m = measured_m() - before_m;
      before_m = measured_m();
      if (i > half && moved_m * force_N < 0.0) break;
    }
    switch_off();
    return record;
  }

  std::string deploy(const DriveSettings& settings, const Terms& target_terms) override {
    const ModelParameters model =
        target_terms.empty() ? mass_only_model(settings.mass_kg) : target_parameters(target_terms);
    return configure({parameters_of(nameplate_, settings), model});
  }

  AxisRecord run(const SetPoints& motion) override {
    AxisRecord record;
    record.rate_Hz = 1.0 / (kAxisTick_s * kTicksPerSample);
    if (!enable(false)) return faulted(std::move(record));
    const auto period = static_cast<std::size_t>(std::lround(1.0 / (motion.rate_Hz * kAxisTick_s)));
    const std::uint32_t refused = link_.stream_refused;
    for (int i = 0; i < kRest && link_.reference_idle == 0; ++i) step();
    // A stream begins at the whole count where the reference rests: without a step, however coarse a count.
    const double shift = static_cast<double>(link_.reference_counts) -
                         motion.position_m.front() / nameplate_.encoder_resolution_m;
    if (std::fabs(shift) * nameplate_.encoder_resolution_m > kFarthestShift_m) {
      record.fault = "the motion does not begin where the axis is held";
      switch_off();
      return record;
    }
    // The queue delays by three periods: the last point is sent three times more.
    const std::size_t count = (motion.size() + sim::kSetPointsAhead) * period;
    std::size_t sent = 0;
    std::size_t limited = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (i < sim::kSetPointsAhead || i % period == 0)
        send(motion.position_m[std::min(sent++, motion.size() - 1)], shift, period);
      const double force_N = step();
      if ((link_.limits & kLimitCurrent) != 0) ++limited;
      if (i % kTicksPerSample == 0) {
        note(record, force_N);
        record.reference_m.push_back(static_cast<double>(link_.reference_counts) *
                                     nameplate_.encoder_resolution_m);
        record.error_m.push_back(static_cast<double>(link_.position_error_m));
      }
      last_N_ = force_N;
      if (link_.fault != 0) return faulted(std::move(record));
      if (link_.stream_refused != refused) {
        record.fault = "the drive refuses a set-point beyond its limits";
        switch_off();
        return record;
      }
    }
    record.limited_share = static_cast<double>(limited) / static_cast<double>(count);
    return record;
  }

  void switch_off() override {
    link_.control_word = 0;
    for (int i = 0; i < kLongestWait && !in(DriveState::kFault) && !in(DriveState::kSwitchOnDisabled); ++i)
      step();
    // The reset of a fault is an edge; then the axis comes to rest.
    link_.control_word = kFaultReset;
    wait(3);
    link_.control_word = 0;
    wait(kRest);
    last_N_ = 0.0;
  }

 private:
  bool in(DriveState state) const { return link_.state == static_cast<std::uint32_t>(state); }
  double measured_m() const { return static_cast<double>(link_.counts) * nameplate_.encoder_resolution_m; }

  void wait(int ticks) {
    for (int i = 0; i < ticks; ++i) step();
  }

  /// One tick of the drive, and the axis meanwhile. Returns the force that the drive reports.
  double step() {
    link_.counts = static_cast<std::int32_t>(encoder_.counts(plant_.position_m()));
    try {
      board_->tick();
    } catch (const sim::LoopError& error) {
      throw DriveLost(error.what());
    }
    const double current_A = link_.driving != 0 ? static_cast<double>(link_.current_A) : 0.0;
    const sim::Axis& axis = machine_.axis;
    const double noise_N = axis.force_noise_N > 0.0 ? axis.force_noise_N * noise_.normal() : 0.0;
    const double stop_N = stops_.force_N(plant_.position_m(), plant_.velocity_mps());
    const bool reversed = machine_.motor_reversed != drive_reversed_;
    plant_.step(reversed ? -current_A : current_A, kAxisTick_s, noise_N + stop_N);
    ++ticks_;
    if (!(std::fabs(plant_.position_m()) < 10.0 * axis.stroke_m))
      throw DriveLost("the simulated axis has left its rail");
    return report_.push(current_A * axis.motor_constant_N_per_A);
  }

  /// The command is held from a tick on: at its instant the force is the mean of those before and after it.
  void note(AxisRecord& record, double force_N) {
    record.position_m.push_back(measured_m());
    record.force_N.push_back(0.5 * (last_N_ + force_N));
    last_N_ = force_N;
  }

  std::string configure(const lockstep::ParameterBlock& block) {
    // Refused by the controller itself, they would stop an enabled axis.
    if (const ParameterStatus status = check(block.axis, block.model); status != ParameterStatus::kOk)
      return fmt::format("the controller refuses its parameters (status {})", static_cast<int>(status));
    lockstep::write_parameters(link_, block);
    constexpr auto kBusy = static_cast<std::uint32_t>(ParameterStatus::kBusy);
    for (int i = 0; i < kRest; ++i) {
      link_.parameter_sequence = link_.parameter_sequence + 1;
      step();
      if (link_.last_status != kBusy) break;
    }
    if (link_.last_status == lockstep::LinkService::kWrongSize)
      return "the image is of another version than this program; build both anew";
    if (link_.last_status != 0) {
      return fmt::format("the controller refuses its parameters (status {})",
                         static_cast<std::uint32_t>(link_.last_status));
    }
    wait(1 + static_cast<int>(block.axis.swap_time_s / block.axis.tick_s));
    if (link_.model_hash == model_hash(block.model)) return "";
    return "the controller does not report the hash of the model that it was given";
  }

  bool enable(bool torque) {
    const bool was_torque = link_.torque_mode != 0;
    link_.torque_mode = torque ? 1 : 0;
    if (in(DriveState::kOperationEnabled) && torque == was_torque) return true;
    for (const std::uint32_t word : {0x00U, 0x06U, 0x07U}) {
      link_.control_word = word;
      wait(3);
    }
    link_.control_word = kOn;
    for (int i = 0; i < kLongestWait && link_.fault == 0; ++i) {
      step();
      if (in(DriveState::kOperationEnabled)) return true;
    }
    return false;
  }

  void send(double at_m, double shift, std::size_t period) {
    const double place = at_m / nameplate_.encoder_resolution_m + shift;
    const double whole = std::floor(place);
    sim::send_set_point(link_, static_cast<std::int64_t>(whole), place - whole,
                        static_cast<std::uint32_t>(period));
  }

  AxisRecord faulted(AxisRecord record) {
    const auto fault = static_cast<Fault>(static_cast<std::uint32_t>(link_.fault));
    record.lost_hold =
        fault == Fault::kFollowingError || fault == Fault::kOverspeed || fault == Fault::kStall;
    record.fault = fault == Fault::kNone ? std::string("the drive cannot be enabled")
                                         : fmt::format("the drive stopped with fault {:04X}h at {:.1f} mm",
                                                       error_code(fault), 1e3 * measured_m());
    switch_off();
    return record;
  }

  std::unique_ptr<sim::LockstepBoard> board_;
  PlantLink& link_;
  LockstepMachine machine_;
  bool drive_reversed_ = false;  // what the drive takes the wires for
  sim::Plant plant_;
  sim::Encoder encoder_;
  sim::DelayLine report_;
  sim::Rng noise_;
  sim::EndStops stops_;
  Nameplate nameplate_;
  std::int64_t ticks_ = 0;
  double last_N_ = 0.0;
};

}  // namespace

std::unique_ptr<LiveAxis> lockstep_axis(std::unique_ptr<sim::LockstepBoard> board,
                                        const LockstepMachine& machine) {
  return std::make_unique<LockstepAxis>(std::move(board), machine);
}

}  // namespace slipstack::workbench
