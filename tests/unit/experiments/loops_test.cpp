// SPDX-License-Identifier: Apache-2.0
// Quasi-static loops: against the closed forms, by force and by displacement, along a rail.
#include <gtest/gtest.h>

#include <cmath>

#include "sim_host/experiments/describing_function.h"
#include "sim_host/experiments/loops.h"

namespace slipstack::sim {
namespace {

LoopRequest request_of(const ExperimentSetup& setup) {
  LoopRequest request;
  request.amplitudes = setup.defaults.loop_amplitudes_m;
  request.positions_m = setup.defaults.loop_positions_m;
  request.frequency_Hz = setup.defaults.loop_frequency_Hz;
  return request;
}

TEST(Loops, HaveTheFormsOfTheirVirginCurve) {
  for (const char* name : {"roller", "slideway", "slideway_loaded", "pick_and_place", "theory"}) {
    const ExperimentSetup setup = read_setup(name);
    for (const MeasuredLoop& loop : run_loops(setup, request_of(setup))) {
      const Equivalent expected = equivalent(setup.axis.curve, loop.asked);
      EXPECT_NEAR(loop.amplitude_m, loop.asked, 1e-3 * loop.asked) << name;
      EXPECT_NEAR(loop.force_amplitude_N, setup.axis.curve.force_N(loop.asked),
                  2e-3 * loop.force_amplitude_N);
      EXPECT_NEAR(loop.area_J, expected.area_J, 5e-3 * expected.area_J) << name << ' ' << loop.asked;
      EXPECT_NEAR(loop.damping_ratio, expected.resonance_damping_ratio,
                  5e-3 * expected.resonance_damping_ratio);
      EXPECT_NEAR(loop.stiffness_N_per_m, expected.tip_stiffness_N_per_m,
                  2e-3 * expected.tip_stiffness_N_per_m);
    }
  }
}

TEST(Loops, ByForceAndByDisplacementAreTheSame) {
  const ExperimentSetup setup = read_setup("slideway");
  LoopRequest request = request_of(setup);
  request.by_force = true;
  request.amplitudes = {1.0, 2.5, 4.0, 4.5};
  for (const MeasuredLoop& loop : run_loops(setup, request)) {
    EXPECT_NEAR(loop.force_amplitude_N, setup.axis.curve.force_N(loop.amplitude_m), 5e-3 * loop.asked);
    EXPECT_NEAR(loop.damping_ratio, loop.closed_form_damping_ratio, 0.01 * loop.closed_form_damping_ratio);
  }
}

// A preload that changes along the rail changes the loops and leaves ζᵣ ([2], four positions of a guideway).
TEST(Loops, DifferAlongTheRailWhileTheirDampingRatioDoesNot) {
  const ExperimentSetup setup = parse_setup(
      "based_on = \"pick_and_place\"\n[preload_map]\nkind = \"trend\"\ndepth = 0.2\n[defaults]\n"
      "loop_positions_m = [0.05, 0.15, 0.25, 0.35]\n",
      "test");
  const auto loops = run_loops(setup, request_of(setup));
  const std::size_t amplitudes = setup.defaults.loop_amplitudes_m.size();
  for (std::size_t k = 0; k < amplitudes; ++k) {
    double low_N = 1e9, high_N = 0.0, low_ratio = 1.0, high_ratio = 0.0;
    for (std::size_t p = 0; p < 4; ++p) {
      const MeasuredLoop& loop = loops[p * amplitudes + k];
      low_N = std::min(low_N, loop.force_amplitude_N);
      high_N = std::max(high_N, loop.force_amplitude_N);
      low_ratio = std::min(low_ratio, loop.damping_ratio);
      high_ratio = std::max(high_ratio, loop.damping_ratio);
    }
    EXPECT_GT(high_N, 1.3 * low_N);
    EXPECT_LT(high_ratio, 1.002 * low_ratio);
  }
}

TEST(Loops, SurviveEncoderAndNoise) {
  const ExperimentSetup setup = read_setup("slideway");
  LoopRequest request = request_of(setup);
  request.sensors = true;
  request.amplitudes = {1e-6, 5e-6};
  for (const MeasuredLoop& loop : run_loops(setup, request)) {
    EXPECT_NEAR(loop.damping_ratio, loop.closed_form_damping_ratio, 0.05 * loop.closed_form_damping_ratio);
    EXPECT_NE(loop.amplitude_m, loop.asked);
  }
}

TEST(Loops, RefuseWhatIsNotQuasiStaticOrDoesNotMove) {
  const ExperimentSetup setup = read_setup("pick_and_place");
  LoopRequest request = request_of(setup);
  request.frequency_Hz = 20.0;
  EXPECT_THROW(run_loops(setup, request), SetupError);
  request = request_of(setup);
  request.amplitudes = {0.0};
  EXPECT_THROW(run_loops(setup, request), SetupError);
  request.amplitudes = {0.1e-6};
  request.sensors = true;
  EXPECT_THROW(run_loops(setup, request), SetupError);
  request = request_of(setup);
  request.positions_m = {0.5};
  EXPECT_THROW(run_loops(setup, request), SetupError);
  request = request_of(setup);
  request.by_force = true;
  request.amplitudes = {13.0};
  EXPECT_THROW(run_loops(setup, request), SetupError);
}

}  // namespace
}  // namespace slipstack::sim
