// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/feedback.h"

#include <algorithm>
#include <cmath>

#include "workbench/frequency/rigid_mass.h"

namespace slipstack::workbench {
namespace {

constexpr double kObserver_rad_per_s = 400.0;
// Of the limits that a motion is planned within; its spline through set-points goes a little beyond.
constexpr double kRoomForVelocity = 1.2;
constexpr double kRoomForAcceleration = 1.3;
constexpr double kRoomForJerk = 2.0;
constexpr double kFollowingError = 0.02;  // of the stroke

Feedback with_margins(const DriveController& gains) {
  const std::vector<ResponsePoint> plant = rigid_mass_response(gains.mass_kg, gains.tick_s);
  std::vector<double> frequency_Hz;
  frequency_Hz.reserve(plant.size());
  for (const ResponsePoint& point : plant) frequency_Hz.push_back(point.frequency_Hz);
  return {gains, margins_of(frequency_Hz, loop_of(plant, FeedbackResponse(gains, plant).of(gains)))};
}

}  // namespace

Feedback full_feedback(double mass_kg, double tick_s) {
  return with_margins(feedback_for_mass(mass_kg, tick_s, kObserver_rad_per_s, {}));
}

Feedback part_of(const Feedback& full, double share) {
  DriveController gains = full.gains;
  gains.position_gain_per_s *= share;
  gains.velocity_gain_N_s_per_m *= share;
  gains.integral_per_s *= share;
  return with_margins(gains);
}

DriveSettings settings_of(const Feedback& feedback, const AxisLimits& limits, double force_limit_N) {
  const DriveController& gains = feedback.gains;
  DriveSettings settings;
  settings.mass_kg = gains.mass_kg;
  settings.observer_rad_per_s = gains.observer_rad_per_s;
  settings.position_gain_per_s = gains.position_gain_per_s;
  settings.velocity_gain_N_s_per_m = gains.velocity_gain_N_s_per_m;
  settings.integral_per_s = gains.integral_per_s;
  settings.force_limit_N = force_limit_N;
  settings.following_error_m = std::clamp(kFollowingError * limits.stroke_m(), 2e-3, 10e-3);
  settings.velocity_limit_mps = kRoomForVelocity * limits.velocity_mps;
  settings.acceleration_limit_mps2 = kRoomForAcceleration * limits.acceleration_mps2;
  settings.jerk_limit_mps3 = kRoomForJerk * limits.jerk_mps3;
  return settings;
}

bool is_steady(const AxisRecord& record, double from_s, double to_s, double most_N) {
  const auto first = static_cast<std::size_t>(from_s * record.rate_Hz);
  const auto end = static_cast<std::size_t>(to_s * record.rate_Hz);
  if (!record.fault.empty() || end > record.force_N.size() || end <= first) return false;
  const auto count = static_cast<double>(end - first);
  double mean_N = 0.0;
  for (std::size_t i = first; i < end; ++i) mean_N += record.force_N[i] / count;
  double squares = 0.0;
  for (std::size_t i = first; i < end; ++i)
    squares += (record.force_N[i] - mean_N) * (record.force_N[i] - mean_N);
  return std::sqrt(squares / count) < most_N;
}

}  // namespace slipstack::workbench
