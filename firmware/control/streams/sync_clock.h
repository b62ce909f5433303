// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// Communication periods against ticks, in time with SYNC: a phase-locked loop of type 2 and third order.
///
/// Its oscillator is a number of periods with 32 binary places that grows by a rate in every tick; a new rate
/// comes about over a period, by the passes of the main loop, so that it steps no velocity. At SYNC,
/// in the main loop, the phase detector reads it: SYNC n should come where the phase is n. The loop filter
/// makes of this error e, in periods, the deviation y of the oscillator's rate,
///
///   y = LP(w T e + sum (w T)^2 e / 4),  LP a low-pass with its pole at 4 w,
///
/// w the bandwidth (gain crossover): the zero lies at w / 4 and the pole at 4 w, so that the phase margin is
/// atan 4 - atan 1/4 = 62 degrees, and the closed loop's poles, -w and -0.38 w and -2.62 w, are real: it does
/// not ring (Gardner, Phaselock Techniques, 3rd edition, 2005, chapter 2). 0.2 Hz: a jitter of 51 us, white,
/// at 1 ms leaves 3 us in the phase; where that would be more than a twentieth of a radian in a period, the
/// bandwidth is lower.
///
/// Lock range: 0.05 % of the period, which is also pulled in without a slip where the period is 1 ms or more:
/// the phase runs ahead by 0.4 ms on the way. Two crystals are apart by 200 ppm at most (100 ppm each).
class SyncClock {
 public:
  static constexpr float kShortestTicks = 2.0F;
  static constexpr float kLongestTicks = 1000.0F;
  static constexpr float kBandwidth_rad_per_s = 1.2566F;
  static constexpr float kLockRange = 5.0e-4F;
  /// SYNCs whose mean phase is where the loop begins.
  static constexpr std::int32_t kAcquired = 8;

  /// In periods: whole ones, and a fraction of 2^-32.
  struct Phase {
    std::uint32_t period = 0;
    std::uint32_t fraction = 0;
  };

  // ---- outside the tick ----

  /// The nominal period. Begins anew when it is another one.
  void set_period(float ticks, float tick_s) {
    ticks = approx::clamp(ticks, kShortestTicks, kLongestTicks);
    if (ticks == period_ticks_) return;
    period_ticks_ = ticks;
    const float wanted = kBandwidth_rad_per_s * ticks * tick_s;
    proportional_ = wanted < 0.05F ? wanted : 0.05F;
    integral_per_period_ = 0.25F * proportional_ * proportional_;
    low_pass_ = -approx::exp_minus_one(-4.0F * proportional_);
    nominal_ = static_cast<std::uint32_t>(0x1p32F / ticks);
    restart();
  }
  float period_ticks() const { return period_ticks_; }

  /// A SYNC has come, after this tick. The period it belongs to, as far as time tells.
  std::uint32_t sync(std::uint32_t tick) {
    Anchor anchor = anchors_[in_use_.load(std::memory_order_relaxed)];
    anchor.phase = at(tick);
    anchor.tick = tick;
    const std::uint32_t period = anchor.phase.period + (anchor.phase.fraction >> 31);
    const std::uint32_t since = period - last_;
    last_ = period;
    if (since > kForgottenPeriods && since < 0x80000000U) restart();
    const auto off = static_cast<std::int32_t>(anchor.phase.fraction);
    const float error = static_cast<float>(off) * 0x1p-32F;
    judge(since == 1 && approx::absolute(error) < kFarthest);
    if (acquired_ < kAcquired) {
      ++acquired_;
      anchor.phase = {period, static_cast<std::uint32_t>(off - off / acquired_)};
      anchor.phase.period -= anchor.phase.fraction >> 31;
    } else {
      correct(approx::clamp(error, -kFarthest, kFarthest));
    }
    const float change = static_cast<float>(nominal_) * deviation_;
    wanted_rate_ = nominal_ - static_cast<std::uint32_t>(static_cast<std::int32_t>(change));
    if (acquired_ < kAcquired) anchor.rate = wanted_rate_;
    slew_ = static_cast<float>(static_cast<std::int32_t>(wanted_rate_ - anchor.rate)) / period_ticks_;
    publish(anchor);
    return period;
  }

  /// In every pass of the main loop, after this tick: the rate goes on to what SYNC has made of it.
  void follow(std::uint32_t tick) {
    Anchor anchor = anchors_[in_use_.load(std::memory_order_relaxed)];
    if (anchor.rate == wanted_rate_ || anchor.tick == tick) return;
    const float part = slew_ * static_cast<float>(tick - anchor.tick);
    const auto left = static_cast<std::int32_t>(wanted_rate_ - anchor.rate);
    const bool arrives = !(approx::absolute(part) < approx::absolute(static_cast<float>(left)));
    const std::int32_t step = arrives ? left : static_cast<std::int32_t>(part);
    // Less than its last bit: in a later pass.
    if (step == 0) return;
    anchor.phase = at(tick);
    anchor.tick = tick;
    anchor.rate += static_cast<std::uint32_t>(step);
    publish(anchor);
  }

  /// Whether SYNC comes as expected.
  bool locked() const { return locked_; }
  /// Deviation of the rate from the nominal one.
  float deviation() const { return deviation_; }

  /// Ticks until it has gone on by so many periods, on the way to the rate that the last SYNC has made.
  float ticks_until(float periods) const {
    const float now = rate();
    const float wanted = wanted_rate();
    const float straight = periods / now;
    // The rate changes over a period: the mean of it on the way.
    const float mean = straight < period_ticks_ ? now + 0.5F * (wanted - now) * straight / period_ticks_
                                                : wanted - 0.5F * (wanted - now) * period_ticks_ / straight;
    return periods / mean;
  }
  /// The rate so many ticks after the last SYNC, of a period, in a tick: what that has made of it is there a
  /// period later.
  float rate_in(float ticks) const {
    const float now = rate();
    const float share = approx::clamp(ticks / period_ticks_, 0.0F, 1.0F);
    return now + share * (wanted_rate() - now);
  }
  float wanted_rate() const { return static_cast<float>(wanted_rate_) * 0x1p-32F; }

  // ---- anywhere ----

  /// Where the oscillator is at a tick. A multiplication.
  Phase at(std::uint32_t tick) const {
    const Anchor& anchor = anchors_[in_use_.load(std::memory_order_acquire)];
    const std::uint64_t gone = static_cast<std::uint64_t>(tick - anchor.tick) * anchor.rate;
    const std::uint32_t fraction = anchor.phase.fraction + static_cast<std::uint32_t>(gone);
    const std::uint32_t carry = fraction < anchor.phase.fraction ? 1U : 0U;
    return {anchor.phase.period + static_cast<std::uint32_t>(gone >> 32) + carry, fraction};
  }
  /// Of a period, in a tick.
  float rate() const { return anchors_[in_use_.load(std::memory_order_relaxed)].share; }

 private:
  // A silence after which the phase may have drifted away: with the lock range 3 % of a period.
  static constexpr std::uint32_t kForgottenPeriods = 64;
  // Beyond, a SYNC may as well be that of another period.
  static constexpr float kFarthest = 0.4F;
  static constexpr std::int32_t kBestQuality = 32;

  // A place of the oscillator from which on its rate is this.
  struct Anchor {
    Phase phase;
    std::uint32_t tick = 0;
    std::uint32_t rate = 0;  // periods x 2^-32 in a tick
    float share = 0.0F;      // the same, in periods
  };

  void publish(Anchor& anchor) {
    anchor.share = static_cast<float>(anchor.rate) * 0x1p-32F;
    const std::uint32_t other = in_use_.load(std::memory_order_relaxed) ^ 1U;
    anchors_[other] = anchor;
    in_use_.store(other, std::memory_order_release);
  }

  void restart() {
    acquired_ = quality_ = 0;
    locked_ = false;
    integral_ = deviation_ = 0.0F;
  }

  // Every fourth SYNC may be missing or out of place. Half of them, and the period is not the one expected.
  void judge(bool good) {
    quality_ += good ? 1 : -2;
    if (quality_ > kBestQuality) quality_ = kBestQuality;
    if (quality_ < 0) quality_ = 0;
    if (quality_ >= kAcquired - 1) locked_ = true;
    if (quality_ == 0 && locked_) restart();
  }

  // A phase that is ahead of SYNC slows the oscillator down.
  void correct(float error) {
    integral_ = approx::clamp(integral_ + integral_per_period_ * error, -kLockRange, kLockRange);
    deviation_ += low_pass_ * (proportional_ * error + integral_ - deviation_);
  }

  float period_ticks_ = 0.0F;
  float proportional_ = 0.0F;
  float integral_per_period_ = 0.0F;
  float low_pass_ = 0.0F;
  std::uint32_t nominal_ = 0;
  float integral_ = 0.0F;
  float deviation_ = 0.0F;
  std::uint32_t wanted_rate_ = 0;
  float slew_ = 0.0F;  // of the rate, in a tick
  std::uint32_t last_ = 0;
  std::int32_t acquired_ = 0;
  std::int32_t quality_ = 0;
  bool locked_ = false;
  std::array<Anchor, 2> anchors_{};  // the tick reads the one in use
  std::atomic<std::uint32_t> in_use_{0};
};

}  // namespace slipstack
