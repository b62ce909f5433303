// SPDX-License-Identifier: Apache-2.0
// Reversal points against Maxwell elements: two descriptions of one hysteresis, two pieces of code.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sim_host/plant/friction/masing.h"
#include "sim_host/plant/friction/maxwell_elements.h"
#include "sim_host/rng.h"

namespace slipstack::sim {
namespace {

// Moves the body on a straight way, resolving what Masing leaves to its mover.
void move(Masing& masing, double from_m, double to_m) {
  if (to_m == from_m) return;
  const int direction = to_m > from_m ? 1 : -1;
  if (direction != masing.direction()) masing.turn(from_m);
  while (direction * (to_m - masing.closing_m()) >= 0.0) masing.close();
}

// The curve through points, and elements with the same slopes.
struct Pair {
  VirginCurve curve;
  MaxwellElements bank;
};
Pair random_pair(Rng& rng) {
  CurveTerm term;
  term.kind = CurveKind::kPoints;
  const std::size_t count = 1 + rng.below(12);
  double x = 0.0;
  double force = 0.0;
  double slope = 1e6;
  std::vector<double> slopes;
  for (std::size_t i = 0; i < count; ++i) {
    const double dx = rng.uniform(0.2e-6, 2e-6);
    x += dx;
    force += slope * dx;
    term.points_m.push_back(x);
    term.points_N.push_back(force);
    slopes.push_back(slope);
    slope *= rng.uniform(0.3, 0.95);
  }
  slopes.push_back(0.0);
  term.level_N = force;
  term.length_m = x;
  std::vector<double> stiffness;
  for (std::size_t i = 0; i < count; ++i) stiffness.push_back(slopes[i] - slopes[i + 1]);
  return {VirginCurve({term}), MaxwellElements(stiffness, term.points_m)};
}

TEST(Masing, EqualsMaxwellElementsOnRandomMotion) {
  std::size_t deepest = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Rng rng(seed);
    Pair pair = random_pair(rng);
    Masing masing(pair.curve);
    const double travel_m = pair.curve.terms().front().length_m;
    const double level_N = pair.curve.saturation_N();
    double x = 0.0;
    for (int i = 0; i < 2000; ++i) {
      // Mostly small loops, sometimes far beyond everything; sometimes exactly back.
      const double to_m =
          rng.chance(0.1) ? 0.0 : x + travel_m * rng.log_uniform(1e-3, 4.0) * rng.pick({-1.0, 1.0});
      move(masing, x, to_m);
      pair.bank.move_to(to_m);
      x = to_m;
      deepest = std::max(deepest, masing.depth());
      ASSERT_NEAR(masing.force_N(x), pair.bank.force_N(), 1e-9 * level_N) << "seed " << seed << " move " << i;
    }
  }
  EXPECT_GT(deepest, 8U);
}

TEST(Masing, ForgetsNothingInASnapshot) {
  Rng rng(3);
  Masing masing(VirginCurve({{CurveKind::kRational, 4.0, 1e-6, 1.0}}));
  double x = 0.0;
  for (int i = 0; i < 30; ++i) {
    const double to_m = 3e-6 * std::pow(0.9, i) * (i % 2 == 0 ? 1.0 : -1.0);
    move(masing, x, to_m);
    x = to_m;
  }
  EXPECT_GT(masing.depth(), 20U);
  const std::vector<double> kept = masing.snapshot();
  Masing other(masing.curve());
  other.restore(kept.data(), kept.size());
  for (int i = 0; i < 200; ++i) {
    const double to_m = x + 1e-6 * rng.normal();
    move(masing, x, to_m);
    move(other, x, to_m);
    x = to_m;
    ASSERT_EQ(masing.force_N(x), other.force_N(x));
  }
}

}  // namespace
}  // namespace slipstack::sim
