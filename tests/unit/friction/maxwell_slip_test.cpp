// SPDX-License-Identifier: Apache-2.0
#include "firmware/friction/maxwell_slip.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "firmware/friction/packed_arithmetic.h"
#include "firmware/friction/packed_maxwell_slip.h"

namespace slipstack {
namespace {

using Counts = MaxwellSlip<4, float, std::int32_t>;
using Metres = MaxwellSlip<4, double>;

constexpr std::array<std::int32_t, 2> kSlip = {2, 10};
constexpr std::array<float, 2> kStiffness = {3.0F, 1.0F};

// Worked by hand: two springs, 3 N per count up to 2 counts and 1 N per count up to 10. The tolerance is what
// rounding the stiffnesses may cost.
template <class Model>
void expect_worked_example(float tolerance_N) {
  Model model;
  ASSERT_EQ(model.set_elements(kSlip, kStiffness), SetupStatus::kOk);
  model.reset(100);
  EXPECT_NEAR(model.step(101), 4.0F, tolerance_N);   // 3*1 + 1*1
  EXPECT_NEAR(model.step(105), 11.0F, tolerance_N);  // 3*2 + 1*5
  EXPECT_NEAR(model.step(120), 16.0F, tolerance_N);  // both slide
  EXPECT_NEAR(model.step(119), 12.0F, tolerance_N);  // 3*1 + 1*9
  EXPECT_NEAR(model.step(110), -6.0F, tolerance_N);  // 3*-2 + 1*0
  EXPECT_NEAR(model.step(110), -6.0F, tolerance_N);  // rest
  EXPECT_EQ(model.z(0), -2);
  EXPECT_EQ(model.z(1), 0);
  EXPECT_NEAR(model.step(0), -16.0F, tolerance_N);
  EXPECT_NEAR(model.stored_energy(), 0.5F * 3 * 4 + 0.5F * 1 * 100, 10 * tolerance_N);
  EXPECT_EQ(model.position(), 0);
  model.reset(7);
  EXPECT_EQ(model.stored_energy(), 0.0F);
  EXPECT_EQ(model.step(7), 0.0F);
}

TEST(MaxwellSlip, WorkedExample) {
  expect_worked_example<Counts>(0.0F);
}
// Half a unit of 3/32767 N per count, times at most twelve counts of both elements.
TEST(PackedMaxwellSlip, WorkedExample) {
  expect_worked_example<PackedMaxwellSlip<10>>(5.5e-4F);
}
TEST(PackedMaxwellSlip, WorkedExampleInOneWord) {
  expect_worked_example<PackedMaxwellSlip<2>>(5.5e-4F);
}

TEST(MaxwellSlip, RunsAtCompileTime) {
  constexpr float kForce = [] {
    Counts model;
    if (model.set_elements(kSlip, kStiffness) != SetupStatus::kOk) return -1.0F;
    model.step(5);
    return model.step(4);
  }();
  static_assert(kForce == 7.0F);  // 3*1 + 1*4
}

TEST(MaxwellSlip, UnusedElementsAreHarmless) {
  Counts model;
  EXPECT_EQ(model.step(5), 0.0F);
  ASSERT_EQ(model.set_elements(std::array<std::int32_t, 1>{3}, std::array<float, 1>{2.0F}), SetupStatus::kOk);
  model.reset(0);
  for (const std::int32_t x : {1, -100, 2147483647, -2147483647, 0}) {
    model.step(x);
    for (std::size_t i = 1; i < 4; ++i) EXPECT_EQ(model.z(i), 0) << x;
  }
  EXPECT_EQ(model.stored_energy(), 0.5F * 2 * 9);
}

TEST(MaxwellSlip, WritesItsRegressors) {
  Metres model;
  const std::array<double, 3> slip = {0.5, 2.0, 8.0};
  const std::array<double, 3> stiffness = {1.0, 1.0, 1.0};
  ASSERT_EQ(model.set_elements(slip, stiffness), SetupStatus::kOk);
  model.step(3.0);
  std::array<double, 4> z{9, 9, 9, 9};
  model.elements(z);
  EXPECT_EQ(z, (std::array<double, 4>{0.5, 2.0, 3.0, 0.0}));
  std::vector<double> two(2);
  model.elements(two);
  EXPECT_EQ(two, (std::vector<double>{0.5, 2.0}));
  std::vector<double> many(6, 9.0);
  model.elements(many);
  EXPECT_EQ(many, (std::vector<double>{0.5, 2.0, 3.0, 0.0, 9.0, 9.0}));
}

TEST(MaxwellSlip, StaysExactWhereTheCounterWraps) {
  Counts model;
  ASSERT_EQ(model.set_elements(kSlip, kStiffness), SetupStatus::kOk);
  model.reset(2147483645);
  EXPECT_EQ(model.step(static_cast<std::int32_t>(2147483648U)), 9.0F);  // three counts on
  EXPECT_EQ(model.step(2147483647), 3.0F + 2.0F);
}

TEST(MaxwellSlip, TakesNewElementsInMotion) {
  Counts model;
  ASSERT_EQ(model.set_elements(kSlip, kStiffness), SetupStatus::kOk);
  model.step(8);
  ASSERT_EQ(model.z(1), 8);
  ASSERT_EQ(model.set_elements(std::array{1, 5}, kStiffness), SetupStatus::kOk);
  EXPECT_EQ(model.z(0), 1);
  EXPECT_EQ(model.z(1), 5);
  EXPECT_EQ(model.step(8), 8.0F);
}

template <class Model>
void expect_refusals() {
  Model model;
  ASSERT_EQ(model.set_elements(kSlip, kStiffness), SetupStatus::kOk);
  const std::vector<std::int32_t> slips(Model::kCapacity + 1, 1);
  const std::vector<float> stiffnesses(Model::kCapacity + 1, 1.0F);
  EXPECT_EQ(model.set_elements(slips, stiffnesses), SetupStatus::kTooMany);
  EXPECT_EQ(model.set_elements(kSlip, std::array{1.0F}), SetupStatus::kSizeMismatch);
  EXPECT_EQ(model.set_elements(std::array{-1, 2}, kStiffness), SetupStatus::kOutOfRange);
  EXPECT_EQ(model.set_elements(std::array{1, 1 << 30}, kStiffness), SetupStatus::kOutOfRange);
  EXPECT_EQ(model.set_elements(kSlip, std::array{1.0F, -1.0F}), SetupStatus::kOutOfRange);
  EXPECT_EQ(model.set_elements(kSlip, std::array{std::numeric_limits<float>::quiet_NaN(), 1.0F}),
            SetupStatus::kOutOfRange);
  EXPECT_EQ(model.set_elements(kSlip, std::array{std::numeric_limits<float>::infinity(), 1.0F}),
            SetupStatus::kOutOfRange);
  EXPECT_NEAR(model.step(1), 4.0F, 1e-4F);  // the old elements are still there
}

TEST(MaxwellSlip, RefusesBadElements) {
  expect_refusals<Counts>();
}
TEST(PackedMaxwellSlip, RefusesBadElements) {
  expect_refusals<PackedMaxwellSlip<4>>();
  PackedMaxwellSlip<4> model;
  EXPECT_EQ(model.set_elements(std::array{16384}, std::array{1.0F}), SetupStatus::kOutOfRange);
  EXPECT_EQ(model.set_elements(std::array{16383}, std::array{1.0F}), SetupStatus::kOk);
  // Finite stiffnesses whose force is not.
  EXPECT_EQ(model.set_elements(std::array{16383}, std::array{3e38F}), SetupStatus::kOutOfRange);
}

TEST(PackedMaxwellSlip, IsQuietWithoutElements) {
  PackedMaxwellSlip<10> model;
  for (const std::int32_t x : {0, 5, -5, 2147483647, -2147483647}) EXPECT_EQ(model.step(x), 0.0F);
  ASSERT_EQ(model.set_elements(std::array{5}, std::array{0.0F}), SetupStatus::kOk);
  EXPECT_EQ(model.step(3), 0.0F);
}

TEST(PackedArithmetic, IsWhatTheInstructionsDo) {
  constexpr std::array<std::int32_t, 9> kValues = {-32768, -32767, -12345, -1, 0, 1, 777, 32766, 32767};
  const auto limited = [](std::int32_t v) { return std::min(32767, std::max(-32768, v)); };
  for (const std::int32_t a : kValues) {
    for (const std::int32_t b : kValues) {
      for (const std::int32_t c : kValues) {
        const std::uint32_t first = portable::pack(a, b);
        const std::uint32_t second = portable::pack(c, a);
        ASSERT_EQ(portable::low_lane(first), a);
        ASSERT_EQ(portable::high_lane(first), b);
        const std::uint32_t added = add_saturating(first, second);
        ASSERT_EQ(portable::low_lane(added), limited(a + c));
        ASSERT_EQ(portable::high_lane(added), limited(b + a));
        const std::int64_t exact = std::int64_t{a} * c + std::int64_t{b} * a + 0x7FFFFFFF;
        ASSERT_EQ(multiply_add(first, second, 0x7FFFFFFFU), static_cast<std::uint32_t>(exact));
      }
    }
    for (const std::int32_t b : kValues) {
      const std::uint32_t own = portable::pack(a, b);
      const std::uint32_t other = portable::pack(b, a);
      const std::int32_t c = a & 0xFFFF;
      const std::int32_t d = b & 0xFFFF;
      const auto more = static_cast<std::uint32_t>(std::min(0xFFFF, c + d));
      ASSERT_EQ(add_saturating_unsigned(own, other), more | (more << 16));
      ASSERT_EQ(subtract_saturating_unsigned(own, other),
                static_cast<std::uint32_t>(std::max(0, c - d)) |
                    (static_cast<std::uint32_t>(std::max(0, d - c)) << 16));
    }
    EXPECT_EQ(both_lanes(a), portable::pack(a, a));
    EXPECT_EQ(saturate16(a * 3), limited(a * 3));
  }
}

}  // namespace
}  // namespace slipstack
