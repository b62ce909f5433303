// SPDX-License-Identifier: Apache-2.0
#include "workbench/frequency/rigid_mass.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace slipstack::workbench {

std::vector<ResponsePoint> rigid_mass_response(double mass_kg, double tick_s) {
  std::vector<ResponsePoint> points;
  for (double frequency_Hz = 2.0; frequency_Hz < 0.2 / tick_s; frequency_Hz *= 1.02) {
    const Complex z = std::polar(1.0, 2.0 * std::numbers::pi * frequency_Hz * tick_s);
    ResponsePoint point;
    point.frequency_Hz = frequency_Hz;
    point.plant = tick_s * tick_s / (2.0 * mass_kg) * (z + 1.0) / ((z - 1.0) * (z - 1.0));
    point.plant_sd = 1e-6 * std::abs(point.plant);
    points.push_back(point);
  }
  return points;
}

DriveController feedback_for_mass(double mass_kg, double tick_s, double observer_rad_per_s,
                                  const TuneRequest& request) {
  // Of these the loop is stable on any mass: velocity at 170 rad/s, position and integral at a quarter.
  DriveController usual;
  usual.tick_s = tick_s;
  usual.mass_kg = mass_kg;
  usual.observer_rad_per_s = observer_rad_per_s;
  usual.position_gain_per_s = 40.0;
  usual.velocity_gain_N_s_per_m = 170.0 * mass_kg;
  usual.integral_per_s = 40.0;
  TuneRequest bounded = request;
  bounded.largest_bandwidth_rad_per_s = std::min(request.largest_bandwidth_rad_per_s, observer_rad_per_s);
  const auto tuning = propose(rigid_mass_response(mass_kg, tick_s), usual, bounded);
  if (!tuning) throw std::logic_error("no feedback keeps the margin on a rigid mass");
  return tuning->gains;
}

}  // namespace slipstack::workbench
