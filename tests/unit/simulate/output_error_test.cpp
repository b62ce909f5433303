// SPDX-License-Identifier: Apache-2.0
#include "workbench/simulate/output_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "workbench/base/errors.h"
#include "workbench/estimate/terms/terms.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/simulate/run_intervals.h"
#include "workbench/simulate/two_criteria.h"

namespace slipstack::workbench {
namespace {

constexpr double kTrueMass_kg = 8.0;
constexpr double kTrueViscous_N_s_per_m = 30.0;
constexpr double kTrueCoulomb_N = 5.0;
constexpr double kTrueOffset_N = 1.5;
constexpr double kSampling_Hz = 500.0;

/// An axis of known parameters, driven by a force of several frequencies, integrated by Runge and Kutta in
/// steps a hundred times shorter than a sample; its position is read with white noise.
Log noisy_log(double noise_m, std::uint64_t seed, double seconds = 20.0) {
  constexpr int kSteps = 100;
  const double step_s = 1.0 / kSampling_Hz / kSteps;
  const auto force_N = [](double t) {
    return 25.0 * std::sin(5.0 * t) + 18.0 * std::sin(11.3 * t + 1.0) + 12.0 * std::sin(23.7 * t + 2.0) +
           kTrueOffset_N;
  };
  const auto acceleration = [&](double t, double v) {
    const double dry_N = kTrueCoulomb_N * std::tanh(v / 1e-4);
    return (force_N(t) - kTrueViscous_N_s_per_m * v - dry_N - kTrueOffset_N) / kTrueMass_kg;
  };
  Log log;
  log.sample_rate_Hz = kSampling_Hz;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, noise_m);
  double x_m = 0.0;
  double v_mps = 0.0;
  for (int i = 0; i < static_cast<int>(seconds * kSampling_Hz); ++i) {
    const double start_s = i / kSampling_Hz;
    log.position_m.push_back(x_m + noise(random));
    log.force_N.push_back(force_N(start_s));
    for (int k = 0; k < kSteps; ++k) {
      const double t = start_s + k * step_s;
      const double middle = v_mps + 0.5 * step_s * acceleration(t, v_mps);
      const double next = v_mps + step_s * acceleration(t + 0.5 * step_s, middle);
      x_m += 0.5 * step_s * (v_mps + next);
      v_mps = next;
    }
  }
  return log;
}

FittedModel by_inverse_dynamics(const Measurement& measurement) {
  return with_standard_errors(
      measurement, fit_effects(measurement, {"inertia", "coulomb", "viscous", "offset_force"}, {}));
}

double gain(const Terms& terms, const char* id) {
  return find_term(terms, id)->gains[0];
}

/// Noise of the position in the regressors biases a fit by inverse dynamics; its mean over seeds does not
/// vanish. That of the fit by simulation does, within what the scatter allows.
TEST(OutputError, RemovesTheBiasOfNoisyVelocity) {
  double mass_before = 0.0;
  double mass_after = 0.0;
  double viscous_after = 0.0;
  constexpr int kSeeds = 3;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Measurement measurement(noisy_log(1e-3, static_cast<std::uint64_t>(seed)));
    const FittedModel start = by_inverse_dynamics(measurement);
    OutputErrorFit fit(measurement, start, run_intervals("log", measurement, start.terms, 2.0));
    EXPECT_TRUE(fit.run());
    mass_before += gain(start.terms, "inertia") / kSeeds;
    mass_after += gain(fit.terms(), "inertia") / kSeeds;
    viscous_after += gain(fit.terms(), "viscous") / kSeeds;
  }
  EXPECT_GT(std::abs(mass_before / kTrueMass_kg - 1.0), 0.02);
  EXPECT_LT(std::abs(mass_after / kTrueMass_kg - 1.0), 0.004);
  EXPECT_LT(std::abs(viscous_after / kTrueViscous_N_s_per_m - 1.0), 0.02);
}

TEST(OutputError, FindsTheTruthWithoutNoiseFromAWrongStart) {
  const Measurement measurement(noisy_log(1e-8, 3));
  FittedModel start = by_inverse_dynamics(measurement);
  start.terms[0].gains[0] *= 1.1;
  start.terms[2].gains[0] *= 0.8;
  OutputErrorFit fit(measurement, start, run_intervals("log", measurement, start.terms, 1.0));
  EXPECT_TRUE(fit.run());
  EXPECT_NEAR(gain(fit.terms(), "inertia"), kTrueMass_kg, 2e-3 * kTrueMass_kg);
  EXPECT_NEAR(gain(fit.terms(), "viscous"), kTrueViscous_N_s_per_m, 5e-3 * kTrueViscous_N_s_per_m);
  EXPECT_NEAR(gain(fit.terms(), "coulomb"), kTrueCoulomb_N, 1e-2 * kTrueCoulomb_N);
  EXPECT_NEAR(gain(fit.terms(), "offset_force"), kTrueOffset_N, 0.02);
}

TEST(OutputError, IsJudgedBesideTheInverseDynamics) {
  const Measurement measurement(noisy_log(1e-3, 7));
  const SimulationFit both =
      fit_by_simulation("log", measurement, by_inverse_dynamics(measurement), 2.0, [](double) {});
  EXPECT_TRUE(both.converged);
  EXPECT_EQ(both.parameters, 4u);
  EXPECT_LT(both.simulation.held_out_position_m, both.inverse_dynamics.held_out_position_m);
  // A fit that has not seen the data does not do better there, and not much worse with four parameters.
  EXPECT_GT(both.inverse_dynamics.held_out_force_N, 0.97 * both.inverse_dynamics.force_N);
  EXPECT_LT(both.inverse_dynamics.held_out_force_N, 1.2 * both.inverse_dynamics.force_N);
  EXPECT_GT(both.simulation.held_out_force_N, 0.97 * both.simulation.force_N);
  // Its own criterion is the minimum of each in sample.
  EXPECT_LE(both.inverse_dynamics.force_N, both.simulation.force_N);
  const Term& mass = both.model.terms[0];
  EXPECT_GT(mass.gain_standard_error(0), 0.0);
  EXPECT_LT(std::abs(mass.gains[0] - kTrueMass_kg), 4.0 * mass.gain_standard_error(0));
}

TEST(OutputError, RefusesWhatCannotBeSimulated) {
  Log log = noisy_log(1e-8, 1);
  const auto refuses = [](const Log& with, const std::vector<std::string>& effects) {
    const Measurement measurement(with);
    const FittedModel start = fit_effects(measurement, effects, {});
    EXPECT_THROW(fit_by_simulation("log", measurement, start, 1.0, [](double) {}), InputError);
  };
  refuses(log, {"coulomb", "viscous"});  // no mass
  for (double& force_N : log.force_N) force_N = 3.0;
  refuses(log, {"inertia", "viscous"});  // nothing drives the axis
}

TEST(RunIntervals, CoverTheLog) {
  Log log = noisy_log(1e-8, 1);
  const Measurement whole(log);
  const Terms terms = by_inverse_dynamics(whole).terms;
  std::size_t samples = 0;
  for (const FreeRunInterval& run : run_intervals("log", whole, terms, 1.0)) samples += run.size();
  EXPECT_GT(samples, 0.98 * static_cast<double>(whole.sample_count()));
  EXPECT_EQ(joined_runs(run_intervals("log", whole, terms, 1.0)).size(), 1u);
}

}  // namespace
}  // namespace slipstack::workbench
