// SPDX-License-Identifier: Apache-2.0
// Homing by distance-coded marks over the bus: methods -5 and -6, and the check of the marks in service. The
// marks are the simulation's own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tests/can/profile/homing_axis.h"

namespace slipstack::can {
namespace {

constexpr double kDistance_m = 0.02;
constexpr double kStep_m = 20e-6;
constexpr double kZero_m = -0.1;  // of the scale: off the axis

class CodedAxis : public HomingAxis {
 public:
  explicit CodedAxis(double start_m, int direction = 1) : HomingAxis(start_m) {
    // A scale that is read downwards begins beyond the other end.
    zero_of_scale_m = direction > 0 ? kZero_m : stroke_m + 0.1;
    loop->coded_marks = sim::CodedScale::drawn(zero_of_scale_m, direction, kDistance_m, kStep_m, 400);
    code(counts(kDistance_m), direction * static_cast<int>(counts(kStep_m)));
  }
  void code(std::uint32_t distance, int step) {
    EXPECT_EQ(write(0x2012, 4, 2, 4), 0U);
    EXPECT_EQ(write(0x2012, 7, distance, 4), 0U);
    EXPECT_EQ(write(0x2012, 8, static_cast<std::uint32_t>(step), 4), 0U);
    EXPECT_EQ(write(0x2140, 3, read(0x2140, 1), 4), 0U);
    run_ms(2);
    EXPECT_EQ(read(0x2140, 4), 0U);
  }
  double zero_of_scale_m = 0.0;
};

TEST(CodedHoming, TheScalesZeroIsFoundBothWaysFromAnywhere) {
  for (const int direction : {1, -1}) {
    for (const int method : {-5, -6}) {
      for (const double start_m : {0.071}) {
        SCOPED_TRACE(testing::Message() << direction << ' ' << method << ' ' << start_m);
        CodedAxis axis(start_m, direction);
        ASSERT_EQ(axis.home(method), HomingAxis::kDone);
        EXPECT_TRUE(axis.referenced());
        EXPECT_NEAR(axis.zero_m(), axis.zero_of_scale_m, 4e-6);
        EXPECT_LT(axis.highest_m - axis.lowest_m, 1.7 * kDistance_m) << "three marks, not the whole axis";
      }
    }
  }
}

TEST(CodedHoming, ALimitSwitchTurnsTheSearchRound) {
  CodedAxis axis(0.03);
  ASSERT_EQ(axis.home(-6), HomingAxis::kDone);
  EXPECT_LT(axis.lowest_m, 0.0201);
  EXPECT_NEAR(axis.zero_m(), kZero_m, 4e-6);
}

TEST(CodedHoming, HomeOffsetShiftsTheZero) {
  CodedAxis axis(0.06);
  ASSERT_EQ(axis.write(0x607C, 0, axis.counts(0.15), 4), 0U);
  ASSERT_EQ(axis.home(-5), HomingAxis::kDone);
  EXPECT_NEAR(axis.zero_m(), kZero_m + 0.15, 4e-6);
}

// Marks that are missing on the scale, and dirt that looks like one: the zero is right or there is none.
TEST(CodedHoming, AMissingMarkAndDirtDoNotMoveTheZero) {
  for (const bool missing : {true, false}) {
    CodedAxis axis(0.06);
    auto& marks = axis.loop->coded_marks->marks_m;
    const auto next =
        static_cast<std::size_t>(std::upper_bound(marks.begin(), marks.end(), 0.06) - marks.begin());
    if (missing) {
      marks.erase(marks.begin() + static_cast<std::ptrdiff_t>(next) + 1);
    } else {
      marks.insert(marks.begin() + static_cast<std::ptrdiff_t>(next) + 1, marks[next] + 0.0031);
    }
    ASSERT_EQ(axis.home(-5), HomingAxis::kDone);
    EXPECT_NEAR(axis.zero_m(), kZero_m, 4e-6);
  }
}

TEST(CodedHoming, AnotherScaleThanStatedIsNotBelieved) {
  CodedAxis axis(0.06);
  axis.loop->coded_marks = sim::CodedScale::drawn(kZero_m, 1, 0.018, kStep_m, 400);
  ASSERT_EQ(axis.write(0x6099, 2, axis.counts(HomingAxis::kFast_mps), 4), 0U);
  EXPECT_EQ(axis.home(-5), HomingAxis::kError | HomingAxis::kReached);
  EXPECT_FALSE(axis.referenced());
}

TEST(CodedHoming, WithoutACodeThereIsNoSuchMethod) {
  HomingAxis axis(0.06);
  EXPECT_EQ(axis.home(-5), HomingAxis::kError | HomingAxis::kReached);
  // Two steps that could be taken for one another: refused when they are to be applied.
  ASSERT_EQ(axis.write(0x6040, 0, 0, 2), 0U);
  axis.run_ms(2);
  ASSERT_EQ(axis.write(0x2012, 4, 5, 4), 0U);
  ASSERT_EQ(axis.write(0x2012, 7, 20000, 4), 0U);
  ASSERT_EQ(axis.write(0x2012, 8, 20, 4), 0U);
  EXPECT_EQ(axis.write(0x2140, 3, axis.read(0x2140, 1), 4), 0x08000000U);
}

// Counts that are lost afterwards are seen at the next mark.
TEST(CodedHoming, MarksAreCheckedInService) {
  for (const int lost : {0, 5}) {
    CodedAxis axis(0.06);
    ASSERT_EQ(axis.home(-5), HomingAxis::kDone);
    axis.enable(1);
    for (double& mark_m : axis.loop->coded_marks->marks_m) mark_m += lost * axis.axis.encoder_resolution_m;
    ASSERT_EQ(axis.write(0x6081, 0, axis.counts(0.1), 4), 0U);
    ASSERT_EQ(axis.write(0x607A, 0, axis.counts(0.18 - kZero_m), 4), 0U);
    ASSERT_EQ(axis.write(0x6040, 0, 0x0F, 2), 0U);
    ASSERT_EQ(axis.write(0x6040, 0, 0x1F, 2), 0U);
    axis.run_ms(1500);
    EXPECT_EQ(axis.read(0x603F, 0), lost == 0 ? 0U : 0x7320U);
    EXPECT_EQ(axis.referenced(), lost == 0);
  }
}

}  // namespace
}  // namespace slipstack::can
