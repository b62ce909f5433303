// SPDX-License-Identifier: Apache-2.0
// Whether the drive knows where on the rail it is: what loses the reference, what depends on it, and the
// index marks that check it in service.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "tests/can/profile/homing_axis.h"

namespace slipstack::can {
namespace {

// A force ripple of 10 N over 24 mm in the model (210Ah: enabled, eight amplitudes, pitch).
void add_ripple(HomingAxis& axis) {
  ASSERT_EQ(axis.write(0x210A, 1, 1, 1), 0U);
  ASSERT_EQ(axis.write_real(0x210A, 2, 10.0F), 0U);
  ASSERT_EQ(axis.write_real(0x210A, 10, 0.024F), 0U);
  ASSERT_EQ(axis.write(0x2140, 3, axis.read(0x2140, 1), 4), 0U);
  axis.run_ms(2);
}
float ripple_N(HomingAxis& axis) {
  return axis.read_real(0x2201, 11);
}
double expected_N(HomingAxis& axis) {
  return 10.0 * std::cos(2.0 * M_PI * axis.read_signed(0x6064, 0) * axis.axis.encoder_resolution_m / 0.024);
}

TEST(PositionReference, WithoutItNoEffectOverPositionActs) {
  HomingAxis axis(0.05);
  add_ripple(axis);
  EXPECT_FALSE(axis.referenced());
  EXPECT_EQ(axis.read(0x2012, 5), 0U);
  EXPECT_EQ(ripple_N(axis), 0.0F);
  ASSERT_EQ(axis.choose(23), 0U);
  axis.enable(6);
  axis.run_ms(100);
  EXPECT_EQ(ripple_N(axis), 0.0F);
  ASSERT_EQ(axis.start(), HomingAxis::kDone);
  EXPECT_EQ(axis.read(0x2012, 5), 1U);
  EXPECT_NEAR(ripple_N(axis), expected_N(axis), 0.05);
  EXPECT_GT(std::abs(ripple_N(axis)), 5.0F) << "at zero the cosine is large";
}

// The force of the model takes no step when its maps come in: fades over the swap time, 20 ms.
TEST(PositionReference, EffectsOverPositionFadeIn) {
  HomingAxis axis(0.05);
  add_ripple(axis);
  ASSERT_EQ(axis.choose(37), 0U);
  axis.enable(6);
  float before_N = ripple_N(axis);
  ASSERT_EQ(axis.write(0x6040, 0, 0x1F, 2), 0U);
  float largest_step_N = 0.0F;
  for (int ms = 0; ms < 60; ++ms) {
    axis.run_ms(1);
    const float now_N = ripple_N(axis);
    largest_step_N = std::max(largest_step_N, std::abs(now_N - before_N));
    before_N = now_N;
  }
  EXPECT_NEAR(ripple_N(axis), 10.0F, 0.01F);
  EXPECT_LT(largest_step_N, 0.7F) << "10 N over 20 ms";
  EXPECT_GT(largest_step_N, 0.3F);
}

TEST(PositionReference, AnAbsoluteEncoderHasItFromTheStart) {
  HomingAxis axis(0.05, true);
  add_ripple(axis);
  EXPECT_TRUE(axis.referenced());
  EXPECT_NEAR(ripple_N(axis), expected_N(axis), 0.05);
  // It may be homed once; the origin is stored.
  ASSERT_EQ(axis.home(23), HomingAxis::kDone);
  const double zero_m = axis.zero_m();
  EXPECT_NEAR(zero_m, 0.1, 5e-6);
  ASSERT_EQ(axis.write(0x6040, 0, 0, 2), 0U);
  axis.run_ms(2);
  ASSERT_EQ(axis.write(0x1010, 1, 0x65766173, 4), 0U);
  const double here_m = axis.x_m();
  const auto switches = axis.loop->switches;
  axis.power_on();
  axis.loop->plant.reset(here_m);
  axis.loop->switches = switches;
  axis.loop->step();
  axis.begin();
  axis.run_ms(5);
  EXPECT_TRUE(axis.referenced());
  EXPECT_NEAR(axis.zero_m(), zero_m, 2e-6);
}

// The origin in 2012h:02, which 1010h stores, is another one when homing has found it, and not before.
TEST(PositionReference, TheOriginIsWrittenWhenHomingIsDone) {
  HomingAxis axis(0.05, true);
  ASSERT_EQ(axis.choose(23), 0U);
  // Staged and not in force.
  const std::uint32_t before = axis.read(0x2012, 2) + 4711;
  ASSERT_EQ(axis.write(0x2012, 2, before, 4), 0U);
  axis.enable(6);
  ASSERT_EQ(axis.write(0x6040, 0, 0x1F, 2), 0U);
  std::uint32_t bits = 0;
  for (int ms = 0; ms < 60000 && (bits & HomingAxis::kEnd) == 0; ++ms) {
    EXPECT_EQ(axis.read(0x2012, 2), before) << ms;
    axis.run_ms(1);
    bits = axis.status();
  }
  ASSERT_EQ(bits & HomingAxis::kError, 0U);
  axis.run_ms(500);
  EXPECT_NE(axis.read(0x2012, 2), before);
  EXPECT_EQ(axis.read(0x2012, 2), static_cast<std::uint32_t>(axis.loop->controller().position().origin()));
  // An encoder that is not absolute has none to store.
  HomingAxis incremental(0.05);
  ASSERT_EQ(incremental.home(23), HomingAxis::kDone);
  EXPECT_EQ(incremental.read(0x2012, 2), 0U);
}

// An absolute encoder keeps its place when homing fails or is interrupted.
TEST(PositionReference, AnAbsoluteEncoderKeepsItWhenHomingFails) {
  HomingAxis axis(0.05, true);
  axis.loop->switches->home_begin_m = 5.0;
  axis.loop->switches->home_end_m = 6.0;
  const double zero_m = axis.zero_m();
  EXPECT_EQ(axis.home(23), HomingAxis::kError | HomingAxis::kReached);
  EXPECT_TRUE(axis.referenced());
  EXPECT_NEAR(axis.zero_m(), zero_m, 2e-6);
}

void lose_signal(HomingAxis& axis) {
  axis.loop->board_encoder.next.valid = false;
  axis.run_ms(1);
  axis.loop->board_encoder.next.valid = true;
  axis.run_ms(1);
}

TEST(PositionReference, AnEncoderFaultTakesItFromAnIncrementalEncoder) {
  HomingAxis axis(0.05);
  add_ripple(axis);
  ASSERT_EQ(axis.home(23), HomingAxis::kDone);
  ASSERT_EQ(axis.write(0x6040, 0, 0, 2), 0U);
  axis.run_ms(5);
  EXPECT_TRUE(axis.referenced()) << "not by disabling";
  lose_signal(axis);
  EXPECT_EQ(axis.read(0x603F, 0), 0x7305U);
  EXPECT_FALSE(axis.referenced());
  EXPECT_EQ(ripple_N(axis), 0.0F);

  HomingAxis absolute(0.05, true);
  lose_signal(absolute);
  EXPECT_EQ(absolute.read(0x603F, 0), 0x7305U);
  EXPECT_TRUE(absolute.referenced());
}

// Only what says that counts may be wrong: whatever else is a fault, the place is known after it.
TEST(PositionReference, AFaultThatSaysNothingOfTheCountsLeavesIt) {
  const auto takes_it = [](Fault fault) {
    return fault == Fault::kEncoderLoss || fault == Fault::kEncoderJump || fault == Fault::kEncoderStands ||
           fault == Fault::kIndexOffPlace;
  };
  for (std::size_t number = 1; number < kFaultCount; ++number) {
    const auto fault = static_cast<Fault>(number);
    for (const bool absolute : {false, true}) {
      HomingAxis axis(0.05, absolute);
      ASSERT_EQ(axis.home(37), HomingAxis::kDone);
      ASSERT_TRUE(axis.referenced());
      axis.loop->controller().inject(fault);
      axis.run_ms(300);
      EXPECT_EQ(axis.read(0x2212, static_cast<std::uint8_t>(number)), 1U) << number;
      EXPECT_EQ(axis.referenced(), absolute || !takes_it(fault)) << number;
    }
  }
}

TEST(PositionReference, AResetTakesItToo) {
  HomingAxis axis(0.05);
  ASSERT_EQ(axis.home(23), HomingAxis::kDone);
  ASSERT_EQ(axis.write(0x6040, 0, 0, 2), 0U);
  axis.run_ms(2);
  ASSERT_EQ(axis.write(0x1010, 1, 0x65766173, 4), 0U);
  axis.nmt(0x81);
  axis.run_ms(20);
  EXPECT_FALSE(axis.referenced());
}

TEST(PositionReference, HomingAnewTakesItUntilItIsFound) {
  HomingAxis axis(0.2);
  ASSERT_EQ(axis.home(23), HomingAxis::kDone);
  ASSERT_EQ(axis.write(0x6040, 0, 0x0F, 2), 0U);
  axis.run_ms(1);
  EXPECT_TRUE(axis.referenced());
  ASSERT_EQ(axis.choose(18), 0U);
  ASSERT_EQ(axis.write(0x6040, 0, 0x1F, 2), 0U);
  axis.run_ms(100);
  EXPECT_FALSE(axis.referenced());
  EXPECT_EQ(axis.until_end(60.0), HomingAxis::kDone);
  EXPECT_NEAR(axis.zero_m(), axis.stroke_m - 0.02, 5e-6);
}

// ---- index marks in service ----

// Marks every 15 mm checked to two counts; back and forth over some of them.
void check_marks(HomingAxis& axis) {
  ASSERT_EQ(axis.write(0x2012, 3, axis.counts(0.015), 4), 0U);
  ASSERT_EQ(axis.write(0x2012, 4, 2, 4), 0U);
  ASSERT_EQ(axis.write(0x2140, 3, axis.read(0x2140, 1), 4), 0U);
  axis.run_ms(2);
}
void go_to(HomingAxis& axis, double from_zero_m) {
  ASSERT_EQ(axis.write(0x6081, 0, axis.counts(0.1), 4), 0U);
  ASSERT_EQ(axis.write(0x607A, 0, axis.counts(from_zero_m), 4), 0U);
  ASSERT_EQ(axis.write(0x6040, 0, 0x0F, 2), 0U);
  ASSERT_EQ(axis.write(0x6040, 0, 0x1F, 2), 0U);
  axis.run_ms(1500);
}

TEST(IndexCheck, MarksInTheirPlacesAreNoFault) {
  HomingAxis axis(0.05);
  check_marks(axis);
  ASSERT_EQ(axis.home(23), HomingAxis::kDone);
  axis.enable(1);
  for (const double there_m : {0.07, -0.04, 0.06, 0.0}) go_to(axis, there_m);
  EXPECT_EQ(axis.read(0x603F, 0), 0U);
  EXPECT_TRUE(axis.referenced());
}

TEST(IndexCheck, LostCountsAreSeenAtTheNextMark) {
  for (const int lost : {3, -3, 40, 2, -2}) {
    SCOPED_TRACE(lost);
    HomingAxis axis(0.05);
    check_marks(axis);
    ASSERT_EQ(axis.home(23), HomingAxis::kDone);
    axis.enable(1);
    go_to(axis, 0.01);
    // Everything behind the marks lies elsewhere in counts now.
    axis.loop->marks->first_m += lost * axis.axis.encoder_resolution_m;
    go_to(axis, 0.04);
    if (std::abs(lost) <= 2) {
      EXPECT_EQ(axis.read(0x603F, 0), 0U) << "within the tolerance";
      EXPECT_TRUE(axis.referenced());
      continue;
    }
    EXPECT_EQ(axis.read(0x603F, 0), 0x7320U);
    EXPECT_FALSE(axis.referenced());
    EXPECT_FALSE(axis.loop->motor.enabled);
    EXPECT_LT(axis.x_m(), 0.1 + 0.04 - 0.003) << "stopped on the way";
  }
}

TEST(IndexCheck, ASingleMark) {
  HomingAxis axis(0.05);
  axis.loop->marks = sim::ReferenceMarks{.first_m = 0.12};
  check_marks(axis);
  ASSERT_EQ(axis.write(0x2012, 3, 0, 4), 0U);
  ASSERT_EQ(axis.write(0x2140, 3, axis.read(0x2140, 1), 4), 0U);
  axis.run_ms(2);
  ASSERT_EQ(axis.home(34), HomingAxis::kDone);
  axis.enable(1);
  go_to(axis, 0.01);
  go_to(axis, -0.01);
  EXPECT_EQ(axis.read(0x603F, 0), 0U);
  axis.loop->marks->first_m += 0.015;
  go_to(axis, 0.03);
  EXPECT_EQ(axis.read(0x603F, 0), 0x7320U) << "a whole distance away is no mark of a single one";
}

}  // namespace
}  // namespace slipstack::can
