// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "firmware/friction/displacement.h"
#include "firmware/friction/virgin_curves.h"

namespace slipstack {

// Hysteresis with non-local memory: a virgin curve y(x) and a stack of up to Depth reversal points.
//
//   Rule I   on the virgin curve:               F = y(x), odd in x, x from the place of the last reset.
//   Rule II  after a reversal at (x_m, F_m):    F = F_m +- 2 y(abs(x - x_m) / 2), + when moving towards +x.
//   Wiping   a branch ends where the branch that encloses it began; there the loop is closed, its two
//   reversal
//            points are forgotten, and the older branch goes on as if the loop had never been. The first
//            reversal is closed by its mirror image, beyond which the virgin curve goes on.
//
// One step closes all the loops it passes. When a reversal finds the stack full, the innermost loop (the
// newest stored reversal and this one) gives way: neither is kept, and the force is taken anew from the
// branch that encloses it. The force is then wrong by at most the height of that loop until the motion leaves
// it; see overflow_count() and overflow_height_N().
//
// Displacements are absolute (encoder counts or metres) and no differences are summed: nothing drifts. Counts
// may wrap around; the travel away from the place of the reset must stay below 2^30 counts.
//
// step() is bounded: at most (Depth + 1) / 2 loops close. For every curve.
//
// Source: Symens, Al-Bender, Swevers, Van Brussel, Harmonic analysis of a mass subject to hysteretic friction
// (Rules I and II, wiping-out).
template <VirginCurve Curve, std::size_t Depth, DisplacementType Displacement = typename Curve::Value>
class MemoryStack {
  static_assert(Depth >= 2, "giving up the innermost loop must leave the first reversal in place");

 public:
  using Real = typename Curve::Value;
  static constexpr std::size_t kDepth = Depth;

  // The curve's length unit is that of Displacement.
  constexpr explicit MemoryStack(const Curve& curve) : curve_(curve) {}

  // Forgets everything: the virgin state, unloaded, at x.
  constexpr void reset(Displacement x) {
    origin_ = x;
    travel_ = Displacement{};
    force_N_ = Real(0);
    direction_ = 0;
    depth_ = 0;
  }

  // Takes another curve for the same motion: what would be had it been there from the start, the count and
  // height of overflow aside. O(Depth), outside the tick.
  constexpr void set_curve(const Curve& curve) {
    curve_ = curve;
    if (depth_ > 0) reversal_[0].force_N = virgin_force_N(reversal_[0].travel);
    for (std::size_t i = 1; i < depth_; ++i) {
      const Reversal& from = reversal_[i - 1];
      const Real height_N = branch_height_N(reversal_[i].travel, from.travel);
      reversal_[i].force_N =
          reversal_[i].travel > from.travel ? from.force_N + height_N : from.force_N - height_N;
    }
    if (direction_ != 0) force_N_ = force_on_branch();
  }

  // Moves to x and returns the friction force in N, positive after motion towards +x.
  constexpr Real step(Displacement x) {
    const Displacement travel = difference(x, origin_);
    if (travel == travel_) return force_N_;
    const int direction = travel > travel_ ? 1 : -1;
    if (direction == -direction_) remember_reversal();
    direction_ = direction;
    travel_ = travel;
    wipe_closed_loops();
    force_N_ = force_on_branch();
    return force_N_;
  }

  constexpr Real force_N() const { return force_N_; }
  constexpr Displacement position() const { return sum(origin_, travel_); }

  // Reversal points held at present; 0 on the virgin curve.
  constexpr std::size_t depth() const { return depth_; }

  // Loops that gave way to a full stack since construction.
  constexpr std::uint32_t overflow_count() const { return overflow_count_; }

  // Height in N of the highest loop that gave way since construction: bounds the error that overflow has
  // caused.
  constexpr Real overflow_height_N() const { return overflow_height_N_; }

 private:
  struct Reversal {
    Displacement travel;  // from the origin
    Real force_N;
  };

  static constexpr Displacement distance(Displacement a, Displacement b) { return a > b ? a - b : b - a; }

  // 2 y(abs(a - b) / 2): the height of a loop between a and b, and the rise of a branch from one to the
  // other.
  constexpr Real branch_height_N(Displacement a, Displacement b) const {
    return Real(2) * curve_.force(static_cast<Real>(distance(a, b)) * Real(0.5));
  }

  constexpr void remember_reversal() {
    if (depth_ < Depth) {
      reversal_[depth_] = {travel_, force_N_};
      ++depth_;
      return;
    }
    const Real height_N = branch_height_N(travel_, reversal_[depth_ - 1].travel);
    if (height_N > overflow_height_N_) overflow_height_N_ = height_N;
    ++overflow_count_;
    --depth_;
  }

  // Where the branch that is being followed ends. Called with depth_ > 0.
  constexpr Displacement end_of_branch() const {
    return depth_ == 1 ? -reversal_[0].travel : reversal_[depth_ - 2].travel;
  }

  constexpr void wipe_closed_loops() {
    while (depth_ > 0) {
      const Displacement end = end_of_branch();
      const bool closed = direction_ > 0 ? travel_ >= end : travel_ <= end;
      if (!closed) return;
      depth_ -= depth_ == 1 ? 1 : 2;
    }
  }

  constexpr Real force_on_branch() const {
    if (depth_ == 0) return virgin_force_N(travel_);
    const Reversal& from = reversal_[depth_ - 1];
    const Real height_N = branch_height_N(travel_, from.travel);
    return direction_ > 0 ? from.force_N + height_N : from.force_N - height_N;
  }

  constexpr Real virgin_force_N(Displacement travel) const {
    const Real force_N = curve_.force(static_cast<Real>(distance(travel, Displacement{})));
    return travel < Displacement{} ? -force_N : force_N;
  }

  Curve curve_;
  Displacement origin_{};
  Displacement travel_{};  // position minus origin
  Real force_N_ = Real(0);
  int direction_ = 0;  // of the last motion: +1, -1, or 0 after a reset
  std::size_t depth_ = 0;
  std::array<Reversal, Depth> reversal_{};
  std::uint32_t overflow_count_ = 0;
  Real overflow_height_N_ = Real(0);
};

}  // namespace slipstack
