// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/supervision/faults.h"
#include "firmware/control/supervision/state_machine.h"
#include "firmware/effects/numerics/approx.h"
#include "firmware/friction/displacement.h"

namespace slipstack {

/// The push at the first enabling: a force that rises slowly until the encoder has moved by a short distance,
/// which must be along the force. Against it, encoder or motor is connected the wrong way round, and every
/// loop would run away. The same again after a fault that a reversed encoder or motor may have caused.
///
/// The axis is pushed only when it stands; after such a fault it is not enabled before either, with the push
/// or without: one that is enabled in motion by a reversed encoder would gain speed each time.
///
/// One direction, then, where nothing moves (an end stop), the other. Bounded: both directions last
/// wait_ticks + 2 (largest_N / step_N + hold_ticks) ticks at most once the axis stands, and until a verdict
/// the motor has done at most largest_N times the distance of work, whatever the axis is; where the encoder
/// stands still although the axis moves, times the way that may go unseen (UnseenMotion), for that ends the
/// push too. On an axis of mass m with friction the force is only just beyond breakaway: with r its rate the
/// distance x takes t = (6 m x / r)^(1/3), and the speed is r t^2 / (2 m).
class DirectionCheck {
 public:
  /// Constants of the tick; made outside it.
  struct Settings {
    bool wanted = false;           ///< the push
    std::int32_t stand_ticks = 1;  ///< the axis stands that moves less than distance_counts in this time
    std::int32_t distance_counts = 0;
    float largest_N = 0.0F;
    float step_N = 0.0F;
    std::int32_t hold_ticks = 0;  ///< at the largest force
  };

  enum class Verdict : std::uint8_t { kNone, kRight, kReversed, kBlocked };

  /// New parameters, or another start.
  void begin(const Settings& settings) {
    unknown_ = settings.wanted;
    rest();
  }
  /// After a fault that doubts_direction().
  void doubt(const Settings& settings) {
    unknown_ = settings.wanted;
    doubted_ = true;
    rest();
  }
  /// The direction is still to be proved.
  bool unknown() const { return unknown_; }
  /// Something is to be passed before operation is enabled.
  bool pending() const { return unknown_ || doubted_; }
  /// The force is this check's.
  bool pushing() const { return phase_ > Phase::kStand; }
  float force_N() const { return force_N_; }

  /// Nothing is asked for, or any more.
  void rest() {
    phase_ = Phase::kRest;
    force_N_ = 0.0F;
  }

  /// In each tick while pending(), before the state machine. Operation is not enabled before the direction is
  /// known: while `command` asks for it, the axis is pushed instead, and the command loses that bit. Returns
  /// the fault of the verdict, or `fault`.
  [[gnu::noinline]] Fault before_enabling(const Settings& settings, std::int32_t wait_ticks,
                                          std::int32_t counts, DriveState state, std::uint32_t& command,
                                          Fault fault) {
    constexpr std::uint32_t kEnable = kSwitchOn | kEnableVoltage | kQuickStop | kEnableOperation;
    const bool unseen = fault == Fault::kEncoderStands;
    const bool asked = state == DriveState::kSwitchedOn && (fault == Fault::kNone || unseen) &&
                       (command & (kEnable | kFaultReset)) == kEnable;
    if (!asked) {
      rest();
      return fault;
    }
    const Verdict verdict = step(settings, wait_ticks, counts, unseen);
    if (verdict == Verdict::kReversed) return Fault::kDirection;
    if (verdict == Verdict::kBlocked) return Fault::kStall;
    if (pending()) command &= ~std::uint32_t{kEnableOperation};
    return Fault::kNone;
  }

  /// One tick of the check. `wait_ticks`: with current and without force, until a brake is open. `unseen`:
  /// the force must have moved a free axis by now.
  Verdict step(const Settings& settings, std::int32_t wait_ticks, std::int32_t counts, bool unseen = false) {
    if (phase_ == Phase::kRest) start(Phase::kStand, counts);
    if (phase_ == Phase::kStand) {
      const std::int32_t moved = difference(counts, from_);
      if (moved >= settings.distance_counts || moved <= -settings.distance_counts) start(phase_, counts);
      if (++ticks_ <= settings.stand_ticks) return Verdict::kNone;
      doubted_ = false;
      if (!unknown_) return end(Verdict::kRight);
      start(Phase::kWait, counts);
    }
    if (phase_ == Phase::kWait) {
      if (++ticks_ <= wait_ticks) return Verdict::kNone;
      start(Phase::kForward, counts);
    }
    const std::int32_t along =
        phase_ == Phase::kForward ? difference(counts, from_) : difference(from_, counts);
    if (along >= settings.distance_counts) return end(Verdict::kRight);
    if (along <= -settings.distance_counts) return end(Verdict::kReversed);
    return push(settings, counts, unseen);
  }

 private:
  enum class Phase : std::uint8_t { kRest, kStand, kWait, kForward, kBackward };

  void start(Phase phase, std::int32_t counts) {
    phase_ = phase;
    from_ = counts;
    force_N_ = 0.0F;
    ticks_ = 0;
  }
  Verdict end(Verdict verdict) {
    unknown_ = verdict != Verdict::kRight;
    rest();
    return verdict;
  }
  Verdict push(const Settings& settings, std::int32_t counts, bool unseen) {
    const float next_N = approx::absolute(force_N_) + settings.step_N;
    const bool full = next_N >= settings.largest_N;
    const float size_N = full ? settings.largest_N : next_N;
    force_N_ = phase_ == Phase::kForward ? size_N : -size_N;
    if (full) ++ticks_;
    if (ticks_ <= settings.hold_ticks && !unseen) return Verdict::kNone;
    if (phase_ == Phase::kBackward) return end(Verdict::kBlocked);
    start(Phase::kBackward, counts);
    return Verdict::kNone;
  }

  bool unknown_ = false;
  bool doubted_ = false;  // the axis must stand first
  Phase phase_ = Phase::kRest;
  std::int32_t from_ = 0;
  std::int32_t ticks_ = 0;
  float force_N_ = 0.0F;
};

}  // namespace slipstack
