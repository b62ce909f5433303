// SPDX-License-Identifier: Apache-2.0
// A ripple repeats along the rail: traverses over whole pitches must show it, not only the places where the
// axis stands.
#include "workbench/diagnose/evidence/repeats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/unit/diagnose/diagnosed.h"
#include "tests/unit/estimate/estimate_support.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

constexpr double kPitch_m = 12e-3;
constexpr double kShortPitch_m = 1e-3;
constexpr double kStroke_m = 50e-3;
constexpr double kSeconds = 24.0;
constexpr double kCycle_s = 8.0;

/// Time within the cycle of the motion. The log begins and ends between traverses, where the filter cuts rows
/// off.
double in_cycle_s(double t) {
  return std::fmod(t + 0.5 * kCycle_s, kCycle_s);
}

/// Whether the axis is on one of the two long traverses of a cycle, which take a second each.
bool traverses(double t) {
  return in_cycle_s(t) < 2.0;
}

/// A traverse out and back in two seconds, then six seconds of moves of a tenth of a millimetre, each second
/// about another place.
double position_m(double t) {
  const double in_cycle = in_cycle_s(t);
  if (traverses(t)) return 0.5 * kStroke_m * (1.0 - std::cos(std::numbers::pi * in_cycle));
  const double second = std::floor(in_cycle) - 2.0;
  const double into = std::min(1.0, (in_cycle - 2.0 - second) / 0.5);
  const double step = 0.5 * (1.0 - std::cos(std::numbers::pi * into));
  const double place = second < 5.0 ? second + step : 5.0 * (1.0 - step);
  return 1.9e-3 * place + 1e-4 * std::sin(2.0 * std::numbers::pi * 3.0 * t) * std::sin(std::numbers::pi * t);
}

/// A ripple of which the share `in_traverses` acts in the traverses, and all of it elsewhere.
Log log_with(double in_traverses) {
  test::Draw draw(3);
  return test::log_of(1000.0, static_cast<std::size_t>(1000.0 * kSeconds), position_m, [&](double t) {
    const double ripple_N = std::cos(2.0 * std::numbers::pi * position_m(t) / kPitch_m);
    return (traverses(t) ? in_traverses : 1.0) * ripple_N + 0.02 * draw.normal();
  });
}

/// A dent, of which the share `beyond` recurs at every pitch along the rail.
Log log_with_dent(double beyond) {
  test::Draw draw(5);
  return test::log_of(1000.0, static_cast<std::size_t>(1000.0 * kSeconds), position_m, [&](double t) {
    const double pitches = position_m(t) / kPitch_m;
    const double from_middle = pitches - std::floor(pitches) - 0.5;
    const double dent_N = std::exp(-std::pow(from_middle / 0.1, 2));
    return (std::floor(pitches) == 2.0 ? 1.0 : beyond) * dent_N + 0.02 * draw.normal();
  });
}

/// A ripple with its gain fitted to all of the log.
FittedModel with_ripple(const Measurement& measurement, double pitch_m = kPitch_m) {
  Term inertia = make_term(measurement, *find_effect("inertia"));
  Term offset = make_term(measurement, *find_effect("offset_force"));
  Term ripple = make_term(measurement, *find_effect("force_ripple"));
  ripple.shapes = {pitch_m};
  return fit_gains(measurement, {inertia, offset, ripple});
}

TEST(DistanceInTraverses, CountsLongTraversesOnly) {
  const Measurement measurement(log_with(1.0));
  const double cycles = kSeconds / kCycle_s;
  EXPECT_NEAR(distance_in_traverses(measurement, kPitch_m).sum(), 2.0 * cycles * kStroke_m, 0.02 * kStroke_m);
  EXPECT_EQ(distance_in_traverses(measurement, 1.1 * kStroke_m).sum(), 0.0);
  // With a shorter required length the moves between the places are traverses too.
  EXPECT_GT(distance_in_traverses(measurement, 1.5e-3).sum(), 2.1 * cycles * kStroke_m);
}

// Where the encoder is stuck, force and recorded motion do not belong together.
TEST(DistanceInTraverses, CountsNoRowThatWasLeftOut) {
  Log log = log_with(1.0);
  constexpr std::size_t kStuck = 12300;  // on the way out
  for (std::size_t i = kStuck; i < kStuck + 300; ++i) log.position_m[i] = log.position_m[kStuck];
  const Measurement measurement(log);
  const Eigen::VectorXd way_m = distance_in_traverses(measurement, kPitch_m);
  int cut = 0;
  for (Eigen::Index row = 0; row < way_m.size(); ++row) {
    if (measurement.row_usable()(row) > 0.0) continue;
    ++cut;
    EXPECT_EQ(way_m(row), 0.0);
  }
  EXPECT_GT(cut, 0);
  EXPECT_FALSE(ripple_not_supported(measurement, with_ripple(measurement), {}));
}

TEST(ShareSupported, IsTheShareThatTheAxisShows) {
  const Eigen::VectorXd claimed_N = Eigen::VectorXd::LinSpaced(50, -1.0, 2.0);
  const Eigen::VectorXd weight = Eigen::VectorXd::Constant(50, 1e-3);
  for (const double shown : {-0.5, 0.0, 0.4, 1.0}) {
    EXPECT_NEAR(share_supported(claimed_N, (shown - 1.0) * claimed_N, weight), shown, 1e-12);
  }
  EXPECT_EQ(share_supported(claimed_N, claimed_N, Eigen::VectorXd::Zero(50)), 0.0);
}

TEST(RippleNotSupported, WhereTraversesDoNotShowIt) {
  for (const double in_traverses : {1.0, 0.8, 0.2, 0.0}) {
    Measurement measurement(log_with(in_traverses));
    EXPECT_EQ(ripple_not_supported(measurement, with_ripple(measurement), {}), in_traverses < 0.5)
        << in_traverses;
  }
}

TEST(RippleNotSupported, WhereItIsADentOfOnePlace) {
  for (const double beyond : {1.0, 0.7, 0.0}) {
    const Measurement measurement(log_with_dent(beyond));
    EXPECT_EQ(ripple_not_supported(measurement, with_ripple(measurement), {}), beyond == 0.0) << beyond;
  }
}

/// Traverses to and fro that pass a short pitch above the band of the rows, but for their ends; a ripple of
/// which the share `when_fast` acts there.
Log log_with_short_pitch(double when_fast) {
  constexpr double kTraverse_s = 2.0;
  const auto traverse_m = [](double t) {
    return 0.5 * kStroke_m * (1.0 - std::cos(std::numbers::pi * t / kTraverse_s));
  };
  test::Draw draw(9);
  return test::log_of(1000.0, 16'000, traverse_m, [&](double t) {
    const bool fast = std::abs(std::sin(std::numbers::pi * t / kTraverse_s)) > 0.2;
    const double ripple_N = std::cos(2.0 * std::numbers::pi * traverse_m(t) / kShortPitch_m);
    return (fast ? when_fast : 1.0) * ripple_N + 0.02 * draw.normal();
  });
}

TEST(RippleNotSupported, WhereTheSamplesRefuteIt) {
  for (const double when_fast : {1.0, 0.8, 0.2}) {
    ConditioningOptions options;
    options.bandwidth_Hz = 8.0;
    const Log log = log_with_short_pitch(when_fast);
    const Measurement measurement(log, options);
    EXPECT_EQ(ripple_not_supported(measurement, with_ripple(measurement, kShortPitch_m), {}), when_fast < 0.5)
        << when_fast;
    // A force that was filtered before it was recorded has lost what is above the band.
    options.force_cut_Hz = 8.0;
    const Measurement filtered(log, options);
    EXPECT_FALSE(ripple_not_supported(filtered, with_ripple(filtered, kShortPitch_m), {})) << when_fast;
  }
}

TEST(RippleNotSupported, TestsOnlyNewRipples) {
  const Measurement measurement(log_with(0.0));
  const FittedModel ripple = with_ripple(measurement);
  EXPECT_FALSE(ripple_not_supported(measurement, ripple, ripple.terms));
  const FittedModel plain = fit_gains(measurement, {make_term(measurement, *find_effect("inertia"))});
  EXPECT_FALSE(ripple_not_supported(measurement, plain, {}));
}

}  // namespace
}  // namespace slipstack::workbench
