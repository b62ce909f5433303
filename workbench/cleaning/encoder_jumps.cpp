// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/encoder_jumps.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "workbench/base/statistics.h"
#include "workbench/cleaning/recorder_faults.h"
#include "workbench/signal/noise_estimate.h"

namespace slipstack::workbench {
namespace {

/// Samples on either side of a possible jump; through all of them the motion is approximated by one cubic.
constexpr std::size_t kSide = 6;
constexpr auto kWindow = static_cast<Eigen::Index>(2 * kSide);
using Window = Eigen::Matrix<double, kWindow, 1>;

/// Least-squares fit of a cubic with a step in its middle: the height of the step and the residual.
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
    residual_maker_ = Eigen::Matrix<double, kWindow, kWindow>::Identity() - columns * solve;
  }
  /// Height of the step in the window that begins at `x`.
  double step(const double* x) const { return step_.dot(centred(x)); }
  /// Rms of the residual of the fit to the same window.
  double residual_rms(const double* x) const {
    return (residual_maker_ * centred(x)).norm() / std::sqrt(static_cast<double>(kWindow));
  }

 private:
  /// Relative to the middle sample: positions are large and steps small, so digits would be lost.
  static Window centred(const double* x) { return Eigen::Map<const Window>(x).array() - x[kSide]; }

  Window step_;
  Eigen::Matrix<double, kWindow, kWindow> residual_maker_;
};

// All thresholds are chosen, judged by tests/unit/cleaning: jumps are found, and no motion counts as one.

/// A jump is at least so many times the encoder step and the noise.
constexpr double kAboveNoise = 12.0;
/// The residual of the fit is at most this share of the jump; a quick move or a knock leaves more.
constexpr double kLargestResidual = 0.05;
/// The jump is so many times as high as any other step within kNear samples.
constexpr double kAboveOthers = 8.0;
constexpr std::size_t kNear = 60;
/// The jump is so many times the displacement that the axis' own acceleration makes within a sample: the
/// acceleration that it exceeds in kRareMotion of the samples only, and the one that nine tenths of the
/// measured forces would not exceed at its mass.
constexpr double kBeyondMotion = 3.0;
constexpr double kRareMotion = 1e-3;
constexpr double kUsualForce = 0.9;
/// Where more than this share of the samples qualify, the log records positions that way.
constexpr double kMostJumps = 1e-3;

/// The largest usual displacement by acceleration within one sample [m], from the measured motion.
double displacement_by_motion_m(const std::vector<double>& x) {
  std::vector<double> differences;
  differences.reserve(x.size());
  for (std::size_t i = 1; i + 1 < x.size(); ++i)
    differences.push_back(std::abs(x[i + 1] - 2.0 * x[i] + x[i - 1]));
  return quantile(std::move(differences), 1.0 - kRareMotion);
}

/// The same from the measured forces; zero where no mass is declared.
double displacement_by_force_m(const Log& log) {
  if (log.mass_kg.value_or(0.0) <= 0.0) return 0.0;
  std::vector<double> forces;
  forces.reserve(log.force_N.size());
  for (const double force_N : log.force_N) forces.push_back(std::abs(force_N));
  return quantile(std::move(forces), kUsualForce) / *log.mass_kg / (log.sample_rate_Hz * log.sample_rate_Hz);
}

bool constant(const double* x, std::size_t count) {
  return std::all_of(x, x + count, [x](double value) { return value == *x; });
}

/// Whether the motion before the jump continues after it: the axis moves on both sides, or stands still on
/// both, decelerated to the standstill as a mass does, and the force shows no motion during it.
bool one_motion(const Log& log, std::size_t sample) {
  const bool still_before = constant(&log.position_m[sample - kSide], kSide);
  const bool still_after = constant(&log.position_m[sample], kSide);
  if (still_before != still_after) return false;
  return !still_before ||
         (log.mass_kg.value_or(0.0) > 0.0 && !stopped_dead(log, sample) && !force_shows_motion(log, sample));
}

}  // namespace

std::vector<EncoderJump> encoder_jumps(const Log& log) {
  const std::vector<double>& x = log.position_m;
  if (x.size() < 4 * kNear) return {};
  static const StepFit fit;
  const double step_m = log.encoder_resolution_m.value_or(0.0);
  const double least_m =
      std::max({kAboveNoise * std::max(step_m, white_noise(x)), kBeyondMotion * displacement_by_motion_m(x),
                kBeyondMotion * displacement_by_force_m(log)});
  if (!(least_m > 0.0)) return {};
  std::vector<EncoderJump> jumps;
  const auto step_at = [&](std::size_t sample) { return std::abs(fit.step(&x[sample - kSide])); };
  for (std::size_t i = kNear; i + kNear < x.size(); ++i) {
    const double jump_m = fit.step(&x[i - kSide]);
    if (std::abs(jump_m) < least_m || fit.residual_rms(&x[i - kSide]) > kLargestResidual * std::abs(jump_m))
      continue;
    double other_m = 0.0;
    for (std::size_t k = i + kSide - kNear; k + kSide <= i + kNear; ++k) {
      if (k + 2 * kSide <= i || k >= i + 2 * kSide) other_m = std::max(other_m, step_at(k));
    }
    if (std::abs(jump_m) < kAboveOthers * other_m || !one_motion(log, i)) continue;
    jumps.push_back({i, step_m > 0.0 ? step_m * std::round(jump_m / step_m) : jump_m});
  }
  if (static_cast<double>(jumps.size()) > kMostJumps * static_cast<double>(x.size())) return {};
  return jumps;
}

void remove_jumps(const std::vector<EncoderJump>& jumps, Log& log) {
  double sum_m = 0.0;
  std::size_t next = 0;
  for (std::size_t i = 0; i < log.position_m.size(); ++i) {
    if (next < jumps.size() && jumps[next].sample == i) sum_m += jumps[next++].jump_m;
    log.position_m[i] -= sum_m;
  }
}

}  // namespace slipstack::workbench
