// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/encoder_jumps.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "workbench/base/statistics.h"
#include "workbench/cleaning/recorder_faults.h"
#include "workbench/signal/white_noise.h"

namespace slipstack::workbench {
namespace {

/// Samples on either side through which the motion is a cubic, but for the jump between them.
constexpr std::size_t kSide = 6;
constexpr auto kWindow = static_cast<Eigen::Index>(2 * kSide);
using Window = Eigen::Matrix<double, kWindow, 1>;

/// A cubic with a step in its middle: how high the step is, and what both leave.
class StepFit {
 public:
  StepFit() {
    constexpr Eigen::Index kUnknowns = 5;
    Eigen::Matrix<double, kWindow, kUnknowns> columns;
    for (Eigen::Index i = 0; i < kWindow; ++i) {
      const double u = (static_cast<double>(i) + 0.5) / static_cast<double>(kSide) - 1.0;
      columns.row(i) << 1.0, u, u * u, u * u * u, (u > 0.0 ? 0.5 : -0.5);
    }
    const Eigen::Matrix<double, kUnknowns, kWindow> solve =
        (columns.transpose() * columns).inverse() * columns.transpose();
    step_ = solve.row(kUnknowns - 1).transpose();
    leave_ = Eigen::Matrix<double, kWindow, kWindow>::Identity() - columns * solve;
  }
  /// Of the window that begins at `x`.
  double step(const double* x) const { return step_.dot(centred(x)); }
  double left_rms(const double* x) const {
    return (leave_ * centred(x)).norm() / std::sqrt(static_cast<double>(kWindow));
  }

 private:
  /// Counts are large and steps small: digits would get lost.
  static Window centred(const double* x) { return Eigen::Map<const Window>(x).array() - x[kSide]; }

  Window step_;
  Eigen::Matrix<double, kWindow, kWindow> leave_;
};

/// A jump stands so many times above encoder steps and noise, ...
constexpr double kAboveNoise = 12.0;
/// ... leaves less than this share of it to the fit, as a quick move or a knock would not, ...
constexpr double kLeaves = 0.05;
/// ... is so many times any other within as many samples, ...
constexpr double kAmongOthers = 8.0;
constexpr std::size_t kNear = 60;
/// ... and needs so many times the acceleration that the axis reaches in all but this share of the time, and
/// than nine tenths of the measured forces would give its mass.
constexpr double kBeyondMotion = 3.0;
constexpr double kRareMotion = 1e-3;
constexpr double kUsualForce = 0.9;
/// More than this share of the samples: so the recorder writes them.
constexpr double kMost = 1e-3;

/// What this share of the values does not exceed; zero of none.
double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto rank = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  return value_at_rank(std::move(values), rank);
}

/// The way that the axis' own acceleration may make within a sample [m]: of what it reaches ...
double way_by_motion_m(const std::vector<double>& x) {
  std::vector<double> seconds;
  seconds.reserve(x.size());
  for (std::size_t i = 1; i + 1 < x.size(); ++i)
    seconds.push_back(std::abs(x[i + 1] - 2.0 * x[i] + x[i - 1]));
  return quantile(std::move(seconds), 1.0 - kRareMotion);
}

/// ... and of what its forces could give it; zero where no mass is declared.
double way_by_force_m(const Log& log) {
  if (log.mass_kg.value_or(0.0) <= 0.0) return 0.0;
  std::vector<double> forces;
  forces.reserve(log.force_N.size());
  for (const double force_N : log.force_N) forces.push_back(std::abs(force_N));
  return quantile(std::move(forces), kUsualForce) / *log.mass_kg / (log.sample_rate_Hz * log.sample_rate_Hz);
}

bool stands(const double* x, std::size_t count) {
  return std::all_of(x, x + count, [x](double value) { return value == *x; });
}

/// Whether what comes on either side of the jump is one motion: the axis moves on both, or rests on both,
/// came to rest as a mass does, and the force says nothing else.
bool one_motion(const Log& log, std::size_t sample) {
  const bool stands_before = stands(&log.position_m[sample - kSide], kSide);
  const bool stands_behind = stands(&log.position_m[sample], kSide);
  if (stands_before != stands_behind) return false;
  return !stands_before ||
         (log.mass_kg.value_or(0.0) > 0.0 && !stopped_dead(log, sample) && !force_shows_motion(log, sample));
}

}  // namespace

std::vector<EncoderJump> encoder_jumps(const Log& log) {
  const std::vector<double>& x = log.position_m;
  if (x.size() < 4 * kNear) return {};
  static const StepFit fit;
  const double step_m = log.encoder_resolution_m.value_or(0.0);
  const double least_m = std::max({kAboveNoise * std::max(step_m, white_noise(x)),
                                   kBeyondMotion * way_by_motion_m(x), kBeyondMotion * way_by_force_m(log)});
  if (!(least_m > 0.0)) return {};
  std::vector<EncoderJump> jumps;
  const auto step_at = [&](std::size_t sample) { return std::abs(fit.step(&x[sample - kSide])); };
  for (std::size_t i = kNear; i + kNear < x.size(); ++i) {
    const double jump_m = fit.step(&x[i - kSide]);
    if (std::abs(jump_m) < least_m || fit.left_rms(&x[i - kSide]) > kLeaves * std::abs(jump_m)) continue;
    double other_m = 0.0;
    for (std::size_t k = i + kSide - kNear; k + kSide <= i + kNear; ++k) {
      if (k + 2 * kSide <= i || k >= i + 2 * kSide) other_m = std::max(other_m, step_at(k));
    }
    if (std::abs(jump_m) < kAmongOthers * other_m || !one_motion(log, i)) continue;
    jumps.push_back({i, step_m > 0.0 ? step_m * std::round(jump_m / step_m) : jump_m});
  }
  if (static_cast<double>(jumps.size()) > kMost * static_cast<double>(x.size())) return {};
  return jumps;
}

void take_back(const std::vector<EncoderJump>& jumps, Log& log) {
  double sum_m = 0.0;
  std::size_t next = 0;
  for (std::size_t i = 0; i < log.position_m.size(); ++i) {
    if (next < jumps.size() && jumps[next].sample == i) sum_m += jumps[next++].jump_m;
    log.position_m[i] -= sum_m;
  }
}

}  // namespace slipstack::workbench
