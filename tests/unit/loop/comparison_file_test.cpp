// SPDX-License-Identifier: Apache-2.0
// What a comparison keeps, and what it makes of kept axes.
#include "workbench/loop/comparison/comparison_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "workbench/base/errors.h"
#include "workbench/loop/comparison/comparison.h"

namespace slipstack::workbench {
namespace {

class ComparisonFileTest : public ::testing::Test {
 protected:
  std::string path_ =
      testing::TempDir() + "/kept-" + testing::UnitTest::GetInstance()->current_test_info()->name();
  std::vector<ContenderName> names_ = contenders_of(Field::kFew);

  void SetUp() override { std::filesystem::remove(path_); }
  void TearDown() override { std::filesystem::remove(path_); }

  /// Measures that tell contender and axis.
  std::vector<Measures> made(double base) const {
    std::vector<Measures> all(names_.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i].fill(base + static_cast<double>(i) / 3.0);
      all[i].back() = std::numeric_limits<double>::quiet_NaN();
    }
    return all;
  }
  std::string content() const {
    std::ifstream file(path_);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }
};

TEST_F(ComparisonFileTest, KeepsEveryDigitOfAnAxis) {
  ComparisonFile(path_, "task").add(7, names_, made(0.1));
  const auto found = ComparisonFile(path_, "task").find(7, names_);
  ASSERT_TRUE(found);
  for (std::size_t i = 0; i < names_.size(); ++i) {
    EXPECT_EQ((*found)[i][0], made(0.1)[i][0]);
    EXPECT_TRUE(std::isnan((*found)[i].back()));
  }
  EXPECT_FALSE(ComparisonFile(path_, "task").find(8, names_));
  EXPECT_FALSE(ComparisonFile(path_, "task").find(7, contenders_of(Field::kAll)));
}

TEST_F(ComparisonFileTest, ALineThatWasCutOffIsDropped) {
  ComparisonFile kept(path_, "task");
  kept.add(7, names_, made(0.1));
  const std::string one = content();
  kept.add(8, names_, made(0.2));
  std::filesystem::resize_file(path_, content().size() - 10);
  ComparisonFile again(path_, "task");
  EXPECT_TRUE(again.find(7, names_));
  EXPECT_FALSE(again.find(8, names_));
  EXPECT_EQ(content(), one);
  again.add(8, names_, made(0.2));
  EXPECT_TRUE(ComparisonFile(path_, "task").find(8, names_));
}

TEST_F(ComparisonFileTest, RefusesWhatIsNoneOrOfAnotherTaskAndLeavesIt) {
  ComparisonFile(path_, "task").add(7, names_, made(0.1));
  const std::string before = content();
  EXPECT_THROW(ComparisonFile(path_, "other"), UsageError);
  EXPECT_EQ(content(), before);
  std::ofstream(path_) << "time_s,position_m\n0,0\n";
  EXPECT_THROW(ComparisonFile(path_, "task"), InputError);
  EXPECT_EQ(content(), "time_s,position_m\n0,0\n");
  EXPECT_THROW(ComparisonFile("/no/such/folder/kept", "task"), UsageError);
}

// No axis is measured again: were it, the figures would be those of the axis.
TEST_F(ComparisonFileTest, AComparisonTakesWhatIsKept) {
  ComparisonFile kept(path_, "task");
  kept.add(5, names_, made(1.0));
  kept.add(6, names_, made(3.0));
  kept.add(7, names_, made(2.0));
  const Comparison comparison =
      compare({.first_seed = 5, .seeds = 3, .field = Field::kFew, .extent = {}}, kept,
              [](const std::string&, double) { FAIL() << "nothing is to be measured"; });
  ASSERT_EQ(comparison.contenders.size(), names_.size());
  EXPECT_DOUBLE_EQ(comparison.contenders[0].median(Measure::kRms), 2.0);
  EXPECT_DOUBLE_EQ(comparison.contenders[0].value(Measure::kRms, 1.0), 3.0);
  EXPECT_DOUBLE_EQ(comparison.contenders[0].ratio(Measure::kRms, 1.0, comparison.contenders[3]), 0.75);
}

}  // namespace
}  // namespace slipstack::workbench
