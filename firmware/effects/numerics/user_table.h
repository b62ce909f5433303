// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"
#include "firmware/effects/numerics/interval.h"

namespace slipstack {

/// Points of the table, at the ends of 32 intervals.
inline constexpr int kUserTablePoints = 33;

/// Represents a user-defined effect on the controller, which evaluates no expressions: forces at evenly
/// spaced positions or velocities, linear interpolation between them, and constant beyond either end. The
/// workbench computes it from a fitted effect (workbench/estimate/terms/user_table.h); no fit chooses it.
template <class Real>
class UserTable {
 public:
  static constexpr EffectText text{
      .id = "user_table",
      .title = "Table of a user-defined effect",
      .formula = "F = T((x - x0) n + (v - v0) m) d, T straight between 33 points; d = 1, or sat(v/vr)",
      .source = "docs/user-effect.md",
      .residual = "that of the tabulated effect",
      .evidence = "a table of up to {force} represents a user-defined effect",
      .cause = "stated by the author of the effect",
      .confirm = "compare a log with the model, once with the table and once without"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"force", "N", -1.0e6f, 1.0e6f, kUserTablePoints, Acts::force, true},
  }};
  /// Intervals per metre, or per m/s: zero where the table does not follow it. A reversal velocity of zero:
  /// the same force both ways.
  static constexpr std::array<ShapeSpec, 5> shapes{{
      {"position_start", "m", -1.0e3f, 1.0e3f, ShapeKind::table},
      {"intervals_per_position", "1/m", 0.0f, 1.0e7f, ShapeKind::table},
      {"velocity_start", "m/s", -1.0e3f, 1.0e3f, ShapeKind::table},
      {"intervals_per_velocity", "s/m", 0.0f, 1.0e7f, ShapeKind::table},
      {"reversal_velocity", "m/s", 0.0f, 1.0f, ShapeKind::table},
  }};
  static constexpr int gain_count = kUserTablePoints;
  static constexpr int shape_count = 5;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>&) {
    per_position_ = shape[1];
    per_velocity_ = shape[3];
    offset_ = -(shape[0] * shape[1] + shape[2] * shape[3]);
    const bool by_direction = shape[4] > Real(0);
    per_reversal_ = by_direction ? Real(1) / shape[4] : Real(0);
    either_way_ = by_direction ? Real(0) : Real(1);
    over_velocity_ = per_position_ == Real(0) ? Real(1) : Real(0);
    over_position_ = Real(1) - over_velocity_;
  }
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    const auto [interval, before, after] = line_at(sample);
    for (Real& weight : out) weight = Real(0);
    out[interval] = before;
    out[interval + 1] = after;
  }

  /// At any place two of the points act.
  Real weighted(const Sample<Real>& sample, const std::array<Real, gain_count>& points) const {
    const auto [interval, before, after] = line_at(sample);
    const auto point = values_from(points, interval);
    return point[0] * before + point[1] * after;
  }

 private:
  static constexpr std::size_t kIntervals = kUserTablePoints - 1;
  struct Line {
    typename IndexOf<Real>::type interval;
    Real before;  ///< weight of the point at the begin of the interval
    Real after;   ///< and at its end
  };

  Line line_at(const Sample<Real>& sample) const {
    const Real raw = per_position_ * sample.position_m + per_velocity_ * sample.velocity_mps + offset_;
    const Real place = approx::clamp(raw, Real(0), static_cast<Real>(kIntervals));
    const auto [interval, t] = interval_at(place, kIntervals);
    const Real direction =
        either_way_ + approx::clamp(sample.velocity_mps * per_reversal_, Real(-1), Real(1));
    // Over position nothing without a position reference; over velocity alone always.
    const Real factor = direction * (over_velocity_ + over_position_ * sample.position_weight);
    return {interval, (Real(1) - t) * factor, t * factor};
  }

  Real per_position_{};
  Real per_velocity_{};
  Real offset_{};
  Real per_reversal_{};
  Real either_way_{};
  Real over_velocity_{};
  Real over_position_{};
};

}  // namespace slipstack
