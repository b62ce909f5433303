// SPDX-License-Identifier: Apache-2.0
// The packed form of the target against the readable one.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>

#include "firmware/friction/maxwell_slip.h"
#include "firmware/friction/packed_maxwell_slip.h"
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

// The unit of the stiffnesses is the smallest that holds each of them in a lane and their greatest sum in a
// word, however small they are.
TEST(PackedMaxwellSlip, ItsUnitIsTheSmallestThatHoldsTheElements) {
  std::mt19937_64 random(5);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int run = 0; run < 500; ++run) {
    std::array<std::int32_t, 10> slip{};
    std::array<float, 10> stiffness{};
    const double size = std::exp(uniform(-20.0, 10.0)), longest = std::exp(uniform(1.0, 9.6));
    double largest = 0.0, sum_N = 0.0, rounding = 0.0;
    for (std::size_t i = 0; i < slip.size(); ++i) {
      slip[i] = static_cast<std::int32_t>(uniform(0.0, longest));
      stiffness[i] = static_cast<float>(size * uniform(0.0, 1.0));
      const auto k = static_cast<double>(stiffness[i]);
      largest = std::max(largest, k);
      sum_N += k * slip[i];
      rounding += slip[i];
    }
    PackedMaxwellSlip<10> packed;
    ASSERT_EQ(packed.set_elements(slip, stiffness), SetupStatus::kOk);
    const double unit = std::max(largest / 32767.0, sum_N / (2147480000.0 - rounding));
    ASSERT_NEAR(static_cast<double>(packed.stiffness_step()), unit, 1e-5 * unit) << run;
  }
}

// Displacements are told as far as there is room for them, and no further.
TEST(PackedMaxwellSlip, TellsItsElementsAsFarAsThereIsRoom) {
  PackedMaxwellSlip<4> packed;
  const std::array<std::int32_t, 4> slip = {10, 20, 30, 40};
  const std::array<float, 4> stiffness = {1.0F, 1.0F, 1.0F, 1.0F};
  ASSERT_EQ(packed.set_elements(slip, stiffness), SetupStatus::kOk);
  packed.step(25);
  for (std::size_t room = 0; room <= 6; ++room) {
    std::array<float, 8> out{};
    out.fill(-7.0F);
    packed.elements(std::span(out).first(room));
    for (std::size_t i = 0; i < out.size(); ++i) {
      const float held = std::min(25.0F, static_cast<float>(10 * (i + 1)));
      EXPECT_EQ(out[i], i < room && i < 4 ? held : -7.0F) << room << ' ' << i;
    }
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

}  // namespace
}  // namespace slipstack::test
