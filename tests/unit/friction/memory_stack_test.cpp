// SPDX-License-Identifier: Apache-2.0
#include "firmware/friction/memory_stack.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <random>

#include "firmware/friction/virgin_curves.h"

namespace slipstack {
namespace {

using Real = double;
using Stack = MemoryStack<RationalCurve<Real>, 16, std::int32_t>;

constexpr double kHeight = 100.0;
constexpr double kDelta = 10.0;

// The curve written as in the paper, not as in the core.
double y(double x) {
  return kHeight * (1 - (kDelta / (x + kDelta)) * (kDelta / (x + kDelta)));
}

Stack make_stack() {
  return Stack({kHeight, kDelta});
}

TEST(MemoryStack, FollowsRuleOneOnBothSides) {
  Stack stack = make_stack();
  stack.reset(50);
  EXPECT_EQ(stack.step(50), 0.0);
  EXPECT_NEAR(stack.step(53), y(3), 1e-12);
  EXPECT_NEAR(stack.step(90), y(40), 1e-12);
  EXPECT_EQ(stack.depth(), 0U);
  stack.reset(50);
  EXPECT_NEAR(stack.step(10), -y(40), 1e-12);
  EXPECT_EQ(stack.position(), 10);
  EXPECT_EQ(stack.force_N(), stack.step(10));
}

TEST(MemoryStack, FollowsRuleTwoAfterEachReversal) {
  Stack stack = make_stack();
  stack.step(40);
  EXPECT_NEAR(stack.step(30), y(40) - 2 * y(5), 1e-12);
  EXPECT_EQ(stack.depth(), 1U);
  const double turned = stack.step(10);
  EXPECT_NEAR(turned, y(40) - 2 * y(15), 1e-12);
  EXPECT_NEAR(stack.step(16), turned + 2 * y(3), 1e-12);
  EXPECT_EQ(stack.depth(), 2U);
}

TEST(MemoryStack, GoesOnAsIfAClosedLoopHadNeverBeen) {
  Stack stack = make_stack();
  stack.step(40);
  stack.step(10);
  stack.step(25);
  EXPECT_EQ(stack.depth(), 2U);
  // Past 10 the loop 10-25 is closed: the branch from 40 goes on.
  EXPECT_NEAR(stack.step(5), y(40) - 2 * y(17.5), 1e-12);
  EXPECT_EQ(stack.depth(), 1U);
  // And up past 40: the virgin curve goes on.
  EXPECT_NEAR(stack.step(45), y(45), 1e-12);
  EXPECT_EQ(stack.depth(), 0U);
}

TEST(MemoryStack, ClosesTheFirstReversalAtItsMirrorImage) {
  Stack stack = make_stack();
  stack.step(40);
  EXPECT_NEAR(stack.step(-39), y(40) - 2 * y(39.5), 1e-12);
  EXPECT_EQ(stack.depth(), 1U);
  EXPECT_NEAR(stack.step(-40), -y(40), 1e-12);
  EXPECT_EQ(stack.depth(), 0U);
  EXPECT_NEAR(stack.step(-41), -y(41), 1e-12);
  EXPECT_NEAR(stack.step(-31), -y(41) + 2 * y(5), 1e-12);
  EXPECT_NEAR(stack.step(60), y(60), 1e-12);
}

TEST(MemoryStack, ClosesWhereALoopBeganNotAfterIt) {
  Stack stack = make_stack();
  const double top = stack.step(40);
  stack.step(10);
  EXPECT_EQ(stack.step(40), top);  // to the bit, and wiped
  EXPECT_EQ(stack.depth(), 0U);
}

TEST(MemoryStack, RestIsNoReversal) {
  Stack stack = make_stack();
  stack.step(40);
  const double force = stack.step(20);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(stack.step(20), force);
  EXPECT_EQ(stack.depth(), 1U);
  EXPECT_NEAR(stack.step(19), y(40) - 2 * y(10.5), 1e-12);
  EXPECT_EQ(stack.depth(), 1U);
}

TEST(MemoryStack, ResetForgets) {
  Stack stack = make_stack();
  for (const std::int32_t x : {40, -20, 30, 0}) stack.step(x);
  stack.reset(7);
  EXPECT_EQ(stack.depth(), 0U);
  EXPECT_EQ(stack.force_N(), 0.0);
  EXPECT_NEAR(stack.step(5), -y(2), 1e-12);
}

// Another curve in the middle of a motion: the force is what it would be had the curve been there from the
// start.
TEST(MemoryStack, TakesAnotherCurveForTheSameMotion) {
  std::mt19937 random(12);
  for (int run = 0; run < 200; ++run) {
    Stack changed({kHeight, kDelta});
    Stack should({0.3 * kHeight, 4.0 * kDelta});
    changed.reset(1000);
    should.reset(1000);
    std::int32_t x = 1000;
    const std::uint64_t change_at = random() % 40;
    for (std::uint64_t step = 0; step < 60; ++step) {
      if (step == change_at) {
        changed.set_curve({0.3 * kHeight, 4.0 * kDelta});
        ASSERT_NEAR(changed.force_N(), should.force_N(), 1e-9) << run << ' ' << step;
      }
      x += static_cast<std::int32_t>(random() % 200) - 100;
      const double is_N = changed.step(x);
      const double should_N = should.step(x);
      ASSERT_EQ(changed.depth(), should.depth());
      if (step >= change_at) {
        ASSERT_NEAR(is_N, should_N, 1e-9) << run << ' ' << step;
      }
    }
  }
}

// A copy goes on from where the other one is, and what either does then is its own.
TEST(MemoryStack, ACopyRemembersTheSameAndIsItsOwn) {
  std::mt19937 random(21);
  const auto step = [&random] { return static_cast<std::int32_t>(random() % 200) - 100; };
  for (int run = 0; run < 200; ++run) {
    Stack original = make_stack(), witness = make_stack();
    std::int32_t x = 0;
    for (auto i = random() % 60; i > 0; --i) {
      x += step();
      original.step(x);
      witness.step(x);
    }
    Stack constructed(original);
    Stack assigned = make_stack();
    for (auto i = random() % 20; i > 0; --i) assigned.step(step());
    assigned = original;
    Stack& itself = assigned;
    assigned = itself;
    // The first goes elsewhere.
    for (int i = 0; i < 20; ++i) original.step(step());
    original = make_stack();
    for (int i = 0; i < 40; ++i) {
      x += step();
      const double should_N = witness.step(x);
      ASSERT_EQ(constructed.step(x), should_N) << run << ' ' << i;
      ASSERT_EQ(assigned.step(x), should_N) << run << ' ' << i;
      ASSERT_EQ(assigned.depth(), witness.depth());
    }
  }
}

TEST(MemoryStack, RunsAtCompileTime) {
  constexpr double kForce = [] {
    Stack stack({kHeight, kDelta});
    stack.step(10);
    return stack.step(-10);
  }();
  static_assert(kForce == -75.0);
}

TEST(MemoryStack, TakesMetres) {
  MemoryStack<RationalCurve<double>, 4, double> stack({15.0, 12e-6});
  const auto curve = [](double x) { return 15.0 * (1 - 12e-6 * 12e-6 / ((x + 12e-6) * (x + 12e-6))); };
  EXPECT_NEAR(stack.step(40e-6), curve(40e-6), 1e-12);
  EXPECT_NEAR(stack.step(-3e-6), curve(40e-6) - 2 * curve(21.5e-6), 1e-12);
}

}  // namespace
}  // namespace slipstack
