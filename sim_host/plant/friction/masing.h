// SPDX-License-Identifier: Apache-2.0
// Hysteresis of a smooth virgin curve by its reversal points ([1], rules I and II).
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "sim_host/plant/friction/virgin_curve.h"

namespace slipstack::sim {

/// The friction force of a body with virgin curve y, as a function of its reversal points:
///   rule I   on the virgin curve: F = y(x − x₀), odd;
///   rule II  after a reversal at (x_m, F_m): F = F_m ± 2·y(|x − x_m|/2);
/// when a loop closes, both its reversals are removed and the branch around it continues.
///
/// Unlike MaxwellElements it has the curve itself, not straight lines through its points; between events the
/// force is smooth, which an integrator of high order needs. The caller has to locate reversals and loop
/// closures.
class Masing {
 public:
  explicit Masing(VirginCurve curve, double x_m = 0.0);

  void reset(double x_m);
  /// Force on the present branch at x, N. Exact up to the next event, smooth beyond. O(terms of the curve).
  double force_N(double x_m) const {
    const double way_m = direction_ * (x_m - start_m_);
    return start_N_ + direction_ * scale_ * curve_value(way_m / scale_);
  }
  int direction() const { return direction_; }
  /// Position at which the innermost loop closes if the motion continues, m; ±infinity when there is none.
  double closing_m() const { return closing_m_; }
  /// The body reverses at x. A reversal within rounding of the one before the last closes that loop too.
  void turn(double x_m);
  /// The body has reached closing_m(): the loop is removed.
  void close();

  const VirginCurve& curve() const { return curve_; }
  double initial_stiffness_N_per_m() const { return stiffness_; }
  /// Reversals remembered.
  std::size_t depth() const { return reversals_.size(); }

  /// The whole state as numbers, and back; bit for bit.
  std::vector<double> snapshot() const;
  void restore(const double* values, std::size_t count);

 private:
  struct Reversal {
    double x_m;
    double force_N;
  };
  double curve_value(double way_m) const { return way_m > 0.0 ? curve_.force_N(way_m) : way_m * stiffness_; }
  void enter_branch();

  VirginCurve curve_;
  double stiffness_ = 0.0;
  double tiny_m_ = 0.0;
  double origin_m_ = 0.0;
  int direction_ = 1;
  std::vector<Reversal> reversals_;
  double start_m_ = 0.0;  // of the present branch
  double start_N_ = 0.0;
  double scale_ = 1.0;  // 1 on the virgin curve, 2 after a reversal
  double closing_m_ = std::numeric_limits<double>::infinity();
};

}  // namespace slipstack::sim
