// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/parallel_sweeps.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace slipstack::workbench {
namespace {

void expect_equal(const std::vector<sim::SweepChain>& a, const std::vector<sim::SweepChain>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].state, b[i].state);
    ASSERT_EQ(a[i].sweeps.size(), b[i].sweeps.size());
    for (std::size_t k = 0; k < a[i].sweeps.size(); ++k) {
      ASSERT_EQ(a[i].sweeps[k].points.size(), b[i].sweeps[k].points.size());
      for (std::size_t p = 0; p < a[i].sweeps[k].points.size(); ++p) {
        EXPECT_EQ(a[i].sweeps[k].points[p].amplitude_m, b[i].sweeps[k].points[p].amplitude_m);
        EXPECT_EQ(a[i].sweeps[k].points[p].phase_rad, b[i].sweeps[k].points[p].phase_rad);
        EXPECT_EQ(a[i].sweeps[k].points[p].jump, b[i].sweeps[k].points[p].jump);
      }
    }
  }
}

TEST(ParallelSweeps, DoNotDependOnThreadsNorOnWhereTheyWereStopped) {
  const sim::ExperimentSetup setup = sim::read_setup("roller");
  sim::SteppedSineRequest request;
  request.forces_N = {0.1, 0.125, 0.15, 0.2};
  request.frequencies_Hz = sim::log_frequencies(20.0, 90.0, 10);
  request.down = true;
  request.sensors = true;
  request.settled = 1e-3;
  std::vector<sim::SweepChain> whole;
  sim::run_stepped_sine(setup, request, whole);
  std::vector<sim::SweepChain> parallel;
  run_sweeps(setup, request, parallel, {.threads = 3});
  expect_equal(whole, parallel);
  std::vector<sim::SweepChain> chains;
  int runs = 0;
  do {
    // Stops after a few points, wherever that is.
    std::atomic<bool> stop{false};
    RunControl control;
    control.threads = 2;
    control.stop = &stop;
    int points = 0;
    control.progress = [&](double) {
      if (++points > 8 + runs) stop = true;
    };
    run_sweeps(setup, request, chains, control);
    ++runs;
  } while (!std::all_of(chains.begin(), chains.end(), [](const auto& chain) { return chain.complete; }) &&
           runs < 100);
  EXPECT_GT(runs, 3);
  expect_equal(whole, chains);
}

// Loops and describing functions: the same, in the same order.
TEST(ParallelSweeps, GiveTheLoopsOfASerialRun) {
  const sim::ExperimentSetup setup = sim::read_setup("roller");
  sim::LoopRequest request;
  request.amplitudes = setup.defaults.loop_amplitudes_m;
  request.positions_m = {setup.position_m};
  request.frequency_Hz = setup.defaults.loop_frequency_Hz;
  request.cycles = 2;
  const auto serial = sim::run_loops(setup, request);
  const auto parallel = measure_loops(setup, request, {.threads = 3});
  ASSERT_EQ(serial.size(), parallel.size());
  ASSERT_GT(serial.size(), 1U);
  for (std::size_t i = 0; i < serial.size(); ++i) {
    EXPECT_EQ(serial[i].asked, parallel[i].asked);
    EXPECT_EQ(serial[i].force_N, parallel[i].force_N);
  }
}

TEST(ParallelSweeps, DescribeEveryForceAtEveryFrequency) {
  const sim::ExperimentSetup setup = sim::read_setup("pick_and_place");
  sim::SteppedSineRequest request;
  request.forces_N = {1.0, 5.0};
  request.frequencies_Hz = {5.0, 10.0, 20.0};
  const auto responses = describe_responses(setup, request, {.threads = 2});
  ASSERT_EQ(responses.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(responses[i].size(), 3U);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(responses[i][k].frequency_Hz, request.frequencies_Hz[k]);
      EXPECT_EQ(responses[i][k].amplitude_m,
                sim::describe_response(setup, request.forces_N[i], request.frequencies_Hz[k]).amplitude_m);
    }
  }
}

}  // namespace
}  // namespace slipstack::workbench
