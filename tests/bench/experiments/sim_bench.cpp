// SPDX-License-Identifier: Apache-2.0
// How long the plant takes: per period of a sine, per event, per frequency response.
#include <benchmark/benchmark.h>

#include <numbers>

#include "sim_host/experiments/describing_function.h"
#include "sim_host/experiments/exact_parts.h"
#include "sim_host/experiments/loops.h"
#include "sim_host/experiments/stepped_sine.h"
#include "sim_host/plant/plant.h"
#include "sim_host/plant/smooth_axis.h"
#include "workbench/papers/parallel_sweeps.h"

namespace slipstack::sim {
namespace {

constexpr double kFrequency_Hz = 20.0;
constexpr double kTurn = 2.0 * std::numbers::pi;

// A period at 20 Hz of the pick-and-place axis, at a tenth of the given per cent of its saturation level.
void smooth_period(benchmark::State& state) {
  const ExperimentSetup setup = read_setup("pick_and_place");
  SmoothAxis axis(setup.axis, 0.0, {1e-7, 0.0});
  const double share = 0.01 * static_cast<double>(state.range(0));
  axis.set_force({0.0, share * setup.axis.curve.saturation_N(), kTurn * kFrequency_Hz, 0.0});
  double periods = 50.0;
  axis.advance_to(periods / kFrequency_Hz);
  const std::size_t before = axis.steps();
  for (auto _ : state) axis.advance_to(++periods / kFrequency_Hz);
  state.counters["steps"] =
      static_cast<double>(axis.steps() - before) / static_cast<double>(state.iterations());
}
BENCHMARK(smooth_period)->Arg(30)->Arg(100)->Arg(130);

void exact_period(benchmark::State& state) {
  const ExperimentSetup setup = read_setup("pick_and_place");
  ExactAxis axis(linear_part(setup, "bench"), maxwell_elements(setup));
  const double share = 0.01 * static_cast<double>(state.range(0));
  axis.set_force({0.0, share * setup.axis.curve.saturation_N(), kTurn * kFrequency_Hz, 0.0});
  double periods = 50.0;
  axis.advance_to(periods / kFrequency_Hz);
  const std::size_t before = axis.events();
  for (auto _ : state) axis.advance_to(++periods / kFrequency_Hz);
  state.counters["events"] =
      static_cast<double>(axis.events() - before) / static_cast<double>(state.iterations());
}
BENCHMARK(exact_period)->Arg(30)->Arg(100)->Arg(130);

void plant_tick(benchmark::State& state) {
  const ExperimentSetup setup = read_setup("pick_and_place");
  Plant plant(setup.axis, 0.2);
  double current_A = 0.1;
  std::size_t tick = 0;
  for (auto _ : state) {
    if (++tick % 100 == 0) current_A = -current_A;
    plant.step(current_A, 1e-4);
  }
}
BENCHMARK(plant_tick);

void frequency_responses(benchmark::State& state) {
  const ExperimentSetup setup = read_setup("pick_and_place");
  SteppedSineRequest request;
  request.forces_N = setup.defaults.forces_N;
  request.frequencies_Hz = log_frequencies(1.0, 100.0, 40);
  workbench::RunControl control;
  control.threads = static_cast<std::size_t>(state.range(0));
  for (auto _ : state) {
    std::vector<SweepChain> chains;
    workbench::run_sweeps(setup, request, chains, control);
    benchmark::DoNotOptimize(chains);
  }
}
BENCHMARK(frequency_responses)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

void describing_function(benchmark::State& state) {
  const ExperimentSetup setup = read_setup("pick_and_place");
  for (auto _ : state) benchmark::DoNotOptimize(describe_response(setup, 6.75, kFrequency_Hz));
}
BENCHMARK(describing_function)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace slipstack::sim

BENCHMARK_MAIN();
