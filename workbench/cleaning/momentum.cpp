// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/momentum.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "workbench/base/statistics.h"
#include "workbench/signal/noise_estimate.h"
#include "workbench/signal/rough_mass.h"

namespace slipstack::workbench {
namespace {

/// Samples on either side of a pulse from which the change of the velocity is found: half a usual distance
/// between the kinks of a set-point, and enough for an encoder of coarse steps. Chosen.
constexpr std::size_t kBeside = 12;
/// So many pulses have a mass in common by no chance. Chosen.
constexpr std::size_t kFewestPulses = 5;
/// Masses agree within this factor: the pulse is sampled, the velocity found from few samples. Chosen.
constexpr double kAgree = 2.0;
/// A change of the velocity is one where it exceeds its standard error by this factor.
constexpr double kClearChange = 3.0;

/// What a pulse gives the axis, and what the axis takes.
struct Pulse {
  double impulse_Ns = 0.0;
  double velocity_step_mps = 0.0;  ///< 0 where none is seen
};

/// The velocity step at the middle of the pulse, beside an acceleration of its own before and after it.
double velocity_step(const Log& log, const Interval& pulse, double noise_m) {
  if (pulse.first < kBeside || pulse.end + kBeside > log.position_m.size()) return 0.0;
  const std::size_t from = pulse.first - kBeside;
  const auto count = static_cast<Eigen::Index>(pulse.size() + 2 * kBeside);
  const double middle = 0.5 * static_cast<double>(pulse.first + pulse.end - 1);
  Eigen::MatrixXd columns(count, 5);
  Eigen::VectorXd position_m(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::size_t sample = from + static_cast<std::size_t>(i);
    const double t_s = (static_cast<double>(sample) - middle) / log.sample_rate_Hz;
    const double after_s = std::max(0.0, t_s);
    columns.row(i) << 1.0, t_s, t_s * t_s, after_s, after_s * after_s;
    position_m(i) = log.position_m[sample];
  }
  const Eigen::VectorXd scale = columns.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  const Eigen::MatrixXd scaled = columns * scale.asDiagonal();
  const Eigen::MatrixXd inverse = (scaled.transpose() * scaled).inverse();
  const Eigen::VectorXd found = scale.cwiseProduct(inverse * (scaled.transpose() * position_m));
  const double error_mps = noise_m * scale(3) * std::sqrt(inverse(3, 3));
  return std::abs(found(3)) > kClearChange * error_mps ? found(3) : 0.0;
}

/// The integral of the force above the straight line between its neighbours.
double impulse(const Log& log, const Interval& pulse) {
  if (pulse.first == 0 || pulse.end >= log.force_N.size()) return 0.0;
  const double beside_N = 0.5 * (log.force_N[pulse.first - 1] + log.force_N[pulse.end]);
  double sum_N = 0.0;
  for (std::size_t i = pulse.first; i < pulse.end; ++i) sum_N += log.force_N[i] - beside_N;
  return sum_N / log.sample_rate_Hz;
}

/// Whether the axis took the impulse with about this mass.
bool moves(const Pulse& pulse, double mass_kg) {
  const double taken_Ns = mass_kg * pulse.velocity_step_mps;
  const double share = pulse.impulse_Ns == 0.0 ? 0.0 : taken_Ns / pulse.impulse_Ns;
  return share * kAgree >= 1.0 && share <= kAgree;
}

/// The declared mass; else that of the pulses, where there are enough of them to have one; else a rough one
/// of the whole log, for which the faults of a sensor are noise.
double mass_of(const Log& log, const std::vector<Pulse>& pulses) {
  if (log.mass_kg) return *log.mass_kg;
  std::vector<double> masses_kg;
  for (const Pulse& pulse : pulses) {
    if (pulse.impulse_Ns * pulse.velocity_step_mps > 0.0)
      masses_kg.push_back(pulse.impulse_Ns / pulse.velocity_step_mps);
  }
  if (masses_kg.size() >= kFewestPulses) return median(masses_kg);
  return rough_mass_kg(log.position_m, log.force_N, log.sample_rate_Hz,
                       log.encoder_resolution_m.value_or(0.0), {});
}

}  // namespace

std::vector<Interval> without_true_pulses(const Log& log, std::vector<Interval> pulses) {
  if (pulses.empty()) return pulses;
  const double noise_m =
      std::max(log.encoder_resolution_m.value_or(0.0) / std::sqrt(12.0), white_noise(log.position_m));
  std::vector<Pulse> known;
  known.reserve(pulses.size());
  for (const Interval& pulse : pulses)
    known.push_back({impulse(log, pulse), velocity_step(log, pulse, noise_m)});
  const double mass_kg = mass_of(log, known);
  if (!(mass_kg > 0.0)) return pulses;
  std::vector<Interval> faults;
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    if (!moves(known[i], mass_kg)) faults.push_back(pulses[i]);
  }
  return 2 * faults.size() < pulses.size() ? faults : pulses;
}

}  // namespace slipstack::workbench
