// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/effects/approx.h"

namespace slipstack {

/// Counts communication periods in the tick, in time with SYNC: a phase-locked loop of type 2 and third
/// order.
///
/// The tick advances the oscillator, a number of periods with 32 binary places. At SYNC, in the main loop,
/// the phase detector reads it: SYNC n should come where the phase is n. The loop filter makes of this error
/// e, in periods, the deviation y of the oscillator's rate,
///
///   y = LP(w T e + sum (w T)^2 e / 4),  LP a low-pass with its pole at 4 w,
///
/// w the bandwidth (gain crossover): the zero lies at w / 4 and the pole at 4 w, so that the phase margin is
/// atan 4 - atan 1/4 = 62 degrees, and the closed loop's poles, -w and -0.38 w and -2.62 w, are real: it does
/// not ring (Gardner, Phaselock Techniques, 3rd edition, 2005, chapter 2). 0.2 Hz: a jitter of 51 us, white,
/// at 1 ms leaves 3 us in the phase; where that would be more than a twentieth of a radian in a period, the
/// bandwidth is lower.
///
/// Lock range: 0.1 % of the period. Crystals of both sides (100 ppm each) and a computer's clock that is
/// slewed (500 ppm, adjtimex(2)) stay below.
class SyncClock {
 public:
  static constexpr float kShortestTicks = 2.0F;
  static constexpr float kLongestTicks = 1000.0F;
  static constexpr float kBandwidth_rad_per_s = 1.2566F;
  static constexpr float kLockRange = 1.0e-3F;
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

  /// A SYNC has come. The period it belongs to, as far as time tells.
  std::uint32_t sync() {
    const Phase at = now();
    const std::uint32_t period = at.period + (at.fraction >> 31);
    // What is pending from the last one is not in the phase yet.
    if (shift_.load(std::memory_order_relaxed) != 0) return period;
    const std::uint32_t since = period - last_;
    last_ = period;
    if (since > kForgottenPeriods && since < 0x80000000U) restart();
    const float error = static_cast<float>(static_cast<std::int32_t>(at.fraction)) * 0x1p-32F;
    judge(since == 1 && approx::absolute(error) < 0.25F);
    if (acquired_ < kAcquired) {
      ++acquired_;
      const float correction = -error / static_cast<float>(acquired_);
      shift_.store(static_cast<std::int32_t>(correction * 0x1p32F), std::memory_order_relaxed);
    } else {
      correct(approx::clamp(error, -0.25F, 0.25F));
    }
    return period;
  }

  /// Whether SYNC comes as expected.
  bool locked() const { return locked_; }
  /// Deviation of the rate from the nominal one.
  float deviation() const { return deviation_; }

  Phase now() const {
    // A tick in between may only change the fraction, or both.
    Phase phase{period_.load(std::memory_order_relaxed), 0};
    for (int i = 0; i < 3; ++i) {
      phase.fraction = fraction_.load(std::memory_order_acquire);
      const std::uint32_t again = period_.load(std::memory_order_acquire);
      if (again == phase.period) break;
      phase.period = again;
    }
    return phase;
  }

  // ---- in the tick ----

  /// Of a period x 2^-32, by which advance() moves.
  std::uint32_t rate() const { return rate_.load(std::memory_order_relaxed); }

  Phase advance() {
    const std::uint32_t rate = rate_.load(std::memory_order_relaxed);
    std::uint32_t fraction = fraction_.load(std::memory_order_relaxed);
    std::uint32_t period = period_.load(std::memory_order_relaxed);
    const std::int32_t shift = shift_.load(std::memory_order_relaxed);
    if (shift != 0) [[unlikely]] {
      // Half a period at most, either way.
      const std::uint32_t shifted = fraction + static_cast<std::uint32_t>(shift);
      if (shift > 0 && shifted < fraction) ++period;
      if (shift < 0 && shifted > fraction) --period;
      fraction = shifted;
      shift_.store(0, std::memory_order_relaxed);
    }
    const std::uint32_t next = fraction + rate;
    if (next < fraction) ++period;
    fraction_.store(next, std::memory_order_relaxed);
    period_.store(period, std::memory_order_relaxed);
    return {period, next};
  }

 private:
  // A silence after which the phase may have drifted away: with the lock range 6 % of a period.
  static constexpr std::uint32_t kForgottenPeriods = 64;
  static constexpr std::int32_t kBestQuality = 32;

  void restart() {
    acquired_ = quality_ = 0;
    locked_ = false;
    integral_ = deviation_ = 0.0F;
    rate_.store(nominal_, std::memory_order_relaxed);
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
    rate_.store(nominal_ - static_cast<std::uint32_t>(
                               static_cast<std::int32_t>(static_cast<float>(nominal_) * deviation_)),
                std::memory_order_relaxed);
  }

  float period_ticks_ = 0.0F;
  float proportional_ = 0.0F;
  float integral_per_period_ = 0.0F;
  float low_pass_ = 0.0F;
  std::uint32_t nominal_ = 0;
  float integral_ = 0.0F;
  float deviation_ = 0.0F;
  std::uint32_t last_ = 0;
  std::int32_t acquired_ = 0;
  std::int32_t quality_ = 0;
  bool locked_ = false;
  std::atomic<std::uint32_t> rate_{0};      // written outside the tick
  std::atomic<std::int32_t> shift_{0};      // asked for outside the tick, done in it
  std::atomic<std::uint32_t> period_{0};    // written in the tick
  std::atomic<std::uint32_t> fraction_{0};  // written in the tick
};

}  // namespace slipstack
