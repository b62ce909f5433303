// SPDX-License-Identifier: Apache-2.0
// The user's unit of position: 607Eh, 608Fh, 6091h, 6092h, against arithmetic of 128 bits, and on the
// simulated axis.
#include "firmware/canopen/profile/user_units.h"

#include <cmath>
#include <random>

#include "tests/can/bench.h"
#include "tests/can/profile/homing_axis.h"

namespace slipstack::can {
namespace {
using canopen::UserUnits;
__extension__ using Wide = __int128;

constexpr std::uint32_t kTooLow = 0x06090032;
constexpr std::uint32_t kTooHigh = 0x06090031;
constexpr std::uint32_t kBadValue = 0x06090030;
constexpr std::uint32_t kDeviceState = 0x08000022;

// Nearest, halves away from zero.
Wide nearest(Wide product, Wide over) {
  const Wide magnitude = product < 0 ? -product : product;
  const Wide rounded = (2 * magnitude + over) / (2 * over);
  return product < 0 ? -rounded : rounded;
}

TEST(UserUnits, AgreeWithArithmeticOf128Bits) {
  std::mt19937_64 random(23);
  int fitting = 0;
  int refused = 0;
  int exact_ways_back = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::array<std::uint32_t, 6> f{};
    for (std::uint32_t& factor : f) {
      factor = static_cast<std::uint32_t>(random() >> (32 + random() % 32));
      if (factor == 0) factor = 1;
    }
    const Wide up = Wide{f[0]} * f[2] * f[5];
    const Wide down = Wide{f[1]} * f[3] * f[4];
    const auto units = UserUnits::of(f, 0);
    if (!units) {
      ++refused;
      continue;
    }
    for (int k = 0; k < 20; ++k) {
      const auto user =
          static_cast<std::int32_t>(static_cast<std::int64_t>(random()) >> (32 + random() % 31));
      const Wide counts = nearest(up * user, down);
      const auto made = units->to_counts(user);
      const bool fits = counts >= INT32_MIN && counts <= INT32_MAX;
      ASSERT_EQ(made.has_value(), fits) << user;
      if (!fits) continue;
      ++fitting;
      ASSERT_EQ(Wide{*made}, counts);
      Wide back = nearest(down * *made, up);
      back = back > INT32_MAX ? INT32_MAX : back < INT32_MIN ? INT32_MIN : back;
      ASSERT_EQ(Wide{units->to_user(*made)}, back);
      if (up >= down) {
        ++exact_ways_back;
        ASSERT_EQ(units->to_user(*made), user);
      }
      const auto turned = UserUnits::of(f, UserUnits::kPosition);
      if (user != INT32_MIN && *made != INT32_MIN) {
        ASSERT_EQ(turned->to_counts(user), -*made);
      }
    }
  }
  EXPECT_GT(fitting, 15'000);
  EXPECT_GT(refused, 2'000);
  EXPECT_GT(exact_ways_back, 5'000);
}

TEST(UserUnits, AreRefusedBeyondWhatIsExact) {
  EXPECT_FALSE(UserUnits::of({0, 1, 1, 1, 1, 1}, 0));
  EXPECT_TRUE(UserUnits::of({1U << 30U, 1, 1, 1, 1, 1}, 0));
  EXPECT_FALSE(UserUnits::of({(1U << 30U) + 1, 1, 1, 1, 1, 1}, 0));
  EXPECT_FALSE(UserUnits::of({65537, 1, 65539, 1, 1, 1}, 0));
  EXPECT_TRUE(UserUnits::of({0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF, 1, 0xFFFFFFFF, 1}, 0)) << "1 : 1";
  // 1 nm over 2 m, in um.
  const auto nano = UserUnits::of({1000, 1, 1, 1, 1, 1}, 0);
  EXPECT_EQ(nano->to_counts(2'000'000), 2'000'000'000);
  EXPECT_EQ(nano->to_counts(2'147'483), 2'147'483'000);
  EXPECT_FALSE(nano->to_counts(2'147'484));
  EXPECT_EQ(nano->to_counts(-2'147'483), -2'147'483'000);
  EXPECT_FALSE(nano->to_counts(INT32_MIN));
}

// Counts of 1 um, the user's unit 0.1 mm, turned round: the axis moves the other way, by a hundred times as
// much.
TEST(UserUnits, MoveTheAxisInTheUsersUnit) {
  Bench bench;
  bench.configure();
  ASSERT_EQ(bench.write(0x6092, 1, 10, 4), 0U);
  ASSERT_EQ(bench.write(0x608F, 1, 1000, 4), 0U);
  ASSERT_EQ(bench.write(0x607E, 0, 0xC0, 1), 0U);
  for (const auto& [index, value] : {std::pair{0x6081, 1000U}, {0x6083, 10000U}, {0x6084, 10000U}}) {
    ASSERT_EQ(bench.write(static_cast<std::uint16_t>(index), 0, value, 4), 0U);
  }
  ASSERT_EQ(bench.write(0x60A4, 1, 1000000, 4), 0U);
  ASSERT_EQ(bench.write(0x6067, 0, 1, 4), 0U);
  const std::int32_t counts = bench.read_signed(0x6063, 0);
  const std::int32_t from = bench.read_signed(0x6064, 0);
  EXPECT_EQ(from, -std::lround(counts / 100.0));
  bench.enable(1);
  ASSERT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(from + 200), 4), 0U);
  ASSERT_EQ(bench.write(0x6040, 0, 0x1F, 2), 0U);
  bench.run_ms(150);
  EXPECT_NEAR(bench.read_signed(0x606C, 0), 1000, 30) << "0.1 m/s, of the user's sign";
  EXPECT_LT(bench.loop->controller().output().velocity_mps, -0.09F);
  bench.run_ms(250);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x400, 0x400U);
  EXPECT_EQ(bench.read_signed(0x6064, 0), from + 200);
  EXPECT_NEAR(bench.read_signed(0x6063, 0), -100 * (from + 200), 10);
}

// Homing leaves the user's offset, and limits hold the axis at the user's place, whatever side that is.
TEST(UserUnits, HomeOffsetAndSoftwareLimitsAreInIt) {
  for (const std::uint32_t polarity : {0x00U, 0x80U}) {
    SCOPED_TRACE(polarity);
    const std::int32_t sign = polarity == 0 ? 1 : -1;
    HomingAxis axis(0.123);
    ASSERT_EQ(axis.write(0x608F, 1, 10, 4), 0U);
    ASSERT_EQ(axis.write(0x607E, 0, polarity, 1), 0U);
    EXPECT_EQ(axis.write(0x607C, 0, 0x7FFFFFFF, 4), kTooHigh);
    ASSERT_EQ(axis.write(0x607C, 0, 500, 4), 0U);
    ASSERT_EQ(axis.home(35), HomingAxis::kDone);
    EXPECT_NEAR(axis.read_signed(0x6064, 0), -500, 1);
    EXPECT_NEAR(axis.read_signed(0x6063, 0), sign * -5000, 10);
    ASSERT_EQ(axis.write(0x607D, 1, static_cast<std::uint32_t>(-1000), 4), 0U);
    ASSERT_EQ(axis.write(0x607D, 2, 2000, 4), 0U);
    const double from_m = axis.x_m();
    ASSERT_EQ(axis.write(0x6060, 0, 1, 1), 0U);
    for (const auto& [target, end] : {std::pair{5000, 2000}, {-5000, -1000}, {300, 300}}) {
      ASSERT_EQ(axis.write(0x6040, 0, 0x0F, 2), 0U);
      axis.run_ms(2);
      ASSERT_EQ(axis.write(0x607A, 0, static_cast<std::uint32_t>(target), 4), 0U);
      ASSERT_EQ(axis.write(0x6040, 0, 0x1F, 2), 0U);
      axis.run_ms(1500);
      EXPECT_NEAR(axis.read_signed(0x6064, 0), end, 1);
      EXPECT_NEAR(axis.x_m() - from_m, sign * (end + 500) * 10.0 * axis.axis.encoder_resolution_m, 2e-5);
    }
  }
}

TEST(UserUnits, AreRefusedWhileEnabledOrOutOfRange) {
  Bench bench;
  bench.configure();
  EXPECT_EQ(bench.write(0x608F, 1, 0, 4), kTooLow);
  EXPECT_EQ(bench.write(0x607E, 0, 0x01, 1), kBadValue);
  EXPECT_EQ(bench.write(0x608F, 1, 0xFFFFFFFF, 4), kBadValue) << "not exact in 64 bits";
  ASSERT_EQ(bench.write(0x608F, 1, 1000, 4), 0U);
  EXPECT_EQ(bench.read_signed(0x607A, 0), bench.read_signed(0x6064, 0)) << "no target in another unit";
  EXPECT_EQ(bench.write(0x607A, 0, 2'147'484, 4), kTooHigh);
  EXPECT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(-2'147'484), 4), kTooLow);
  EXPECT_EQ(bench.write(0x607A, 0, 2'147'483, 4), 0U);
  bench.enable(1);
  for (const auto& [index, sub] : {std::pair{0x608F, 1}, {0x6091, 2}, {0x6092, 1}}) {
    EXPECT_EQ(bench.write(static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(sub), 2, 4),
              kDeviceState);
  }
  EXPECT_EQ(bench.write(0x607E, 0, 0x80, 1), kDeviceState);
}

}  // namespace
}  // namespace slipstack::can
