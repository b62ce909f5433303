// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/rough_mass.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "workbench/signal/zero_phase.h"

namespace slipstack::workbench {

double rough_mass_kg(const std::vector<double>& position_m, const std::vector<double>& force_N,
                     double rate_Hz, const std::vector<Interval>& cut) {
  const std::vector<double> taps = low_pass_taps(0.02 * rate_Hz, rate_Hz);
  const std::vector<double> x = filter_all(position_m, taps);
  const std::vector<double> f = filter_all(force_N, taps);
  const std::vector<double> v = first_derivative(x, rate_Hz);
  const std::vector<double> a = second_derivative(x, rate_Hz);
  Eigen::Matrix4d gram = 1e-12 * Eigen::Matrix4d::Identity();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  auto next = cut.begin();
  for (std::size_t i = 0; i < x.size(); ++i) {
    while (next != cut.end() && i >= next->end + taps.size()) ++next;
    if (next != cut.end() && i + taps.size() >= next->first) continue;
    const Eigen::Vector4d row(a[i], v[i], std::copysign(1.0, v[i]), 1.0);
    gram += row * row.transpose();
    right += row * f[i];
  }
  return std::max(0.0, gram.ldlt().solve(right)(0));
}

}  // namespace slipstack::workbench
