// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "tests/bench/soak/axis.h"
#include "tests/bench/soak/faults.h"
#include "tests/bench/soak/operator.h"

namespace slipstack::soak {

/// With what energy the carriage reaches an end stop, by what there was to stop it.
enum class Guard : std::uint8_t {
  kGuarded,  ///< place or switch known, sensor and amplifier well: for half a second, which is longer than
             ///< any stop
  kBraked,   ///< the same with a sensor or an amplifier that fails, or current off; the brake is left
  kNone,     ///< place and switch wrong, or nothing to brake with
};

/// What must hold in every tick, whatever fails.
class Invariants {
 public:
  Invariants(SoakAxis& axis, const Faults& faults, const Operator& master)
      : axis_(axis), faults_(faults), master_(master) {}

  /// After each tick; empty, or what does not hold.
  std::string check(std::int64_t tick) {
    tick_ = tick;
    wrong_.clear();
    look_at_current();
    look_at_state();
    look_at_reference();
    look_at_guards();
    look_at_energy();
    look_at_analogue();
    last_state_ = state().state();
    return wrong_;
  }

  std::array<double, 3> largest_J{};
  std::array<std::uint32_t, 3> contacts{};
  std::array<std::uint32_t, kFaultCount> latched{};
  std::int64_t driven_ticks = 0;
  double travelled_m = 0.0;

  /// Largest energy at a contact, J.
  double allowed_J(Guard guard) const {
    const double fastest = 1.2 * axis_.build().speed_mps;
    switch (guard) {
      case Guard::kGuarded:
        return 0.5;  // homing on the stop: 0.1 m/s
      case Guard::kBraked:
        return 30.0;
      default:
        return 0.5 * kMass_kg * fastest * fastest;
    }
  }

 private:
  static constexpr std::int64_t kLong = 5000;  // ticks
  static constexpr std::int32_t kBeyond = 1;   // count

  Controller& controller() { return axis_.controller(); }
  const StateMachine& state() { return controller().state(); }
  void wrong(const std::string& what) {
    if (wrong_.empty()) wrong_ = what;
  }

  void look_at_current() {
    const AxisParameters& axis = controller().parameters().axis;
    const ControlOutput& out = controller().output();
    const float now_A = axis_.motor().set_point_A;
    if (!std::isfinite(now_A) || !std::isfinite(out.feedforward_N) || !std::isfinite(out.velocity_mps))
      wrong("a value is not finite");
    if (std::abs(now_A) > axis.current_limit_A) wrong("the current is beyond its limit");
    const float largest_A = axis.current_rate_A_per_s * axis.tick_s * 1.001F;
    if (axis_.motor().enabled && std::abs(now_A - last_A_) > largest_A) wrong("the current jumps");
    if (!controller().driving() && (axis_.motor().enabled || now_A != 0.0F))
      wrong("current without permission");
    last_A_ = now_A;
  }

  // Transitions of IEC 61800-7-201 figure 2, one in a tick.
  static bool legal(DriveState from, DriveState to) {
    using enum DriveState;
    if (from == to) return true;
    switch (from) {
      case kNotReadyToSwitchOn:
        return to == kSwitchOnDisabled || to == kFault;
      case kSwitchOnDisabled:
        return to == kReadyToSwitchOn || to == kFault;
      case kReadyToSwitchOn:
        return to == kSwitchedOn || to == kSwitchOnDisabled || to == kFault;
      case kSwitchedOn:
        return to == kOperationEnabled || to == kReadyToSwitchOn || to == kSwitchOnDisabled || to == kFault ||
               to == kFaultReactionActive;
      case kOperationEnabled:
        return to != kNotReadyToSwitchOn;
      case kQuickStopActive:
        return to == kOperationEnabled || to == kSwitchOnDisabled || to == kFault ||
               to == kFaultReactionActive;
      case kFaultReactionActive:
        return to == kFault;
      case kFault:
        return to == kSwitchOnDisabled;
    }
    return false;
  }

  void look_at_state() {
    const DriveState now = state().state();
    if (!legal(last_state_, now)) {
      wrong("from state " + std::to_string(static_cast<int>(last_state_)) + " to " +
            std::to_string(static_cast<int>(now)));
    }
    in_state_ = now == last_state_ ? in_state_ + 1 : 0;
    const Fault latched_now = state().faults().latched();
    if (now == DriveState::kFault && last_state_ != now) ++latched[static_cast<std::size_t>(latched_now)];
    const bool faulty = now == DriveState::kFault || now == DriveState::kFaultReactionActive;
    if (faulty != (latched_now != Fault::kNone))
      wrong("a fault state without a fault, or a fault without its state");
    if (last_state_ == DriveState::kFault && now != last_state_ && tick_ - master_.fault_reset_at() > kLate)
      wrong("a fault was left without a reset");
    if (now == DriveState::kOperationEnabled && last_state_ != now &&
        (master_.delivered_word() & 0x0F) != 0x0F && tick_ - master_.delivered_at() > kLate) {
      wrong("enabled without a command");
    }
    const std::int64_t longest = static_cast<std::int64_t>(1.0 / kTick_s) + 500;
    const bool stays = now == DriveState::kQuickStopActive && axis_.build().quick_stop_option >= 5;
    if ((now == DriveState::kFaultReactionActive || (now == DriveState::kQuickStopActive && !stays)) &&
        in_state_ > longest) {
      wrong("a stop does not end");
    }
    driven_ticks += controller().driving() ? 1 : 0;
    travelled_m += std::abs(axis_.velocity_mps()) * kTick_s;
  }

  // Where the reference is the axis's command: in position mode, and not in a tick in which it begins anew.
  void look_at_reference() {
    const ReferenceGenerator& reference = controller().reference();
    const FaultRecord& faults = state().faults();
    const std::uint32_t anew = faults.count(Fault::kFollowingError) + faults.count(Fault::kOverCurrent) +
                               faults.count(Fault::kOverspeed);
    const bool commands = state().driving() && !state().torque_mode() && anew == anew_;
    anew_ = anew;
    const std::int32_t counts = reference.counts();
    const auto fraction = static_cast<double>(reference.fraction());
    const double step = static_cast<double>(difference(counts, last_counts_)) + fraction - last_fraction_;
    last_counts_ = counts;
    last_fraction_ = fraction;
    since_ = commands ? since_ + 1 : 0;
    if (since_ >= 3) {
      const double per_tick = kTick_s / kResolution_m;
      const double fastest = axis_.build().speed_mps * per_tick * 1.001 + 1.0;
      if (std::abs(step) > std::max(fastest, std::abs(last_step_) + 0.01)) wrong("the reference is too fast");
      const double largest = kDeceleration_mps2 * kTick_s * per_tick * 1.002 + 0.01;
      if (std::abs(step - last_step_) > std::max(largest, std::abs(last_change_) + 0.01))
        wrong("the reference steps");
      look_at_range(reference, step);
    } else if (!state().driving() && axis_.motor().enabled == false && in_state_ > 2 && has_position() &&
               difference(counts, axis_.reading()) != 0) {
      wrong("the reference is away from an axis that is off");
    }
    last_change_ = step - last_step_;
    last_step_ = step;
  }

  // Without one the controller carries the axis on at the velocity of the tick before (EncoderBridge).
  bool has_position() const { return faults_.broken.encoder != Broken::Encoder::kInvalid; }

  // Beyond a software limit the reference goes no further.
  void look_at_range(const ReferenceGenerator& reference, double step) {
    const PositionRange& range = controller().user_bounds().range;
    const bool settled = range.lowest == range_.lowest && range.highest == range_.highest;
    range_ = range;
    range_since_ = settled ? range_since_ + 1 : 0;
    if (range_since_ < kLong || since_ < kLong) return;
    const std::int32_t above = difference(reference.counts(), range.highest);
    const std::int32_t below = difference(range.lowest, reference.counts());
    const bool leaves = (above > kBeyond && range.highest != PositionRange::kNoHighest && step > 0.01) ||
                        (below > kBeyond && range.lowest != PositionRange::kNoLowest && step < -0.01);
    if (leaves)
      wrong("the reference leaves the range by " + std::to_string(std::max(above, below)) + " counts");
  }

  // What there is to keep the carriage from either end stop, for how long.
  void look_at_guards() {
    const PositionRange range = controller().user_bounds().range;
    const bool low =
        range.lowest != PositionRange::kNoLowest && axis_.place_m(range.lowest) > 0.9 * kSoftware_m;
    const bool high = range.highest != PositionRange::kNoHighest &&
                      axis_.place_m(range.highest) < kLength_m - 0.9 * kSoftware_m;
    const bool switches = controller().user_bounds().switches;
    const bool negative = low || (switches && faults_.broken.negative == Broken::Switch::kWell);
    const bool positive = high || (switches && faults_.broken.positive == Broken::Switch::kWell);
    guarded_[0] = negative ? guarded_[0] + 1 : 0;
    guarded_[1] = positive ? guarded_[1] + 1 : 0;
    const bool well = !faults_.encoder_fails() && !faults_.amplifier_fails();
    well_ = well ? well_ + 1 : 0;
    driving_ = controller().driving() ? driving_ + 1 : 0;
  }

  void look_at_energy() {
    const bool in_stop = axis_.in_stop();
    if (in_stop && !in_stop_) {
      const bool guarded = guarded_[axis_.position_m() < 0.0 ? 0 : 1] > kLong;
      const bool holds = driving_ > kLong && well_ > kLong;
      const Guard guard = guarded && holds                 ? Guard::kGuarded
                          : guarded && axis_.build().brake ? Guard::kBraked
                                                           : Guard::kNone;
      const auto index = static_cast<std::size_t>(guard);
      ++contacts[index];
      largest_J[index] = std::max(largest_J[index], axis_.energy_J());
      if (axis_.energy_J() > allowed_J(guard)) {
        wrong(std::to_string(axis_.energy_J()) + " J into the end stop, guard " + std::to_string(index));
      }
    }
    in_stop_ = in_stop;
    const double fastest = 1.5 * axis_.build().speed_mps + 0.05;
    if (std::abs(axis_.velocity_mps()) > fastest) wrong("faster than any fault explains");
  }

  // What lasts acts: a link too high at once, what else there is when the axis has been braked. And no such
  // fault without its cause in the last second.
  void look_at_analogue() {
    const Broken& broken = faults_.broken;
    using Cause = std::pair<Fault, bool>;
    const std::array<Cause, 4> causes = {Cause{Fault::kOverVoltage, broken.link_V > kHighest_V},
                                         Cause{Fault::kUnderVoltage, broken.link_V < kLowest_V},
                                         Cause{Fault::kOverTemperature, broken.temperature_C > kHot_C},
                                         Cause{Fault::kAnalogueSensor, broken.temperature_invalid}};
    const Fault latched_now = state().faults().latched();
    const bool ready = controller().parameters().valid;
    for (std::size_t i = 0; i < causes.size(); ++i) {
      const auto& [fault, there] = causes[i];
      // Passes of the main loop are every other tick; 20 of them in a row without one are one in 10^6.
      lasts_[i] = there && ready && !broken.main_loop_dead ? lasts_[i] + 1 : 0;
      since_cause_[i] = there ? 0 : since_cause_[i] + 1;
      const std::int64_t acts = fault == Fault::kOverVoltage ? 60 : 1000 + 15000;
      if (lasts_[i] > acts && controller().driving()) wrong("driven with " + std::to_string(i));
      const bool began = latched_now == fault && last_latched_ != fault;
      if (began && since_cause_[i] > kLate) wrong("a fault without its cause");
    }
    last_latched_ = latched_now;
  }

  static constexpr std::int64_t kLate = 11000;  // a main loop that hangs for a second

  SoakAxis& axis_;
  const Faults& faults_;
  const Operator& master_;
  std::string wrong_;
  std::int64_t tick_ = 0;
  float last_A_ = 0.0F;
  DriveState last_state_ = DriveState::kNotReadyToSwitchOn;
  std::int64_t in_state_ = 0;
  std::uint32_t anew_ = 0;
  std::int64_t since_ = 0;
  std::int32_t last_counts_ = 0;
  double last_fraction_ = 0.0;
  double last_step_ = 0.0;
  double last_change_ = 0.0;
  PositionRange range_;
  std::int64_t range_since_ = 0;
  std::array<std::int64_t, 2> guarded_{};
  std::int64_t well_ = 0;
  std::int64_t driving_ = 0;
  bool in_stop_ = false;
  std::array<std::int64_t, 4> lasts_{};
  std::array<std::int64_t, 4> since_cause_{};
  Fault last_latched_ = Fault::kNone;
};

}  // namespace slipstack::soak
