// SPDX-License-Identifier: Apache-2.0
// The motion of a measurement: smooth position and its derivatives, the displacement that drives the
// hysteresis, and its turning points.
#include <algorithm>
#include <array>
#include <cmath>

#include "workbench/estimate/measurement/conditioning.h"
#include "workbench/estimate/measurement/measurement.h"
#include "workbench/signal/zero_phase.h"

namespace slipstack::workbench {
namespace {

/// The hysteresis is driven by the unfiltered displacement where the log has an encoder's grid: a filter with
/// a steep edge overshoots by nanometres where a movement ends, and to hysteresis that is a reversal.
/// Readings without a grid contain noise instead, which causes reversals too; the taps below are all positive
/// and add none of their own.
constexpr std::array<double, 5> kDisplacementTaps{1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0};

/// A cubic follows the motion over this fraction of a period of the force's bandwidth. Chosen.
constexpr double kFollowed = 0.25;

/// The turning points of all parts, in the order of time.
std::vector<TurningPoint> turning_points_of(const std::vector<double>& displacement_m,
                                            const std::vector<LogPart>& parts, double beyond_corners) {
  std::vector<TurningPoint> found;
  for (const LogPart& part : parts) {
    find_turning_points(displacement_m, {part.first_sample, part.end_sample()}, part.encoder_resolution_m,
                        beyond_corners, found);
  }
  return found;
}

/// Positions as an encoder reads them whose grid is shifted by a share of a step.
std::vector<double> quantised(std::span<const double> position_m, double step_m, double shift_steps) {
  std::vector<double> reading_m(position_m.size());
  std::transform(position_m.begin(), position_m.end(), reading_m.begin(), [&](double x) {
    return (std::floor(x / step_m + shift_steps) + 0.5 - shift_steps) * step_m;
  });
  return reading_m;
}

}  // namespace

void Measurement::estimate_motion() {
  const double rate = sample_rate_Hz();
  const std::vector<double> taps = motion_taps(bandwidth_Hz_, rate);
  const bool several = parts_.size() > 1;
  const auto append = [several](std::vector<double>& all, std::vector<double> more) {
    if (several) {
      all.insert(all.end(), more.begin(), more.end());
    } else {
      all = std::move(more);
    }
  };
  Motion motion;
  if (several) {
    for (auto* all : {&displacement_m_, &motion.position_m, &motion.velocity_mps, &motion.acceleration_mps2})
      all->reserve(sample_count());
  }
  for (const LogPart& part : parts_) {
    const std::span<const double> reading_m =
        std::span(log_->position_m).subspan(part.first_sample, part.sample_count);
    std::vector<double> position_m = interpolate_between_steps(reading_m, part.encoder_resolution_m);
    std::vector<double> smooth_m = filter_all(position_m, taps);
    append(displacement_m_, part.encoder_resolution_m > 0.0 ? std::move(position_m)
                                                            : filter_all(position_m, kDisplacementTaps));
    append(motion.velocity_mps, first_derivative(smooth_m, rate));
    append(motion.acceleration_mps2, second_derivative(smooth_m, rate));
    append(motion.position_m, std::move(smooth_m));
  }
  motion.range_m = value_range(motion.position_m);
  motion_ = std::make_shared<const Motion>(std::move(motion));
  turning_points_ = turning_points_of(displacement_m_, parts_, 0.0);
}

std::span<const TurningPoint> Measurement::turning_points(std::size_t first, std::size_t count) const {
  const auto at = [&](std::size_t sample) {
    return std::lower_bound(turning_points_.begin(), turning_points_.end(), sample,
                            [](const TurningPoint& point, std::size_t s) { return point.before_sample < s; });
  };
  return {at(first), at(first + count)};
}

Measurement Measurement::with_realisation(const EncoderRealisation& other) const {
  Measurement copy = *this;
  UnobservedMotion unobserved = other.unobserved;
  unobserved.longest_known = kFollowed * sample_rate_Hz() / bandwidth_Hz_;
  for (const LogPart& part : parts_) {
    const double step_m = part.encoder_resolution_m;
    if (step_m <= 0.0) continue;
    const std::span<const double> own_m =
        std::span(displacement_m_).subspan(part.first_sample, part.sample_count);
    const std::vector<double> displacement_m =
        interpolate_between_steps(quantised(own_m, step_m, other.shift_steps), step_m, unobserved);
    std::copy(displacement_m.begin(), displacement_m.end(),
              copy.displacement_m_.begin() + static_cast<std::ptrdiff_t>(part.first_sample));
  }
  copy.turning_points_ = turning_points_of(copy.displacement_m_, parts_, other.beyond_corners);
  return copy;
}

std::vector<double> Measurement::rounding_m(double shift_steps) const {
  const std::vector<double> taps = motion_taps(bandwidth_Hz_, sample_rate_Hz());
  std::vector<double> rounding_m(sample_count(), 0.0);
  for (const LogPart& part : parts_) {
    const double step_m = part.encoder_resolution_m;
    if (step_m <= 0.0) continue;
    const std::span<const double> own_m =
        std::span(motion_->position_m).subspan(part.first_sample, part.sample_count);
    std::vector<double> error_m = interpolate_between_steps(quantised(own_m, step_m, shift_steps), step_m);
    for (std::size_t i = 0; i < error_m.size(); ++i) error_m[i] -= own_m[i];
    error_m = filter_all(error_m, taps);
    std::copy(error_m.begin(), error_m.end(),
              rounding_m.begin() + static_cast<std::ptrdiff_t>(part.first_sample));
  }
  return rounding_m;
}

Measurement Measurement::with_motion(std::vector<double> position_m, std::vector<double> force_N) const {
  Measurement copy = *this;
  Motion motion;
  for (const LogPart& part : parts_) {
    const std::vector<double> own_m = part_of(position_m, part);
    const std::vector<double> own_mps = first_derivative(own_m, sample_rate_Hz());
    const std::vector<double> own_mps2 = second_derivative(own_m, sample_rate_Hz());
    motion.velocity_mps.insert(motion.velocity_mps.end(), own_mps.begin(), own_mps.end());
    motion.acceleration_mps2.insert(motion.acceleration_mps2.end(), own_mps2.begin(), own_mps2.end());
  }
  motion.position_m = position_m;
  motion.range_m = value_range(motion.position_m);
  copy.motion_ = std::make_shared<const Motion>(std::move(motion));
  copy.displacement_m_ = std::move(position_m);
  copy.turning_points_.clear();  // the motion is smooth: it reverses at the samples
  Log log = *log_;
  log.force_N = std::move(force_N);
  copy.log_ = std::make_shared<const Log>(std::move(log));
  copy.recorded_force_N_ = std::make_shared<const Eigen::VectorXd>(copy.filtered(copy.log_->force_N));
  return copy;
}

}  // namespace slipstack::workbench
