// SPDX-License-Identifier: Apache-2.0
// Forces outside the catalogue that are tried as effects are: found with their values, beside an effect too.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/unit/diagnose/diagnosed.h"
#include "tests/unit/estimate/estimate_support.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/verdict.h"

namespace slipstack::workbench {
namespace {

using test::diagnosed;

constexpr std::uint64_t kAxisSeed = 33;

sim::Bench bench_with_payload(double share) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, kAxisSeed);
  bench.programme.seconds = 15.0;
  bench.axis.effects.payload_kg = share * bench.axis.mass_kg;
  return bench;
}

/// A log to which `force_N(time, position)` is added.
template <class Force>
Log log_and_force(double payload_share, Force&& force_N) {
  Log log = test::simulate(bench_with_payload(payload_share), kAxisSeed);
  for (std::size_t i = 0; i < log.force_N.size(); ++i)
    log.force_N[i] += force_N(static_cast<double>(i) / log.sample_rate_Hz, log.position_m[i]);
  return log;
}

double no_force(double, double) {
  return 0.0;
}

/// Far above what decides whether a force is found.
double strong_N() {
  static const double floor_N = diagnosed(log_and_force(0.0, no_force)).noise_floor_N;
  return 10.0 * floor_N;
}

struct Case {
  const char* name;
  double (*force_N)(double, double);
  Coordinate coordinate;
};

double hum(double time_s, double) {
  return strong_N() * std::sin(2.0 * std::numbers::pi * 13.7 * time_s);
}
double jump(double time_s, double) {
  return time_s > 6.0 ? strong_N() : 0.0;
}
double creep(double time_s, double) {
  return strong_N() * (std::sin(0.31 * time_s) + std::sin(0.73 * time_s + 1.0));
}

class Causes : public ::testing::TestWithParam<Case> {};

TEST_P(Causes, AreFoundAndNoEffectIsNamedForThem) {
  const Diagnosis is = diagnosed(log_and_force(0.0, GetParam().force_N));
  EXPECT_EQ(is.verdict, Verdict::unexplained);
  EXPECT_EQ(is.steps.size(), 1u) << is.steps.back().effect;
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, GetParam().coordinate) << is.unexplained->description;
}

TEST_P(Causes, LeaveTheNameToAnEffectThatIsLarger) {
  const Diagnosis is = diagnosed(log_and_force(0.3, GetParam().force_N));
  EXPECT_EQ(is.verdict, Verdict::missing_effect);
  ASSERT_EQ(is.steps.size(), 2u);
  EXPECT_EQ(is.steps[1].effect, "payload_mass");
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, GetParam().coordinate) << is.unexplained->description;
}

INSTANTIATE_TEST_SUITE_P(OfAllKinds, Causes,
                         ::testing::Values(Case{"line", hum, Coordinate::frequency},
                                           Case{"change", jump, Coordinate::time},
                                           Case{"curve", creep, Coordinate::time}),
                         [](const auto& kind) { return std::string(kind.param.name); });

// An eddy brake, of which the force rises and falls with the velocity, is no effect of the catalogue. A free
// curve over time follows a slow motion, and so this force too.
TEST(Causes, ADependenceOnVelocityIsNotToldAsTime) {
  constexpr double kMass_kg = 10.0;
  constexpr double kLevel_N = 4.0;
  constexpr double kSlip_m = 20e-6;
  const auto x = [](double t) { return 0.15 * std::sin(0.6 * t) + 0.05 * std::sin(0.17 * t); };
  test::Draw draw(3);
  double last_m = 0.0;
  double deflection = 0.0;  // of one stop operator, relative to its slip distance
  Log log = test::log_of(500.0, 20'000, x, [&](double t) {
    const double velocity_mps = 0.09 * std::cos(0.6 * t) + 0.0085 * std::cos(0.17 * t);
    const double acceleration_mps2 = -0.054 * std::sin(0.6 * t) - 0.001445 * std::sin(0.17 * t);
    deflection = std::clamp(deflection + (x(t) - last_m) / kSlip_m, -1.0, 1.0);
    last_m = x(t);
    const double u = velocity_mps / 0.06;
    return kMass_kg * acceleration_mps2 + kLevel_N * deflection + 60.0 * velocity_mps / (1.0 + u * u) +
           0.05 * draw.normal();
  });
  log.mass_kg = kMass_kg;
  const Diagnosis is = diagnosed(log);
  EXPECT_EQ(is.verdict, Verdict::unexplained) << is.steps.back().effect;
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::velocity) << is.unexplained->description;
}

// A curve over time has an offset in it: beside a rest that neither describes it always leaves less than the
// offset alone, and is no better explanation for that.
TEST(Causes, AnOffsetKeepsItsNameBesideACurveOfLess) {
  test::Draw draw(11);
  std::vector<double> rest(200);
  for (double& value : rest) value = draw.normal();
  const Diagnosis is = diagnosed(log_and_force(0.0, [&](double time_s, double) {
    const double step_N = rest[static_cast<std::size_t>(time_s / 0.1) % rest.size()];
    return 10.0 * strong_N() + 0.5 * creep(time_s, 0.0) + 2.0 * strong_N() * step_N;
  }));
  EXPECT_EQ(is.verdict, Verdict::missing_effect) << is.steps.back().effect;
  ASSERT_GE(is.steps.size(), 2u);
  EXPECT_EQ(is.steps[1].effect, "offset_force");
}

// Two breaks anywhere fit whatever differs between two parts of a log: a change that explains less than half
// of what there is, is none.
TEST(Causes, AChangeThatExplainsLittleIsNotTold) {
  const Diagnosis is = diagnosed(log_and_force(0.0, [](double time_s, double position_m) {
    return (time_s > 5.0 && time_s < 8.0 ? 1.3 : 1.0) * 2.0 * strong_N() *
           std::sin(2.0 * std::numbers::pi * 0.9 * time_s + 200.0 * position_m);
  }));
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->description.find("changes at"), std::string::npos) << is.unexplained->description;
}

// The values that the description states are those that were hidden.
TEST(Causes, StateTheirValues) {
  const Diagnosis line = diagnosed(log_and_force(0.0, hum));
  ASSERT_TRUE(line.unexplained);
  EXPECT_NEAR(line.unexplained->where, 13.7, 1e-3);
  const Diagnosis change = diagnosed(log_and_force(0.0, jump));
  ASSERT_TRUE(change.unexplained);
  EXPECT_NEAR(change.unexplained->where, 6.0, 0.05);
}

// A brake that drags for a part of the log: the friction is higher there, and before and after it the same.
TEST(Causes, AChangeThatEndsIsToldWithBothTimes) {
  const Log plain = log_and_force(0.0, no_force);
  Log log = plain;
  constexpr double kFrom_s = 4.0;
  constexpr double kUntil_s = 9.0;
  for (std::size_t i = 1; i < log.force_N.size(); ++i) {
    const double time_s = static_cast<double>(i) / log.sample_rate_Hz;
    const double way_m = log.position_m[i] - log.position_m[i - 1];
    if (time_s >= kFrom_s && time_s < kUntil_s) log.force_N[i] += std::copysign(strong_N(), way_m);
  }
  const Diagnosis is = diagnosed(log);
  EXPECT_EQ(is.verdict, Verdict::unexplained) << is.steps.back().effect;
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::time) << is.unexplained->description;
  EXPECT_NEAR(is.unexplained->where, kFrom_s, 0.1);
  const std::string until = " and is as before from ";
  const std::size_t at = is.unexplained->description.find(until);
  ASSERT_NE(at, std::string::npos) << is.unexplained->description;
  EXPECT_NEAR(std::stod(is.unexplained->description.substr(at + until.size())), kUntil_s, 0.2);
  const Diagnosis step = diagnosed(log_and_force(0.0, jump));
  ASSERT_TRUE(step.unexplained);
  EXPECT_EQ(step.unexplained->description.find("as before"), std::string::npos)
      << step.unexplained->description;
}

// A payload that is picked up when the log holds half of its force: the motion is imposed, so that it is the
// same without it.
TEST(Causes, AMassThatChangesIsToldWithItsTime) {
  const auto simulated = [](double payload_share) {
    sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, kAxisSeed);
    bench.programme.seconds = 30.0;
    bench.axis.effects.payload_kg = payload_share * bench.axis.mass_kg;
    return test::simulate(bench, kAxisSeed);
  };
  Log log = simulated(0.0);
  const Log loaded = simulated(0.3);
  ASSERT_EQ(log.position_m, loaded.position_m);
  std::vector<double> energy(1, 0.0);
  for (std::size_t i = 0; i < log.force_N.size(); ++i)
    energy.push_back(energy.back() + std::pow(loaded.force_N[i] - log.force_N[i], 2));
  const auto half = std::lower_bound(energy.begin(), energy.end(), 0.5 * energy.back()) - energy.begin();
  std::copy(loaded.force_N.begin() + half, loaded.force_N.end(), log.force_N.begin() + half);
  const Diagnosis is = diagnosed(log);
  EXPECT_EQ(is.verdict, Verdict::unexplained) << is.steps.back().effect;
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::time);
  EXPECT_NEAR(is.unexplained->where, static_cast<double>(half) / log.sample_rate_Hz, 0.3);
  EXPECT_NE(is.unexplained->description.find("as where a payload is picked up"), std::string::npos)
      << is.unexplained->description;
}

/// A place of the rail of the logs above, by shares of their travel.
struct Place {
  double middle_m;
  double half_width_m;
  Place(double middle, double half_width) {
    const Log clean = log_and_force(0.0, no_force);
    const auto [low, high] = std::minmax_element(clean.position_m.begin(), clean.position_m.end());
    middle_m = *low + middle * (*high - *low);
    half_width_m = half_width * (*high - *low);
  }
  /// In half widths.
  double from_middle(double position_m) const { return (position_m - middle_m) / half_width_m; }
};

TEST(Causes, APlaceIsFoundWhereItIs) {
  const Place place(0.4, 0.02);
  const Diagnosis is = diagnosed(log_and_force(0.0, [&](double, double position_m) {
    const double u = place.from_middle(position_m);
    return 2.0 * strong_N() * std::exp(-u * u);
  }));
  EXPECT_EQ(is.verdict, Verdict::unexplained) << is.steps.back().effect << is.steps.back().holdout_rmse_N;
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::position) << is.unexplained->description;
  // The place is that of the peak, not of a window that has it at its side.
  EXPECT_NEAR(is.unexplained->where, place.middle_m, 0.1 * place.half_width_m);
}

/// More dry friction about a place, half a width to either side, in a log that is given by the distance from
/// it.
Log log_with_friction_at(const Place& place, double size_N) {
  Log log = log_and_force(0.0, no_force);
  for (std::size_t i = 1; i < log.force_N.size(); ++i) {
    const double u = place.from_middle(log.position_m[i]);
    log.force_N[i] += std::copysign(size_N * std::exp(-u * u), log.position_m[i] - log.position_m[i - 1]);
  }
  for (double& position_m : log.position_m) position_m -= place.middle_m;
  return log;
}

// What a place is, is no value that is zero where it is at the zero of the position.
TEST(Causes, APlaceMayBeAtTheZeroOfThePosition) {
  const Diagnosis is = diagnosed(log_with_friction_at(Place(0.4, 0.02), 2.0 * strong_N()));
  EXPECT_EQ(is.verdict, Verdict::unexplained) << is.steps.back().effect << is.steps.back().holdout_rmse_N;
  ASSERT_TRUE(is.unexplained);
  EXPECT_TRUE(is.unexplained->description.starts_with("a force sits at one place of the rail"))
      << is.unexplained->description;
}

// Where the axis is most of the time, the model takes its friction from: the friction differs elsewhere.
TEST(Causes, APlaceWhereTheAxisStaysIsFoundThere) {
  constexpr double kPlace_m = 0.04;
  constexpr double kHalfWidth_m = 0.004;
  constexpr double kMoreFriction = 0.4;
  const auto position_m = [](double t) {
    const double far_m = 0.06 * std::exp(-squared(std::sin(0.2 * t) / 0.15));
    return kPlace_m + (0.003 + far_m) * std::sin(5.0 * t);
  };
  test::Draw draw(3);
  const auto force_N = [&](double t) {
    constexpr double kTick_s = 1e-3;
    constexpr double kMass_kg = 10.0;
    const double next_m = position_m(t + kTick_s);
    const double last_m = position_m(t - kTick_s);
    const double u = (position_m(t) - kPlace_m) / kHalfWidth_m;
    const double inertia_N = kMass_kg * (next_m - 2.0 * position_m(t) + last_m) / (kTick_s * kTick_s);
    const double friction_N = 10.0 * (1.0 + kMoreFriction * std::exp(-u * u));
    return inertia_N + friction_N * std::tanh(1e6 * (next_m - last_m)) + 0.05 * draw.normal();
  };
  const Diagnosis is = diagnosed(test::log_of(1000.0, 30000, position_m, force_N));
  EXPECT_EQ(is.verdict, Verdict::unexplained) << is.steps.back().effect << is.steps.back().holdout_rmse_N;
  ASSERT_TRUE(is.unexplained);
  EXPECT_TRUE(is.unexplained->description.starts_with("a force sits at one place of the rail"))
      << is.unexplained->description;
  EXPECT_NEAR(is.unexplained->where, kPlace_m, 0.1 * kHalfWidth_m);
  const std::string& told = is.unexplained->description;
  const std::string more = "the friction is +";
  ASSERT_NE(told.find(more), std::string::npos) << told;
  EXPECT_NEAR(std::stod(told.substr(told.find(more) + more.size())), 100.0 * kMoreFriction, 4.0) << told;
}

// In 1 % of the time the axis is there, and most of the error.
TEST(Causes, APlaceThatIsPassedQuicklyIsNoMoment) {
  const Place place(0.8, 0.003);
  const Diagnosis is = diagnosed(log_and_force(0.0, [&](double, double position_m) {
    const double u = place.from_middle(position_m);
    return 20.0 * strong_N() / (1.0 + u * u);
  }));
  EXPECT_EQ(is.verdict, Verdict::unexplained) << is.steps.back().effect << is.steps.back().holdout_rmse_N;
  ASSERT_TRUE(is.unexplained);
  EXPECT_TRUE(is.unexplained->description.starts_with("a force sits at one place of the rail"))
      << is.unexplained->description;
}

/// Half-sines of 12 ms, each at its own time of 10 to 30 ms after the axis turned round.
Log log_with_hits_after_reversals(double size_N) {
  Log log = log_and_force(0.0, no_force);
  test::Draw draw(5);
  const auto samples = [&](double seconds) {
    return static_cast<std::size_t>(std::lround(seconds * log.sample_rate_Hz));
  };
  const std::size_t length = samples(0.012);
  double side = 0.0;
  for (std::size_t i = 1; i + samples(0.06) < log.force_N.size(); ++i) {
    const double step_m = log.position_m[i] - log.position_m[i - 1];
    if (step_m == 0.0 || step_m * side > 0.0) continue;
    side = std::copysign(1.0, step_m);
    const std::size_t first = i + samples(0.02 + 0.01 * std::clamp(draw.normal(), -1.0, 1.0));
    for (std::size_t k = 0; k < length; ++k) {
      const double phase = std::numbers::pi * static_cast<double>(k) / static_cast<double>(length);
      log.force_N[first + k] += side * size_N * std::sin(phase);
    }
  }
  return log;
}

// A place that explains a twentieth is no answer where nearly all of the error comes after reversals; nor is
// a cause of which no value is known, unless it is a curve that explains most.
TEST(Causes, OneThatExplainsLittleIsNotToldWhereReversalsHoldTheError) {
  Measurement measurement(log_with_hits_after_reversals(20.0 * strong_N()));
  Diagnosis is = diagnosed(measurement);
  const auto judged_beside = [&](Coordinate coordinate, double explained, bool free_curve, bool determined) {
    is.outside = {};
    is.outside.causes.push_back({coordinate, explained, 0.1, "a force outside the catalogue",
                                 Eigen::VectorXd::Zero(measurement.row_count()), false, free_curve,
                                 determined});
    is.outside.explain_most = true;
    judge(measurement, is);
    return is.unexplained.value_or(Structure{}).coordinate;
  };
  EXPECT_EQ(judged_beside(Coordinate::position, 0.05, false, true), Coordinate::reversal);
  EXPECT_EQ(judged_beside(Coordinate::position, 0.8, false, true), Coordinate::position);
  EXPECT_EQ(judged_beside(Coordinate::position, 0.8, false, false), Coordinate::reversal);
  EXPECT_EQ(judged_beside(Coordinate::time, 0.8, true, false), Coordinate::time);
  EXPECT_EQ(judged_beside(Coordinate::time, 0.05, true, false), Coordinate::reversal);
}

// Noise does not hold most of its square in 1 % of the time, however large it is said to be.
TEST(Causes, MomentsAreToldAtTheFloorToo) {
  Log log = log_and_force(0.0, no_force);
  const double glitch_N = 20.0 * strong_N();
  const auto length = static_cast<std::size_t>(0.006 * log.sample_rate_Hz);
  for (std::size_t k = 1; k < 8; ++k) {
    const std::size_t first = k * log.force_N.size() / 8;
    for (std::size_t i = first; i < first + length; ++i) log.force_N[i] += glitch_N;
  }
  Measurement measurement(log, {.force_noise_N = glitch_N});
  const Diagnosis is = diagnosed(measurement);
  EXPECT_LT(is.explained.holdout_rmse_N, 1.01 * is.noise_floor_N);
  EXPECT_EQ(is.verdict, Verdict::unexplained);
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::time) << is.unexplained->description;
}

double cosine(double position_m, double pitch_m) {
  return std::cos(2.0 * std::numbers::pi * position_m / pitch_m);
}

double travel_m(const Log& log) {
  const auto [low, high] = std::minmax_element(log.position_m.begin(), log.position_m.end());
  return *high - *low;
}

TEST(Causes, ASecondRippleIsToldWithItsPitch) {
  const double travel = travel_m(log_and_force(0.0, no_force));
  const double first_m = travel / 6.3;
  const double second_m = travel / 11.7;
  const Diagnosis is = diagnosed(log_and_force(0.0, [&](double, double position_m) {
    return strong_N() * (3.0 * cosine(position_m, first_m) + 2.0 * cosine(position_m, second_m));
  }));
  EXPECT_EQ(is.verdict, Verdict::missing_effect);
  ASSERT_EQ(is.steps.size(), 2u);
  EXPECT_EQ(is.steps[1].effect, "force_ripple");
  const Term& first = *find_term(is.explained.terms, "force_ripple");
  EXPECT_NEAR(first.shape(ShapeKind::pitch).value(), first_m, 0.01 * first_m);
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::position) << is.unexplained->description;
  EXPECT_NEAR(is.unexplained->where, second_m, 0.002 * second_m) << is.unexplained->description;
  EXPECT_NE(is.unexplained->description.find("second pitch"), std::string::npos);
}

// With the same force in both directions one pitch is enough.
TEST(Causes, HarmonicsOfOneRippleAreNoSecondOne) {
  const double pitch_m = travel_m(log_and_force(0.0, no_force)) / 6.3;
  const Diagnosis is = diagnosed(log_and_force(0.0, [&](double, double position_m) {
    return strong_N() * (3.0 * cosine(position_m, pitch_m) + cosine(position_m, pitch_m / 2.0) +
                         2.0 * cosine(position_m, pitch_m / 4.0));
  }));
  EXPECT_EQ(is.verdict, Verdict::missing_effect);
  ASSERT_EQ(is.steps.size(), 2u);
  EXPECT_EQ(is.steps[1].effect, "force_ripple");
  EXPECT_FALSE(is.unexplained) << is.unexplained->description;
}

TEST(Causes, FrictionOfAShortPitchIsNoMotorConstant) {
  const double pitch_m = travel_m(log_and_force(0.0, no_force)) / 15.3;
  double before_m = 0.0;
  double side = 0.0;
  const Diagnosis is = diagnosed(log_and_force(0.0, [&](double, double position_m) {
    if (position_m != before_m) side = position_m > before_m ? 1.0 : -1.0;
    before_m = position_m;
    return 3.0 * strong_N() * side * cosine(position_m, pitch_m);
  }));
  EXPECT_EQ(is.verdict, Verdict::unexplained) << is.steps.back().effect;
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::position) << is.unexplained->description;
  EXPECT_NEAR(is.unexplained->where, pitch_m, 0.005 * pitch_m) << is.unexplained->description;
  EXPECT_NE(is.unexplained->description.find("the friction repeats"), std::string::npos)
      << is.unexplained->description;
}

// A link above the horizontal: its gravity falls with the angle. A payload, which in a motion to and fro is
// nearly the same force, keeps its name.
TEST(Causes, ASpringBeyondItsDeadCentreHasANegativeStiffness) {
  const double travel = travel_m(log_and_force(0.0, no_force));
  const double slope_N_per_m = -40.0 * strong_N() / travel;
  const Diagnosis is =
      diagnosed(log_and_force(0.0, [&](double, double position_m) { return slope_N_per_m * position_m; }));
  EXPECT_EQ(is.verdict, Verdict::missing_effect);
  ASSERT_EQ(is.steps.size(), 2u);
  EXPECT_EQ(is.steps[1].effect, "cable_chain_stiffness");
  EXPECT_NEAR(find_term(is.explained.terms, "cable_chain_stiffness")->gains[0], slope_N_per_m,
              -0.05 * slope_N_per_m);
  const Diagnosis heavier = diagnosed(log_and_force(0.3, no_force));
  ASSERT_EQ(heavier.steps.size(), 2u);
  EXPECT_EQ(heavier.steps[1].effect, "payload_mass");
}

// The plant simulates the carriage behind elastic flanks; the form that is fitted has rigid ones.
TEST(Causes, AGapIsFoundWithItsWidth) {
  for (const double gap_m : {20e-6, 60e-6}) {
    sim::Bench bench = bench_with_payload(0.0);
    bench.axis.outside.backlash = sim::Backlash{gap_m, 0.2, 800.0, 0.3};
    const Diagnosis is = diagnosed(test::simulate(bench, kAxisSeed));
    EXPECT_EQ(is.verdict, Verdict::unexplained);
    EXPECT_EQ(is.steps.size(), 1u) << is.steps.back().effect;
    ASSERT_TRUE(is.unexplained);
    EXPECT_EQ(is.unexplained->coordinate, Coordinate::reversal) << is.unexplained->description;
    EXPECT_NEAR(is.unexplained->where, gap_m, 0.5 * gap_m) << is.unexplained->description;
    EXPECT_GT(is.unexplained->error_reduction, 0.5) << is.unexplained->description;
  }
}

// sigma1 dz/dt of the LuGre model (its equations, integrated by Euler's method) on an axis of stop operators:
// a force that leads the motion, which a delay of the force describes nearly as well. The deflection is that
// of the axis's own hysteresis, within a factor of two.
TEST(Causes, DampingOfTheContactsIsNotADelay) {
  constexpr double kLength_m = 6e-6;
  constexpr double kDamping_Ns_per_m = 1500.0;
  double before_m = 0.0;
  double deflection_m = 0.0;
  bool first = true;
  const Log log = log_and_force(0.0, [&](double, double position_m) {
    const double way_m = first ? 0.0 : position_m - before_m;
    first = false;
    before_m = position_m;
    double moved_m = 0.0;
    constexpr int kSteps = 200;
    for (int i = 0; i < kSteps; ++i) {
      const double step_m = (way_m - std::abs(way_m) * (deflection_m + moved_m) / kLength_m) / kSteps;
      moved_m += step_m;
    }
    deflection_m += moved_m;
    return kDamping_Ns_per_m * moved_m * 2000.0;
  });
  const Diagnosis is = diagnosed(log);
  EXPECT_EQ(is.steps.size(), 1u) << is.steps.back().effect;
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::reversal) << is.unexplained->description;
  EXPECT_NE(is.unexplained->description.find("sigma1"), std::string::npos) << is.unexplained->description;
}

/// Moves of 2 mm each second and small loops between them, with an encoder of 10 nm; a mass of 3 kg, viscous
/// friction, and dry friction of 8 N: of a bristle (the equations of LuGre, integrated by Euler's method,
/// whose level rises by `stribeck` of it towards standstill), or of two stop operators, both over some 20 um.
Log log_with_loops(bool of_bristle, double viscous_Ns_per_m, double stribeck, std::uint64_t seed) {
  constexpr double kSampling_Hz = 1000.0;
  constexpr double kMass_kg = 3.0;
  constexpr double kStep_m = 10e-9;
  const auto x = [](double t) {
    const double number = std::floor(t);
    const double share = std::min(2.0 * (t - number), 1.0);
    const double way = share * share * share * (10.0 + share * (6.0 * share - 15.0));
    const double from_m = 2e-3 * (static_cast<int>(number) % 3);
    const double to_m = 2e-3 * (static_cast<int>(number + 1.0) % 3);
    const double rest = std::max(0.0, 2.0 * (t - number) - 1.0);
    const double loops_m = 15e-6 * std::pow(std::sin(std::numbers::pi * rest), 2) *
                           std::sin(2.0 * std::numbers::pi * 3.0 * rest);
    return from_m + (to_m - from_m) * way + loops_m;
  };
  test::Draw draw(seed);
  double before_m = x(0.0);
  double bristle = 0.0;
  double short_stop = 0.0;
  double long_stop = 0.0;
  const auto friction = [&](double way_m) {
    constexpr int kSubsteps = 100;
    const double level = 1.0 + stribeck * std::exp(-std::pow(way_m * kSampling_Hz / 2e-3, 2));
    for (int i = 0; i < kSubsteps; ++i)
      bristle += (way_m - std::abs(way_m) * bristle / level) / 20e-6 / kSubsteps;
    short_stop = std::clamp(short_stop + way_m / 15e-6, -1.0, 1.0);
    long_stop = std::clamp(long_stop + way_m / 60e-6, -1.0, 1.0);
    return 8.0 * (of_bristle ? bristle : 0.5 * (short_stop + long_stop));
  };
  Log log = test::log_of(
      kSampling_Hz, 30'000, [&](double t) { return kStep_m * std::round(x(t) / kStep_m); },
      [&](double t) {
        constexpr double h = 1e-4;
        const double way_m = x(t) - before_m;
        before_m = x(t);
        return kMass_kg * (x(t + h) - 2.0 * x(t) + x(t - h)) / (h * h) +
               viscous_Ns_per_m * (x(t + h) - x(t - h)) / (2.0 * h) + friction(way_m) + 0.02 * draw.normal();
      });
  log.mass_kg = kMass_kg;
  log.encoder_resolution_m = kStep_m;
  return log;
}

void expect_bristle(const Diagnosis& is) {
  ASSERT_TRUE(is.unexplained);
  EXPECT_NE(is.unexplained->description.find("is that of a bristle"), std::string::npos)
      << is.unexplained->description;
}

// Small loops of a bristle do not close: stop operators leave most of the friction there, at times.
TEST(Causes, ABristleIsTheFormOfTheFriction) {
  const Diagnosis is = diagnosed(log_with_loops(true, 0.0, 0.0, 1));
  EXPECT_EQ(is.verdict, Verdict::unexplained);
  EXPECT_EQ(is.steps.size(), 1u) << is.steps.back().effect;
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::reversal) << is.unexplained->description;
  EXPECT_NE(is.unexplained->description.find("is that of a bristle"), std::string::npos)
      << is.unexplained->description;
  EXPECT_NEAR(is.unexplained->where, 20e-6, 1e-6);
  EXPECT_GT(is.unexplained->error_reduction, 0.9);
}

// What is missing is the line; that the friction is a bristle's is said besides, and the error of both.
TEST(Causes, AForceIsToldBeforeTheFormOfTheFriction) {
  Log log = log_with_loops(true, 0.0, 0.0, 1);
  for (std::size_t i = 0; i < log.force_N.size(); ++i) {
    const double time_s = static_cast<double>(i) / log.sample_rate_Hz;
    log.force_N[i] += std::sin(2.0 * std::numbers::pi * 13.7 * time_s);
  }
  const Diagnosis is = diagnosed(log);
  EXPECT_EQ(is.verdict, Verdict::unexplained);
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::frequency) << is.unexplained->description;
  EXPECT_NEAR(is.unexplained->where, 13.7, 1e-3);
  EXPECT_NE(is.unexplained->description.find("; with all that was chosen"), std::string::npos)
      << is.unexplained->description;
  expect_bristle(is);
}

// It takes the place of the hysteresis and not that of another effect.
TEST(Causes, AnEffectKeepsItsNameBesideABristle) {
  const Diagnosis is = diagnosed(log_with_loops(true, 80.0, 0.0, 2));
  EXPECT_EQ(is.verdict, Verdict::missing_effect);
  ASSERT_EQ(is.steps.size(), 2u);
  EXPECT_EQ(is.steps[1].effect, "viscous");
  expect_bristle(is);
}

// A bristle whose level falls with velocity looks like a lag too, which is dropped where it stands alone.
TEST(Causes, StribeckFrictionKeepsItsNameBesideABristle) {
  const Diagnosis is = diagnosed(log_with_loops(true, 0.0, 0.4, 4));
  EXPECT_EQ(is.verdict, Verdict::missing_effect);
  ASSERT_GE(is.steps.size(), 2u);
  EXPECT_EQ(is.steps[1].effect, "stribeck");
  expect_bristle(is);
}

TEST(Causes, StopOperatorsAreNoBristle) {
  const Diagnosis is = diagnosed(log_with_loops(false, 0.0, 0.0, 3));
  for (const Structure& cause : is.outside.causes)
    EXPECT_EQ(cause.description.find("bristle"), std::string::npos) << cause.description;
}

// A blow that rings, whenever mass times acceleration and friction together change their sign, of another
// strength each time: what no rigid gap describes, and a delay of the force a little.
TEST(Causes, BlowsAfterLoadReversalsAreBacklash) {
  constexpr double kSampling_Hz = 2000.0;
  constexpr double kMass_kg = 8.0;
  constexpr double kFriction_N = 12.0;
  constexpr double kSlip_m = 20e-6;
  const auto x = [](double t) { return 0.05 * std::sin(7.0 * t) + 0.02 * std::sin(11.3 * t + 1.0); };
  const auto a = [](double t) {
    return -0.05 * 49.0 * std::sin(7.0 * t) - 0.02 * 11.3 * 11.3 * std::sin(11.3 * t + 1.0);
  };
  double before_m = x(0.0);
  double deflection_m = 0.0;
  double side = 0.0;
  double since_s = 1e9;
  double strength_N = 0.0;
  test::Draw draw(5);
  const Log log = test::log_of(kSampling_Hz, 46'000, x, [&](double t) {
    deflection_m = std::clamp(deflection_m + x(t) - before_m, -kSlip_m, kSlip_m);
    before_m = x(t);
    const double load_N = kMass_kg * a(t) + kFriction_N * deflection_m / kSlip_m;
    since_s += 1.0 / kSampling_Hz;
    if (load_N * side <= 0.0) {
      side = load_N > 0.0 ? 1.0 : -1.0;
      since_s = 0.0;
      strength_N = draw.uniform(6.0, 12.0);
    }
    const double ringing = std::exp(-since_s / 8e-3) * std::sin(2.0 * std::numbers::pi * 40.0 * since_s);
    return load_N + side * strength_N * ringing + 0.05 * draw.normal();
  });
  const Diagnosis is = diagnosed(log);
  EXPECT_EQ(is.verdict, Verdict::unexplained);
  EXPECT_EQ(is.steps.size(), 1u) << is.steps.back().effect;
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::reversal);
  EXPECT_NE(is.unexplained->description.find("load of the drive changes its sign"), std::string::npos)
      << is.unexplained->description;
  EXPECT_GT(is.unexplained->error_reduction, 0.5) << is.unexplained->description;
}

TEST(Causes, NoneIsFoundWhereNoneIs) {
  const Diagnosis is = diagnosed(log_and_force(0.0, no_force));
  EXPECT_EQ(is.verdict, Verdict::complete);
  EXPECT_TRUE(is.outside.causes.empty());
}

}  // namespace
}  // namespace slipstack::workbench
