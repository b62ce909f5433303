// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/characterize.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim_host/experiments/quasi_static.h"

namespace slipstack::workbench {
namespace {

/// Of the saturation: the loop just before rolling.
constexpr double kBeforeRolling = 0.85;
constexpr double kLeastStepsPerLoop = 20.0;

}  // namespace

LoopTest loop_test_of(const sim::ExperimentSetup& setup) {
  LoopTest test;
  test.amplitudes_m = setup.defaults.loop_amplitudes_m;
  std::sort(test.amplitudes_m.begin(), test.amplitudes_m.end());
  test.frequency_Hz = setup.defaults.loop_frequency_Hz;
  test.sample_rate_Hz = std::min(setup.sensors.sample_rate_Hz, 1000.0 * test.frequency_Hz);
  test.encoder_resolution_m = setup.sensors.encoder_resolution_m;
  test.force_noise_N = setup.sensors.force_noise_N;
  return test;
}

std::vector<AveragedLoop> characterize(const sim::VirginCurve& curve, const LoopTest& test) {
  sim::QuasiStaticTest run;
  run.frequency_Hz = test.frequency_Hz;
  run.sample_rate_Hz = test.sample_rate_Hz;
  run.encoder_resolution_m = test.encoder_resolution_m;
  run.force_noise_N = test.force_noise_N;
  run.seed = test.seed;
  double smallest_m = 0.0;
  double largest_m = 0.0;
  for (const double amplitude_m : test.amplitudes_m) {
    if (!(amplitude_m > 0.0)) throw std::invalid_argument("loops: amplitudes must be positive");
    if (2.0 * amplitude_m < kLeastStepsPerLoop * test.encoder_resolution_m) continue;
    if (run.forces_N.empty()) smallest_m = amplitude_m;
    run.forces_N.push_back(curve.force_N(amplitude_m));
    largest_m = amplitude_m;
  }
  if (run.forces_N.empty()) {
    throw std::invalid_argument(
        "loops: every amplitude is below what the encoder resolves; ask for larger ones");
  }
  const sim::MaxwellElements bank = sim::elements_between(curve, smallest_m, largest_m);
  const sim::QuasiStaticRecord record = sim::record_loops(bank, run);
  return averaged_loops(record.position_m, record.force_N);
}

std::vector<PreloadSeries> characterize_preloads(const sim::VirginCurve& curve, const LoopTest& test,
                                                 const std::vector<double>& preloads) {
  std::vector<PreloadSeries> series;
  for (const double preload : preloads) {
    if (!(preload > 0.0)) throw std::invalid_argument("preloads must be positive");
    LoopTest once = test;
    once.seed = test.seed + series.size();
    series.push_back({preload, characterize(scaled(curve, {std::sqrt(preload), 1.0}), once)});
  }
  return series;
}

sim::VirginCurve scaled(const sim::VirginCurve& curve, const Scaling& factors) {
  std::vector<sim::CurveTerm> terms = curve.terms();
  for (sim::CurveTerm& term : terms) {
    term.level_N *= factors.force;
    term.length_m *= factors.displacement;
    for (double& x : term.points_m) x *= factors.displacement;
    for (double& force : term.points_N) force *= factors.force;
  }
  return sim::VirginCurve(std::move(terms));
}

std::vector<GuidewayLoop> guideways_tried(const sim::VirginCurve& curve, const BallContact& reference,
                                          const LoopTest& test) {
  std::vector<BallContact> contacts;
  const auto vary = [&](double BallContact::*what, std::initializer_list<double> values) {
    for (const double value : values) {
      contacts.push_back(reference);
      contacts.back().*what = value;
    }
  };
  vary(&BallContact::load_per_ball_N, {10.0, 25.0, 55.0});
  vary(&BallContact::groove_angle_deg, {60.0, 90.0, 120.0});
  vary(&BallContact::ball_diameter_m, {1.5e-3, 6e-3});
  std::vector<GuidewayLoop> loops;
  for (const BallContact& contact : contacts) {
    const sim::VirginCurve its = scaled(curve, scaling(reference, contact));
    LoopTest once = test;
    once.amplitudes_m = {its.displacement_m(kBeforeRolling)};
    once.seed = test.seed + loops.size();
    loops.push_back({contact, characterize(its, once).back()});
  }
  return loops;
}

}  // namespace slipstack::workbench
