// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/measurement/motion_terms.h"

#include <algorithm>
#include <cstddef>

namespace slipstack::workbench {

std::vector<double> signs_of(const std::vector<double>& values) {
  std::vector<double> signs(values.size());
  std::transform(values.begin(), values.end(), signs.begin(), [](double v) { return (v > 0.0) - (v < 0.0); });
  return signs;
}

MotionTerms::MotionTerms(const Measurement& measurement)
    : inertia_N(measurement.acceleration_mps2()),
      direction(signs_of(measurement.velocity_mps())),
      at_rows(measurement.row_count(), kCount) {
  for (const LogPart& part : measurement.parts()) {
    const double mass_kg = part.mass_kg.value_or(0.0) > 0.0 ? *part.mass_kg : 1.0;
    for (std::size_t i = part.first_sample; i < part.end_sample(); ++i) inertia_N[i] *= mass_kg;
  }
  at_rows.col(kInertia) = measurement.filtered(inertia_N);
  at_rows.col(kViscous) = measurement.filtered(measurement.velocity_mps());
  at_rows.col(kCoulomb) = measurement.filtered(direction);
  at_rows.col(kSpring) = measurement.filtered(measurement.position_m());
  at_rows.col(kSpring).array() -= at_rows.col(kSpring).mean();
  at_rows.col(kSpring) /= std::max(at_rows.col(kSpring).cwiseAbs().maxCoeff(), 1e-300);
  at_rows.col(kSquare) = at_rows.col(kSpring).cwiseAbs2();
  at_rows.col(kCube) = at_rows.col(kSquare).cwiseProduct(at_rows.col(kSpring));
  at_rows.col(kConstant).setOnes();
}

}  // namespace slipstack::workbench
