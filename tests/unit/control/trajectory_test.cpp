// SPDX-License-Identifier: Apache-2.0
// Trajectories from any state to any target: they arrive, within their limits, and no faster way is found.
#include "firmware/control/reference/trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "tests/unit/control/fastest_trajectory.h"

namespace slipstack::trajectory {
namespace {

// Random problems over ten orders of magnitude: short and long, with and without cruise, with limits alike
// and wide apart. `viable`: no limit is exceeded at the begin, nor must be.
class Problems {
 public:
  explicit Problems(unsigned seed) : random_(seed) {}

  void draw(bool viable) {
    limits = {log_uniform(1e-3, 2.5e5), 0.0, 0.0, 0.0};
    limits.acceleration = limits.velocity * log_uniform(1e-5, 0.1);
    limits.deceleration = limits.acceleration * (coin() ? 1.0 : log_uniform(0.2, 5.0));
    limits.jerk = limits.acceleration * log_uniform(1e-4, 0.5);
    const double scale = coin() ? 0.95 : log_uniform(1e-6, 0.95);
    do {
      const double beyond = viable ? 1.0 : 1.5;
      from = {0.0, beyond * scale * limits.velocity * uniform(), 0.0};
      const double lowest = std::min(limits.acceleration, limits.deceleration);
      if (!coin()) from.acceleration = beyond * lowest * uniform();
    } while (viable && !is_viable());
    const double span = limits.velocity * limits.velocity / limits.acceleration +
                        limits.velocity * limits.acceleration / limits.jerk;
    target = uniform() * span * log_uniform(1e-4, 3.0);
    target += std::copysign(1.0, target);  // at least a count
  }

  Limits limits;
  State from;
  double target = 0.0;

 private:
  bool is_viable() const {
    const double left = from.velocity + 0.5 * from.acceleration * std::abs(from.acceleration) / limits.jerk;
    return std::abs(left) <= limits.velocity && std::abs(from.velocity) <= limits.velocity;
  }
  double uniform() { return std::uniform_real_distribution<double>(-1.0, 1.0)(random_); }
  double log_uniform(double low, double high) {
    return std::exp(std::uniform_real_distribution<double>(std::log(low), std::log(high))(random_));
  }
  bool coin() { return random_() % 2 == 0; }
  std::mt19937 random_;
};

double duration(const Profile& profile) {
  double ticks = 0.0;
  for (std::size_t i = 0; i < profile.size(); ++i) ticks += profile[i].ticks;
  return ticks;
}

struct Excess {
  double velocity = 0.0, acceleration = 0.0, jerk = 0.0, break_ = 0.0;
};

// By how much a profile exceeds its limits or is not continuous, relative to them: on a grid of its own, from
// the phases alone.
Excess excess(const Profile& profile, const State& from, const Limits& limits) {
  Excess worst;
  State at = from;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const Phase& phase = profile[i];
    worst.break_ = std::max({worst.break_, std::abs(phase.begin.velocity - at.velocity) / limits.velocity,
                             std::abs(phase.begin.acceleration - at.acceleration) / limits.acceleration});
    worst.jerk = std::max(worst.jerk, std::abs(phase.jerk) / limits.jerk - 1.0);
    constexpr int kGrid = 16;
    for (int k = 0; k <= kGrid; ++k) {
      const double t = phase.ticks * k / kGrid;
      const double v = phase.begin.velocity + t * (phase.begin.acceleration + 0.5 * phase.jerk * t);
      const double a = phase.begin.acceleration + phase.jerk * t;
      worst.velocity = std::max(worst.velocity, std::abs(v) / limits.velocity - 1.0);
      // At rest either bound holds.
      const double bound = std::abs(v) < 1e-6 * limits.velocity
                               ? std::max(limits.acceleration, limits.deceleration)
                           : (v > 0.0) == (a > 0.0) ? limits.acceleration
                                                    : limits.deceleration;
      worst.acceleration = std::max(worst.acceleration, std::abs(a) / bound - 1.0);
      if (k == kGrid) at = {0.0, v, a};
    }
  }
  worst.break_ = std::max({worst.break_, std::abs(at.velocity) / limits.velocity,
                           std::abs(at.acceleration) / limits.acceleration});
  return worst;
}

// 10^6 by SLIPSTACK_TRAJECTORIES=1000000; then a hundredth of them are searched for a faster way.
int problems(int otherwise, int of_asked = 1) {
  const char* asked = std::getenv("SLIPSTACK_TRAJECTORIES");
  return asked != nullptr ? std::atoi(asked) / of_asked : otherwise;
}

TEST(Trajectory, ArrivesWithinItsLimitsFromAnyState) {
  Problems problem(1);
  Planner planner;
  // At the velocity limit there is nothing to speed up.
  EXPECT_NEAR(planner.move({0.0, 20.0, 0.0}, 5000.0, {20.0, 0.1, 0.1, 0.001}).end().position, 5000.0, 1e-6);
  int most_steps = 0;
  std::size_t most_phases = 0;
  double farthest = 0.0;
  for (int i = 0; i < problems(20000); ++i) {
    problem.draw(true);
    const Profile& profile = planner.move(problem.from, problem.target, problem.limits);
    farthest = std::max(farthest, std::abs(profile.end().position - problem.target));
    ASSERT_NEAR(profile.end().position, problem.target, 1e-3) << i;
    const Excess worst = excess(profile, problem.from, problem.limits);
    ASSERT_LT(worst.velocity, 1e-9) << i;
    ASSERT_LT(worst.acceleration, 1e-6) << i;
    ASSERT_LT(worst.jerk, 1e-12) << i;
    ASSERT_LT(worst.break_, 1e-9) << i;
    most_steps = std::max(most_steps, planner.steps());
    most_phases = std::max(most_phases, profile.size());
  }
  std::printf("%.1e counts off, %d evaluations, %zu phases at most\n", farthest, most_steps, most_phases);
  EXPECT_LT(most_steps, 31);
  EXPECT_LT(most_phases, Profile::kMost);
}

// Beyond its limits, or about to be: brought back within them, and at the target all the same.
TEST(Trajectory, BringsAStateBeyondItsLimitsBack) {
  Problems problem(3);
  Planner planner;
  for (int i = 0; i < problems(20000); ++i) {
    problem.draw(false);
    const Limits& own = problem.limits;
    const Profile& profile = planner.move(problem.from, problem.target, own);
    ASSERT_NEAR(profile.end().position, problem.target, 1e-3) << i;
    // At full jerk the acceleration falls to zero before anything else; velocity rises that far.
    const double a = std::abs(problem.from.acceleration);
    const double v = std::abs(problem.from.velocity) + 0.5 * a * a / own.jerk;
    const Excess worst = excess(profile, problem.from, own);
    ASSERT_LT(worst.velocity, std::max(1e-9, v / own.velocity - 1.0 + 1e-9)) << i;
    const double least = std::min(own.acceleration, own.deceleration);
    ASSERT_LT(worst.acceleration,
              std::max({1e-6, a / least - 1.0 + 1e-6,
                        std::max(own.acceleration, own.deceleration) / least - 1.0 + 1e-6}))
        << i;
    ASSERT_LT(worst.jerk, 1e-12) << i;
    ASSERT_LT(worst.break_, 1e-9) << i;
  }
}

// The farthest places of a motion that turns round anywhere: as far as it is seen to go in small steps, and
// no farther than one of these steps may hide.
TEST(Trajectory, ExtentIsHowFarItGoes) {
  std::mt19937 random(12);
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  constexpr int kSteps = 2000;
  int within = 0;
  for (int run = 0; run < 500; ++run) {
    Profile profile;
    profile.begin({uniform(-100.0, 100.0), uniform(-5.0, 5.0), uniform(-0.5, 0.5)});
    const double first = profile.end().position;
    double lowest = first, highest = first, hidden = 0.0;
    for (int phase = 0; phase < 1 + run % 4; ++phase) {
      const State from = profile.end();
      // Without jerk, and without acceleration, now and then.
      const double jerk = run % 5 == 0 ? 0.0 : uniform(-0.05, 0.05);
      const double ticks = uniform(1.0, 60.0);
      profile.add(jerk, ticks);
      double hardest = 0.0;
      for (int i = 0; i <= kSteps; ++i) {
        const State at = after(from, jerk, ticks * i / kSteps);
        lowest = std::min(lowest, at.position);
        highest = std::max(highest, at.position);
        hardest = std::max(hardest, std::abs(at.acceleration));
      }
      // Between two steps around a place of rest.
      hidden = std::max(hidden, 0.5 * hardest * std::pow(ticks / kSteps, 2));
    }
    const Extent found = extent(profile);
    ASSERT_LE(found.lowest, lowest + 1e-9) << run;
    ASSERT_GE(found.lowest, lowest - hidden - 1e-9) << run;
    ASSERT_GE(found.highest, highest - 1e-9) << run;
    ASSERT_LE(found.highest, highest + hidden + 1e-9) << run;
    const double last = profile.end().position;
    within += lowest < std::min(first, last) - 1.0 || highest > std::max(first, last) + 1.0 ? 1 : 0;
  }
  EXPECT_GT(within, 200) << "beyond both ends";
  EXPECT_EQ(extent(Profile{}).highest, 0.0);
}

TEST(Trajectory, IsAsFastAsTheFastestFoundByBruteForce) {
  Problems problem(2);
  Planner planner;
  double slowest = 1.0, fastest = 1.0;
  for (int i = 0; i < problems(300, 100); ++i) {
    problem.draw(true);
    const double ticks = duration(planner.move(problem.from, problem.target, problem.limits));
    const Limits& own = problem.limits;
    const double found = fastest::duration(
        {problem.from.position, problem.from.velocity, problem.from.acceleration}, problem.target,
        {own.velocity, own.acceleration, own.deceleration, own.jerk}, ticks / 16000.0, 1.2 * ticks);
    slowest = std::max(slowest, ticks / found);
    fastest = std::min(fastest, ticks / found);
  }
  std::printf("%.5f to %.5f of the numerical optimum\n", fastest, slowest);
  EXPECT_LT(slowest, 1.01);
  EXPECT_GT(fastest, 0.99);
}

}  // namespace
}  // namespace slipstack::trajectory
