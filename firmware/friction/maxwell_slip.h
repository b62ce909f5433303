// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <span>

#include "firmware/friction/displacement.h"
#include "firmware/friction/virgin_curves.h"

namespace slipstack {

/// Maxwell-slip hysteresis: up to N springs in parallel, each of stiffness k_i and dragging its far end, the
/// anchor w_i, along once it is stretched by its slip distance Delta_i (N stop operators):
///
///     w_i <- clamp(w_i, x - Delta_i, x + Delta_i),   z_i = x - w_i,   F = sum k_i z_i.
///
/// x, w, z, Delta are in the unit of Displacement: absolute encoder counts (int32; a counter that wraps does
/// no harm) or metres (double); k in N per that unit. The anchors are absolute, so nothing is summed up and
/// nothing drifts: with counts every z_i is exact for ever.
///
/// The work of step() is the same for every input: N elements, used or not. Elements with Delta = 0 and k = 0
/// add nothing. PackedMaxwellSlip is the fast form of the same thing, this one is the reference.
///
/// Source: Lampaert, Swevers, Al-Bender, IEEE TAC 47(4) 2002 (Maxwell-slip in the Leuven model); EMRP SIB63.
template <std::size_t N, std::floating_point Real = float, DisplacementType Displacement = Real>
class MaxwellSlip {
 public:
  static constexpr std::size_t kCapacity = N;  ///< elements

  /// Takes up to N elements; the others become unused. Slip distances >= 0, below 2^30 if they are counts;
  /// stiffnesses >= 0 and finite: a negative spring could give out energy that was never put in. Anchors stay
  /// where they are as far as the new slip distances allow, so parameters may change in motion.
  [[nodiscard]] constexpr SetupStatus set_elements(std::span<const Displacement> slip_distance,
                                                   std::span<const Real> stiffness) {
    if (slip_distance.size() != stiffness.size()) return SetupStatus::kSizeMismatch;
    if (slip_distance.size() > N) return SetupStatus::kTooMany;
    for (std::size_t i = 0; i < slip_distance.size(); ++i) {
      if (!valid_slip_distance(slip_distance[i])) return SetupStatus::kOutOfRange;
      if (!is_finite(stiffness[i]) || stiffness[i] < Real(0)) return SetupStatus::kOutOfRange;
    }
    slip_distance_ = {};
    stiffness_ = {};
    for (std::size_t i = 0; i < slip_distance.size(); ++i) {
      slip_distance_[i] = slip_distance[i];
      stiffness_[i] = stiffness[i];
    }
    step(position_);
    return SetupStatus::kOk;
  }

  /// Unloads every spring at position x: the virgin state.
  constexpr void reset(Displacement x) {
    position_ = x;
    anchor_.fill(x);
  }

  /// Moves to position x and returns the friction force in N: the force the springs exert against the motion,
  /// positive after motion towards +x. N clamps, N multiplications and N additions.
  constexpr Real step(Displacement x) {
    position_ = x;
    Real force_N = Real(0);
    for (std::size_t i = 0; i < N; ++i) {
      const Displacement limit = slip_distance_[i];
      const Displacement stretch = difference(x, anchor_[i]);
      const Displacement below = stretch > limit ? limit : stretch;
      const Displacement z = below < -limit ? -limit : below;
      if constexpr (std::integral<Displacement>) {
        anchor_[i] = difference(x, z);
      } else {
        // A spring that sticks keeps its anchor to the bit; x - z would round it. By the two comparisons
        // above and not by z, so that the next step waits for neither.
        const Displacement ahead = stretch > limit ? x - limit : anchor_[i];
        anchor_[i] = stretch < -limit ? x + limit : ahead;
      }
      force_N += stiffness_[i] * static_cast<Real>(z);
    }
    return force_N;
  }

  /// Stretch of spring i in displacement units, within [-Delta_i, Delta_i]: the regressor of k_i. At the rail
  /// it is exactly Delta_i for counts, and to the rounding of the position for floating displacements.
  constexpr Displacement z(std::size_t i) const { return difference(position_, anchor_[i]); }

  /// Writes the stretches of the first min(N, out.size()) springs.
  constexpr void elements(std::span<Real> out) const {
    for (std::size_t i = 0; i < N && i < out.size(); ++i) out[i] = static_cast<Real>(z(i));
  }

  /// Energy held by the springs, sum k z^2 / 2, in N times the displacement unit. Every step obeys
  /// step(x) * (x - x_before) >= change of stored_energy(): the model is passive.
  constexpr Real stored_energy() const {
    Real energy = Real(0);
    for (std::size_t i = 0; i < N; ++i) {
      const Real stretch = static_cast<Real>(z(i));
      energy += Real(0.5) * stiffness_[i] * stretch * stretch;
    }
    return energy;
  }

  constexpr Displacement position() const { return position_; }  ///< of the last step or reset
  constexpr Displacement slip_distance(std::size_t i) const { return slip_distance_[i]; }  ///< of spring i
  constexpr Real stiffness(std::size_t i) const {
    return stiffness_[i];
  }  ///< of spring i, N per displacement

 private:
  static constexpr bool valid_slip_distance(Displacement distance) {
    if constexpr (std::integral<Displacement>) {
      return distance >= 0 && distance < (Displacement(1) << 30);
    } else {
      return is_finite(distance) && distance >= Displacement(0);
    }
  }

  Displacement position_{};
  std::array<Displacement, N> anchor_{};
  std::array<Displacement, N> slip_distance_{};
  std::array<Real, N> stiffness_{};
};

}  // namespace slipstack
