// SPDX-License-Identifier: Apache-2.0
// Distance-coded marks on random scales, both ways, with marks missed and marks that are none.
#include "firmware/control/homing/coded_marks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "sim_host/sensors/coded_scale.h"

namespace slipstack {
namespace {

// A scale whose unit is the count, drawn by the simulation; the zero lies anywhere in 32 bits.
struct Scale {
  explicit Scale(std::mt19937& random) {
    const auto between = [&random](int low, int high) {
      return std::uniform_int_distribution<int>(low, high)(random);
    };
    const int tolerance = between(1, 5);
    const int step = between(4 * tolerance + 1, 4 * tolerance + 40);
    const int distance = 2 * between(4 * step, 60 * step);
    reversed = between(0, 1) == 1;
    code = {static_cast<std::uint32_t>(distance), reversed ? -step : step,
            static_cast<std::uint32_t>(tolerance)};
    pairs = distance / 2 / step - 1;
    const auto drawn = sim::CodedScale::drawn(0.0, reversed ? -1 : 1, distance, step, pairs);
    zero = static_cast<std::int32_t>(random());
    for (const double mark : drawn.marks_m) {
      const int off = tolerance > 1 ? between(-(tolerance - 1), tolerance - 1) : 0;
      marks.push_back(static_cast<std::int32_t>(static_cast<std::uint32_t>(zero) +
                                                static_cast<std::uint32_t>(std::lround(mark) + off)));
    }
  }
  bool right(std::int32_t found) const {
    const std::int32_t off = difference(found, zero);
    return std::abs(off) <= static_cast<std::int32_t>(code.tolerance);
  }

  MarkCode code;
  bool reversed = false;
  int pairs = 0;
  std::int32_t zero = 0;
  std::vector<std::int32_t> marks;  // upwards
};

TEST(CodedMarks, ThreeMarksOfAnyScaleSayWhereItsZeroIs) {
  std::mt19937 random(1);
  for (int i = 0; i < 5000; ++i) {
    const Scale scale(random);
    ASSERT_TRUE(valid(scale.code));
    if (scale.marks.size() < 3) continue;
    std::vector<std::int32_t> passed = scale.marks;
    if (i % 2 == 1) std::reverse(passed.begin(), passed.end());
    const auto from = std::uniform_int_distribution<std::size_t>(0, passed.size() - 3)(random);
    CodedMarks coded;
    EXPECT_FALSE(coded.passed(scale.code, passed[from]));
    EXPECT_FALSE(coded.passed(scale.code, passed[from + 1]));
    ASSERT_TRUE(coded.passed(scale.code, passed[from + 2])) << i;
    ASSERT_TRUE(scale.right(coded.zero())) << i;
  }
}

// One mark is missed, or one is none: what was passed with it is refused, and the marks that follow are
// believed.
TEST(CodedMarks, AMarkThatIsMissedOrNoneIsRefused) {
  std::mt19937 random(2);
  int refused = 0;
  int found_after = 0;
  for (int i = 0; i < 5000; ++i) {
    const Scale scale(random);
    if (scale.marks.size() < 8) continue;
    const auto first = std::uniform_int_distribution<std::size_t>(0, scale.marks.size() - 8)(random);
    std::vector<std::int32_t> passed(scale.marks.begin() + static_cast<std::ptrdiff_t>(first),
                                     scale.marks.begin() + static_cast<std::ptrdiff_t>(first) + 8);
    const bool false_one = i % 2 == 0;
    if (false_one) {
      const std::int32_t gap = difference(passed[2], passed[1]);
      const auto place = std::uniform_int_distribution<std::int32_t>(0, gap)(random);
      passed.insert(passed.begin() + 2, sum(passed[1], place));
    } else {
      passed.erase(passed.begin() + 1);
    }
    if (i % 4 >= 2) std::reverse(passed.begin(), passed.end());
    CodedMarks coded;
    bool found = false;
    std::size_t n = 0;
    for (; n < passed.size() && !found; ++n) {
      found = coded.passed(scale.code, passed[n]);
      refused += n >= 2 && !found ? 1 : 0;
    }
    ASSERT_TRUE(found) << i;
    ASSERT_TRUE(scale.right(coded.zero())) << i << (false_one ? " false" : " missed") << " mark";
    found_after += n > 3 ? 1 : 0;
  }
  EXPECT_GT(refused, 1500);
  EXPECT_GT(found_after, 1500);
}

// Two neighbours may be further apart or nearer by the tolerance of both, and by no count more; the same
// whichever of the two is the longer distance, and whichever way the scale counts.
TEST(CodedMarks, ADistanceIsOneOfTheScaleUpToTheToleranceOfTwoMarks) {
  for (const std::int32_t sign : {1, -1}) {
    for (const std::uint32_t tolerance : {1U, 3U}) {
      const MarkCode code{.distance = 2000, .step = sign * 20, .tolerance = tolerance};
      const auto most = 2 * static_cast<std::int32_t>(tolerance);
      for (std::int32_t off = -most - 3; off <= most + 3; ++off) {
        // Of the even mark 7 and the odd one behind it, then of that and the even mark 8.
        for (const bool first : {true, false}) {
          std::array<std::int32_t, 3> marks = {7 * 2000, 7 * 2000 + 1000 + 7 * 20, 8 * 2000};
          (first ? marks[0] : marks[2]) += first ? -off : off;
          if (sign < 0) marks = {-marks[0], -marks[1], -marks[2]};
          CodedMarks coded;
          EXPECT_FALSE(coded.passed(code, marks[0]));
          EXPECT_FALSE(coded.passed(code, marks[1]));
          EXPECT_EQ(coded.passed(code, marks[2]), std::abs(off) <= most)
              << sign << ' ' << tolerance << ' ' << off << ' ' << first;
        }
      }
    }
  }
}

TEST(CodedMarks, TurningRoundIsNoNewMark) {
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    const Scale scale(random);
    if (scale.marks.size() < 3) continue;
    CodedMarks coded;
    for (const std::size_t mark : {0U, 1U, 1U, 0U, 0U, 1U}) {
      ASSERT_FALSE(coded.passed(scale.code, scale.marks[mark])) << i;
    }
  }
}

TEST(CodedMarks, TheCheckInServiceTakesTheMarksAndNothingElse) {
  std::mt19937 random(4);
  for (int i = 0; i < 2000; ++i) {
    const Scale scale(random);
    for (const std::int32_t mark : scale.marks) {
      ASSERT_TRUE(CodedMarks::belongs(scale.code, scale.zero, mark)) << i;
    }
    for (int k = 0; k < 20; ++k) {
      const auto low = scale.marks.front();
      const auto length = difference(scale.marks.back(), low);
      const std::int32_t there = sum(low, std::uniform_int_distribution<std::int32_t>(0, length)(random));
      std::int32_t nearest = 1 << 30;
      for (const std::int32_t mark : scale.marks)
        nearest = std::min(nearest, std::abs(difference(there, mark)));
      if (nearest < 2 * static_cast<std::int32_t>(scale.code.tolerance)) continue;
      ASSERT_FALSE(CodedMarks::belongs(scale.code, scale.zero, there)) << i;
    }
  }
}

TEST(CodedMarks, CodesThatCannotBeToldApartAreRefused) {
  EXPECT_TRUE(valid(MarkCode{}));
  EXPECT_FALSE(valid(MarkCode{0, 20, 1})) << "a step without a distance";
  EXPECT_FALSE(valid(MarkCode{20000, 0, 1})) << "no step";
  EXPECT_TRUE(valid(MarkCode{20000, 20, 4}));
  EXPECT_TRUE(valid(MarkCode{20000, -20, 4}));
  EXPECT_FALSE(valid(MarkCode{20000, 20, 5})) << "two places could be one";
  EXPECT_FALSE(valid(MarkCode{20000, 5000, 4})) << "not even three places";
}

}  // namespace
}  // namespace slipstack
