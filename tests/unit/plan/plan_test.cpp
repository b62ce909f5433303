// SPDX-License-Identifier: Apache-2.0
#include "workbench/plan/segment_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

Knowledge knowledge_of(const std::vector<std::string>& effects) {
  Knowledge knowledge;
  Term inertia;
  inertia.effect = find_effect("inertia");
  inertia.gains = inertia.lower = inertia.upper = {12.0};
  Term hysteresis;
  hysteresis.effect = find_effect("presliding_hysteresis");
  const auto capacity = static_cast<std::size_t>(hysteresis.effect->gain_count);
  hysteresis.shapes = slip_distances(1e-6, 5e-5, 8, capacity);
  hysteresis.gains.assign(capacity, 0.0);
  for (std::size_t i = 0; i < 8; ++i) hysteresis.gains[i] = 1.0 / hysteresis.shapes[i];
  hysteresis.lower.assign(capacity, 0.0);
  hysteresis.upper.assign(capacity, 1e12);
  knowledge.model = {inertia, hysteresis};
  for (const std::string& id : effects) {
    Term term;
    term.effect = find_effect(id);
    knowledge.effects.push_back(term);
  }
  knowledge.encoder_resolution_m = 1e-7;
  knowledge.force_noise_N = 0.1;
  return knowledge;
}

PlanOptions options_of(double seconds) {
  PlanOptions options;
  options.limits = {0.02, 0.38, 0.5, 5.0, 250.0, 0.0};
  options.seconds = seconds;
  return options;
}

const ExpectedEvidence& evidence(const Plan& plan, const std::string& effect, const std::string& other) {
  for (const ExpectedEvidence& one : plan.expected) {
    if (one.effect == effect && one.other == other) return one;
  }
  throw std::logic_error("no such pair");
}

TEST(Plan, KeepsTheLimitsAndTheTime) {
  const PlanOptions options = options_of(25.0);
  const Plan plan = plan_experiment(knowledge_of({"stribeck", "frictional_lag"}), options);
  const AxisLimits found = extremes_of(plan.motion);
  EXPECT_GE(found.low_m, options.limits.low_m);
  EXPECT_LE(found.high_m, options.limits.high_m);
  EXPECT_LE(found.velocity_mps, options.limits.velocity_mps);
  EXPECT_LE(found.acceleration_mps2, options.limits.acceleration_mps2);
  EXPECT_LE(found.jerk_mps3, 1.02 * options.limits.jerk_mps3);
  EXPECT_LE(plan.motion.duration_s(), options.seconds);
  EXPECT_GT(plan.motion.duration_s(), 0.2 * options.seconds);
  EXPECT_FALSE(plan.segments.empty());
  // Against Stribeck's law, a lag is detectable; the opposite is not, since the lag contains Stribeck's law.
  EXPECT_GT(evidence(plan, "frictional_lag", "stribeck").evidence, 10.0);
  EXPECT_GT(evidence(plan, "stribeck", "").evidence, 10.0);
  EXPECT_GT(evidence(plan, "frictional_lag", "").chi_squared,
            evidence(plan, "frictional_lag", "stribeck").chi_squared);
}

TEST(Plan, IsTheSameEveryTime) {
  const Plan one = plan_experiment(knowledge_of({"viscous", "quadratic_drag"}), options_of(15.0));
  const Plan two = plan_experiment(knowledge_of({"viscous", "quadratic_drag"}), options_of(15.0));
  EXPECT_EQ(one.motion.position_m, two.motion.position_m);
  EXPECT_EQ(one.segments, two.segments);
}

// A motion that ends before it shows as much as the log in hand is made again, as long as there is time.
TEST(Plan, IsRepeatedUntilItShowsMoreThanWhatIsInHand) {
  const Knowledge knowledge = knowledge_of({"viscous"});
  PlanOptions options = options_of(60.0);
  const Plan once = plan_experiment(knowledge, options);
  ASSERT_LT(once.motion.duration_s(), 20.0);
  const double shown = evidence(once, "viscous", "").evidence;
  options.in_hand = [&](const Terms&) {
    std::vector<ExpectedEvidence> in_hand = once.expected;
    for (ExpectedEvidence& one : in_hand) one.evidence *= 2.5;
    return in_hand;
  };
  const Plan more = plan_experiment(knowledge, options);
  EXPECT_GT(evidence(more, "viscous", "").evidence, 2.5 * shown);
  EXPECT_LE(more.motion.duration_s(), options.seconds);
  EXPECT_EQ(more.in_hand.size(), once.expected.size());
  options.seconds = 1.5 * once.motion.duration_s();
  EXPECT_LE(plan_experiment(knowledge, options).motion.duration_s(), options.seconds);
  options.repeated_s = 60.0;
  EXPECT_EQ(plan_experiment(knowledge, options).motion.position_m, more.motion.position_m);
}

TEST(Plan, ExcludesSegmentsThatExceedTheForce) {
  Knowledge knowledge = knowledge_of({"viscous"});
  PlanOptions options = options_of(20.0);
  EXPECT_GT(plan_experiment(knowledge, options).peak_force_N, 30.0);
  options.limits.force_N = 15.0;
  const Plan weak = plan_experiment(knowledge, options);
  EXPECT_LE(weak.peak_force_N, 15.0);
  options.limits.force_N = 1.0;  // less than the friction alone
  EXPECT_THROW(plan_experiment(knowledge, options), std::invalid_argument);
}

TEST(Plan, NeverExceedsRandomLimits) {
  std::mt19937_64 random(16);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int trial = 0; trial < 6; ++trial) {
    Knowledge knowledge = knowledge_of({"viscous", "stribeck"});
    PlanOptions options = options_of(20.0);
    AxisLimits& limits = options.limits;
    limits.velocity_mps = uniform(0.05, 0.6);
    limits.acceleration_mps2 = uniform(0.5, 6.0);
    limits.jerk_mps3 = limits.acceleration_mps2 * uniform(10.0, 80.0);
    // Mass 12 kg, friction level 8 N: sometimes the acceleration limits, sometimes the force.
    limits.force_N = uniform(12.0, 60.0);
    const Plan plan = plan_experiment(knowledge, options);
    const AxisLimits found = extremes_of(plan.motion);
    EXPECT_GE(found.low_m, limits.low_m) << trial;
    EXPECT_LE(found.high_m, limits.high_m) << trial;
    EXPECT_LE(found.velocity_mps, limits.velocity_mps) << trial;
    EXPECT_LE(found.acceleration_mps2, limits.acceleration_mps2) << trial;
    EXPECT_LE(found.jerk_mps3, limits.jerk_mps3) << trial;
    EXPECT_LE(plan.peak_force_N, limits.force_N) << trial;
    for (const double force_N : force_along(plan.motion, knowledge.model)) {
      ASSERT_LE(std::abs(force_N), limits.force_N) << trial;
    }
  }
}

TEST(LeastEvidence, CountsOnlyWhatOneOfTheTwoAnswers) {
  const auto pair = [](const char* effect, const char* other, double evidence) {
    return ExpectedEvidence{effect, other, 45.0, evidence, evidence};
  };
  const std::vector<ExpectedEvidence> log{pair("a", "", 5e4), pair("a", "b", 900.0), pair("b", "a", -8.0)};
  const auto worse = least_evidence(log, {pair("a", "", 3e4), pair("a", "b", 200.0), pair("b", "a", -9.0)});
  ASSERT_TRUE(worse);
  EXPECT_EQ(worse->log, 900.0);
  EXPECT_EQ(worse->plan, 200.0);
  const auto better = least_evidence(log, {pair("a", "", 3e4), pair("a", "b", 950.0), pair("b", "a", 40.0)});
  ASSERT_TRUE(better);
  EXPECT_EQ(better->log, -8.0);
  EXPECT_EQ(better->plan, 40.0);
  EXPECT_FALSE(least_evidence({pair("b", "a", -8.0)}, {pair("b", "a", 2.0)}));
}

}  // namespace
}  // namespace slipstack::workbench
