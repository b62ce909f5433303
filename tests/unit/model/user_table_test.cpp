// SPDX-License-Identifier: Apache-2.0
// A user-defined effect as the table that the controller runs: which forms have one, its error, and that the
// target computes what the workbench evaluated.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "tests/unit/estimate/simulated_axis.h"
#include "tests/unit/model/model_support.h"
#include "workbench/estimate/linear/linearisation.h"
#include "workbench/estimate/terms/user_table.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/model/effect_adapters/user_effect.h"

namespace slipstack::workbench::test {
namespace {

/// Movements of 0.33 m at up to some 0.6 m/s.
const Measurement& measurement() {
  static const Measurement measured = [] {
    sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 3);
    bench.programme.seconds = 10.0;
    bench.rate_Hz = 1000.0;
    return Measurement(simulate(bench, 3));
  }();
  return measured;
}

Term user_term(const std::string& definition, std::vector<double> gains, std::vector<double> shapes) {
  Term term = make_term(measurement(), declare_effect(definition));
  term.gains = std::move(gains);
  term.shapes = std::move(shapes);
  return term;
}

struct Case {
  std::string definition;
  std::vector<double> gains;
  std::vector<double> shapes;
  bool over_velocity;
  bool by_direction;
  std::function<double(double x, double v)> is_N;
};

double sign(double v) {
  return v > 0.0 ? 1.0 : (v < 0.0 ? -1.0 : 0.0);
}

std::vector<Case> cases() {
  return {
      {"t_snag = A*exp(-((x-x0)/w)^2)*sign(v); A: N; x0: m; w: m in [1e-4, 1e-2]",
       {4.0},
       {0.21, 3e-3},
       false,
       true,
       [](double x, double v) { return 4.0 * std::exp(-std::pow((x - 0.21) / 3e-3, 2)) * sign(v); }},
      {"t_hill = A*exp(-((x-x0)/w)^2); A: N; x0: m; w: m in [1e-4, 1e-1]",
       {-2.0},
       {0.15, 0.05},
       false,
       false,
       [](double x, double) { return -2.0 * std::exp(-std::pow((x - 0.15) / 0.05, 2)); }},
      {"t_cubic = A*v^3; A: N s3/m3",
       {30.0},
       {},
       true,
       false,
       [](double, double v) { return 30.0 * v * v * v; }},
      // A step at standstill, smooth otherwise; a different level in each direction.
      {"t_step = A*exp(-abs(v)/vs)*sign(v); A: N; vs: m/s in [1e-2, 1]",
       {3.0},
       {0.2},
       true,
       true,
       [](double, double v) { return 3.0 * std::exp(-std::abs(v) / 0.2) * sign(v); }},
      {"t_sign = A*sign(v); A: N", {1.5}, {}, true, true, [](double, double v) { return 1.5 * sign(v); }},
  };
}

double force_of(const Term& table, double x, double v) {
  const auto basis = table.effect->make();
  basis->prepare(table.shapes, {});
  Sample<double> sample;
  sample.position_m = x;
  sample.velocity_mps = v;
  std::vector<double> columns(table.gains.size());
  basis->run({&sample, 1}, columns.data());
  double sum = 0.0;
  for (std::size_t i = 0; i < columns.size(); ++i) sum += table.gains[i] * columns[i];
  return sum;
}

TEST(TabulatedEffect, TakesEveryPossibleFormAndReportsItsError) {
  const auto& x_m = measurement().position_m();
  const auto [lowest, highest] = std::minmax_element(x_m.begin(), x_m.end());
  for (const Case& one : cases()) {
    const Tabulated made = tabulate(measurement(), user_term(one.definition, one.gains, one.shapes), 0.0);
    ASSERT_TRUE(made.table) << one.definition << ": " << made.why_not;
    const TabulatedEffect& table = *made.table;
    EXPECT_EQ(table.over_velocity, one.over_velocity) << one.definition;
    EXPECT_EQ(table.reversal_velocity_mps > 0.0, one.by_direction) << one.definition;
    double worst_N = 0.0;
    double peak_N = 0.0;
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int i = 0; i < 20000; ++i) {
      // Half of the positions within the range of the table.
      double x = *lowest + unit(random) * (*highest - *lowest);
      if (!one.over_velocity && i % 2 == 0) x = table.from + unit(random) * (table.to - table.from);
      double v = (unit(random) - 0.5) * 1.2;
      if (one.over_velocity) v = table.from + unit(random) * (table.to - table.from);
      if (std::abs(v) < table.reversal_velocity_mps) continue;
      const double is_N = one.is_N(x, v);
      worst_N = std::max(worst_N, std::abs(force_of(table.term, x, v) - is_N));
      peak_N = std::max(peak_N, std::abs(is_N));
    }
    EXPECT_LE(worst_N, 1.02 * table.largest_error_N + 1e-9) << one.definition;
    EXPECT_GE(worst_N, 0.7 * table.largest_error_N - 1e-9) << one.definition;
    EXPECT_LE(table.largest_error_N, 0.01 * table.peak_N) << one.definition;
    EXPECT_NEAR(table.peak_N, peak_N, 0.1 * peak_N) << one.definition;
  }
}

TEST(TabulatedEffect, BelowTheReversalVelocityTheSignIsASlope) {
  const Case snag = cases()[0];
  const TabulatedEffect table =
      *tabulate(measurement(), user_term(snag.definition, snag.gains, snag.shapes), 0.0).table;
  const double v = table.reversal_velocity_mps;
  EXPECT_GT(v, 1e-4);
  EXPECT_LT(v, 1e-2);
  EXPECT_EQ(force_of(table.term, 0.21, 0.0), 0.0);
  EXPECT_NEAR(force_of(table.term, 0.21, 0.5 * v), 0.5 * force_of(table.term, 0.21, v), 1e-12);
  EXPECT_NEAR(force_of(table.term, 0.21, -3.0 * v), -force_of(table.term, 0.21, v), 1e-12);
  EXPECT_NEAR(force_of(table.term, 0.21, v), 4.0, 0.02);
}

TEST(TabulatedEffect, ReportsWhyThereIsNone) {
  const auto why = [](const std::string& definition, std::vector<double> gains, std::vector<double> shapes) {
    const Tabulated made =
        tabulate(measurement(), user_term(definition, std::move(gains), std::move(shapes)), 0.0);
    EXPECT_FALSE(made.table) << definition;
    return made.why_not;
  };
  EXPECT_NE(why("n_both = A*x*v; A: N s/m2", {1.0}, {}).find("position and speed"), std::string::npos);
  EXPECT_NE(why("n_time = A*t*v; A: N/m", {1.0}, {}).find("time"), std::string::npos);
  EXPECT_NE(why("n_acc = A*a^3; A: N s6/m3", {1.0}, {}).find("acceleration"), std::string::npos);
  EXPECT_NE(why("n_way = A*x*(v > 0 ? 1 : 0.3); A: N/m", {1.0}, {}).find("directions"), std::string::npos);
  EXPECT_NE(why("n_wave = A*sin(2*pi*x/p); A: N; p: m in [1e-3, 1]", {1.0}, {2e-3}).find("straight lines"),
            std::string::npos);
  EXPECT_NE(why("n_zero = A*v; A: N s/m", {0.0}, {}).find("zero"), std::string::npos);
  EXPECT_NE(why("n_root = A*ln(abs(x - 0.2)); A: N", {1.0}, {}), "");
  // Errors far below the noise are allowed.
  EXPECT_TRUE(tabulate(measurement(),
                       user_term("n_wave = A*sin(2*pi*x/p); A: N; p: m in [1e-3, 1]", {1.0}, {2e-3}), 2.5)
                  .table);
}

// The workbench evaluates the table by its basis; the tick runs its weighted form, in single precision.
TEST(TabulatedEffect, TheControllerComputesWhatTheWorkbenchEvaluated) {
  for (const Case& one : cases()) {
    const TabulatedEffect table =
        *tabulate(measurement(), user_term(one.definition, one.gains, one.shapes), 0.0).table;
    Model model;
    model.target_terms = {table.term};
    FrictionModel<float> target;
    target.prepare(target_parameters(model.target_terms),
                   {.tick_s = 1e-3F, .metres_per_displacement = 1e-6F});
    const ForceTrace trace = evaluate_force(measurement(), model.target_terms);
    double worst_N = 0.0;
    for (std::size_t i = 0; i < measurement().sample_count(); ++i) {
      const Sample<double> at = measurement().sample(i);
      Sample<float> sample;
      sample.position_m = static_cast<float>(at.position_m);
      sample.velocity_mps = static_cast<float>(at.velocity_mps);
      const double is_N = static_cast<double>(target.step(sample).total_N);
      worst_N = std::max(worst_N, std::abs(is_N - trace.force_N[i]));
    }
    // A position in float has an error of up to 1.5e-8 m: some 1e-5 of an interval of a table of some
    // millimetres.
    EXPECT_LT(worst_N, 2e-5 * table.peak_N) << one.definition;
    EXPECT_GT(worst_N, 0.0) << one.definition;
  }
}

TEST(TabulatedEffect, IsKeptByTheModelFileAndOnlyForTheController) {
  const Case snag = cases()[0];
  const Term own = user_term(snag.definition, snag.gains, snag.shapes);
  const TabulatedEffect table = *tabulate(measurement(), own, 0.0).table;
  Model written;
  written.terms = {own};
  written.target_terms = {table.term};
  written.target_user_effects = {{own.id(), "", "position", table.from, table.to, table.reversal_velocity_mps,
                                  table.largest_error_N, table.peak_N},
                                 {"other", "it changes with time", "", 0.0, 0.0, 0.0, 0.0, 0.0}};
  const TemporaryFile file;
  const Model read = read_model(file.write(to_toml(written)));
  EXPECT_EQ(to_toml(read), to_toml(written));
  EXPECT_EQ(target_hash(read), target_hash(written));
  ASSERT_EQ(read.target_user_effects.size(), 2u);
  EXPECT_EQ(read.target_user_effects[1].why_not, "it changes with time");
  Model wrong = written;
  wrong.terms = {table.term};
  EXPECT_NE(refusal(file.write(to_toml(wrong))).find("unknown effect 'user_table'"), std::string::npos);
  EXPECT_EQ(find_effect("user_table"), nullptr);
}

}  // namespace
}  // namespace slipstack::workbench::test
