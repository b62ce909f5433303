// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "firmware/effects/approx.h"
#include "firmware/effects/effect.h"

namespace slipstack {

/// Intervals of the map over the stroke, and the splines that this takes.
inline constexpr int kPreloadMapIntervals = 17;
inline constexpr int kPreloadMapSplines = kPreloadMapIntervals + 3;

template <class Real>
class PositionDependentPreload {
 public:
  static constexpr EffectText text{
      .id = "position_dependent_preload",
      .title = "Preload that varies along the rail",
      .formula = "dry friction x (1 + sum_j w_j B3((x - x0)/h - j)), cubic B-splines on a uniform grid",
      .source = "[1] set-ups 1 and 3, [2]: loops at four positions differ by preload",
      .residual = "follows position, with the sign of friction: opposite in the two directions",
      .evidence =
          "the friction level varies along the rail, by up to {map} of itself, opposite in the two "
          "directions",
      .cause = "rail straightness and mounting, carriage preload, a rail joint",
      .confirm =
          "pre-sliding loops and slow strokes at several places: the level differs, the shape does not"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"map", "1", -0.95f, 3.0f, kPreloadMapSplines, Acts::dry_scale, true},
  }};
  static constexpr std::array<ShapeSpec, 2> shapes{{
      {"map_start", "m", -1.0e3f, 1.0e3f, ShapeKind::position},
      {"map_length", "m", 1.0e-4f, 1.0e3f, ShapeKind::travel},
  }};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 2;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>&) {
    start_m_ = shape[0];
    intervals_per_m_ = static_cast<Real>(kIntervals) / shape[1];
  }
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    const auto [interval, t] = place_of(sample.position_m);
    const Real s = Real(1) - t;
    const Real t2 = t * t;
    for (Real& weight : out) weight = Real(0);
    out[interval] = s * s * s * Real(1.0 / 6);
    out[interval + 1] = Real(2.0 / 3) + t2 * (Real(0.5) * t - Real(1));
    out[interval + 2] = Real(1.0 / 6) + Real(0.5) * (t + t2 - t2 * t);
    out[interval + 3] = t2 * t * Real(1.0 / 6);
  }

  /// The controller's form: the cubic of each interval, multiplied out beforehand.
  using Table = std::array<std::array<Real, 4>, kPreloadMapIntervals>;
  void prepare_weighted(const std::array<Real, gain_count>& map, Table& cubics) {
    for (std::size_t i = 0; i < kIntervals; ++i) {
      const Real w0 = map[i], w1 = map[i + 1], w2 = map[i + 2], w3 = map[i + 3];
      cubics[i] = {(w0 + Real(4) * w1 + w2) * Real(1.0 / 6), (w2 - w0) * Real(0.5),
                   (w0 - Real(2) * w1 + w2) * Real(0.5), (w3 - w0 + Real(3) * (w1 - w2)) * Real(1.0 / 6)};
    }
  }
  Real weighted(const Sample<Real>& sample, const std::array<Real, gain_count>&, const Table& cubics) const {
    // The end of the map is taken in its last interval, the least bit before its end.
    constexpr Real kLast = static_cast<Real>(kIntervals) * (Real(1) - std::numeric_limits<Real>::epsilon());
    const Real place = approx::clamp((sample.position_m - start_m_) * intervals_per_m_, Real(0), kLast);
    const auto interval = static_cast<std::int32_t>(place);
    const Real t = place - static_cast<Real>(interval);
    const Real* const c = approx::one_address(cubics[static_cast<std::size_t>(interval)].data());
    return approx::multiply_add(approx::multiply_add(approx::multiply_add(c[3], t, c[2]), t, c[1]), t, c[0]);
  }

 private:
  static constexpr std::size_t kIntervals = kPreloadMapIntervals;
  struct Place {
    std::size_t interval;
    Real t;
  };

  /// The interval a position is in, beyond the map its first or last, and where in it, 0 to 1.
  Place place_of(Real position_m) const {
    const Real place =
        approx::clamp((position_m - start_m_) * intervals_per_m_, Real(0), static_cast<Real>(kIntervals));
    const auto whole = static_cast<std::size_t>(static_cast<std::int32_t>(place));
    const std::size_t interval = whole < kIntervals ? whole : kIntervals - 1;
    return {interval, place - static_cast<Real>(static_cast<std::int32_t>(interval))};
  }

  Real start_m_{};
  Real intervals_per_m_{};
};

}  // namespace slipstack
