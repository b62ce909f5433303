// SPDX-License-Identifier: Apache-2.0
// What the main loop keeps of the ticks, each against a plain form of the same: the history of the last
// ticks, the virgin curve and memory of the hysteresis, where position zero is, and motion that the encoder
// does not show.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <memory>
#include <vector>

#include "firmware/control/force/hysteresis_memory.h"
#include "firmware/control/homing/position_reference.h"
#include "firmware/control/supervision/unseen_motion.h"
#include "firmware/control/tick_history.h"
#include "tests/unit/draw.h"

namespace slipstack {
namespace {

/// Ticks that leave their number, and a main loop that reads them.
class ReadTicks {
 public:
  void tick() {
    ++now;
    history.entry(now).reading.counts = static_cast<std::int32_t>(now);
  }
  // `meanwhile`: ticks that come while each of them is read.
  void read(std::uint32_t meanwhile = 0) {
    seen.clear();
    missed = 0;
    history.follow(
        last, now, [this] { return now; },
        [&](const TickHistory::Entry& entry, std::uint32_t gone) {
          missed += gone;
          // What is missed lies before what is seen.
          if (!seen.empty()) {
            EXPECT_EQ(static_cast<std::uint32_t>(entry.reading.counts), seen.back() + 1 + gone);
          }
          seen.push_back(static_cast<std::uint32_t>(entry.reading.counts));
          for (std::uint32_t i = 0; i < meanwhile; ++i) tick();
        });
  }
  TickHistory history;
  std::uint32_t now = 1000, last = 1000, missed = 0;
  std::vector<std::uint32_t> seen;
};

TEST(TickHistory, IsReadOnceAndInOrderAndTellsWhatIsMissed) {
  test::Draw draw(1);
  ReadTicks one;
  std::uint32_t expected = 1001;
  for (int i = 0; i < 300; ++i) {
    const auto ticks = static_cast<std::uint32_t>(draw.below(150));
    for (std::uint32_t k = 0; k < ticks; ++k) one.tick();
    one.read();
    const std::uint32_t lost = ticks > TickHistory::kLatest ? ticks - TickHistory::kLatest : 0;
    ASSERT_EQ(one.missed, lost) << ticks;
    ASSERT_EQ(one.seen.size(), ticks - lost);
    if (!one.seen.empty()) {
      ASSERT_EQ(one.seen.front(), expected + lost);
      ASSERT_EQ(one.seen.back(), one.now);
    }
    ASSERT_EQ(one.last, one.now);
    expected = one.now + 1;
  }
}

// Ticks that come while it is read overwrite the oldest: those are missed, none is read twice or torn.
TEST(TickHistory, WhatIsOverwrittenMeanwhileIsMissed) {
  for (const std::uint32_t meanwhile : {1U, 2U, 5U}) {
    ReadTicks one;
    for (std::uint32_t k = 0; k < TickHistory::kLatest; ++k) one.tick();
    const std::uint32_t until = one.now;
    one.read(meanwhile);
    EXPECT_EQ(one.last, until) << "as far as it was asked to";
    // The n-th that is read is still there while n x meanwhile ticks have come since.
    EXPECT_EQ(one.seen.front(), 1001U);
    EXPECT_LE(one.seen.size() + one.missed, std::size_t{TickHistory::kLatest});
    if (meanwhile == 1) {
      EXPECT_EQ(one.seen.size(), std::size_t{TickHistory::kLatest});
    }
    if (meanwhile == 5) {
      EXPECT_LT(one.seen.size(), std::size_t{TickHistory::kLatest} / 2);
    }
  }
}

// No lead reaches back beyond where the reference began anew.
TEST(TickHistory, TheLeadGrowsFromWhereTheReferenceBegan) {
  TickHistory history;
  history.begin_anew(500);
  for (std::uint32_t tick = 500; tick < 600; ++tick) {
    for (const std::int32_t lead : {0, 1, 7, 63}) {
      EXPECT_EQ(history.lead_within(tick, lead), std::min(lead, static_cast<std::int32_t>(tick - 500)));
    }
    history.entry(tick).point.counts = static_cast<std::int32_t>(tick);
    EXPECT_EQ(history.behind(tick, std::min<std::int32_t>(7, static_cast<std::int32_t>(tick - 500))).counts,
              static_cast<std::int32_t>(std::max(tick - 7, 500U)));
  }
  EXPECT_EQ(history.index_number(), 0U);
  history.index_passed(-77);
  history.index_passed(55);
  EXPECT_EQ(history.index_number(), 2U);
  EXPECT_EQ(history.index_counts(), 55);
}

ModelParameters hysteresis_of(test::Draw& draw) {
  ModelParameters model{};
  auto& own = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(model);
  own.enabled = true;
  for (std::size_t i = 0; i < own.shapes.size(); ++i) {
    // In any order, some of them alike, or without a slip distance or a stiffness.
    own.shapes[i] = draw.below(6) == 0 ? 0.0F : 1e-6F * static_cast<float>(1 + draw.below(40));
    own.gains[i] = draw.below(6) == 0 ? 0.0F : static_cast<float>(draw.uniform(1e4, 1e6));
  }
  return model;
}

// The curve at any displacement is the sum of the elements there.
TEST(VirginCurveOfTheModel, IsTheSumOfItsElements) {
  test::Draw draw(2);
  for (int i = 0; i < 300; ++i) {
    ModelParameters model = hysteresis_of(draw);
    const auto& own = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(model);
    const float step_m = static_cast<float>(draw.log_uniform(5e-8, 2e-6));
    const TargetCurve curve = virgin_curve_of(model, step_m);
    for (int k = 0; k < 30; ++k) {
      const double x = std::floor(draw.uniform(0.0, 60e-6 / static_cast<double>(step_m)));
      double force_N = 0.0;
      for (std::size_t e = 0; e < own.shapes.size(); ++e) {
        const double slip = std::floor(static_cast<double>(own.shapes[e] / step_m) + 0.5);
        force_N += static_cast<double>(own.gains[e] * step_m) * std::min(x, slip);
      }
      ASSERT_NEAR(static_cast<double>(curve.force(static_cast<float>(x))), force_N, 1e-5 * force_N + 1e-6)
          << i << ' ' << x;
    }
  }
  ModelParameters without = hysteresis_of(draw);
  std::get<EffectParameters<PreslidingHysteresis<float>, float>>(without).enabled = false;
  EXPECT_EQ(virgin_curve_of(without, 1e-7F).size(), 0U);
}

// Reversals that are not wiped out yet are held; the force is that of as many elements, by the plain rule.
TEST(HysteresisMemory, FollowsElementsAndSaysHowManyReversalsItHolds) {
  test::Draw draw(3);
  for (int run = 0; run < 20; ++run) {
    const ModelParameters model = hysteresis_of(draw);
    const auto& own = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(model);
    constexpr float kStep_m = 1e-7F;
    HysteresisMemory memory;
    EXPECT_EQ(memory.depth(), 0U);
    EXPECT_EQ(memory.force_N(), 0.0F);
    const TargetCurve curve = virgin_curve_of(model, kStep_m);
    memory.take(curve, false);
    std::int32_t at = -100, last = at;
    memory.step(at);
    std::vector<double> elements(own.shapes.size(), 0.0);
    double largest_N = 0.0;
    for (int k = 0; k < 400; ++k) {
      at += static_cast<std::int32_t>(draw.uniform(-150.0, 150.0));
      memory.step(at);
      double force_N = 0.0;
      for (std::size_t e = 0; e < elements.size(); ++e) {
        const double slip = std::floor(static_cast<double>(own.shapes[e] / kStep_m) + 0.5);
        elements[e] = std::clamp(elements[e] + at - last, -slip, slip);
        force_N += static_cast<double>(own.gains[e] * kStep_m) * elements[e];
      }
      last = at;
      largest_N = std::max(largest_N, std::abs(force_N));
      // A loop that gave way to a full stack is forgotten.
      ASSERT_NEAR(static_cast<double>(memory.force_N()), force_N,
                  1e-4 * largest_N + 1e-3 + static_cast<double>(memory.overflow_height_N()))
          << run << ' ' << k;
      ASSERT_LE(memory.depth(), HysteresisMemory::kDepth);
    }
    // Other parameters with the same unit go on with the motion; with another they begin anew.
    const std::uint32_t depth = memory.depth();
    memory.take(curve, true);
    EXPECT_EQ(memory.depth(), depth);
    memory.take(curve, false);
    EXPECT_EQ(memory.depth(), 0U);
    memory.step(at);
    EXPECT_EQ(memory.force_N(), 0.0F);
    memory.take({}, true);
    memory.step(at + 50);
    EXPECT_EQ(memory.force_N(), 0.0F) << "no hysteresis";
    memory.miss(3);
    memory.miss(4);
    EXPECT_EQ(memory.missed_ticks(), 7U);
  }
}

// One element is a hysteresis, too.
TEST(HysteresisMemory, OfASingleElement) {
  ModelParameters model{};
  auto& own = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(model);
  own.enabled = true;
  own.shapes[3] = 10e-6F;
  own.gains[3] = 1e6F;
  HysteresisMemory memory;
  memory.take(virgin_curve_of(model, 1e-7F), false);
  memory.step(0);
  memory.step(50);
  EXPECT_NEAR(memory.force_N(), 5.0F, 1e-4F);
  memory.step(40);
  EXPECT_NEAR(memory.force_N(), 4.0F, 1e-4F);
  EXPECT_EQ(memory.depth(), 1U);
}

// Marks at a distance from the first one that passed; each may be off its place by the tolerance.
TEST(PositionReference, AMarkIsOffItsPlaceFromTheToleranceOn) {
  test::Draw draw(4);
  for (int run = 0; run < 500; ++run) {
    PositionReferenceParameters parameters;
    parameters.index_tolerance = 1 + static_cast<std::uint32_t>(draw.below(20));
    parameters.index_distance = run % 4 == 0 ? 0 : 100 + static_cast<std::uint32_t>(draw.below(5000));
    PositionReference place;
    place.start(parameters);
    EXPECT_TRUE(place.check_index(parameters)) << "none has passed";
    const auto first = static_cast<std::int32_t>(draw.uniform(-2e9, 2e9));
    place.index_passed(first);
    EXPECT_TRUE(place.check_index(parameters)) << "the first one says where they are";
    for (int k = 0; k < 20; ++k) {
      const auto marks = static_cast<std::int32_t>(draw.uniform(-50.0, 50.0));
      const auto whole = marks * static_cast<std::int32_t>(parameters.index_distance);
      const auto off = static_cast<std::int32_t>(draw.uniform(-45.0, 45.0));
      place.index_passed(sum(first, whole + off));
      EXPECT_EQ(place.check_index(parameters),
                static_cast<std::uint32_t>(std::abs(off)) <= parameters.index_tolerance)
          << parameters.index_distance << ' ' << off;
      EXPECT_TRUE(place.check_index(parameters)) << "each is told once";
    }
    place.lose();
    place.index_passed(sum(first, 50));
    EXPECT_TRUE(place.check_index(parameters)) << "another first one";
    parameters.index_tolerance = 0;
    place.index_passed(first);
    EXPECT_TRUE(place.check_index(parameters)) << "not checked";
  }
}

// What depends on the place comes and goes over the time of fading, and zero moves while it counts nothing.
TEST(PositionReference, ItsWeightFadesAndZeroWaitsForIt) {
  PositionReference place;
  place.start({});
  EXPECT_FALSE(place.referenced());
  EXPECT_EQ(place.weight(), 0.0F);
  place.fade(0.25F);
  EXPECT_EQ(place.weight(), 0.0F);
  EXPECT_TRUE(place.set(1000));
  EXPECT_TRUE(place.referenced());
  EXPECT_EQ(place.position_of(1500), 500);
  EXPECT_EQ(place.counts_of(-500), 500);
  for (const float wanted : {0.25F, 0.5F, 0.75F, 1.0F, 1.0F}) {
    place.fade(0.25F);
    EXPECT_EQ(place.weight(), wanted);
  }
  EXPECT_FALSE(place.set(2000)) << "it would step";
  EXPECT_EQ(place.origin(), 1000);
  EXPECT_TRUE(place.set(1000)) << "the same zero";
  place.give_up();
  for (const float wanted : {0.75F, 0.5F, 0.25F}) {
    EXPECT_FALSE(place.set(2000)) << wanted;
    place.fade(0.25F);
    EXPECT_EQ(place.weight(), wanted);
  }
  EXPECT_FALSE(place.referenced());
  place.fade(1.0F);
  EXPECT_EQ(place.weight(), 0.0F);
  EXPECT_TRUE(place.set(2000));
  EXPECT_EQ(place.origin(), 2000);
  place.start({.absolute_encoder = true, .absolute_origin = -3});
  EXPECT_TRUE(place.referenced());
  EXPECT_EQ(place.weight(), 1.0F);
  EXPECT_EQ(place.origin(), -3);
  place.lose();
  EXPECT_FALSE(place.referenced());
}

// The plain form in double: an axis of the model's mass, with more than its friction, from where the counts
// moved last.
class FreeAxis {
 public:
  explicit FreeAxis(const UnseenMotion::Settings& settings) : settings_(settings) {}
  bool step(std::int32_t counts, double current_A, bool free) {
    const std::int32_t step = counts - last_;
    last_ = counts;
    ++still_;
    const std::int32_t moved = counts - from_;
    if (std::abs(moved) > 1 || !free) {
      begin(counts, static_cast<double>(moved) / still_, std::abs(step) > 1 ? 0.0 : current_A);
      return false;
    }
    if (held_A_ * current_A < 0.0) held_A_ = 0.0;
    const double more_A = current_A - held_A_;
    double velocity = velocity_;
    if (more_A * current_A > 0.0) velocity += d(settings_.counts_per_A) * more_A;
    const bool pressed = std::abs(held_A_) > d(settings_.friction_A);
    const double slowed = std::abs(velocity) - d(pressed ? settings_.pressed : settings_.friction);
    velocity_ = slowed > 0.0 ? std::copysign(slowed, velocity) : 0.0;
    way_ += velocity_;
    if (std::abs(way_) <= d(settings_.most_counts)) return false;
    begin(counts, 0.0, current_A);
    return true;
  }

 private:
  static double d(float value) { return static_cast<double>(value); }
  void begin(std::int32_t counts, double velocity, double held_A) {
    from_ = counts;
    velocity_ = velocity;
    held_A_ = held_A;
    way_ = 0.0;
    still_ = 0;
  }
  UnseenMotion::Settings settings_;
  std::int32_t last_ = 0, from_ = 0;
  int still_ = 0;
  double held_A_ = 0.0, velocity_ = 0.0, way_ = 0.0;
};

TEST(UnseenMotionLaw, IsFoundWhenAFreeAxisWouldHaveGoneThatFar) {
  test::Draw draw(5);
  int found = 0, pressed = 0;
  for (int run = 0; run < 200; ++run) {
    UnseenMotion::Settings settings;
    settings.counts_per_A = static_cast<float>(draw.log_uniform(0.01, 0.3));
    settings.friction_A = static_cast<float>(draw.uniform(0.2, 2.0));
    settings.friction = settings.friction_A * settings.counts_per_A;
    settings.pressed = settings.friction * static_cast<float>(draw.uniform(1.2, 4.0));
    settings.most_counts = static_cast<float>(draw.log_uniform(8.0, 400.0));
    UnseenMotion unseen;
    FreeAxis axis(settings);
    TickHistory history;
    std::uint32_t now = 0;
    double counts = 0.0, velocity = 0.0, current_A = 0.0, wanted_A = 0.0;
    for (int k = 0; k < 3000; ++k) {
      if (draw.below(60) == 0) velocity = draw.below(2) == 0 ? 0.0 : draw.uniform(-3.0, 3.0);
      if (draw.below(60) == 0) wanted_A = draw.uniform(-6.0, 6.0);
      // Rises, falls, or leaps.
      current_A += draw.below(100) == 0 ? wanted_A - current_A : 0.05 * (wanted_A - current_A);
      counts += velocity;
      const auto read = static_cast<std::int32_t>(std::lround(counts)) + (draw.below(40) == 0 ? 1 : 0);
      const bool free = draw.below(200) != 0;
      history.entry(++now).reading = {read, 0, static_cast<float>(current_A)};
      const bool told = unseen.follow(
          settings, history, [&] { return now; }, free);
      ASSERT_EQ(told, axis.step(read, static_cast<double>(static_cast<float>(current_A)), free))
          << run << ' ' << k;
      found += told ? 1 : 0;
      pressed += std::abs(current_A) > static_cast<double>(settings.friction_A) ? 1 : 0;
    }
  }
  EXPECT_GT(found, 300);
  EXPECT_GT(pressed, 10000);
}

}  // namespace
}  // namespace slipstack
