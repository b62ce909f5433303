// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/mass.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/commission/axes.h"

namespace slipstack::workbench {
namespace {

// A mass with dry friction of one level, in closed form.
AxisRecord pulse_of(double mass_kg, double friction_N, double force_N, double seconds, double step_m) {
  AxisRecord record;
  record.rate_Hz = 10000.0;
  const double a1 = (force_N - friction_N) / mass_kg;
  const double a2 = -(force_N + friction_N) / mass_kg;
  const double turn_s = -a1 * seconds / a2;
  for (int i = 0; static_cast<double>(i) / record.rate_Hz < seconds + turn_s + 1e-3; ++i) {
    const double t = static_cast<double>(i) / record.rate_Hz;
    const double u = std::max(0.0, t - seconds);
    const double x =
        t < seconds ? 0.5 * a1 * t * t : 0.5 * a1 * seconds * seconds + a1 * seconds * u + 0.5 * a2 * u * u;
    record.position_m.push_back(std::round((0.3 + x) / step_m) * step_m);
    record.force_N.push_back(t < seconds ? force_N : -force_N);
  }
  return record;
}

TEST(PulseResult, TellsMassAndFrictionApart) {
  for (const double mass_kg : {1.0, 8.0, 60.0}) {
    for (const double friction_N : {0.0, 3.0, 20.0}) {
      for (const double sign : {1.0, -1.0}) {
        const double force_N = friction_N * 1.6 + 0.6 * mass_kg;
        AxisRecord record = pulse_of(mass_kg, friction_N, force_N, 0.04, 1e-7);
        for (double& x : record.position_m) x = 0.3 + sign * (x - 0.3);
        const PulseResult found = result_of_pulse(record, sign * force_N, 0.04, 1e-7);
        EXPECT_NEAR(found.mass_kg, mass_kg, 0.02 * mass_kg) << friction_N;
        EXPECT_NEAR(found.friction_N, friction_N, 0.03 * force_N);
        EXPECT_LT(std::fabs(found.mass_kg - mass_kg), 5.0 * found.mass_error_kg);
      }
    }
  }
}

TEST(PulseResult, SaysNothingOfAnAxisThatHardlyMoves) {
  const AxisRecord little = pulse_of(60.0, 9.0, 10.0, 0.04, 1e-6);
  const PulseResult found = result_of_pulse(little, 10.0, 0.04, 1e-6);
  EXPECT_EQ(found.mass_kg, 0.0);
  EXPECT_LT(found.moved_m, 100e-6);
  AxisRecord broken = little;
  broken.position_m.resize(100);  // ended early
  EXPECT_EQ(result_of_pulse(broken, 10.0, 0.04, 1e-6).mass_kg, 0.0);
}

// On axes of the simulator, with hysteresis, encoder and noise.
TEST(PulseResult, FindsTheMassOfDrawnAxes) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U}) {
    const sim::Axis axis = sim::draw_bench(sim::Setup::kRandom, seed).axis;
    const auto live = host_axis({.axis = axis, .seed = seed});
    ASSERT_EQ(live->check_direction(), LiveAxis::Direction::kRight) << seed;
    PulseResult found;
    const double most_N = live->nameplate().force_limit_N();
    for (double force_N = 0.02 * most_N; force_N < 0.5 * most_N && found.mass_kg == 0.0; force_N *= 1.4) {
      const AxisRecord record = live->pulse(force_N, 0.04);
      ASSERT_EQ(record.fault, "") << seed;
      found = result_of_pulse(record, force_N, 0.04, axis.encoder_resolution_m);
    }
    EXPECT_NEAR(found.mass_kg, axis.mass_kg, 0.15 * axis.mass_kg) << seed;
  }
}

}  // namespace
}  // namespace slipstack::workbench
