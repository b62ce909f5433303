// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/step_response.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "sim_host/plant/smooth_axis.h"
#include "sim_host/turn.h"

namespace slipstack::sim {
namespace {

constexpr std::size_t kSamples = 1000;
/// Swings below this share of the first are below the noise of any sensor.
constexpr double kSmallestOvershoot = 1e-3;

void check(const ExperimentSetup& setup, double force_N, double duration_s) {
  if (!(std::isfinite(force_N) && force_N > 0.0)) {
    throw SetupError(fmt::format("a step of {:g} N cannot move the axis; give a positive force", force_N));
  }
  const double limit_N = setup.axis.current_limit_A * setup.axis.motor_constant_N_per_A;
  if (force_N > limit_N) {
    throw SetupError(fmt::format("the drive of {} gives at most {:g} N, not {:g}; lower the step", setup.name,
                                 limit_N, force_N));
  }
  if (force_N >= setup.axis.curve.saturation_N()) {
    throw SetupError(fmt::format(
        "a step of {:g} N is beyond the friction's level of {:g} N: the axis slides away and does "
        "not ring; give less",
        force_N, setup.axis.curve.saturation_N()));
  }
  if (!(std::isfinite(duration_s) && duration_s > 0.0))
    throw SetupError("a step response needs a time above 0 s");
}

void read_ring(StepResponse& out) {
  std::vector<RingReversal>& points = out.turning_points;
  for (std::size_t i = 1; i < points.size(); ++i) {
    points[i].frequency_Hz = 0.5 / (points[i].time_s - points[i - 1].time_s);
    if (i < 2) continue;
    const double before = std::fabs(points[i - 1].position_m - points[i - 2].position_m);
    const double after = std::fabs(points[i].position_m - points[i - 1].position_m);
    const double decrement = std::log(before / after);  // of half a period
    points[i].damping_ratio = decrement / std::hypot(std::numbers::pi, decrement);
  }
  if (points.size() >= 3) {
    out.ring_Hz = 1.0 / (points[2].time_s - points[0].time_s);
    out.small_Hz = 1.0 / (points.back().time_s - points[points.size() - 3].time_s);
  }
}

}  // namespace

StepResponse run_step(const ExperimentSetup& setup, double force_N, double duration_s) {
  check(setup, force_N, duration_s);
  SmoothAxis::Options options;
  options.tolerance = 1e-10;
  SmoothAxis axis(setup.axis, setup.position_m, options);
  axis.set_force({force_N, 0.0, 0.0, 0.0});
  StepResponse out;
  out.force_N = force_N;
  const double step_s = duration_s / static_cast<double>(kSamples);
  bool ringing = true;
  for (std::size_t i = 0; i <= kSamples; ++i) {
    const double to_s = static_cast<double>(i) * step_s;
    while (axis.advance_to_reversal(to_s)) {
      if (!ringing) continue;
      const RingReversal point{axis.time_s(), axis.position_m() - setup.position_m, 0.0, 0.0};
      if (out.turning_points.size() >= 3) {
        const double first = std::fabs(out.turning_points[1].position_m - out.turning_points[0].position_m);
        ringing =
            std::fabs(point.position_m - out.turning_points.back().position_m) > kSmallestOvershoot * first;
      }
      if (ringing) out.turning_points.push_back(point);
    }
    out.time_s.push_back(to_s);
    out.position_m.push_back(axis.position_m() - setup.position_m);
  }
  read_ring(out);
  const double mass_kg = setup.axis.mass_kg + setup.axis.effects.payload_kg.value_or(0.0);
  const VirginCurve& curve = setup.axis.curve;
  const double hair_m = 1e-6 * curve.travel_m();
  out.curve_Hz = std::sqrt(curve.force_N(hair_m) / hair_m / mass_kg) / kTurn;
  const double seen_m = std::max(2.0 * setup.sensors.encoder_resolution_m, 0.02 * curve.travel_m());
  out.differentiated_Hz = std::sqrt(curve.force_N(seen_m) / seen_m / mass_kg) / kTurn;
  return out;
}

}  // namespace slipstack::sim
