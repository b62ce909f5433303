// SPDX-License-Identifier: Apache-2.0
// The fast forms of the target against the readable ones.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include "firmware/friction/maxwell_slip.h"
#include "firmware/friction/memory_stack.h"
#include "firmware/friction/packed_maxwell_slip.h"
#include "firmware/friction/rational_memory_stack.h"
#include "tests/property/friction/motion.h"

namespace slipstack::test {
namespace {

// Steps of every size a counter can make, and a counter that wraps around.
class AnyMotion {
 public:
  explicit AnyMotion(std::uint64_t seed) : random_(seed) {}

  std::int32_t next() {
    const auto size = static_cast<std::uint32_t>(random_() % 31);
    const auto step = static_cast<std::uint32_t>(random_() % (1ULL << size));
    x_ = random_() % 2 == 0 ? x_ + step : x_ - step;
    return static_cast<std::int32_t>(x_);
  }

  std::uint64_t below(std::uint64_t bound) { return random_() % bound; }

 private:
  std::mt19937_64 random_;
  std::uint32_t x_ = 0;
};

// The reference has the same elements; its exact displacements give the force that the packed form must
// return: an integer sum, rounded once to float and scaled.
template <std::size_t N, class Motion>
void expect_packed_is_exact(std::uint64_t seed, std::int32_t largest_slip, Motion motion) {
  AnyMotion random(seed);
  std::array<std::int32_t, N> slip{};
  std::array<float, N> stiffness{};
  for (std::size_t i = 0; i < N; ++i) {
    slip[i] = static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(largest_slip) + 1));
    stiffness[i] = 0.001F * static_cast<float>(random.below(1000));
  }
  slip[0] = largest_slip;
  PackedMaxwellSlip<N> packed;
  MaxwellSlip<N, float, std::int32_t> reference;
  ASSERT_EQ(packed.set_elements(slip, stiffness), SetupStatus::kOk);
  ASSERT_EQ(reference.set_elements(slip, stiffness), SetupStatus::kOk);
  const auto unit = static_cast<double>(packed.stiffness_step());
  std::array<std::int64_t, N> units{};
  for (std::size_t i = 0; i < N; ++i) {
    units[i] = std::llround(static_cast<double>(packed.stiffness(i)) / unit);
    // One rounding of the quotient in float comes on top of half a unit.
    ASSERT_NEAR(static_cast<double>(packed.stiffness(i)), static_cast<double>(stiffness[i]), 0.504 * unit);
    ASSERT_EQ(packed.slip_distance(i), slip[i]);
  }
  for (int step = 0; step < 200000; ++step) {
    const std::int32_t x = motion.next();
    const float force_N = packed.step(x);
    reference.step(x);
    std::int64_t total = 0;
    for (std::size_t i = 0; i < N; ++i) {
      ASSERT_EQ(packed.z(i), reference.z(i)) << "seed " << seed << " step " << step << " element " << i;
      total += units[i] * reference.z(i);
    }
    ASSERT_EQ(force_N, static_cast<float>(total) * packed.stiffness_step())
        << "seed " << seed << " step " << step;
  }
}

TEST(PackedMaxwellSlip, IsExactForEveryStep) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    expect_packed_is_exact<10>(seed, 100, NestedMotion(seed, 150));
    expect_packed_is_exact<10>(seed, 1000, AnyMotion(seed));
    expect_packed_is_exact<10>(seed, PackedMaxwellSlip<10>::kLargestSlipDistance, AnyMotion(seed));
    expect_packed_is_exact<6>(seed, 40, NestedMotion(seed, 60));
    expect_packed_is_exact<28>(seed, 16000, AnyMotion(seed));
  }
}

TEST(PackedMaxwellSlip, FitsTheLargestForceIntoItsSum) {
  constexpr std::int32_t kSlip = PackedMaxwellSlip<10>::kLargestSlipDistance;
  std::array<std::int32_t, 10> slip{};
  std::array<float, 10> stiffness{};
  slip.fill(kSlip);
  stiffness.fill(3.7F);
  PackedMaxwellSlip<10> packed;
  ASSERT_EQ(packed.set_elements(slip, stiffness), SetupStatus::kOk);
  const double expected = 10 * 3.7 * kSlip;
  EXPECT_NEAR(static_cast<double>(packed.step(1000000)) / expected, 1.0, 1e-4);
  EXPECT_NEAR(static_cast<double>(packed.step(-1000000)) / expected, -1.0, 1e-4);
}

template <std::size_t Depth>
void expect_fast_stack_agrees(std::uint64_t seed, std::int32_t range) {
  constexpr double kHeight = 15.0;
  MemoryStack<RationalCurve<double>, Depth, std::int32_t> reference({kHeight, 12.0});
  RationalMemoryStack<Depth> fast({static_cast<float>(kHeight), 12.0F});
  NestedMotion motion(seed, range);
  double worst = 0;
  std::size_t deepest = 0;
  for (int i = 0; i < 200000; ++i) {
    const std::int32_t x = motion.next();
    worst = std::max(worst, std::abs(static_cast<double>(fast.step(x)) - reference.step(x)));
    ASSERT_EQ(fast.depth(), reference.depth()) << "seed " << seed << " step " << i;
    ASSERT_EQ(fast.overflow_count(), reference.overflow_count()) << "seed " << seed << " step " << i;
    ASSERT_EQ(fast.position(), x);
    deepest = std::max(deepest, fast.depth());
  }
  EXPECT_EQ(deepest, Depth);
  // Half a unit in the last place of 2 h0 at each reversal held, and the worst of 200 000 steps.
  const double bound = static_cast<double>(Depth + 2) * kHeight * 0x1p-23;
  EXPECT_LT(worst, bound);
  EXPECT_GT(worst, kHeight * 0x1p-25);
}

TEST(RationalMemoryStack, AgreesWithMemoryStack) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    expect_fast_stack_agrees<2>(seed, 100);
    expect_fast_stack_agrees<4>(seed, 100);
    expect_fast_stack_agrees<6>(seed, 20);
    expect_fast_stack_agrees<10>(seed, 100);
    expect_fast_stack_agrees<16>(seed, 100);
    expect_fast_stack_agrees<16>(seed, 1000);
    expect_fast_stack_agrees<32>(seed, 100);
  }
}

// Every depth, every number of loops closed at once, on either side, with and without a reversal in the same
// step.
TEST(RationalMemoryStack, ClosesAnyNumberOfLoopsInOneStep) {
  for (std::int32_t reversals = 0; reversals <= 18; ++reversals) {
    for (std::int32_t target = -200; target <= 200; ++target) {
      MemoryStack<RationalCurve<double>, 16, std::int32_t> reference({15.0, 12.0});
      RationalMemoryStack<16> fast({15.0F, 12.0F});
      const auto both = [&](std::int32_t x) {
        const double expected = reference.step(x);
        ASSERT_NEAR(static_cast<double>(fast.step(x)), expected, 5e-5);
        ASSERT_EQ(fast.depth(), reference.depth()) << reversals << " " << target;
      };
      for (std::int32_t i = 0; i <= reversals; ++i) both((i % 2 == 0 ? 1 : -1) * (190 - 10 * i));
      both(target);
      both(target + (target % 2 == 0 ? 3 : -3));
      both(-target);
    }
  }
}

// The closed loop returns to the bit here as well: the older branch is computed anew from what it was.
TEST(RationalMemoryStack, ClosedLoopsReturnExactly) {
  RationalMemoryStack<16> stack({15.0F, 12.0F});
  NestedMotion motion(3, 30);
  for (int loop = 0; loop < 2000; ++loop) {
    stack.step(100);
    stack.step(-80);
    const float top = stack.step(70);
    for (int i = 0; i < 20; ++i) stack.step(motion.next());
    ASSERT_EQ(stack.step(70), top);
  }
}

}  // namespace
}  // namespace slipstack::test
