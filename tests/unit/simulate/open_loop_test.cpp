// SPDX-License-Identifier: Apache-2.0
#include "workbench/simulate/open_loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "sim_host/log/closed_loop.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/simulate/set_points.h"

namespace slipstack::workbench {
namespace {

constexpr double kMass_kg = 20.0;
constexpr double kViscous_N_s_per_m = 60.0;
constexpr double kForce_N = 30.0;
constexpr double kRate_rad_per_s = 5.0;

/// x of m x'' + c x' = F cos(w t), the stationary solution: closed form.
double position_m(double t_s) {
  const double inertia = -kMass_kg * kRate_rad_per_s * kRate_rad_per_s;
  const double drag = kViscous_N_s_per_m * kRate_rad_per_s;
  const double size = kForce_N / (inertia * inertia + drag * drag);
  return size * (inertia * std::cos(kRate_rad_per_s * t_s) + drag * std::sin(kRate_rad_per_s * t_s));
}

Log analytic_log() {
  Log log;
  log.sample_rate_Hz = 1000.0;
  log.mass_kg = kMass_kg;
  for (int i = 0; i < 8000; ++i) {
    const double t_s = 1e-3 * i;
    log.position_m.push_back(position_m(t_s));
    log.force_N.push_back(kForce_N * std::cos(kRate_rad_per_s * t_s));
  }
  return log;
}

Terms mass_and_drag(const Measurement& measurement) {
  Terms terms{make_term(measurement, *find_effect("inertia")),
              make_term(measurement, *find_effect("viscous"))};
  terms[0].gains[0] = kMass_kg;
  terms[1].gains[0] = kViscous_N_s_per_m;
  return terms;
}

TEST(OpenLoop, FollowsTheClosedFormOfMassAndDrag) {
  const Measurement measurement(analytic_log());
  const Terms terms = mass_and_drag(measurement);
  // From the middle of the log, since the smoothed velocity is least accurate at its ends.
  const OpenLoop found =
      simulate_open_loop(measurement, terms, {.start_s = 1.0, .end_s = 7.0, .progress = {}});
  EXPECT_EQ(found.position_m.size(), 6001u);
  EXPECT_LT(found.rmse_m, 2e-3 * std::abs(position_m(0.0)));
  EXPECT_GT(found.fit, 0.99);
  // With half the drag it must not follow: the test can fail.
  Terms wrong = terms;
  wrong[1].gains[0] *= 0.5;
  EXPECT_GT(simulate_open_loop(measurement, wrong, {.start_s = 1.0, .end_s = 7.0, .progress = {}}).rmse_m,
            20.0 * found.rmse_m);
}

TEST(OpenLoop, RefusesWhatCannotBeSimulated) {
  const Measurement measurement(analytic_log());
  Terms terms = mass_and_drag(measurement);
  EXPECT_THROW(simulate_open_loop(measurement, terms, {.start_s = 7.999, .end_s = 7.999, .progress = {}}),
               std::invalid_argument);
  terms.erase(terms.begin());
  EXPECT_THROW(simulate_open_loop(measurement, terms), std::invalid_argument);
}

/// A model with the mass and the elements of the plant follows the plant: hysteresis holds the axis at
/// standstill, and the integration adds no error of its own.
TEST(OpenLoop, FollowsThePlantWithItsOwnParameters) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 5);
  bench.axis.elements = 30;
  bench.axis.force_noise_N = 0.0;
  bench.axis.encoder_resolution_m = 1e-9;
  bench.programme.seconds = 10.0;
  bench.rate_Hz = 5000.0;
  sim::Rng motion(5, "motion");
  const sim::MotionProgramme programme = sim::make_test_programme(bench.axis, bench.programme, motion);
  const sim::SimulatedLog log = sim::simulate_closed_loop_log(bench.axis, programme, bench.rate_Hz, 5);
  const Measurement measurement(test::log_of(bench.axis, log));
  const OpenLoop found = simulate_open_loop(measurement, test::truth_of(measurement, bench.axis));
  EXPECT_GT(found.fit, 0.95);
  EXPECT_LT(found.rmse_m, 3e-3) << "largest " << found.largest_m;
}

TEST(ForceAlong, IsMassTimesAccelerationPlusFriction) {
  const Measurement measurement(analytic_log());
  const Terms terms = mass_and_drag(measurement);
  SetPoints points;
  for (int i = 0; i < 500; ++i) {
    const double t_s = 1e-3 * i;
    points.position_m.push_back(0.1 * std::sin(3.0 * t_s));
    points.velocity_mps.push_back(0.3 * std::cos(3.0 * t_s));
    points.acceleration_mps2.push_back(-0.9 * std::sin(3.0 * t_s));
  }
  const std::vector<double> force_N = force_along(points, terms);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(force_N[i],
                kMass_kg * points.acceleration_mps2[i] + kViscous_N_s_per_m * points.velocity_mps[i], 1e-9);
  }
}

}  // namespace
}  // namespace slipstack::workbench
