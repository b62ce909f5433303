// SPDX-License-Identifier: Apache-2.0
#include "sim_host/plant/friction/virgin_curve.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
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
    case CurveKind::kPoints:
      return "points";
  }
  return "unknown";
}

namespace {

void check_points(const CurveTerm& term) {
  if (term.points_m.empty() || term.points_m.size() != term.points_N.size()) {
    throw std::invalid_argument("virgin curve: as many forces as displacements, at least one");
  }
  double last_m = 0.0;
  double last_N = 0.0;
  double last_slope = HUGE_VAL;
  for (std::size_t i = 0; i < term.points_m.size(); ++i) {
    if (!(term.points_m[i] > last_m)) throw std::invalid_argument("virgin curve: displacements must rise");
    const double slope = (term.points_N[i] - last_N) / (term.points_m[i] - last_m);
    if (!(slope >= 0.0)) throw std::invalid_argument("virgin curve: forces fall, a stiffness is negative");
    if (slope > last_slope * (1.0 + 1e-9)) {
      throw std::invalid_argument("virgin curve: it is not concave at its point " + std::to_string(i + 1));
    }
    last_m = term.points_m[i];
    last_N = term.points_N[i];
    last_slope = slope;
  }
}

double points_N(const CurveTerm& term, double displacement_m) {
  const auto behind = std::lower_bound(term.points_m.begin(), term.points_m.end(), displacement_m);
  if (behind == term.points_m.end()) return term.points_N.back();
  const auto i = static_cast<std::size_t>(behind - term.points_m.begin());
  const double from_m = i > 0 ? term.points_m[i - 1] : 0.0;
  const double from_N = i > 0 ? term.points_N[i - 1] : 0.0;
  return from_N + (term.points_N[i] - from_N) * (displacement_m - from_m) / (term.points_m[i] - from_m);
}

}  // namespace

VirginCurve::VirginCurve(std::vector<CurveTerm> terms) : terms_(std::move(terms)) {
  for (const CurveTerm& term : terms_) {
    if (!(term.level_N > 0.0)) throw std::invalid_argument("virgin curve: level must be positive");
    if (!(term.length_m > 0.0)) throw std::invalid_argument("virgin curve: length must be positive");
    if (!(term.exponent > 0.0 && term.exponent <= 1.0)) {
      throw std::invalid_argument("virgin curve: exponent must be in (0, 1], else it is not concave");
    }
    if (term.kind == CurveKind::kPoints) check_points(term);
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
      case CurveKind::kPoints:
        force += points_N(term, displacement_m);
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
