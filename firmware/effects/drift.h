// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <span>

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"

namespace slipstack {

template <class Real>
class Drift {
 public:
  static constexpr EffectText text{
      .id = "drift",
      .title = "Friction level that changes with time",
      .formula = "dry friction x (1 + b (1 - exp(-t / tau)) / (1 - exp(-T / tau))), t at most T",
      .source = "warming of the lubricant; run-in; creep of the carriage preload",
      .residual = "follows time, with the sign of friction",
      .evidence =
          "the friction level changes by {change} of itself within {observed_time}, with a time constant of "
          "{time_constant}",
      .cause =
          "the guideway warms and its grease thins, or the surfaces run in | the bearing or gear "
          "warms and its grease thins, or the surfaces run in",
      .confirm = "one and the same slow move every minute from cold for half an hour"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"change", "1", -0.95f, 20.0f, 1, Acts::dry_scale},
  }};
  /// The change is that within the time for which the axis was observed, which a log determines whatever the
  /// time constant is: also a drift in proportion to time, whose end nobody knows. The level stays from then
  /// on, since a change that nobody has seen is not compensated.
  static constexpr std::array<ShapeSpec, 2> shapes{{
      {"time_constant", "s", 1.0f, 1.0e6f, ShapeKind::time_constant},
      {"observed_time", "s", 1.0e-3f, 1.0e9f, ShapeKind::duration},
  }};
  static constexpr EffectTraits traits{.per_log = true};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 2;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>&) {
    inverse_time_per_s_ = Real(1) / shape[0];
    observed_s_ = shape[1];
    whole_ = Real(1) / -approx::exp_minus_one(-observed_s_ * inverse_time_per_s_);
  }
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) { out[0] = share(sample.time_s); }

  /// It follows time alone, and slowly: the controller computes it outside the tick.
  void refresh(Real time_s) { std::atomic_ref<Real>(share_).store(share(time_s), std::memory_order_relaxed); }
  void refreshed_basis(std::span<Real, gain_count> out) {
    out[0] = std::atomic_ref<Real>(share_).load(std::memory_order_relaxed);
  }

 private:
  /// Of the change, the share that has come about.
  Real share(Real time_s) const {
    const Real seen_s = approx::select(time_s < observed_s_, time_s, observed_s_);
    return -approx::exp_minus_one(-seen_s * inverse_time_per_s_) * whole_;
  }

  Real share_{};
  Real inverse_time_per_s_{};
  Real observed_s_{};
  Real whole_{};  ///< over the share that the time constant would have reached at its end
};

}  // namespace slipstack
