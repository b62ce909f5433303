// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"
#include "firmware/effects/numerics/interval.h"

namespace slipstack {

/// Intervals of the map over the stroke, and the splines that this takes.
inline constexpr int kPreloadMapIntervals = 17;
inline constexpr int kPreloadMapSplines = kPreloadMapIntervals + 3;

template <class Real>
class PositionDependentPreload {
 public:
  static constexpr EffectText text{
      .id = "position_dependent_preload",
      .title = "Preload that varies with position",
      .formula = "dry friction x (1 + sum_j w_j B3((x - x0)/h - j)), cubic B-splines on a uniform grid",
      .source = "[1] set-ups 1 and 3, [2]: loops at four positions differ by preload",
      .residual = "follows position, with the sign of friction: opposite in the two directions",
      .evidence =
          "the friction level varies with position, by up to {map} of itself, opposite in the two "
          "directions",
      .cause =
          "rail straightness and mounting, carriage preload, a rail joint | an eccentric bearing, "
          "gear or seal",
      .confirm = "pre-sliding loops and slow moves at several places: the level differs, the shape does not"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"map", "1", -0.95f, 3.0f, kPreloadMapSplines, Acts::dry_scale, true},
  }};
  static constexpr std::array<ShapeSpec, 2> shapes{{
      {"map_start", "m", -1.0e3f, 1.0e3f, ShapeKind::position},
      {"map_length", "m", 1.0e-4f, 1.0e3f, ShapeKind::travel},
  }};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 2;
  static constexpr bool over_position = true;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>&) {
    start_m_ = shape[0];
    intervals_per_m_ = static_cast<Real>(kIntervals) / shape[1];
  }
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    const auto [interval, splines] = splines_at(sample.position_m);
    for (Real& weight : out) weight = Real(0);
    for (std::size_t i = 0; i < splines.size(); ++i) out[interval + i] = splines[i];
  }

  /// At any position four of the splines are not zero.
  Real weighted(const Sample<Real>& sample, const std::array<Real, gain_count>& map) const {
    const auto [interval, splines] = splines_at(sample.position_m);
    const auto weight = values_from(map, interval);
    return weight[0] * splines[0] + weight[1] * splines[1] + weight[2] * splines[2] + weight[3] * splines[3];
  }

 private:
  static constexpr std::size_t kIntervals = kPreloadMapIntervals;
  struct Splines {
    typename IndexOf<Real>::type interval;
    std::array<Real, 4> value;
  };

  /// The interval of a position, beyond the map its first or last one, and the splines that are not zero
  /// there.
  Splines splines_at(Real position_m) const {
    const Real place =
        approx::clamp((position_m - start_m_) * intervals_per_m_, Real(0), static_cast<Real>(kIntervals));
    const auto [interval, t] = interval_at(place, kIntervals);
    const Real s = Real(1) - t;
    const Real t2 = t * t;
    return {interval,
            {s * s * s * Real(1.0 / 6), Real(2.0 / 3) + t2 * (Real(0.5) * t - Real(1)),
             Real(1.0 / 6) + Real(0.5) * (t + t2 - t2 * t), t2 * t * Real(1.0 / 6)}};
  }

  Real start_m_{};
  Real intervals_per_m_{};
};

}  // namespace slipstack
