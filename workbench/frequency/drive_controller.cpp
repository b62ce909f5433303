// SPDX-License-Identifier: Apache-2.0
#include "workbench/frequency/drive_controller.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace slipstack::workbench {

Complex notch_response(const DriveNotch& notch, double tick_s, Complex z) {
  if (!(notch.frequency_Hz > 0.0)) return 1.0;
  const double w = std::tan(std::numbers::pi * notch.frequency_Hz * tick_s);
  const Complex s = (z - 1.0) / (z + 1.0);  // bilinear, the centre frequency kept
  const Complex rest = s * s + w * w;
  return (rest + 2.0 * notch.depth * notch.damping * w * s) / (rest + 2.0 * notch.damping * w * s);
}

FeedbackResponse::FeedbackResponse(const DriveController& drive, const std::vector<ResponsePoint>& at) {
  const double t = drive.tick_s;
  const double q = std::exp(-drive.observer_rad_per_s * t);
  const double p = 1.0 - q;
  const Eigen::Vector3d correction(1.0 - q * q * q, 1.5 * p * p * (1.0 + q) / t, p * p * p / (t * t));
  Eigen::Matrix3d predict;
  predict << 1.0, t, 0.5 * t * t, 0.0, 1.0, t, 0.0, 0.0, 1.0;
  const Eigen::Vector3d pushed(0.5 * t * t / drive.mass_kg, t / drive.mass_kg, 0.0);
  const Eigen::RowVector3d seen(1.0, 0.0, 0.0);
  const Eigen::Matrix3d kept = Eigen::Matrix3d::Identity() - correction * seen;
  const Eigen::Matrix3d step = kept * predict;
  const Eigen::Vector3d step_pushed = kept * pushed;
  for (const ResponsePoint& point : at) {
    Estimate estimate;
    estimate.z = std::exp(Complex(0.0, 2.0 * std::numbers::pi * point.frequency_Hz * t));
    const Eigen::Matrix3cd system = Eigen::Matrix3cd::Identity() - step.cast<Complex>() / estimate.z;
    const Eigen::PartialPivLU<Eigen::Matrix3cd> solver(system);
    const Eigen::Vector3cd by_counts = solver.solve(correction.cast<Complex>());
    const Eigen::Vector3cd by_force = solver.solve((step_pushed.cast<Complex>() / estimate.z).eval());
    for (int i = 0; i < 3; ++i) {
      const auto at_i = static_cast<std::size_t>(i);
      estimate.by_counts[at_i] = by_counts(i);
      estimate.by_force[at_i] = by_force(i);
    }
    estimates_.push_back(estimate);
  }
}

Complex FeedbackResponse::filter(const DriveController& gains, Complex z) {
  // The integral acts from the next tick on.
  Complex product = 1.0 + gains.integral_per_s * gains.tick_s / (z - 1.0);
  for (const DriveNotch& notch : gains.notch) product *= notch_response(notch, gains.tick_s, z);
  return product;
}

Complex FeedbackResponse::force(const DriveController& gains, const Estimate& at,
                                const std::array<Complex, 3>& state) {
  const double disturbance_kg = gains.disturbance_share * gains.mass_kg;
  return -gains.velocity_gain_N_s_per_m * filter(gains, at.z) *
             (gains.position_gain_per_s * state[0] + state[1]) -
         disturbance_kg * state[2];
}

std::vector<Complex> FeedbackResponse::of(const DriveController& gains) const {
  std::vector<Complex> found;
  found.reserve(estimates_.size());
  for (const Estimate& at : estimates_)
    found.push_back(-force(gains, at, at.by_counts) / (1.0 - force(gains, at, at.by_force)));
  return found;
}

std::vector<Complex> FeedbackResponse::of_reference(const DriveController& gains) const {
  std::vector<Complex> found;
  found.reserve(estimates_.size());
  const double stiffness = gains.velocity_gain_N_s_per_m * gains.position_gain_per_s;
  for (const Estimate& at : estimates_)
    found.push_back(stiffness * filter(gains, at.z) / (1.0 - force(gains, at, at.by_force)));
  return found;
}

}  // namespace slipstack::workbench
