// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <set>

#include "tests/unit/estimate/estimate_support.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/estimate/uncertainty/row_weights.h"

// Several logs of one axis in one measurement.
namespace slipstack::workbench {
namespace {

const ConditioningOptions kSameBandwidth{.bandwidth_Hz = 25.0};

std::vector<double> part_of_trace(const Measurement& all, std::size_t log, const Terms& terms) {
  return part_of(evaluate_force(all, terms).force_N, all.parts()[log]);
}

TEST(SeveralLogs, NoMemoryReachesFromOneToTheNext) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Log first = test::wandering_log(seed, 500.0, 4001);
    const Log second = test::wandering_log(seed + 100, 500.0, 3507);
    ConditioningOptions shared = kSameBandwidth;
    shared.per_log.clear();
    const Measurement both({first, second}, shared);
    const Measurement alone(second, shared);
    const Terms terms = test::full_model(alone, seed);
    EXPECT_EQ(part_of_trace(both, 1, terms), evaluate_force(alone, terms).force_N) << seed;
    const Measurement alone_first(first, shared);
    EXPECT_EQ(part_of_trace(both, 0, terms), evaluate_force(alone_first, terms).force_N) << seed;
  }
}

TEST(SeveralLogs, RowsDependOnOneLogOnlyAndEveryFoldHasEveryLog) {
  const Log first = test::wandering_log(3, 500.0, 9000);
  Log second = test::wandering_log(4, 500.0, 2500);
  const Measurement both({first, second}, kSameBandwidth);
  // The rows of the first log do not depend on the other.
  for (double& force : second.force_N) force = 1e6 + 3.0 * force;
  for (double& x : second.position_m) x *= -2.0;
  const Measurement other({first, second}, kSameBandwidth);
  const auto rows = static_cast<Eigen::Index>(both.parts()[0].row_count);
  ASSERT_EQ(rows, static_cast<Eigen::Index>(other.parts()[0].row_count));
  EXPECT_EQ(both.force_N().head(rows), other.force_N().head(rows));
  EXPECT_EQ(both.force_N({0.003}).head(rows), other.force_N({0.003}).head(rows));
  for (const LogPart& part : both.parts()) {
    std::set<int> folds;
    for (std::size_t row = part.first_row; row < part.first_row + part.row_count; ++row) {
      folds.insert(both.fold_of_block(both.row_blocks()[row]));
      EXPECT_GE(both.row_samples()[row], part.first_sample);
      EXPECT_LT(both.row_samples()[row], part.end_sample());
    }
    EXPECT_EQ(folds.size(), static_cast<std::size_t>(both.fold_count())) << part.path;
  }
}

TEST(SeveralLogs, SeparateGainsAreFittedAsIfAlone) {
  // With every gain fitted for each log separately, the joint fit equals the two fits.
  Log first = test::wandering_log(5, 500.0, 6000);
  Log second = test::wandering_log(6, 500.0, 6000);
  ConditioningOptions own = kSameBandwidth;
  own.per_log = {"inertia", "viscous", "offset_force"};
  for (Log* log : {&first, &second}) {
    const double mass = log == &first ? 2.0 : 5.0;
    const Measurement motion(*log, own);
    for (std::size_t i = 0; i < log->force_N.size(); ++i) {
      log->force_N[i] += mass * motion.acceleration_mps2()[i] + 4.0 * mass * motion.velocity_mps()[i] - mass;
    }
  }
  const std::vector<std::string> effects{"inertia", "viscous", "offset_force"};
  const FittedModel joint = fit_effects(Measurement({first, second}, own), effects, {});
  ASSERT_EQ(joint.terms[0].gain_sets(), 2u);
  std::size_t log_index = 0;
  for (const Log* log : {&first, &second}) {
    const FittedModel alone = fit_effects(Measurement(*log, own), effects, {});
    for (std::size_t t = 0; t < effects.size(); ++t) {
      // Rows lie up to a group of samples apart.
      EXPECT_NEAR(joint.terms[t].gains[log_index], alone.terms[t].gains[0],
                  0.01 * std::abs(alone.terms[t].gains[0]))
          << effects[t];
    }
    ++log_index;
  }
}

TEST(SeveralLogs, PayloadOfEachLogIsFoundOnThePlant) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 1);
  bench.programme.seconds = 20.0;
  std::vector<Log> logs;
  for (const double payload_kg : {0.0, 3.0}) {
    sim::Bench loaded = bench;
    loaded.axis.mass_kg += payload_kg;
    logs.push_back(test::simulate(loaded, 7 + logs.size()));
    logs.back().mass_kg.reset();
  }
  ConditioningOptions options;
  Measurement both(logs, options);
  weigh_rows(both);
  const FittedModel fitted = fit_effects(both, {"inertia", "presliding_hysteresis", "offset_force"}, {});
  const Term& inertia = *find_term(fitted.terms, "inertia");
  ASSERT_EQ(inertia.gains.size(), 2u);
  EXPECT_NEAR(inertia.gains[0], bench.axis.mass_kg, 0.1);
  EXPECT_NEAR(inertia.gains[1] - inertia.gains[0], 3.0, 0.1);
  EXPECT_EQ(find_term(fitted.terms, "presliding_hysteresis")->gain_sets(), 1u);
  const double floor_N = both.noise_floor_N();
  EXPECT_LT(fitted.holdout_rmse_N, 2.5 * floor_N);
  // One mass for both cannot explain the loaded log.
  options.per_log.clear();
  Measurement shared(logs, options);
  weigh_rows(shared);
  const FittedModel one_mass = fit_effects(shared, {"inertia", "presliding_hysteresis", "offset_force"}, {});
  EXPECT_GT(one_mass.holdout_rmse_N, 3.0 * fitted.holdout_rmse_N);
  // The model file holds the mean, weighted by the lengths of the logs.
  const Terms mean = averaged_over_logs(both, fitted.terms);
  const double share =
      static_cast<double>(both.parts()[1].sample_count) / static_cast<double>(both.sample_count());
  EXPECT_NEAR(find_term(mean, "inertia")->gains[0],
              inertia.gains[0] + share * (inertia.gains[1] - inertia.gains[0]), 1e-9);
}

TEST(SeveralLogs, IncompatibleLogsAreRefused) {
  const Log good = test::wandering_log(1, 500.0, 2000);
  const auto refused = [&](const Log& other) {
    try {
      join({good, other});
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refused(good), "");
  Log other = good;
  other.sample_rate_Hz = 510.0;
  EXPECT_NE(refused(other).find("sampled at 510 Hz"), std::string::npos);
  other = good;
  other.mass_kg = 2.0;
  EXPECT_NE(refused(other).find("mass_kg"), std::string::npos);
}

}  // namespace
}  // namespace slipstack::workbench
