// SPDX-License-Identifier: Apache-2.0
// Hunting by its parts: which oscillations are found and how soon, what is none, and how the cause is told,
// on counts that are made here.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>

#include "firmware/control/hunting/hunting_watch.h"

namespace slipstack {
namespace {

constexpr double kTickOfWatch_s = 1e-4;
using Position = std::function<double(double time_s)>;  // counts

AxisParameters axis_parameters() {
  AxisParameters axis;
  axis.tick_s = static_cast<float>(kTickOfWatch_s);
  return axis;
}

ModelParameters with_friction() {
  ModelParameters model{};
  auto& coulomb = std::get<EffectParameters<Coulomb<float>, float>>(model);
  coulomb.enabled = true;
  coulomb.gains[0] = 10.0F;
  return model;
}

OscillationSearch::Settings swings(const AxisParameters& axis = axis_parameters()) {
  return HuntingWatch::settings(axis, with_friction()).swings;
}

// When an oscillation is first found, in seconds; negative: never.
double found_after(const OscillationSearch::Settings& settings, double seconds, const Position& position) {
  OscillationSearch search;
  for (int tick = 0; tick < seconds / kTickOfWatch_s; ++tick) {
    const double time_s = tick * kTickOfWatch_s;
    if (search.step(settings, static_cast<std::int32_t>(std::lround(position(time_s))))) return time_s;
  }
  return -1.0;
}

Position sine(double amplitude, double frequency_Hz, double mean = 0.0) {
  return [=](double time_s) {
    return mean + amplitude * std::sin(2.0 * std::numbers::pi * frequency_Hz * time_s);
  };
}

// ---- which oscillations ----

TEST(OscillationSearch, FindsSinesSoon) {
  for (const double frequency_Hz : {2.1, 3.0, 7.7, 20.0, 61.0, 150.0, 333.0, 700.0, 1100.0}) {
    for (const double amplitude : {2.0, 5.0, 100.0, 1e5}) {
      const double found_s = found_after(swings(), 20.0, sine(amplitude, frequency_Hz, 1e6));
      // The first period has no begin.
      const double judged_s = std::max(0.5, 8.0 / frequency_Hz);
      EXPECT_GT(found_s, judged_s) << frequency_Hz << " Hz, " << amplitude;
      EXPECT_LT(found_s, judged_s + 3.0 / frequency_Hz) << frequency_Hz << " Hz, " << amplitude;
    }
  }
}

// One that begins at any time is found within twice as long and two periods.
TEST(OscillationSearch, FindsWhatBegins) {
  for (const double frequency_Hz : {3.0, 20.0, 150.0}) {
    for (const double begin_s : {0.1, 0.37, 0.9, 1.3}) {
      const auto begins = [=](double t) {
        return t < begin_s ? std::round(sine(0.9, 11.0)(t)) : sine(10.0, frequency_Hz)(t - begin_s);
      };
      const double found_s = found_after(swings(), 20.0, begins) - begin_s;
      EXPECT_GT(found_s, 0.0);
      EXPECT_LT(found_s, 2.0 * std::max(0.5, 8.0 / frequency_Hz) + 3.0 / frequency_Hz)
          << frequency_Hz << ' ' << begin_s;
    }
  }
}

TEST(OscillationSearch, NotThoseThatAreTooSmallTooSlowOrTooFast) {
  EXPECT_LT(found_after(swings(), 10.0, sine(1.0, 20.0)), 0.0) << "two counts";
  EXPECT_LT(found_after(swings(), 20.0, sine(1000.0, 1.9)), 0.0) << "a hand";
  EXPECT_LT(found_after(swings(), 10.0, sine(1000.0, 1400.0)), 0.0) << "seven ticks a period";
  AxisParameters noisy = axis_parameters();
  noisy.friction_band_counts = 3.0F;  // six counts from peak to peak: twelve are none
  EXPECT_LT(found_after(swings(noisy), 10.0, sine(6.0, 20.0)), 0.0);
  EXPECT_GT(found_after(swings(noisy), 10.0, sine(7.0, 20.0)), 0.0);
  AxisParameters fine = axis_parameters();
  fine.encoder_resolution_m = 1e-9F;  // 0.1 um are a hundred counts
  EXPECT_LT(found_after(swings(fine), 10.0, sine(49.0, 20.0)), 0.0);
  EXPECT_GT(found_after(swings(fine), 10.0, sine(52.0, 20.0)), 0.0);
}

TEST(OscillationSearch, LimitCyclesOfOtherForms) {
  const auto saw = [](double time_s) { return 30.0 * std::fmod(time_s * 25.0, 1.0); };
  EXPECT_GT(found_after(swings(), 5.0, saw), 0.0) << "it sticks, and slips back at once";
  const auto slow_and_fast = [](double time_s) {
    const double phase = std::fmod(time_s * 25.0, 1.0);
    return phase < 0.8 ? 30.0 * phase / 0.8 : 30.0 * (1.0 - phase) / 0.2;
  };
  EXPECT_GT(found_after(swings(), 5.0, slow_and_fast), 0.0);
  const auto grows = [](double t) { return sine(3.0 * std::exp(0.3 * t), 30.0)(t); };
  EXPECT_GT(found_after(swings(), 5.0, grows), 0.0);
  const auto creeps = [](double t) { return 100.0 * t + sine(20.0, 30.0)(t); };
  EXPECT_GT(found_after(swings(), 5.0, creeps), 0.0) << "in slow motion, where the axis turns round";
}

TEST(OscillationSearch, NotWhatIsNoLimitCycle) {
  const auto rings = [](double t) {
    return sine(1000.0 * std::exp(-0.005 * 2.0 * std::numbers::pi * 30.0 * t), 30.0)(t);
  };
  EXPECT_LT(found_after(swings(), 5.0, rings), 0.0) << "a damping of half a per cent";
  const auto fast = [](double t) { return 20000.0 * t + sine(20.0, 30.0)(t); };
  EXPECT_LT(found_after(swings(), 5.0, fast), 0.0) << "a ripple that never turns the axis round";
  const auto beats = [](double t) { return sine(20.0, 30.0)(t) * sine(1.0, 3.0)(t); };
  EXPECT_LT(found_after(swings(), 10.0, beats), 0.0);
}

// Noise of any band, far above what 2000h:24 says, for ten minutes of each.
TEST(OscillationSearch, NoiseIsNone) {
  int found = 0;
  for (const double share : {1.0, 0.3, 0.1, 0.03, 0.01}) {
    for (const double sigma : {1.0, 3.0, 30.0}) {
      std::mt19937 random(17);
      std::normal_distribution<double> normal;
      double filtered = 0.0;
      OscillationSearch search;
      // A first-order low-pass, scaled so that its output has this deviation.
      const double input = sigma * std::sqrt((2.0 - share) / share);
      for (int tick = 0; tick < 6'000'000; ++tick) {
        filtered += share * (input * normal(random) - filtered);
        found += search.step(swings(), static_cast<std::int32_t>(std::lround(filtered))) ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(found, 0);
}

/// How often in ten minutes an oscillation is found in a resonance that noise excites, 20 counts rms.
int found_in_resonance(double frequency_Hz, double damping) {
  std::mt19937 random(23);
  std::normal_distribution<double> normal;
  const double rate = 2.0 * std::numbers::pi * frequency_Hz;
  const double input = 20.0 * std::sqrt(4.0 * damping * rate * rate * rate / kTickOfWatch_s);
  double position = 0.0, velocity = 0.0;
  OscillationSearch search;
  int found = 0;
  for (int tick = 0; tick < 6'000'000; ++tick) {
    velocity +=
        kTickOfWatch_s * (input * normal(random) - 2.0 * damping * rate * velocity - rate * rate * position);
    position += kTickOfWatch_s * velocity;
    found += search.step(swings(), static_cast<std::int32_t>(std::lround(position))) ? 1 : 0;
  }
  return found;
}

// Its swings grow and fade; where that takes longer than what is judged together nothing tells it from a
// limit cycle, and an axis that rings so long nearly is one.
TEST(OscillationSearch, AResonanceUnderNoiseIsNoneUnlessItRingsFor0s5) {
  for (const double frequency_Hz : {10.0, 50.0, 200.0}) EXPECT_EQ(found_in_resonance(frequency_Hz, 0.2), 0);
  for (const double frequency_Hz : {50.0, 200.0}) EXPECT_EQ(found_in_resonance(frequency_Hz, 0.05), 0);
  EXPECT_EQ(found_in_resonance(200.0, 0.02), 0);
  const int rings = found_in_resonance(10.0, 0.02);
  EXPECT_GT(rings, 20);
  EXPECT_LT(rings, 200);
}

// Counters wrap round.
TEST(OscillationSearch, PlacesDoNotMatter) {
  const double here = found_after(swings(), 5.0, sine(50.0, 30.0));
  OscillationSearch search;
  double there = -1.0;
  for (int tick = 0; there < 0.0 && tick < 50000; ++tick) {
    const auto offset = static_cast<std::int32_t>(std::lround(sine(50.0, 30.0)(tick * kTickOfWatch_s)));
    if (search.step(swings(), sum(0x7FFFFFFF, offset))) there = tick * kTickOfWatch_s;
  }
  EXPECT_EQ(here, there);
}

// ---- whose fault ----

using Drive = HuntingWatch::Drive;

/// An axis whose swing depends on what is in force; it swings to the new size within some periods.
struct HuntingAxis {
  explicit HuntingAxis(const std::function<void(AxisParameters&)>& differs = {}) {
    AxisParameters axis = axis_parameters();
    axis.disturbance_share = 1.0F;
    if (differs) differs(axis);
    settings = HuntingWatch::settings(axis, with_friction());
  }
  void run(double seconds) {
    for (int tick = 0; tick < seconds / kTickOfWatch_s; ++tick) {
      time_s += kTickOfWatch_s;
      const double wanted = size(*this);
      amplitude += 0.002 * (wanted - amplitude);
      const double phase = 2.0 * std::numbers::pi * frequency_Hz * time_s;
      watch.step(settings, point, static_cast<std::int32_t>(std::lround(amplitude * std::sin(phase))), drive);
    }
  }

  HuntingWatch::Settings settings;
  HuntingWatch watch;
  std::function<double(const HuntingAxis&)> size = [](const HuntingAxis&) { return 0.0; };
  double frequency_Hz = 40.0;
  ReferencePoint point;
  Drive drive = Drive::kPosition;
  double time_s = 0.0;
  double amplitude = 0.0;
};

double by_friction(const HuntingAxis& axis) {
  return 20.0 * static_cast<double>(axis.watch.friction_share());
}
double by_observer(const HuntingAxis& axis) {
  return 20.0 * static_cast<double>(axis.watch.disturbance_share());
}

TEST(Hunting, TheFrictionIsLoweredAndStaysSo) {
  HuntingAxis axis;
  axis.size = by_friction;
  axis.run(12.0);
  EXPECT_EQ(axis.watch.cause(), HuntingCause::kFriction);
  EXPECT_EQ(axis.watch.warning(), HuntingCause::kFriction);
  EXPECT_EQ(axis.watch.state(), HuntingState::kLowered);
  EXPECT_EQ(axis.watch.friction_share(), 0.0F);
  EXPECT_EQ(axis.watch.disturbance_share(), 1.0F) << "it was tried first, and is not to blame";
  EXPECT_EQ(axis.watch.found(), 1);
  EXPECT_NEAR(1.0 / (static_cast<double>(axis.watch.oscillation().period_ticks) * kTickOfWatch_s), 40.0, 1.0);
  EXPECT_NEAR(axis.watch.oscillation().swing_counts, 40, 3);
  axis.run(100.0);
  EXPECT_EQ(axis.watch.friction_share(), 0.0F);
  axis.watch.forget();
  EXPECT_EQ(axis.watch.state(), HuntingState::kWatching);
  axis.run(0.25);
  EXPECT_EQ(axis.watch.friction_share(), 1.0F);
  axis.run(12.0);
  EXPECT_EQ(axis.watch.cause(), HuntingCause::kFriction) << "again";
  EXPECT_EQ(axis.watch.found(), 2);
}

TEST(Hunting, TheDisturbanceObserverIsLoweredAlone) {
  HuntingAxis axis;
  axis.size = by_observer;
  axis.run(8.0);
  EXPECT_EQ(axis.watch.cause(), HuntingCause::kDisturbanceObserver);
  EXPECT_EQ(axis.watch.disturbance_share(), 0.0F);
  EXPECT_EQ(axis.watch.friction_share(), 1.0F);
  EXPECT_EQ(axis.watch.state(), HuntingState::kLowered);
  // The next one, by the friction, is told apart.
  axis.size = by_friction;
  axis.run(12.0);
  EXPECT_EQ(axis.watch.cause(), HuntingCause::kFriction);
  EXPECT_EQ(axis.watch.disturbance_share(), 0.0F);
  EXPECT_EQ(axis.watch.friction_share(), 0.0F);
}

// In torque mode no disturbance is compensated, whatever its share.
TEST(Hunting, InTorqueModeOnlyTheFrictionIsTried) {
  HuntingAxis axis([](AxisParameters& a) { a.torque_friction_share = 1.0F; });
  ASSERT_TRUE(axis.settings.torque && axis.settings.disturbance);
  axis.drive = Drive::kTorque;
  axis.size = by_friction;
  for (int part = 0; part < 120; ++part) {
    axis.run(0.1);
    ASSERT_EQ(axis.watch.disturbance_share(), 1.0F) << part;
  }
  EXPECT_EQ(axis.watch.cause(), HuntingCause::kFriction);
  EXPECT_EQ(axis.watch.friction_share(), 0.0F);
}

TEST(Hunting, WhatGoesOnIsNotTheCompensation) {
  HuntingAxis axis;
  axis.size = [](const HuntingAxis&) { return 20.0; };
  axis.run(6.0);
  EXPECT_EQ(axis.watch.cause(), HuntingCause::kElsewhere);
  EXPECT_EQ(axis.watch.state(), HuntingState::kGoesOn);
  EXPECT_EQ(axis.watch.friction_share(), 1.0F);
  EXPECT_EQ(axis.watch.disturbance_share(), 1.0F);
  axis.run(300.0);
  EXPECT_EQ(axis.watch.found(), 1) << "as long as it goes on it is tried once";
  axis.size = [](const HuntingAxis&) { return 0.0; };
  axis.run(3.0);
  EXPECT_EQ(axis.watch.warning(), HuntingCause::kNone);
  EXPECT_EQ(axis.watch.cause(), HuntingCause::kElsewhere) << "what was found last stays";
}

// What swings by less than half once the compensation is lowered has it lowered, though it goes on.
TEST(Hunting, HalfOfItIsTheLesserEvil) {
  for (const double added : {15.0, 30.0}) {
    HuntingAxis axis([](AxisParameters& p) { p.disturbance_share = 0.0F; });
    axis.size = [added](const HuntingAxis& own) {
      return 20.0 + added * static_cast<double>(own.watch.friction_share());
    };
    axis.run(12.0);
    EXPECT_EQ(axis.watch.warning(), HuntingCause::kElsewhere);
    EXPECT_EQ(axis.watch.friction_share(), added > 20.0 ? 0.0F : 1.0F);
  }
}

// A vibration that ends while the compensation is lowered does not take it away; twice in the ramp it would.
TEST(Hunting, WhatEndsByItselfIsNotBlamedOnTheCompensation) {
  HuntingAxis axis([](AxisParameters& p) { p.disturbance_share = 0.0F; });
  for (int times = 0; times < 5; ++times) {
    axis.size = [](const HuntingAxis&) { return 20.0; };
    for (int i = 0; i < 500 && axis.watch.state() != HuntingState::kTrying; ++i) axis.run(0.01);
    axis.run(0.8);
    axis.size = [](const HuntingAxis&) { return 0.0; };
    axis.run(8.0);
    EXPECT_NE(axis.watch.cause(), HuntingCause::kFriction);
    EXPECT_EQ(axis.watch.friction_share(), 1.0F);
    EXPECT_EQ(axis.watch.warning(), HuntingCause::kNone);
  }
}

// It hunts once it is pushed, and as long as the compensation lets it.
TEST(Hunting, WhatStopsWithTheRampTwiceIsTheCause) {
  HuntingAxis axis([](AxisParameters& p) { p.disturbance_share = 0.0F; });
  bool pushed = true;
  axis.size = [&pushed](const HuntingAxis& own) {
    pushed = pushed && own.watch.friction_share() > 0.5F;
    return pushed ? 20.0 : 0.0;
  };
  axis.run(12.0);
  EXPECT_EQ(axis.watch.cause(), HuntingCause::kEnded);
  EXPECT_EQ(axis.watch.friction_share(), 1.0F);
  pushed = true;
  axis.run(12.0);
  EXPECT_EQ(axis.watch.cause(), HuntingCause::kFriction);
  EXPECT_EQ(axis.watch.friction_share(), 0.0F);
  EXPECT_EQ(axis.watch.found(), 2);
}

TEST(Hunting, OnlyOfAnAxisThatIsFreeAndSteady) {
  const auto found = [](const std::function<void(HuntingAxis&)>& differs) {
    HuntingAxis axis;
    axis.size = by_friction;
    differs(axis);
    axis.run(2.0);
    return axis.watch.found();
  };
  EXPECT_EQ(found([](HuntingAxis&) {}), 1);
  EXPECT_EQ(found([](HuntingAxis& a) { a.drive = Drive::kNotFree; }), 0);
  EXPECT_EQ(found([](HuntingAxis& a) { a.drive = Drive::kTorque; }), 0) << "nothing there is compensated";
  EXPECT_EQ(found([](HuntingAxis& a) { a.settings.torque = true, a.drive = Drive::kTorque; }), 1);
  EXPECT_EQ(found([](HuntingAxis& a) { a.settings.on = false; }), 0);
  EXPECT_EQ(found([](HuntingAxis& a) { a.point.velocity = 0.05F; }), 1) << "slow motion";
}

// The axis follows a small sine, over all its frequencies: found nowhere.
TEST(Hunting, AReferenceThatSwaysIsNotSteady) {
  for (const double frequency_Hz : {2.1, 5.0, 20.0, 100.0, 400.0}) {
    HuntingAxis axis;
    const double w = 2.0 * std::numbers::pi * frequency_Hz * kTickOfWatch_s;
    for (const double amplitude : {1.6, 5.0, 100.0}) {
      for (int tick = 0; tick < 50000; ++tick) {
        axis.point.velocity = static_cast<float>(amplitude * w * std::cos(w * tick));
        const double counts = amplitude * std::sin(w * tick);
        axis.watch.step(axis.settings, axis.point, static_cast<std::int32_t>(std::lround(counts)),
                        axis.drive);
      }
    }
    EXPECT_EQ(axis.watch.found(), 0) << frequency_Hz;
  }
}

// A trial ends with what it waits for: a move, a stop.
TEST(Hunting, AMoveEndsATrial) {
  HuntingAxis axis;
  axis.size = [](const HuntingAxis&) { return 20.0; };
  for (int i = 0; i < 500 && axis.watch.state() != HuntingState::kTrying; ++i) axis.run(0.01);
  axis.run(0.15);
  EXPECT_LT(axis.watch.disturbance_share(), 0.5F);
  axis.point.velocity = 3.0F;
  axis.run(0.25);
  EXPECT_EQ(axis.watch.disturbance_share(), 1.0F);
}

// No share changes by more than its ramp.
TEST(Hunting, SharesChangeByARamp) {
  HuntingAxis axis;
  axis.size = by_friction;
  float friction = 1.0F, observer = 1.0F, largest = 0.0F;
  for (int tick = 0; tick < 120000; ++tick) {
    axis.run(0.5 * kTickOfWatch_s);
    largest = std::max({largest, std::fabs(axis.watch.friction_share() - friction),
                        std::fabs(axis.watch.disturbance_share() - observer)});
    friction = axis.watch.friction_share();
    observer = axis.watch.disturbance_share();
  }
  EXPECT_EQ(axis.watch.cause(), HuntingCause::kFriction);
  EXPECT_LT(largest, 1.01F * 2.0F * axis.settings.ramp);
  EXPECT_GT(largest, 0.99F * axis.settings.ramp);
}

}  // namespace
}  // namespace slipstack
