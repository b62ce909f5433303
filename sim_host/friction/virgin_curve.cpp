// SPDX-License-Identifier: Apache-2.0
#include "sim_host/friction/virgin_curve.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace slipstack::sim {

std::string_view name(CurveKind kind) {
  switch (kind) {
    case CurveKind::kExponential:
      return "exponential";
    case CurveKind::kRational:
      return "rational";
    case CurveKind::kStretched:
      return "stretched_power";
  }
  return "unknown";
}

VirginCurve::VirginCurve(std::vector<CurveTerm> terms) : terms_(std::move(terms)) {
  for (const CurveTerm& term : terms_) {
    if (!(term.level_N > 0.0)) throw std::invalid_argument("virgin curve: level must be positive");
    if (!(term.length_m > 0.0)) throw std::invalid_argument("virgin curve: length must be positive");
    if (!(term.exponent > 0.0 && term.exponent <= 1.0)) {
      throw std::invalid_argument("virgin curve: exponent must be in (0, 1], else it is not concave");
    }
  }
}

double VirginCurve::force_N(double displacement_m) const {
  double force = 0.0;
  for (const CurveTerm& term : terms_) {
    const double u = displacement_m / term.length_m;
    switch (term.kind) {
      case CurveKind::kExponential:
        force -= term.level_N * std::expm1(-u);
        break;
      case CurveKind::kRational:
        force += term.level_N * u * (2.0 + u) / ((1.0 + u) * (1.0 + u));
        break;
      case CurveKind::kStretched:
        force -= term.level_N * std::expm1(-std::pow(u, term.exponent));
        break;
    }
  }
  return force;
}

double VirginCurve::saturation_N() const {
  double level = 0.0;
  for (const CurveTerm& term : terms_) level += term.level_N;
  return level;
}

double VirginCurve::displacement_m(double share) const {
  const double target = share * saturation_N();
  double high = terms_.empty() ? 0.0 : terms_.front().length_m;
  while (force_N(high) < target && high < 1e3) high *= 2.0;
  double low = 0.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (force_N(middle) < target ? low : high) = middle;
  }
  return high;
}

}  // namespace slipstack::sim
