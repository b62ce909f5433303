// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/rough_mass.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "workbench/base/statistics.h"
#include "workbench/signal/zero_phase.h"

namespace slipstack::workbench {

namespace {

/// The mean square of the acceleration that an encoder's steps alone leave below `cutoff_Hz`, white noise of
/// variance resolution^2 / 12 differentiated twice.
double acceleration_of_steps_m2ps4(double resolution_m, double cutoff_Hz, double rate_Hz) {
  const double omega_per_s = 2.0 * std::numbers::pi * cutoff_Hz;
  return resolution_m * resolution_m / 12.0 * std::pow(omega_per_s, 4) * 2.0 * cutoff_Hz / (5.0 * rate_Hz);
}

/// Samples at either end of a log that are not smooth: the filter takes an axis that is cut out of a motion
/// to have stood still before, and the derivatives reach two samples further.
std::size_t edge_of(const std::vector<double>& taps) {
  return taps.size() / 2 + 2;
}

/// The acceleration below a frequency at which it stands out of the encoder's steps, by a factor of ten in
/// power where the log has one: noise of a regressor lowers its coefficient by as much as it has of its
/// power (Fuller 1987, Measurement Error Models, 1.1).
struct SmoothMotion {
  std::vector<double> taps;
  std::vector<double> velocity_mps;
  std::vector<double> acceleration_mps2;
};
SmoothMotion smooth_motion(const std::vector<double>& position_m, double rate_Hz, double resolution_m) {
  constexpr double kClear = 10.0;
  constexpr double kLowest = 0.02 / 16.0;  // of the rate: filters of ever more taps
  SmoothMotion motion;
  for (double share = 0.02; share >= kLowest; share *= 0.5) {
    const double cutoff_Hz = share * rate_Hz;
    motion.taps = low_pass_taps(cutoff_Hz, rate_Hz);
    const std::vector<double> x = filter_all(position_m, motion.taps);
    motion.velocity_mps = first_derivative(x, rate_Hz);
    motion.acceleration_mps2 = second_derivative(x, rate_Hz);
    const std::size_t edge = edge_of(motion.taps);
    if (position_m.size() <= 4 * edge) break;
    double power = 0.0;
    for (std::size_t i = edge; i + edge < x.size(); ++i) power += squared(motion.acceleration_mps2[i]);
    power /= static_cast<double>(x.size() - 2 * edge);
    if (power > kClear * acceleration_of_steps_m2ps4(resolution_m, cutoff_Hz, rate_Hz)) break;
  }
  return motion;
}

}  // namespace

double rough_mass_kg(const std::vector<double>& position_m, const std::vector<double>& force_N,
                     double rate_Hz, double resolution_m, const std::vector<Interval>& cut) {
  const auto [taps, v, a] = smooth_motion(position_m, rate_Hz, resolution_m);
  const std::vector<double> f = filter_all(force_N, taps);
  Eigen::Matrix4d gram = 1e-12 * Eigen::Matrix4d::Identity();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  auto next = cut.begin();
  const std::size_t edge = edge_of(taps);
  for (std::size_t i = edge; i + edge < f.size(); ++i) {
    while (next != cut.end() && i >= next->end + taps.size()) ++next;
    if (next != cut.end() && i + taps.size() >= next->first) continue;
    const Eigen::Vector4d row(a[i], v[i], std::copysign(1.0, v[i]), 1.0);
    gram += row * row.transpose();
    right += row * f[i];
  }
  return std::max(0.0, gram.ldlt().solve(right)(0));
}

}  // namespace slipstack::workbench
