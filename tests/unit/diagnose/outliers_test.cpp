// SPDX-License-Identifier: Apache-2.0
// Wild samples of a bad cable or an encoder that miscounts, among good ones: the answer must be that of the
// good.
#include <gtest/gtest.h>

#include "tests/unit/diagnose/diagnosed.h"
#include "tests/unit/estimate/estimate_support.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/estimate/uncertainty/standard_errors.h"

namespace slipstack::workbench {
namespace {

using test::diagnosed;

struct Recorded {
  Log log;
  double noise_N = 0.0;
  double viscous_N_s_per_m = 0.0;
};

Recorded record(bool viscous, std::uint64_t seed) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, seed);
  bench.programme.seconds = 20.0;
  if (viscous) {
    // Twice the noise at 0.1 m/s.
    bench.axis.effects.viscous = sim::Viscous{20.0 * bench.axis.force_noise_N, 1.0};
  }
  return {test::simulate(bench, seed), bench.axis.force_noise_N, 20.0 * bench.axis.force_noise_N};
}

/// One force in a hundred is wrong by up to forty times the noise, twenty at the mean; a few positions by
/// many counts.
Log with_outliers(const Recorded& recorded, std::uint64_t seed) {
  Log log = recorded.log;
  test::Draw draw(seed);
  for (double& force_N : log.force_N) {
    if (draw.uniform(0.0, 1.0) < 0.01) force_N += draw.sign() * draw.uniform(0.0, 40.0) * recorded.noise_N;
  }
  for (int glitch = 0; glitch < 5; ++glitch) {
    const auto at =
        static_cast<std::size_t>(draw.uniform(0.05, 0.95) * static_cast<double>(log.force_N.size()));
    log.position_m[at] += 2048.0 * *log.encoder_resolution_m;
  }
  return log;
}

TEST(Outliers, AreNoEffect) {
  const Recorded clean = record(false, 41);
  Measurement measurement(with_outliers(clean, 1));
  const Diagnosis is = diagnosed(measurement);
  EXPECT_EQ(is.verdict, Verdict::complete);
  EXPECT_LT(is.explained.holdout_rmse_N, 1.2 * is.noise_floor_N);
}

TEST(Outliers, HideNoEffectAndBendNoGain) {
  const Recorded viscous = record(true, 42);
  Measurement measurement(with_outliers(viscous, 2));
  const Diagnosis is = diagnosed(measurement);
  ASSERT_EQ(is.verdict, Verdict::missing_effect);
  ASSERT_EQ(is.steps.size(), 2U);
  EXPECT_EQ(is.steps[1].effect, "viscous");
  const Terms terms = with_standard_errors(measurement, is.explained).terms;
  const Term& term = *find_term(terms, "viscous");
  EXPECT_NEAR(term.gains[0], viscous.viscous_N_s_per_m, 3.0 * term.gain_standard_errors[0]);
  EXPECT_LT(term.gain_standard_errors[0], 0.02 * viscous.viscous_N_s_per_m);
}

}  // namespace
}  // namespace slipstack::workbench
