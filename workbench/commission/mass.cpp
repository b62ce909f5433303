// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/mass.h"
#include "workbench/base/linear_systems.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace slipstack::workbench {
namespace {

// The motion is sliding, and the encoder's step small against it.
constexpr double kLeastMotion_m = 100e-6;
constexpr double kFewestSteps = 100.0;
constexpr std::size_t kFewestSamples = 30;
constexpr double kSettled = 0.3;  // of the first half: the friction has reached its level
constexpr double kTurned = 0.05;  // of the second half: the force has turned round

struct Parabola {
  double acceleration = 0.0;
  double error = 0.0;
};

Parabola parabola(const std::vector<double>& position_m, std::size_t first, std::size_t end, double rate_Hz,
                  double resolution_m) {
  const auto count = static_cast<Eigen::Index>(end - first);
  Eigen::MatrixXd columns(count, 3);
  Eigen::VectorXd values(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / rate_Hz;
    columns.row(i) << 1.0, t, 0.5 * t * t;
    values[i] = position_m[first + static_cast<std::size_t>(i)] - position_m[first];
  }
  const Eigen::VectorXd found = solve_least_squares(columns, values);
  const double left = (values - columns * found).squaredNorm() / static_cast<double>(count - 3);
  const double variance = std::max(left, resolution_m * resolution_m / 12.0);
  const Eigen::Matrix3d normal = columns.transpose() * columns;
  const Eigen::Matrix3d covariance = normal.inverse();
  return {found[2], std::sqrt(variance * covariance(2, 2))};
}

}  // namespace

PulseResult result_of_pulse(const AxisRecord& record, double force_N, double seconds,
                            double encoder_resolution_m) {
  PulseResult result;
  if (record.pulse_s > 0.0) {
    seconds = record.pulse_s;
    force_N = record.pulse_N;
  }
  const std::vector<double>& x = record.position_m;
  const auto half = static_cast<std::size_t>(std::lround(seconds * record.rate_Hz));
  if (x.size() <= half) return result;
  const double sign = force_N < 0.0 ? -1.0 : 1.0;
  result.moved_m = sign * (x[half] - x.front());
  if (result.moved_m < std::max(kLeastMotion_m, kFewestSteps * encoder_resolution_m)) return result;
  const auto furthest = std::max_element(x.begin() + static_cast<std::ptrdiff_t>(half), x.end(),
                                         [&](double a, double b) { return sign * a < sign * b; });
  const auto turn = static_cast<std::size_t>(furthest - x.begin());
  const auto settled = static_cast<std::size_t>(kSettled * static_cast<double>(half));
  const auto against = half + static_cast<std::size_t>(kTurned * static_cast<double>(half));
  if (turn < against + kFewestSamples || half < settled + kFewestSamples) return result;
  const Parabola ahead = parabola(x, settled, half, record.rate_Hz, encoder_resolution_m);
  const Parabola braked = parabola(x, against, turn, record.rate_Hz, encoder_resolution_m);
  const double difference = sign * (ahead.acceleration - braked.acceleration);
  if (!(difference > 0.0)) return result;
  const double mass_kg = 2.0 * std::fabs(force_N) / difference;
  result.mass_error_kg = mass_kg * std::hypot(ahead.error, braked.error) / difference;
  result.friction_N = std::max(0.0, -0.5 * mass_kg * sign * (ahead.acceleration + braked.acceleration));
  result.mass_kg = mass_kg;
  return result;
}

}  // namespace slipstack::workbench
