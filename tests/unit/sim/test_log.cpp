// SPDX-License-Identifier: Apache-2.0
// Logs: they repeat, their parts add up, and what is hidden can be seen.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "sim_host/log/closed_loop.h"
#include "sim_host/log/draw.h"
#include "sim_host/log/record.h"
#include "sim_host/log/write.h"
#include "sim_host/sensors/low_pass.h"

namespace slipstack::sim {
namespace {

struct Scene {
  Bench bench;
  MotionProgramme programme;
};

Scene make_scene(Setup setup, std::uint64_t seed, double seconds) {
  Scene scene{draw_bench(setup, seed), {}};
  scene.bench.programme.seconds = seconds;
  Rng rng(seed, "motion");
  scene.programme = make_test_programme(scene.bench.axis, scene.bench.programme, rng);
  return scene;
}

void expect_parts_add_up(const SimulatedLog& log) {
  ASSERT_EQ(log.parts_N.size(), log.size());
  for (std::size_t i = 0; i < log.size(); ++i) {
    double sum = 0.0;
    for (const double part : log.parts_N[i]) sum += part;
    ASSERT_NEAR(log.force_N[i] - log.noise_N[i], sum, 1e-9 * (1.0 + std::fabs(log.force_N[i]))) << i;
  }
}

TEST(Log, ForceMinusNoiseIsTheSumOfTheDeclaredParts) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    Scene scene = make_scene(Setup::kRandom, seed, 12.0);
    add_effects(scene.bench.axis, drawable_effects(), scene.programme, 1000.0, 3.0, seed);
    for (const OutsideKind kind : {OutsideKind::kLine, OutsideKind::kBump, OutsideKind::kBurst,
                                   OutsideKind::kSlip, OutsideKind::kRing, OutsideKind::kForceFilter}) {
      add_outside(scene.bench.axis, kind, scene.programme, 1000.0, 3.0, seed);
    }
    if (seed % 2 == 0)
      add_outside(scene.bench.axis, OutsideKind::kBacklash, scene.programme, 1000.0, 3.0, seed);
    const SimulatedLog log = simulate_log(scene.bench.axis, scene.programme, 1000.0, seed, true);
    expect_parts_add_up(log);
    for (const EffectId id : drawable_effects()) EXPECT_GT(log.parts_rms_N[index(id)], 0.0) << name(id);
    EXPECT_GT(log.parts_rms_N[index(EffectId::kOutside)], 0.0);
  }
}

TEST(Log, ClosedLoopForceIsTheSumOfTheDeclaredPartsToo) {
  Scene scene = make_scene(Setup::kPickAndPlace, 2, 10.0);
  add_effects(scene.bench.axis, {EffectId::kStribeck, EffectId::kForceRipple, EffectId::kTimeDelay},
              scene.programme, 2000.0, 3.0, 2);
  const SimulatedLog log = simulate_closed_loop_log(scene.bench.axis, scene.programme, 2000.0, 2, true);
  expect_parts_add_up(log);
  double worst = 0.0;
  for (std::size_t i = 0; i < log.size(); ++i) {
    worst = std::max(worst, std::fabs(log.reference_position_m[i] - log.true_position_m[i]));
  }
  EXPECT_LT(worst, 1e-3);
  EXPECT_GT(worst, 2e-6) << "a controller without following error";
}

// The amplifier's noise moves the axis but is not in the command of the same tick, which is computed before.
TEST(Log, ClosedLoopCommandDoesNotKnowTheNoiseToCome) {
  Scene scene = make_scene(Setup::kPickAndPlace, 3, 10.0);
  scene.bench.axis.force_noise_N = 5.0;
  scene.bench.axis.encoder_resolution_m = 1e-8;
  const SimulatedLog log = simulate_closed_loop_log(scene.bench.axis, scene.programme, 2000.0, 3);
  double product = 0.0;
  double noise_squares = 0.0;
  double step_squares = 0.0;
  for (std::size_t i = 1; i < log.size(); ++i) {
    const double step_N = log.force_N[i] - log.force_N[i - 1];
    product += step_N * log.noise_N[i];
    noise_squares += log.noise_N[i] * log.noise_N[i];
    step_squares += step_N * step_N;
  }
  EXPECT_NEAR(product / std::sqrt(noise_squares * step_squares), 0.0, 0.05);
  EXPECT_NEAR(std::sqrt(noise_squares / static_cast<double>(log.size())), 5.0, 0.1);
}

TEST(Log, TheSameSeedGivesTheSameBytes) {
  const auto bytes = [](std::uint64_t seed) {
    Scene scene = make_scene(Setup::kRandom, seed, 10.0);
    const auto effects = draw_effect_ids(2, seed);
    add_effects(scene.bench.axis, effects, scene.programme, 1000.0, 0.0, seed);
    const SimulatedLog log = simulate_log(scene.bench.axis, scene.programme, 1000.0, seed);
    return log_as_csv(scene.bench.axis, log) +
           truth_as_json(scene.bench.axis, log, {"random", seed, false, effects, ""});
  };
  EXPECT_EQ(bytes(7), bytes(7));
  EXPECT_NE(bytes(7), bytes(8));
}

// Every effect, several axes: alone on the axis, at least 1.5 × the noise, and nothing else hidden beside it.
TEST(Log, HiddenEffectsStandOutFromTheNoise) {
  for (const EffectId id : drawable_effects()) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      Scene scene = make_scene(Setup::kRandom, seed, 10.0);
      const double quiet_N = scene.bench.axis.force_noise_N;
      add_effects(scene.bench.axis, {id}, scene.programme, 1000.0, 0.0, seed);
      const Axis& axis = scene.bench.axis;
      const SimulatedLog log = simulate_log(axis, scene.programme, 1000.0, seed);
      const double rms_N = log.parts_rms_N[index(id)];
      EXPECT_GE(rms_N, 1.4 * axis.force_noise_N) << name(id) << " seed " << seed;
      EXPECT_LE(rms_N, 20.0 * noise_floor_N(axis)) << name(id) << " seed " << seed;
      EXPECT_LE(axis.force_noise_N, quiet_N);
      EXPECT_GT(axis.force_noise_N, 0.0);
      for (std::size_t i = 0; i < kEffectCount; ++i) {
        const bool expected =
            i == index(id) || i == index(EffectId::kInertia) || i == index(EffectId::kPreslidingHysteresis);
        EXPECT_EQ(log.parts_rms_N[i] > 0.0, expected) << kEffectNames[i] << " in a log of " << name(id);
      }
    }
  }
}

TEST(Log, StrengthIsWhatWasAskedFor) {
  for (const EffectId id :
       {EffectId::kViscous, EffectId::kStribeck, EffectId::kOffsetForce, EffectId::kPayloadMass}) {
    Scene scene = make_scene(Setup::kPickAndPlace, 3, 15.0);
    const double wanted_N = 2.0 * noise_floor_N(scene.bench.axis);
    add_effects(scene.bench.axis, {id}, scene.programme, 1000.0, 2.0, 3);
    const SimulatedLog log = simulate_log(scene.bench.axis, scene.programme, 1000.0, 3);
    EXPECT_NEAR(log.parts_rms_N[index(id)], wanted_N, 0.03 * wanted_N) << name(id);
  }
}

TEST(Log, NothingHiddenMeansInertiaHysteresisAndNoise) {
  Scene scene = make_scene(Setup::kPickAndPlace, 1, 20.0);
  const SimulatedLog log = simulate_log(scene.bench.axis, scene.programme, 2000.0, 1, true);
  double squares = 0.0;
  for (std::size_t i = 0; i < log.size(); ++i) {
    const double rest = log.force_N[i] - log.parts_N[i][index(EffectId::kInertia)] -
                        log.parts_N[i][index(EffectId::kPreslidingHysteresis)];
    squares += rest * rest;
    // Half a count, and up to one for where on its grating the axis was switched on.
    ASSERT_LE(std::fabs(log.position_m[i] - log.true_position_m[i]), 1.5e-6);
  }
  const double noise_N = std::sqrt(squares / static_cast<double>(log.size()));
  EXPECT_NEAR(noise_N, scene.bench.axis.force_noise_N, 0.02 * noise_N);
}

// [1], set-up 3, as far as the paper tells it.
TEST(Log, PickAndPlaceAxisIsThatOfThePaper) {
  const Bench bench = draw_bench(Setup::kPickAndPlace, 9);
  EXPECT_EQ(bench.axis.mass_kg, 35.45);
  EXPECT_EQ(bench.axis.encoder_resolution_m, 1e-6);
  EXPECT_DOUBLE_EQ(bench.axis.curve.saturation_N(), 15.0);
  EXPECT_EQ(bench.programme.largest_loop_m, 40e-6);
  EXPECT_EQ(bench.axis.curve.terms().size(), 2U);
  // A loop of ±40 µm reaches the saturation, as the paper's loops do.
  EXPECT_GT(bench.axis.curve.force_N(40e-6), 0.95 * 15.0);
}

TEST(Log, DrawsEveryEffectAndNoContradictions) {
  PerEffect seen{};
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const auto pair = draw_effect_ids(2, seed);
    ASSERT_EQ(pair.size(), 2U);
    ASSERT_NE(pair[0], pair[1]);
    const bool twins = (pair[0] == EffectId::kStribeck && pair[1] == EffectId::kFrictionalLag) ||
                       (pair[1] == EffectId::kStribeck && pair[0] == EffectId::kFrictionalLag);
    ASSERT_FALSE(twins);
    seen[index(pair[0])] += 1.0;
  }
  for (const EffectId id : drawable_effects()) EXPECT_GT(seen[index(id)], 8.0) << name(id);
}

TEST(Log, RefusesEffectsThatCannotBeHidden) {
  Scene scene = make_scene(Setup::kPickAndPlace, 1, 8.0);
  EXPECT_THROW(add_effects(scene.bench.axis, {EffectId::kInertia}, scene.programme, 1000.0, 0.0, 1),
               std::invalid_argument);
}

TEST(Log, BurstSlipAndLineShowWhereTheyAre) {
  Scene scene = make_scene(Setup::kPickAndPlace, 4, 12.0);
  Axis axis = scene.bench.axis;
  axis.force_noise_N = 0.0;
  const SimulatedLog clean = simulate_log(axis, scene.programme, 1000.0, 4);
  axis.outside.burst = Burst{3.0, 0.1, 50.0};
  axis.outside.slip = EncoderSlip{{{6.0, 25.0}}};
  const SimulatedLog dirty = simulate_log(axis, scene.programme, 1000.0, 4);
  double outside_N = 0.0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const double t = clean.time_s(i);
    const double difference = std::fabs(dirty.force_N[i] - clean.force_N[i]);
    if (t >= 3.0 && t < 3.1) {
      outside_N = std::max(outside_N, difference);
    } else {
      ASSERT_EQ(difference, 0.0) << t;
    }
    ASSERT_NEAR(clean.position_m[i] - dirty.position_m[i], t >= 6.0 ? 25e-6 : 0.0, 1e-12);
  }
  EXPECT_GT(outside_N, 25.0);
  EXPECT_LE(outside_N, 50.0);
}

// Above the band in which logs are judged, as strong as asked; the motion and the noise are those without it.
TEST(Log, RingIsAboveTheBandAndNoMotion) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Scene scene = make_scene(Setup::kRandom, seed, 12.0);
    Axis axis = scene.bench.axis;
    add_outside(axis, OutsideKind::kRing, scene.programme, 1000.0, 2.0, seed);
    ASSERT_TRUE(axis.outside.ring);
    EXPECT_GT(axis.outside.ring->frequency_Hz, 1000.0 / 20.0);
    EXPECT_LT(axis.outside.ring->frequency_Hz, 1000.0 / 4.0);
    EXPECT_GE(axis.outside.ring->damping_ratio, 0.003);
    EXPECT_LE(axis.outside.ring->damping_ratio, 0.04);
    const SimulatedLog with = simulate_log(axis, scene.programme, 1000.0, seed);
    const SimulatedLog without = simulate_log(scene.bench.axis, scene.programme, 1000.0, seed);
    EXPECT_EQ(with.position_m, without.position_m);
    EXPECT_EQ(with.noise_N, without.noise_N);
    EXPECT_DOUBLE_EQ(with.ring_rms_N, with.parts_rms_N[index(EffectId::kOutside)]);
    EXPECT_EQ(without.ring_rms_N, 0.0);
    const double asked_N = 2.0 * noise_floor_N(axis);
    if (axis.outside.ring->share < 1.0) {
      EXPECT_NEAR(with.ring_rms_N, asked_N, 1e-6 * asked_N);
    } else {
      EXPECT_LT(with.ring_rms_N, asked_N);
    }
  }
}

TEST(Log, AFilteredForceIsThatOfTheLogWithoutTheFilter) {
  Scene scene = make_scene(Setup::kPickAndPlace, 4, 12.0);
  Axis axis = scene.bench.axis;
  add_outside(axis, OutsideKind::kForceFilter, scene.programme, 1000.0, 0.0, 4);
  ASSERT_TRUE(axis.outside.force_filter);
  const ForceFilter& filter = *axis.outside.force_filter;
  for (const bool closed_loop : {false, true}) {
    const auto log_of = [&](const Axis& of) {
      return closed_loop ? simulate_closed_loop_log(of, scene.programme, 1000.0, 4, true)
                         : simulate_log(of, scene.programme, 1000.0, 4, true);
    };
    const SimulatedLog with = log_of(axis);
    const SimulatedLog without = log_of(scene.bench.axis);
    EXPECT_EQ(with.position_m, without.position_m);
    EXPECT_EQ(with.force_N,
              low_passed(without.force_N, 1000.0, filter.cut_Hz, filter.order, filter.zero_phase));
    expect_parts_add_up(with);
    EXPECT_GT(with.parts_rms_N[index(EffectId::kOutside)], 0.5 * axis.force_noise_N);
  }
}

// Like /dev/null: a rename would put a file in its place.
TEST(WriteFile, WritesIntoWhatIsNoRegularFile) {
  const std::string pipe = testing::TempDir() + "write_file_pipe";
  std::remove(pipe.c_str());
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDWR | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  write_file(pipe, "content");
  std::string read_back(100, ' ');
  const ssize_t count = read(reader, read_back.data(), read_back.size());
  close(reader);
  EXPECT_EQ(read_back.substr(0, count > 0 ? static_cast<std::size_t>(count) : 0), "content");
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
  std::remove(pipe.c_str());
}

}  // namespace
}  // namespace slipstack::sim
