// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/commission_folder.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/unit/temporary_directory.h"
#include "workbench/base/errors.h"

namespace slipstack::workbench {
namespace {

using slipstack::test::TemporaryDirectory;

TEST(CommissionFolder, GoesOnWhereItWasLeft) {
  const TemporaryDirectory folder;
  {
    CommissionFolder of_axis(folder / "new", "axis 1");
    EXPECT_FALSE(of_axis.resumed());
    of_axis.finish("mass", {{"mass_kg", 12.5}});
    of_axis.write("log.csv", "a\n");
    of_axis.write("log.csv", "b\n");
  }
  // What a cut of the power leaves of a file that was being written.
  std::ofstream(folder / "new" / "stages.json.part") << "{\"format\": 1, ";
  const CommissionFolder of_axis(folder / "new", "axis 1");
  EXPECT_TRUE(of_axis.resumed());
  EXPECT_TRUE(of_axis.done("mass"));
  EXPECT_FALSE(of_axis.done("feedback"));
  EXPECT_EQ(of_axis.found("mass").at("mass_kg"), 12.5);
  EXPECT_EQ(of_axis.read("log.csv"), "b\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "new" / "log.csv.part"));
  EXPECT_THROW(static_cast<void>(of_axis.read("other.csv")), UsageError);
}

TEST(CommissionFolder, RefusesWhatIsNotIts) {
  const TemporaryDirectory folder;
  { const CommissionFolder made(folder / "a", "axis 1"); }
  EXPECT_THROW(CommissionFolder(folder / "a", "axis 2"), UsageError);
  std::filesystem::create_directories(folder / "b");
  std::ofstream(folder / "b" / "letters.txt") << "dear";
  EXPECT_THROW(CommissionFolder(folder / "b", "axis 1"), UsageError);
  EXPECT_FALSE(std::filesystem::exists(folder / "b" / "stages.json"));
  for (const char* text : {"", "{", "[]", "{\"format\": 2}", "{\"format\": \"1\", \"axis\": \"axis 1\"}",
                           "{\"format\": 1, \"axis\": 3}"}) {
    std::ofstream(folder / "a" / "stages.json", std::ios::trunc) << text;
    EXPECT_THROW(CommissionFolder(folder / "a", "axis 1"), UsageError) << text;
  }
  std::ofstream(folder / "file") << "x";
  EXPECT_THROW(CommissionFolder(folder / "file", "axis 1"), UsageError);
}

}  // namespace
}  // namespace slipstack::workbench
