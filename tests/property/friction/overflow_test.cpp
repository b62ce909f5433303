// SPDX-License-Identifier: Apache-2.0
// A full stack: the innermost loop gives way, counted, with an error that its height bounds, gone when it is
// left.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "firmware/friction/memory_stack.h"
#include "tests/property/friction/motion.h"

namespace slipstack::test {
namespace {

constexpr RationalCurve<double> kCurve{15.0, 12.0};
constexpr std::size_t kDeep = 256;

template <std::size_t Depth>
void expect_bounded_error(std::uint64_t seed) {
  MemoryStack<RationalCurve<double>, kDeep, std::int32_t> exact(kCurve);
  MemoryStack<RationalCurve<double>, Depth, std::int32_t> shallow(kCurve);
  NestedMotion motion(seed, 100);
  double worst = 0;
  for (int i = 0; i < 100000; ++i) {
    const std::int32_t x = motion.next();
    const double error = std::abs(exact.step(x) - shallow.step(x));
    ASSERT_LE(error, shallow.overflow_height_N() + 1e-12) << "step " << i;
    ASSERT_LE(shallow.depth(), Depth);
    // What both remember they agree on; on the virgin curve that is everything.
    if (exact.depth() < 2) {
      ASSERT_EQ(error, 0.0) << "step " << i;
    }
    worst = std::max(worst, error);
  }
  EXPECT_GT(shallow.overflow_count(), 100U);
  EXPECT_GT(worst, 0.1);  // the stack was too small, and it showed
  EXPECT_EQ(exact.overflow_count(), 0U);
}

TEST(Overflow, ErrorStaysBelowTheHeightOfTheLoopsThatGaveWay) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    expect_bounded_error<2>(seed);
    expect_bounded_error<3>(seed);
    expect_bounded_error<8>(seed);
    expect_bounded_error<15>(seed);
  }
}

TEST(Overflow, CountsEveryLoopThatGivesWay) {
  MemoryStack<RationalCurve<double>, 16, std::int32_t> stack(kCurve);
  // 17 reversals: the first 16 are held, the 17th takes the 16th with it.
  for (std::int32_t i = 0; i < 17; ++i) stack.step((i % 2 == 0 ? 1 : -1) * (1000 - 10 * i));
  EXPECT_EQ(stack.depth(), 16U);
  EXPECT_EQ(stack.overflow_count(), 0U);
  stack.step(-800);
  EXPECT_EQ(stack.depth(), 15U);
  EXPECT_EQ(stack.overflow_count(), 1U);
  // Spiralling on, every second reversal finds the stack full again.
  for (std::int32_t i = 0; i < 10; ++i) stack.step((i % 2 == 0 ? 1 : -1) * (700 - 10 * i));
  EXPECT_EQ(stack.overflow_count(), 6U);
}

// Keeping the stored force instead of taking it anew ratchets: a small cycle at a full stack would climb for
// ever.
TEST(Overflow, DoesNotRatchet) {
  MemoryStack<RationalCurve<double>, 4, std::int32_t> stack(kCurve);
  for (std::int32_t i = 0; i < 5; ++i) stack.step((i % 2 == 0 ? 1 : -1) * (100 - 10 * i));
  double first = 0;
  for (int cycle = 0; cycle < 1000; ++cycle) {
    stack.step(10);
    stack.step(20);
    stack.step(12);
    const double force = stack.step(18);
    if (cycle == 1) first = force;
    if (cycle > 1) {
      ASSERT_EQ(force, first) << "cycle " << cycle;
    }
  }
  EXPECT_GT(stack.overflow_count(), 500U);
}

TEST(Overflow, IsForgottenOnceTheLoopIsLeft) {
  MemoryStack<RationalCurve<double>, 4, std::int32_t> shallow(kCurve);
  MemoryStack<RationalCurve<double>, kDeep, std::int32_t> exact(kCurve);
  NestedMotion motion(9, 60);
  for (int i = 0; i < 5000; ++i) {
    const std::int32_t x = motion.next();
    shallow.step(x);
    exact.step(x);
  }
  ASSERT_GT(shallow.overflow_count(), 0U);
  // Beyond everything so far, and all that follows within the depth of four.
  for (const std::int32_t x : {70, -65, 60, -50, 40, 41, 62, -40, -66, 71, -72, 5}) {
    ASSERT_EQ(shallow.step(x), exact.step(x)) << x;
  }
}

}  // namespace
}  // namespace slipstack::test
