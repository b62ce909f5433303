// SPDX-License-Identifier: Apache-2.0
// Smooth virgin curves of rolling contacts: those of the simulated axis, not those that an observer fits.
#pragma once

#include <string_view>
#include <vector>

namespace slipstack::sim {

enum class CurveKind { kExponential, kRational, kStretched, kPoints };

std::string_view name(CurveKind kind);

/// One term of a virgin curve, for a displacement x ≥ 0 and u = x / length:
///   exponential  level·(1 − exp(−u))
///   rational     level·(1 − 1/(1+u)²)                        ([2], h₀ and δ)
///   stretched    level·(1 − exp(−uⁿ)), 0 < n ≤ 1: a power law xⁿ that saturates
///   points       straight lines from the origin through measured points, level from the last on
struct CurveTerm {
  CurveKind kind = CurveKind::kExponential;
  double level_N = 1.0;
  double length_m = 1e-5;
  double exponent = 1.0;
  std::vector<double> points_m{};  // of `points`: displacements, and the forces there
  std::vector<double> points_N{};
};

/// A virgin curve: the sum of its terms (several scales, several rails). Rising, concave, saturating.
class VirginCurve {
 public:
  VirginCurve() = default;
  /// Throws std::invalid_argument when a level or length is not positive, an exponent not in (0, 1], or
  /// points do not rise and bend downwards.
  explicit VirginCurve(std::vector<CurveTerm> terms);

  /// Force at displacement x ≥ 0 on the virgin curve, N.
  double force_N(double displacement_m) const;
  /// The saturation force, N.
  double saturation_N() const;
  /// Displacement at which `share` (0…1) of the saturation is reached, m; by bisection.
  double displacement_m(double share) const;
  /// The pre-sliding travel: 90 % of the saturation.
  double travel_m() const { return displacement_m(0.9); }

  const std::vector<CurveTerm>& terms() const { return terms_; }

 private:
  std::vector<CurveTerm> terms_;
};

}  // namespace slipstack::sim
