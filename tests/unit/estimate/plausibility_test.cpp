// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/measurement/plausibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iostream>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "tests/unit/draw.h"
#include "tests/unit/estimate/estimate_support.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/base/axis_units.h"

// Logs that are spoiled on purpose are recognised; the same logs as they were are not called so. The axes and
// the effects that they hide are drawn by the plant, which knows nothing of the criteria.
namespace slipstack::workbench {
namespace {

constexpr std::uint64_t kSeeds = 12;
constexpr double kRadius_m = 0.05;

Log drawn(sim::Setup setup, std::uint64_t seed) {
  sim::Bench bench = sim::draw_bench(setup, seed);
  bench.rate_Hz = 1000.0;
  const sim::MotionProgramme programme = sim::draw_programme(bench, seed);
  // None, one, two or three effects beside mass and hysteresis.
  sim::add_effects(bench.axis, sim::draw_effect_ids(seed % 4, seed), programme, bench.rate_Hz, 0.0, seed);
  return test::log_of(bench.axis, sim::simulate_log(bench.axis, programme, bench.rate_Hz, seed));
}

void scale(std::vector<double>& values, double factor) {
  for (double& value : values) value *= factor;
}

/// The log of a shaft that moves like the carriage at a radius.
Log turned(Log log) {
  scale(log.position_m, 1.0 / kRadius_m);
  scale(log.force_N, kRadius_m);
  log.mass_kg = *log.mass_kg * kRadius_m * kRadius_m;
  if (log.encoder_resolution_m) log.encoder_resolution_m = *log.encoder_resolution_m / kRadius_m;
  return log;
}

std::string kinds_in(const Log& log) {
  std::string kinds;
  for (const InputWarning& warning : input_warnings(Measurement(log))) {
    kinds += (kinds.empty() ? "" : ",") + warning.kind;
  }
  return kinds;
}

struct Fault {
  const char* name;
  const char* kind;  ///< of the warning; "": none is due
  AxisKind axis;
  std::function<void(Log&)> spoil;
  double least;  ///< share of the logs in which it is recognised
};

void reverse(Log& log) {
  scale(log.force_N, -1.0);
}
void scale_position(Log& log, double factor) {
  scale(log.position_m, factor);
  if (log.encoder_resolution_m) log.encoder_resolution_m = *log.encoder_resolution_m * factor;
}

/// The force of another time; what is missing at an end is that of the end.
void delay_force(Log& log, double late_s) {
  const auto shift = static_cast<std::ptrdiff_t>(std::lround(late_s * log.sample_rate_Hz));
  const std::vector<double> force_N = log.force_N;
  for (std::ptrdiff_t i = 0; i < std::ssize(force_N); ++i) {
    const std::ptrdiff_t from = std::clamp<std::ptrdiff_t>(i - shift, 0, std::ssize(force_N) - 1);
    log.force_N[static_cast<std::size_t>(i)] = force_N[static_cast<std::size_t>(from)];
  }
}
/// A reference that is `factor` times the position.
void follow(Log& log, double factor) {
  log.reference_position_m = log.position_m;
  scale(log.reference_position_m, factor);
}

const Fault kFaults[] = {
    {"as recorded", "", AxisKind::linear, [](Log&) {}, 1.0},
    {"force reversed", "force_sign", AxisKind::linear, reverse, 0.9},
    {"position reversed", "force_sign", AxisKind::linear, [](Log& log) { scale(log.position_m, -1.0); }, 0.9},
    {"force without sign", "force_unsigned", AxisKind::linear,
     [](Log& log) {
       for (double& force : log.force_N) force = std::abs(force);
     },
     0.9},
    {"a weight that pulls", "", AxisKind::linear,
     [](Log& log) {
       double least = 0.0;
       for (const double force : log.force_N) least = std::min(least, force);
       for (double& force : log.force_N) force -= least;
     },
     1.0},
    {"mN as N", "units", AxisKind::linear, [](Log& log) { scale(log.force_N, 1e3); }, 0.85},
    {"mm as m", "units", AxisKind::linear, [](Log& log) { scale_position(log, 1e3); }, 0.9},
    {"mm as m, no mass", "units", AxisKind::linear,
     [](Log& log) {
       scale_position(log, 1e3);
       log.mass_kg.reset();
     },
     0.9},
    {"reversed, no mass", "force_sign", AxisKind::linear,
     [](Log& log) {
       reverse(log);
       log.mass_kg.reset();
     },
     0.9},
    {"force 0.2 s late", "clocks", AxisKind::linear, [](Log& log) { delay_force(log, 0.2); }, 0.6},
    {"force 0.06 s early", "clocks", AxisKind::linear, [](Log& log) { delay_force(log, -0.06); }, 0.5},
    {"force 10 ms late", "", AxisKind::linear, [](Log& log) { delay_force(log, 0.01); }, 1.0},
    {"reference in mm", "reference", AxisKind::linear, [](Log& log) { follow(log, 1e3); }, 1.0},
    {"reference reversed", "reference", AxisKind::linear, [](Log& log) { follow(log, -1.0); }, 1.0},
    {"reference with half the stroke", "", AxisKind::linear, [](Log& log) { follow(log, 0.5); }, 1.0},
    {"position and force interchanged", "reference", AxisKind::linear,
     [](Log& log) {
       follow(log, 1.0);
       std::swap(log.position_m, log.force_N);
     },
     1.0},
    {"a reference that the axis does not follow", "", AxisKind::linear,
     [](Log& log) {
       log.reference_position_m = log.position_m;
       std::reverse(log.reference_position_m.begin(), log.reference_position_m.end());
     },
     1.0},
    {"turned", "", AxisKind::rotary, [](Log&) {}, 1.0},
    {"turned, torque reversed", "force_sign", AxisKind::rotary, reverse, 0.9},
    {"turned, degrees as rad", "units", AxisKind::rotary,
     [](Log& log) { scale_position(log, 180.0 / std::numbers::pi); }, 0.85},
};

TEST(Plausibility, SpoiledLogsAreRecognisedAndOthersAreNot) {
  std::map<std::string, int> right;
  int logs = 0;
  for (const sim::Setup setup : {sim::Setup::kPickAndPlace, sim::Setup::kRandom}) {
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      const Log log = drawn(setup, seed);
      ++logs;
      for (const Fault& fault : kFaults) {
        forget_axis();
        use_axis({fault.axis, AngleUnit::radian}, "test");
        Log spoiled = fault.axis == AxisKind::rotary ? turned(log) : log;
        fault.spoil(spoiled);
        const std::string kinds = kinds_in(spoiled);
        right[fault.name] += kinds == fault.kind ? 1 : 0;
        // A fault that is not seen is passed over in silence; another one is never made up.
        EXPECT_TRUE(kinds.empty() || kinds == fault.kind)
            << fault.name << ", set-up " << static_cast<int>(setup) << ", seed " << seed << ": " << kinds;
      }
    }
  }
  forget_axis();
  for (const Fault& fault : kFaults) {
    const double share = static_cast<double>(right[fault.name]) / logs;
    std::cout << fault.name << ": " << right[fault.name] << " of " << logs << "\n";
    EXPECT_GE(share, fault.least) << fault.name;
  }
}

/// The force of a bristle (Dahl 1968) of 20 N that has its slope over `length_m`, along a motion.
std::vector<double> bristle_N(const std::vector<double>& position_m, double length_m) {
  constexpr double kLevel_N = 20.0;
  std::vector<double> force_N(position_m.size(), 0.0);
  for (std::size_t i = 1; i < position_m.size(); ++i) {
    const double step_m = position_m[i] - position_m[i - 1];
    force_N[i] = force_N[i - 1] + (kLevel_N * step_m - force_N[i - 1] * std::abs(step_m)) / length_m;
  }
  return force_N;
}

/// A motion to and fro of two frequencies against a bristle, with noise.
Log bristle_log(double frequency_Hz, double ratio, double length_m, double amplitude_m) {
  const double per_s = 2.0 * std::numbers::pi * frequency_Hz;
  const auto position_m = [&](double t) {
    return amplitude_m * (std::sin(per_s * t) + 0.5 * std::sin(ratio * per_s * t));
  };
  Log log = test::log_of(2000.0, 40'000, position_m, [](double) { return 0.0; });
  log.mass_kg = 8.0;
  log.force_N = bristle_N(log.position_m, length_m);
  test::Draw draw(7);
  for (double& force_N : log.force_N) force_N += 0.1 * draw.normal();
  return log;
}

// Before it slides an axis is a spring, which in a motion to and fro is an inertia below zero, and follows
// the motion at any lag where the motion repeats. A weight keeps its force positive.
TEST(Plausibility, AnAxisThatHardlySlidesHasNoWrongSignAndOneClock) {
  constexpr double kWeight_N = 25.0;
  for (const double frequency_Hz : {0.15, 0.3, 1.0}) {
    for (const double ratio : {2.7, 3.0}) {
      for (const double length_m : {3e-6, 10e-6, 30e-6}) {
        for (const double amplitude_m : {2e-6, 5e-6, 25e-6}) {
          Log log = bristle_log(frequency_Hz, ratio, length_m, amplitude_m);
          EXPECT_EQ(kinds_in(log), "")
              << frequency_Hz << " " << ratio << " " << length_m << " " << amplitude_m;
          for (double& force_N : log.force_N) force_N += kWeight_N;
          EXPECT_EQ(kinds_in(log), "")
              << "weight, " << frequency_Hz << " " << ratio << " " << length_m << " " << amplitude_m;
        }
      }
    }
  }
}

// Where friction is all of the force, its magnitude is near its level except at reversals.
TEST(Plausibility, ASlidingAxisWithoutInertiaNeedsItsSign) {
  for (const double frequency_Hz : {0.15, 0.3, 1.0}) {
    for (const double length_m : {3e-6, 10e-6, 30e-6}) {
      Log log = bristle_log(frequency_Hz, 2.7, length_m, 10.0 * length_m);
      for (double& force_N : log.force_N) force_N = std::abs(force_N);
      EXPECT_EQ(kinds_in(log), "force_unsigned") << frequency_Hz << " " << length_m;
    }
  }
}

}  // namespace
}  // namespace slipstack::workbench
