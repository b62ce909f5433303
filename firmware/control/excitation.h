// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/control/feedback.h"
#include "firmware/control/reference.h"
#include "firmware/effects/approx.h"

namespace slipstack {

/// Where the excitation enters the loop.
enum class ExcitationPlace : std::uint8_t {
  kCurrent,   ///< added to the force behind the feedback: what the axis then does is its sensitivity
  kPosition,  ///< added to the position error: a change of the position reference
};

enum class ExcitationState : std::uint8_t {
  kIdle,
  kRunning,
  kComplete,  ///< all periods were there
  kStopped,   ///< by command
  kEnded,     ///< halt, stop, fault, or a reference that accelerates
  kTooFar,    ///< the position error left the bound
};

/// What is asked for; one period is a sweep from `lowest` to `highest`, both in harmonics of 1 / period.
struct ExcitationSettings {
  ExcitationPlace place = ExcitationPlace::kCurrent;
  float amplitude = 0.0F;  ///< N or m
  float largest_deviation_m = 0.0F;
  std::uint32_t period_ticks = 0;
  std::uint32_t lowest = 1;
  std::uint32_t highest = 2;
  std::uint32_t periods = 1;

  /// The harmonics next to two frequencies. Their sum is even, so that a period ends in the phase in which it
  /// began.
  void set_band(float lowest_Hz, float highest_Hz, float tick_s) {
    const float period_s = static_cast<float>(period_ticks) * tick_s;
    lowest = static_cast<std::uint32_t>(approx::clamp(lowest_Hz * period_s, 1.0F, 1.0e6F) + 0.5F);
    highest = static_cast<std::uint32_t>(approx::clamp(highest_Hz * period_s, 1.0F, 1.0e6F) + 0.5F);
    highest += (lowest + highest) % 2;
  }
  /// Finite, at least one harmonic wide, below a quarter of the tick's rate.
  bool possible() const {
    return approx::is_finite(amplitude) && amplitude > 0.0F && largest_deviation_m > 0.0F &&
           lowest < highest && highest <= period_ticks / 4 && periods > 0;
  }
};

/// A periodic swept sine: in every period the frequency rises linearly from the lowest to the highest one.
///
/// Periodic, so that a whole number of periods shows its harmonics without leakage and their scatter from
/// period to period is the noise; nearly all power between the two frequencies, evenly; crest factor 1.45,
/// where a multisine with Schroeder's phases (which are those of a sweep) has 1.7 (Pintelon and Schoukens,
/// System Identification, 2nd ed. 2012, 5.3.1; Schroeder, IEEE Trans. Inf. Theory 16, 1970). One sine per
/// tick, where a multisine has one for each harmonic or a table of a period.
///
/// The phase is an integer, so that no rounding adds up: period after period is the same bit for bit. The
/// amplitude begins and ends along a parabola over a quarter of a period.
class Excitation {
 public:
  /// Outside the tick, while it does not run: from the next tick on. Nothing where the settings are not
  /// possible.
  void begin(const ExcitationSettings& settings) {
    if (!settings.possible()) return;
    settings_ = settings;
    // Fractions of a turn, 2^-64: the frequency per tick, and what it grows by in each.
    const std::uint64_t turn = ~std::uint64_t{0} / settings.period_ticks;
    first_step_ = turn * settings.lowest;
    step_growth_ = turn / settings.period_ticks * (settings.highest - settings.lowest);
    step_ = first_step_ + (step_growth_ >> 1);
    first_step_ = step_;
    left_ = settings.period_ticks;
    phase_ = 0;
    fade_ = 4.0F / static_cast<float>(settings.period_ticks);
    weight_ = 0.0F;
    value_ = 0.0F;
    force_share_ = settings.place == ExcitationPlace::kCurrent ? 1.0F : 0.0F;
    position_share_ = 1.0F - force_share_;
    limits_ = 0;
    periods_.store(0, std::memory_order_relaxed);
    state_.store(ExcitationState::kRunning, std::memory_order_relaxed);
    takes_part_.store(true, std::memory_order_release);
  }
  /// Fades out, then stops.
  void stop() { fade_ = -4.0F / static_cast<float>(settings_.period_ticks); }

  ExcitationState state() const { return state_.load(std::memory_order_acquire); }
  bool running() const { return state() == ExcitationState::kRunning; }
  /// Whole periods since the beginning.
  std::uint32_t periods() const { return periods_.load(std::memory_order_relaxed); }
  /// Limits that were met while it ran, bits of Limit: what is measured then is not linear.
  std::uint16_t limits() const { return limits_; }
  /// Of the last tick, N or m.
  float value() const { return value_; }
  const ExcitationSettings& settings() const { return settings_; }

  /// In the tick: it has begun, and the tick has not left it.
  bool takes_part() const { return takes_part_.load(std::memory_order_relaxed); }
  /// In the tick: the axis does something else.
  [[gnu::noinline]] void leave() {
    takes_part_.store(false, std::memory_order_relaxed);
    finish(ExcitationState::kEnded);
  }
  /// In the tick: what is to be added now, N or m. When the excitation is over the value stays for this last
  /// tick.
  [[gnu::always_inline]] float step(const ReferencePoint& reference, float error_m) {
    if (reference.acceleration != 0.0F) {
      finish(ExcitationState::kEnded);
    } else if (approx::absolute(error_m) > settings_.largest_deviation_m) {
      finish(ExcitationState::kTooFar);
    } else {
      value_ = faded() * sweep();
    }
    return value_;
  }
  /// Which of the two the value is added to: 1 or 0.
  float force_share() const { return force_share_; }
  float position_share() const { return position_share_; }
  /// The force that is missing when the value is: of the position error, by the gains without the integral.
  float left_N(const Feedback::Gains& gain) const {
    const float per_m = gain.position_per_s * gain.velocity_N_s_per_m;
    return value_ * (force_share_ + position_share_ * per_m);
  }
  /// In the tick, behind the limits: those that were met.
  void note(std::uint16_t limits) { limits_ = static_cast<std::uint16_t>(limits_ | limits); }
  /// In the tick: is over at once.
  void finish(ExcitationState state) {
    if (running()) state_.store(state, std::memory_order_release);
  }

 private:
  // The amplitude, from 0 and back to it.
  float faded() {
    weight_ = approx::clamp(weight_ + fade_, 0.0F, 1.0F);
    if (weight_ == 0.0F) [[unlikely]]
      finish(periods() >= settings_.periods ? ExcitationState::kComplete : ExcitationState::kStopped);
    return settings_.amplitude * weight_ * weight_;
  }

  float sweep() {
    // Half turns from -1 to 1.
    const float turn = static_cast<float>(static_cast<std::int32_t>(phase_ >> 32)) * 0x1p-31F;
    phase_ += step_;
    step_ += step_growth_;
    if (--left_ == 0) [[unlikely]]
      begin_period();
    return nearly_sine(turn);
  }

  // sin(pi x) to 0.0011: two parabolas, and a correction of the same kind. What is left, the third harmonic at
  // -60 dB, is part of the excitation as it is recorded.
  static float nearly_sine(float x) {
    const float parabola = 4.0F * x * (1.0F - approx::absolute(x));
    return parabola * (0.775F + 0.225F * approx::absolute(parabola));
  }

  void begin_period() {
    left_ = settings_.period_ticks;
    phase_ = 0;
    step_ = first_step_;
    const std::uint32_t whole = periods() + 1;
    periods_.store(whole, std::memory_order_relaxed);
    if (whole >= settings_.periods) stop();
  }

  std::atomic<bool> takes_part_{false};
  std::atomic<ExcitationState> state_{ExcitationState::kIdle};
  std::uint16_t limits_ = 0;
  std::uint64_t phase_ = 0;
  std::uint64_t step_ = 0;
  std::uint64_t step_growth_ = 0;
  std::uint64_t first_step_ = 0;
  std::uint32_t left_ = 0;  // ticks of the period
  float fade_ = 0.0F;       // of the weight, per tick
  float weight_ = 0.0F;
  float value_ = 0.0F;
  float force_share_ = 1.0F;
  float position_share_ = 0.0F;
  ExcitationSettings settings_;
  std::atomic<std::uint32_t> periods_{0};
};

}  // namespace slipstack
