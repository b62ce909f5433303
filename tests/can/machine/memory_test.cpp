// SPDX-License-Identifier: Apache-2.0
// What the observer tells of its memory, 2200h:0Eh to 11h: reversal points held, loops given up, ticks
// missed.
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

constexpr std::uint16_t kObserver = 0x2200;
constexpr std::uint8_t kDepth = 14;
constexpr std::uint8_t kOverflows = 15;
constexpr std::uint8_t kHeight = 16;
constexpr std::uint8_t kMissed = 17;

class Memory : public ::testing::Test {
 protected:
  Memory() {
    bench_.run_ms(1);  // as on a board: the tick knows the place before it has parameters
    // Without the friction observer turning points are those of the reference.
    EXPECT_EQ(bench_.read(0x2000, 0x23), 1U);
    EXPECT_EQ(bench_.write(0x2000, 0x23, 0, 1), 0U);
    bench_.configure();
    bench_.enable(1);
    home_ = bench_.read_signed(0x6064, 0);
  }

  void observe() {
    AxisParameters axis = bench_.loop->controller().parameters().axis;
    EXPECT_FALSE(axis.observe_friction);
    axis.observe_friction = true;
    const ModelParameters model = loop::identified_model(bench_.axis, 0.02, 0.01);
    EXPECT_EQ(bench_.loop->controller().configure(axis, model), ParameterStatus::kOk);
    bench_.run_ms(50);
  }
  float friction_N() { return bench_.read_real(kObserver, 5); }
  // Pushes the standing axis to and fro; by how much the model's friction changes.
  float pushed_N() {
    bench_.run_ms(300);
    const float before_N = friction_N();
    bench_.loop->pushed_N = before_N > 0.0F ? -12.0 : 12.0;
    bench_.run_ms(300);
    bench_.loop->pushed_N = 0.0;
    return std::abs(friction_N() - before_N);
  }

  // By profile position, in counts from home.
  void move(std::int32_t to) {
    ASSERT_EQ(bench_.write(0x607A, 0, static_cast<std::uint32_t>(home_ + to), 4), 0U);
    ASSERT_EQ(bench_.write(0x6040, 0, 0x1F, 2), 0U);
    ASSERT_EQ(bench_.write(0x6040, 0, 0x0F, 2), 0U);
    for (int i = 0; i < 100; ++i) {
      bench_.run_ms(5);
      if ((bench_.read(0x6041, 0) & 0x0400) != 0) break;
    }
    ASSERT_EQ(bench_.read(0x2200, 9), static_cast<std::uint32_t>(home_ + to));
  }
  std::uint32_t depth() { return bench_.read(kObserver, kDepth); }

  Bench bench_;
  std::int32_t home_ = 0;
};

// Wiping-out from the whole history: what is remembered is the farthest extremum, then the farthest one the
// other way since, and so on; the present place is none.
std::size_t remembered(const std::vector<std::int32_t>& places) {
  std::size_t from = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (std::abs(places[i]) >= std::abs(places[from])) from = i;
  }
  std::size_t count = 0;
  bool top = places[from] > 0;
  while (from + 1 < places.size()) {
    ++count;
    std::size_t next = from + 1;
    for (std::size_t i = next; i < places.size(); ++i) {
      if (top ? places[i] <= places[next] : places[i] >= places[next]) next = i;
    }
    from = next;
    top = !top;
  }
  return count;
}

TEST_F(Memory, DepthIsThatOfTheExtremesNotWipedOut) {
  move(3000);
  std::vector<std::int32_t> places = {0, 3000};
  EXPECT_EQ(depth(), 0U) << "the virgin curve: what the axis did before was less";
  std::mt19937 random(4);
  std::size_t deepest = 0;
  std::size_t wiped = 0;
  for (int i = 0; i < 60; ++i) {
    // A spiral inwards that is left now and then.
    const std::int32_t last = places.back();
    const std::int32_t reach = std::max(8, std::abs(last) * 17 / 20);
    std::int32_t to = last > 0 ? -reach : reach;
    if (random() % 7 == 0) to = static_cast<std::int32_t>(random() % 5000) - 2500;
    if (to == last) continue;
    // Turning points only: motion on in the same direction replaces the last.
    const std::size_t n = places.size();
    if (n > 1 && (places[n - 1] > places[n - 2]) == (to > places[n - 1])) places.pop_back();
    places.push_back(to);
    const std::size_t should = remembered(places);
    if (should > 16) break;
    move(to);
    ASSERT_EQ(depth(), should) << i << ": to " << to;
    wiped += should < deepest ? 1U : 0U;
    deepest = std::max(deepest, should);
  }
  EXPECT_GE(deepest, 6U);
  EXPECT_GE(wiped, 5U);
  EXPECT_EQ(bench_.read(kObserver, kOverflows), 0U);
  EXPECT_EQ(bench_.read(kObserver, kMissed), 0U);
}

TEST_F(Memory, MoreLoopsThanTheStackHoldsAreCountedAndBounded) {
  move(2100);
  std::int32_t at = 2100;
  for (int reversal = 1; reversal <= 20; ++reversal) {
    at = (at > 0 ? -1 : 1) * (2100 - 100 * reversal);
    move(at);
    // The 17th finds the stack full and takes one with it, and so does every other from then on.
    const int full = reversal <= 16 ? 0 : (reversal - 15) / 2;
    ASSERT_EQ(bench_.read(kObserver, kOverflows), static_cast<std::uint32_t>(full)) << reversal;
    ASSERT_EQ(depth(), static_cast<std::uint32_t>(reversal - 2 * full)) << reversal;
  }
  // The first to give way is the highest: from the 16th reversal, at -600, to the 17th at 500. A loop of
  // width d between reversals is sum k min(d, 2 D) high.
  const ModelParameters model = loop::identified_model(bench_.axis, 0.02, 0.01);
  const auto& own = std::get<1>(model);
  float height_N = 0.0F;
  for (std::size_t i = 0; i < own.gains.size(); ++i) {
    height_N += own.gains[i] * std::min(1100.0e-6F, 2.0F * own.shapes[i]);
  }
  EXPECT_NEAR(bench_.read_real(kObserver, kHeight), height_N, 0.02F * height_N);
  move(2500);
  EXPECT_EQ(depth(), 0U) << "beyond everything: the virgin curve";
}

// At rest the hysteresis sees the axis where the drive is told so, in moves and behind a stream that stands.
TEST_F(Memory, TheHysteresisFollowsTheAxisAtRest) {
  move(2000);
  EXPECT_EQ(pushed_N(), 0.0F);
  observe();
  EXPECT_GT(pushed_N(), 0.3F);
  ASSERT_EQ(bench_.write(0x6060, 0, 8, 1), 0U);
  EXPECT_GT(pushed_N(), 0.3F);
  EXPECT_EQ(bench_.read(0x6041, 0) & 0x6FU, 0x27U);
}

// 2000h:26, 2200h:12: the model of these tests has a hundredth more mass than the axis.
TEST(AdaptedMass, IsLearnedWhereTheDriveIsToldSo) {
  for (const bool adapts : {false, true}) {
    Bench bench;
    bench.run_ms(1);
    EXPECT_EQ(bench.read(0x2000, 0x26), 0U);
    ASSERT_EQ(bench.write(0x2000, 0x22, 1, 1), 0U);
    ASSERT_EQ(bench.write(0x2000, 0x26, adapts ? 1 : 0, 1), 0U);
    bench.configure();
    bench.enable(1);
    const std::int32_t home = bench.read_signed(0x6064, 0);
    for (int move = 0; move < 8; ++move) {
      const std::int32_t target = home + (move % 2 == 0 ? 60000 : 0);
      ASSERT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(target), 4), 0U);
      ASSERT_EQ(bench.write(0x6040, 0, 0x1F, 2), 0U);
      ASSERT_EQ(bench.write(0x6040, 0, 0x0F, 2), 0U);
      bench.run_ms(700);
    }
    const double added_kg = static_cast<double>(bench.read_real(kObserver, 18));
    EXPECT_NEAR(added_kg, adapts ? -0.01 * bench.axis.mass_kg : 0.0, 0.1);
  }
}

// The tick's elements and the stack are two descriptions of the same hysteresis.
TEST_F(Memory, ItsForceIsThatOfTheElements) {
  observe();
  std::mt19937 random(8);
  const auto agree = [&] {
    const Controller& controller = bench_.loop->controller();
    bench_.loop->controller().poll();
    const float elements_N = controller.friction().by_effect_N[1];
    ASSERT_NEAR(controller.memory().force_N(), elements_N, 0.02F);
  };
  for (int i = 0; i < 25; ++i) {
    move(static_cast<std::int32_t>(random() % 400) - 200);
    agree();
  }
  // Another level in the middle of a motion that is remembered.
  AxisParameters axis = bench_.loop->controller().parameters().axis;
  ModelParameters model = loop::identified_model(bench_.axis, 0.5, 0.0);
  std::swap(std::get<1>(model).gains[2], std::get<1>(model).gains[7]);
  std::swap(std::get<1>(model).shapes[2], std::get<1>(model).shapes[7]);
  const std::uint32_t before = depth();
  ASSERT_EQ(bench_.loop->controller().configure(axis, model), ParameterStatus::kOk);
  bench_.run_ms(2);
  EXPECT_EQ(depth(), before);
  for (int i = 0; i < 25; ++i) {
    move(static_cast<std::int32_t>(random() % 400) - 200);
    agree();
  }
}

TEST_F(Memory, TicksThatTheMainLoopComesTooLateForAreCounted) {
  move(1000);
  for (int tick = 0; tick < 200; ++tick) bench_.loop->step();
  bench_.poll();
  EXPECT_EQ(bench_.read(kObserver, kMissed), 200U - Controller::kLatest);
  for (std::uint32_t tick = 0; tick < Controller::kLatest; ++tick) bench_.loop->step();
  bench_.poll();
  EXPECT_EQ(bench_.read(kObserver, kMissed), 200U - Controller::kLatest);
}

TEST(MemoryAsDelivered, WithoutParametersNoTickIsMissed) {
  Bench bench;
  for (int i = 0; i < 3; ++i) {
    for (int tick = 0; tick < 200; ++tick) bench.loop->step();
    bench.run_ms(1);
  }
  bench.configure();
  bench.run_ms(5);
  EXPECT_EQ(bench.read(kObserver, kMissed), 0U);
}

TEST_F(Memory, WithoutHysteresisThereIsNone) {
  move(1000);
  move(-500);
  EXPECT_EQ(depth(), 1U);
  ModelParameters model = loop::identified_model(bench_.axis, 0.0, 0.0);
  std::get<1>(model).enabled = false;
  const AxisParameters axis = bench_.loop->controller().parameters().axis;
  ASSERT_EQ(bench_.loop->controller().configure(axis, model), ParameterStatus::kOk);
  bench_.run_ms(2);
  move(300);
  EXPECT_EQ(depth(), 0U);
}

}  // namespace
}  // namespace slipstack::can
