// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/control/hunting/oscillation_search.h"
#include "firmware/control/parameters/parameters.h"
#include "firmware/control/tick_history.h"
#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// What hunting was found to come from; the numbers of 2202h:03.
enum class HuntingCause : std::uint8_t {
  kNone,
  kFriction,             ///< the compensation of the friction
  kDisturbanceObserver,  ///< the compensation of the observed disturbance
  kElsewhere,            ///< the feedback, a master's loop, or a force from outside
  kEnded,                ///< it ended while something was lowered, and did not come back with it
};

/// The numbers of 2202h:02.
enum class HuntingState : std::uint8_t { kWatching, kTrying, kLowered, kGoesOn };

/// Finds an axis that hunts, and by trial what it comes from. While the reference is steady (standing, or of
/// constant velocity), and in torque mode, the counts are searched for a sustained oscillation
/// (OscillationSearch). What compensates by the measurement, or may in a world that is not as modelled, is
/// then lowered by a ramp, one after the other: the disturbance observer, the compensation of the friction.
///
///   it goes on     not the cause: it comes back, and the next one is tried
///   it stops       it comes back once; if the hunting does too, it is the cause: lowered until told
///   otherwise
///
/// Without this return a vibration of the floor that ends at the right moment would take the compensation
/// away for good; the price is a second time of hunting. An axis that hunts only once it is pushed does not
/// hunt again at once: what stops it with the ramp for the second time is the cause, too. When nothing was
/// the cause, no trial is made for a minute.
///
/// In the main loop, from what the ticks leave for it; the shares are applied there. Some 120 instructions
/// for a tick, 275 where periods are judged (`stage_hunting` of tests/budget/budget.csv).
class HuntingWatch {
 public:
  /// Constants; made outside the tick.
  struct Settings {
    OscillationSearch::Settings swings;
    bool on = false;
    bool friction = false;  ///< it is compensated
    bool torque = false;    ///< in torque mode, too
    bool disturbance = false;
    float steady = 0.0F;  ///< by which a steady reference may change its velocity, counts per tick
    float ramp = 1.0F;    ///< share in a tick
    std::int32_t settle_ticks = 0;
    std::int32_t hold_ticks = 0;
  };

  /// From 2 Hz (a hand that leads an axis to and fro is slower) to an eighth of the ticks' rate, of
  /// twice the noise that 2000h:24 tells. A reference whose velocity changes by less than `steady` sways by
  /// at most a quarter of that.
  static Settings settings(const AxisParameters& axis, const ModelParameters& model) {
    constexpr float kLowest_Hz = 2.0F;
    constexpr float kJudged_s = 0.5F;
    constexpr float kRamp_s = 0.2F, kSettle_s = 0.2F, kHold_s = 60.0F;
    constexpr float kMost_counts = 1.0e8F;
    Settings made;
    made.on = axis.hunting_swing_m > 0.0F;
    made.friction = axis.compensate && dry_friction_N(model) > 0.0F;
    made.torque = made.friction && axis.torque_friction_share > 0.0F;
    made.disturbance = axis.disturbance_share > 0.0F;
    const float noise = up(2.0F * axis.friction_band_counts);
    const float wanted = up(axis.hunting_swing_m / axis.encoder_resolution_m);
    const float swing = 2.0F * (noise > 1.0F ? noise : 1.0F);
    const float least = approx::clamp(wanted > swing ? wanted : swing, 2.0F, kMost_counts);
    made.swings.least_counts = static_cast<std::int32_t>(least);
    made.swings.longest_ticks = static_cast<std::int32_t>(1.0F / (kLowest_Hz * axis.tick_s));
    made.swings.least_ticks = static_cast<std::int32_t>(kJudged_s / axis.tick_s);
    made.steady = 0.25F * 0.5F * least * 6.2831853F * kLowest_Hz * axis.tick_s;
    made.ramp = axis.tick_s / kRamp_s;
    made.settle_ticks = static_cast<std::int32_t>(kSettle_s / axis.tick_s);
    made.hold_ticks = static_cast<std::int32_t>(kHold_s / axis.tick_s);
    return made;
  }

  /// Whether and how the axis is driven.
  enum class Drive : std::uint8_t { kNotFree, kPosition, kTorque };

  /// In every pass of the main loop, over the ticks since the last one. `number`: of the parameters; what
  /// was found does not hold for others. `now()`: the tick now.
  template <class Now>
  void follow(const Settings& settings, std::uint32_t number, const TickHistory& history, Now&& now,
              Drive drive) {
    if (number != number_) forget();
    number_ = number;
    history.follow(seen_, now(), now, [&](const TickHistory::Entry& tick, std::uint32_t missed) {
      if (missed > 0) swings_.begin();
      step(settings, tick.point, tick.reading.counts, drive);
    });
  }

  /// One tick of it.
  void step(const Settings& settings, const ReferencePoint& at, std::int32_t counts, Drive drive) {
    if (hold_ticks_ > 0) --hold_ticks_;
    if (waits_ > 0) --waits_;
    const bool ramped = there_ || ramp(settings);
    if (!watched(settings, at, drive)) return give_up();
    const bool found = swings_.step(settings.swings, counts);
    switch (phase_) {
      case Phase::kWatch:
        // What was blamed is still being lowered.
        if (!ramped) swings_.begin();
        if (ramped && found) begin_trial(settings);
        break;
      case Phase::kLower:
        if (!ramped) waits_ = settings.settle_ticks;
        if (waits_ > 0) break;
        turns_ = 0;
        observe(Phase::kObserve);
        break;
      case Phase::kObserve:
        // Less than half of it is the lesser evil.
        if (found && 2.0F * swings_.found().swing_counts >= found_.swing_counts) {
          acquit(settings);
        } else if (waits_ == 0) {
          observe(Phase::kReturn);
        } else if (swings_.turned() && turns_ < kFew) {
          ++turns_;
        }
        break;
      case Phase::kReturn:
        // While it comes back, and as long again as before.
        if (!ramped) waits_ = patience_;
        if (found) {
          blame();
        } else if (waits_ == 0) {
          end();
        }
        break;
      case Phase::kGoesOn:
        if (found) waits_ = patience_;
        if (waits_ == 0) watch();
        break;
    }
  }

  /// Back to full compensation, as if nothing had been found; the count stays.
  void forget() {
    blamed_ = {};
    stopped_before_ = {};
    cause_ = HuntingCause::kNone;
    hold_ticks_ = 0;
    watch();
  }

  HuntingState state() const {
    if (phase_ == Phase::kGoesOn) return HuntingState::kGoesOn;
    if (phase_ != Phase::kWatch) return HuntingState::kTrying;
    return blamed_[kFriction] || blamed_[kObserver] ? HuntingState::kLowered : HuntingState::kWatching;
  }
  /// Of what was found last.
  HuntingCause cause() const { return cause_; }
  /// What holds now and is worth a warning: something stays lowered, or hunts on.
  HuntingCause warning() const {
    if (phase_ == Phase::kGoesOn) return HuntingCause::kElsewhere;
    if (blamed_[kFriction]) return HuntingCause::kFriction;
    return blamed_[kObserver] ? HuntingCause::kDisturbanceObserver : HuntingCause::kNone;
  }
  /// The one found last while nothing was tried.
  const OscillationSearch::Found& oscillation() const { return found_; }
  /// How often one was found; stops at its largest value.
  std::uint16_t found() const { return times_; }
  /// What the compensation is multiplied by, 0 to 1.
  float friction_share() const { return share_[kFriction]; }
  float disturbance_share() const { return share_[kObserver]; }

 private:
  static constexpr std::size_t kObserver = 0, kFriction = 1, kSuspects = 2;  // in the order of the trials
  static constexpr int kFew = 2;  // one turn may be that of an axis that creeps
  enum class Phase : std::uint8_t { kWatch, kLower, kObserve, kReturn, kGoesOn };

  static float up(float number) {
    const float limited = approx::clamp(number, 0.0F, 1.0e9F);
    const auto whole = static_cast<float>(static_cast<std::int32_t>(limited));
    return whole < limited ? whole + 1.0F : whole;
  }

  // Each share towards where it shall be; true when all are there.
  bool ramp(const Settings& settings) {
    there_ = true;
    for (std::size_t i = 0; i < kSuspects; ++i) {
      const bool tried = i == suspect_ && (phase_ == Phase::kLower || phase_ == Phase::kObserve);
      const float end = blamed_[i] || tried ? 0.0F : 1.0F;
      const float step = approx::clamp(end - share_[i], -settings.ramp, settings.ramp);
      share_[i] = step == end - share_[i] ? end : share_[i] + step;
      there_ = there_ && share_[i] == end;
    }
    return there_;
  }

  // Steady, and free to hunt. In torque mode there is no reference; without a compensation nothing there is
  // the drive's.
  bool watched(const Settings& settings, const ReferencePoint& at, Drive drive) {
    const bool same = drive == drive_;
    drive_ = drive;
    if (!settings.on || drive == Drive::kNotFree) return false;
    if (drive == Drive::kTorque) return same && settings.torque;
    if (same && approx::absolute(at.velocity - velocity_) <= settings.steady) return true;
    velocity_ = at.velocity;
    return false;
  }

  // What is no longer watched is not tried either.
  void give_up() {
    swings_.begin();
    if (phase_ != Phase::kWatch) watch();
  }

  void watch() {
    swings_.begin();
    phase_ = Phase::kWatch;
    suspect_ = kSuspects;
    there_ = false;
  }

  void observe(Phase phase) {
    swings_.begin();
    phase_ = phase;
    waits_ = patience_;
    there_ = false;
  }

  void begin_trial(const Settings& settings) {
    if (times_ < 0xFFFF) ++times_;
    note_found(settings);
    suspect_ = 0;
    if (hold_ticks_ > 0) suspect_ = kSuspects;
    try_next(settings);
  }

  void note_found(const Settings& settings) {
    found_ = swings_.found();
    // Four times what was judged, and what settles.
    patience_ = 4 * found_.ticks + settings.settle_ticks;
  }

  // suspect_ or one behind it.
  void try_next(const Settings& settings) {
    const bool torque = drive_ == Drive::kTorque;
    const std::array<bool, kSuspects> tried{settings.disturbance && !torque,
                                            torque ? settings.torque : settings.friction};
    while (suspect_ < kSuspects && (!tried[suspect_] || blamed_[suspect_])) ++suspect_;
    if (suspect_ < kSuspects) {
      phase_ = Phase::kLower;
      there_ = false;
      return;
    }
    if (hold_ticks_ == 0) hold_ticks_ = settings.hold_ticks;
    cause_ = HuntingCause::kElsewhere;
    observe(Phase::kGoesOn);
  }

  void acquit(const Settings& settings) {
    ++suspect_;
    try_next(settings);
  }

  // It has not come back.
  void end() {
    const bool at_once = turns_ < kFew;
    if (at_once && stopped_before_[suspect_]) return blame();
    stopped_before_[suspect_] = at_once;
    cause_ = HuntingCause::kEnded;
    watch();
  }

  void blame() {
    blamed_[suspect_] = true;
    cause_ = suspect_ == kFriction ? HuntingCause::kFriction : HuntingCause::kDisturbanceObserver;
    watch();
  }

  OscillationSearch swings_;
  std::array<float, kSuspects> share_{1.0F, 1.0F};
  bool there_ = true;  // each share is where it shall be
  std::array<bool, kSuspects> blamed_{};
  std::array<bool, kSuspects> stopped_before_{};  // with the ramp, when it was tried last
  int turns_ = 0;                                 // while it was lowered and had settled
  std::size_t suspect_ = kSuspects;
  Phase phase_ = Phase::kWatch;
  Drive drive_ = Drive::kNotFree;
  HuntingCause cause_ = HuntingCause::kNone;
  std::uint16_t times_ = 0;
  OscillationSearch::Found found_;
  float velocity_ = 0.0F;  // of the reference, counts per tick
  std::int32_t patience_ = 0;
  std::int32_t waits_ = 0;  // ticks
  std::int32_t hold_ticks_ = 0;
  std::uint32_t number_ = 0;
  std::uint32_t seen_ = 0;  // the last tick that was followed
};

}  // namespace slipstack
