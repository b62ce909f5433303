// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/control/reference/reference.h"
#include "firmware/effects/numerics/approx.h"

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
/// amplitude begins and ends as a first-order lag of a sixteenth of a period.
class Excitation {
 public:
  /// Outside the tick, while it does not run: from the next tick on. Nothing where the settings are not
  /// possible.
  void begin(const ExcitationSettings& settings) {
    if (!settings.possible()) return;
    settings_ = settings;
    // Fractions of a turn, 2^-64: the frequency per tick, and what it grows by in each.
    const std::uint64_t turn = ~std::uint64_t{0} / settings.period_ticks;
    step_growth_ = turn / settings.period_ticks * (settings.highest - settings.lowest);
    first_step_ = turn * settings.lowest + (step_growth_ >> 1);
    left_ = settings.period_ticks;
    phase_ = 0;
    step_ = first_step_;
    scale_ = 0.0F;
    target_ = settings.amplitude;
    change_ = kFadesInPeriod / static_cast<float>(settings.period_ticks);
    value_ = 0.0F;
    force_share_ = settings.place == ExcitationPlace::kCurrent ? 1.0F : 0.0F;
    position_share_ = 1.0F - force_share_;
    limits_ = 0;
    ending_ = false;
    periods_.store(0, std::memory_order_relaxed);
    state_.store(ExcitationState::kRunning, std::memory_order_relaxed);
    takes_part_.store(true, std::memory_order_release);
  }
  /// Fades out within half a period, then ends.
  void stop() {
    if (ending_) return;
    ending_ = true;
    target_ = 0.0F;
    left_ = settings_.period_ticks / 2;
  }

  ExcitationState state() const { return state_.load(std::memory_order_acquire); }
  bool running() const { return state_.load(std::memory_order_relaxed) == ExcitationState::kRunning; }
  /// Whole periods since the beginning.
  std::uint32_t periods() const { return periods_.load(std::memory_order_relaxed); }
  /// Limits that were met while it ran, bits of Limit: what is measured then is not linear.
  std::uint16_t limits() const { return limits_; }
  /// Of the last tick, N or m.
  float value() const { return value_; }

  /// Behind the tick: the limits that it met.
  void note(std::uint16_t limits) {
    if (running()) limits_ = static_cast<std::uint16_t>(limits_ | limits);
  }

  // ---- in the tick ----

  /// It has begun, and the tick has not left it.
  bool takes_part() const { return takes_part_.load(std::memory_order_relaxed); }
  /// The tick before was the first without it.
  bool left() {
    if (!left_it_) [[likely]]
      return false;
    left_it_ = false;
    return true;
  }
  /// The axis does something else.
  [[gnu::noinline]] void leave() {
    takes_part_.store(false, std::memory_order_relaxed);
    left_it_ = true;
    scale_ = target_ = 0.0F;
    finish(ExcitationState::kEnded);
  }
  /// What is to be added now, N or m. It is over with a reference that accelerates, and too far from it.
  [[gnu::always_inline]] float step(const ReferencePoint& reference, float error_m) {
    if (reference.acceleration != 0.0F) [[unlikely]]
      finish(ExcitationState::kEnded);
    if (approx::absolute(error_m) > settings_.largest_deviation_m) [[unlikely]]
      finish(ExcitationState::kTooFar);
    scale_ += change_ * (target_ - scale_);
    value_ = scale_ * sweep();
    return value_;
  }
  /// Which of the two the value is added to: 1 or 0.
  float force_share() const { return force_share_; }
  float position_share() const { return position_share_; }

 private:
  // Time constants of the amplitude in a period: 4e-4 of it are left after half of one.
  static constexpr float kFadesInPeriod = 16.0F;

  // Over, if nothing has ended it before; the next tick leaves it.
  [[gnu::noinline]] void finish(ExcitationState state) {
    if (running()) state_.store(state, std::memory_order_release);
  }

  [[gnu::always_inline]] float sweep() {
    // Half turns from -1 to 1.
    const float turn = static_cast<float>(static_cast<std::int32_t>(phase_)) * 0x1p-31F;
    phase_ += static_cast<std::uint32_t>(step_ >> 32);
    step_ += step_growth_;
    if (--left_ == 0) [[unlikely]]
      end_period();
    return nearly_sine(turn);
  }

  // sin(pi x) to 0.0011: two parabolas, and a correction of the same kind. What is left, the third harmonic
  // at -60 dB, is part of the excitation as it is recorded.
  static float nearly_sine(float x) {
    const float parabola = 4.0F * x * (1.0F - approx::absolute(x));
    return parabola * (0.775F + 0.225F * approx::absolute(parabola));
  }

  [[gnu::noinline]] void end_period() {
    if (ending_) {
      const bool complete = periods() >= settings_.periods;
      return finish(complete ? ExcitationState::kComplete : ExcitationState::kStopped);
    }
    left_ = settings_.period_ticks;
    phase_ = 0;
    step_ = first_step_;
    periods_.store(periods() + 1, std::memory_order_relaxed);
    if (periods() >= settings_.periods) stop();
  }

  std::atomic<bool> takes_part_{false};
  std::atomic<ExcitationState> state_{ExcitationState::kIdle};
  bool left_it_ = false;
  bool ending_ = false;
  std::uint16_t limits_ = 0;
  std::uint32_t phase_ = 0;
  std::uint64_t step_ = 0;
  std::uint64_t step_growth_ = 0;
  std::uint64_t first_step_ = 0;
  std::uint32_t left_ = 0;  // ticks of the period, or until the end
  float scale_ = 0.0F;      // of the sine, N or m
  float target_ = 0.0F;
  float change_ = 0.0F;  // of the difference between them, per tick
  float value_ = 0.0F;
  float force_share_ = 1.0F;
  float position_share_ = 0.0F;
  ExcitationSettings settings_;
  std::atomic<std::uint32_t> periods_{0};
};

}  // namespace slipstack
