// SPDX-License-Identifier: Apache-2.0
// Slip distances where the virgin curve is curved: properties on random curves, and the residual on a
// simulated axis.
#include "workbench/estimate/terms/slip_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/estimate/estimate_support.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

using test::Draw;

/// Hysteresis with a bell of levels over the logarithm of slip, on an even grid.
Term bell(const Measurement& measurement, double middle_m, double width) {
  Term term = make_term(measurement, *find_effect("presliding_hysteresis"));
  term.shapes = slip_distances(2e-8, 1e-3, term.shapes.size(), term.shapes.size());
  for (std::size_t i = 0; i < term.gains.size(); ++i) {
    const double away = std::log(term.shapes[i] / middle_m) / width;
    term.gains[i] = 10.0 * std::exp(-away * away) / term.shapes[i];
  }
  return term;
}

TEST(SlipGrid, IsDenserWhereTheCurveIsCurvedAndKeepsItsEnds) {
  const Measurement measurement(test::wandering_log(1, 1000.0, 4000));
  Draw draw(2);
  for (int k = 0; k < 50; ++k) {
    const double middle_m = draw.log_uniform(5e-7, 5e-5);
    const Term even = bell(measurement, middle_m, draw.uniform(0.7, 2.0));
    const std::vector<double> refined = refined_slip_distances(even, 1e-7);
    ASSERT_EQ(refined.size(), even.shapes.size());
    EXPECT_NEAR(refined.front() / even.shapes.front(), 1.0, 1e-9);
    EXPECT_NEAR(refined.back() / even.shapes.back(), 1.0, 1e-9);
    const double usual = std::log(even.shapes[1] / even.shapes[0]);
    double nearest = 1e9;
    for (std::size_t i = 1; i < refined.size(); ++i) {
      ASSERT_GT(refined[i], refined[i - 1]);
      EXPECT_LT(std::log(refined[i] / refined[i - 1]), 4.0 * usual) << "a stretch without elements";
      if (refined[i - 1] < middle_m && refined[i] >= middle_m)
        nearest = std::log(refined[i] / refined[i - 1]);
    }
    EXPECT_LT(nearest, 0.75 * usual);
  }
}

TEST(SlipGrid, ReachesBelowItsShortestWhereSlipBeginsThere) {
  const Measurement measurement(test::wandering_log(3, 1000.0, 4000));
  const Term steep = bell(measurement, 2e-8, 1.0);
  EXPECT_LT(refined_slip_distances(steep, 2e-8).front(), 0.6 * steep.shapes.front());
  EXPECT_NEAR(refined_slip_distances(steep, 2e-7).front() / steep.shapes.front(), 1.0, 1e-9)
      << "below what the encoder can show";
}

// The polygon on an even grid misses the virgin curve; with the same number of refined distances it misses
// far less.
TEST(SlipGrid, LowersTheResidualOfASimulatedAxis) {
  double even_N2 = 0.0;
  double placed_N2 = 0.0;
  for (std::uint64_t seed = 300; seed < 306; ++seed) {
    sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, seed);
    bench.programme.seconds = 25.0;
    bench.axis.force_noise_N *= 0.01;
    bench.axis.encoder_resolution_m *= 0.01;
    const Log log = test::simulate(bench, seed);
    const double level_N = bench.axis.curve.saturation_N();
    const auto left = [&](bool placed) {
      Measurement measurement(log);
      if (placed) weigh_rows(measurement);
      measurement.set_row_weights(Eigen::VectorXd::Ones(measurement.row_count()));
      const FittedModel fitted = fit_effects(measurement, {"inertia", "presliding_hysteresis"}, {});
      return std::pow(fitted.train_rmse_N / level_N, 2);
    };
    even_N2 += left(false);
    placed_N2 += left(true);
  }
  EXPECT_LT(placed_N2, 0.35 * even_N2);
  EXPECT_GT(placed_N2, 0.0);
}

}  // namespace
}  // namespace slipstack::workbench
