// SPDX-License-Identifier: Apache-2.0
// Many Maxwell elements (spring and slider in series, all in parallel), exact in displacement.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sim_host/plant/friction/virgin_curve.h"

namespace slipstack::sim {

/// A bank of Maxwell elements. Each has a stiffness kᵢ, a slip distance dᵢ, an anchor pᵢ that does not move
/// while the element sticks and follows dᵢ behind the body while it slips; its force is kᵢ·(x − pᵢ).
///
/// From a relaxed start, anchors of neighbouring elements never differ by more than their slip distances do
/// (the play operators of a Prandtl-Ishlinskii bank), so with elements sorted by slip distance those that
/// slip are always the first few. Hence one index separates slipping from sticking elements, and moving the
/// body costs one step per element that begins to slip, not one per element. Anchors do not move while
/// sticking, so no rounding errors accumulate.
class MaxwellElements {
 public:
  MaxwellElements() = default;
  /// Elements from stiffness and slip distance, sorted by slip distance. Throws std::invalid_argument when
  /// the sizes differ, a stiffness is negative, or slip distances are not positive and increasing.
  MaxwellElements(std::vector<double> stiffness_N_per_m, std::vector<double> slip_m);
  /// The piecewise linear curve through `count` points of a smooth virgin curve, geometrically spaced from
  /// 1/1000 of its travel to 99.99 % of its saturation; it levels off after the last.
  static MaxwellElements sample(const VirginCurve& curve, std::size_t count);
  /// The same, from the first to the last slip distance given: 0 < first_m < last_m, count of two or more.
  static MaxwellElements sample(const VirginCurve& curve, double first_m, double last_m, std::size_t count);

  /// Moves the body to x without reversal; the caller splits a motion at its reversals. Cost: one step per
  /// element that begins to slip; after a reversal one per element.
  void move_to(double x_m);
  /// Force of the bank at the present position, N (positive resists positive motion).
  double force_N() const { return event_force_N_ + sticking_stiffness() * (x_m_ - event_x_m_); }
  /// The force after a move to x without reversal, N; the bank is not changed.
  double force_after_N(double x_m) const;
  /// Tangent stiffness in the present direction, N/m.
  double sticking_stiffness() const { return tail_stiffness_[slipping_]; }
  /// Tangent stiffness at the start of motion in `direction` (+1 or −1), N/m.
  double stiffness_towards(int direction) const;
  /// Where, moving in `direction`, the next element begins to slip, m; ±infinity when all slip.
  double next_slip_m(int direction) const;
  /// Changes the direction without moving: all elements stick when it is a reversal.
  void turn_to(int direction);

  /// The whole state as numbers, and back into a bank of the same elements; bit for bit. restore() throws
  /// std::invalid_argument when their count does not fit.
  std::vector<double> snapshot() const;
  void restore(std::span<const double> values);

  /// All relaxed at x, energies zero.
  void reset(double x_m);
  double position_m() const { return x_m_; }
  /// +1 or −1: the direction of the last motion; 0 before any.
  int direction() const { return direction_; }
  std::size_t size() const { return stiffness_.size(); }
  double stiffness_N_per_m(std::size_t i) const { return stiffness_[i]; }
  double slip_m(std::size_t i) const { return slip_[i]; }
  double initial_stiffness_N_per_m() const { return tail_stiffness_[0]; }
  double saturation_N() const { return slipping_force_.back(); }
  /// Energy in the springs now, J; one step per element.
  double stored_J() const;
  /// Work done by the sliders since the last reset, J.
  double dissipated_J() const { return dissipated_J_; }

 private:
  double anchor_m(std::size_t i) const;
  double elongation_m(std::size_t i) const;

  std::vector<double> stiffness_;
  std::vector<double> slip_;
  std::vector<double> anchor_;               // valid for sticking elements
  std::vector<double> tail_stiffness_{0.0};  // [j]: Σ kᵢ of i ≥ j
  std::vector<double> slipping_force_{0.0};  // [j]: Σ kᵢ·dᵢ of i < j
  double x_m_ = 0.0;
  int direction_ = 0;
  std::size_t slipping_ = 0;  // elements 0 … slipping_−1 slip
  double event_x_m_ = 0.0;    // where the last element began to slip, or the last reversal
  double event_force_N_ = 0.0;
  double dissipated_J_ = 0.0;
};

}  // namespace slipstack::sim
