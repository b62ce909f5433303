// SPDX-License-Identifier: Apache-2.0
// Where the carriage ends after each fault at worst speed and place, and docs/energy.md against it.
#include <gtest/gtest.h>

#include "tests/bench/documented_table.h"
#include "tests/bench/energy/cases.h"

namespace slipstack::energy {
namespace {

TEST(Energy, NothingReachesTheStopWithMoreThanStated) {
  for (const Case& one : cases()) {
    SCOPED_TRACE(one.name);
    const Outcome with_brake = run(one, true);
    EXPECT_LE(with_brake.energy_J, one.most_J);
    EXPECT_GE(with_brake.energy_J, 0.6 * one.most_J);
    EXPECT_LT(with_brake.peak_mps, 1.2 * kSpeed_mps);
    const Outcome without = run(one, false);
    EXPECT_LE(without.energy_J, one.most_without_J);
    // What can only coast reaches the stop: the table does not flatter.
    if (one.most_without_J > 0.0) {
      EXPECT_GT(without.energy_J, 50.0);
    }
  }
}

// As the page says to make it: energy_test --table.
TEST(Energy, ThePageHasTheTableOfToday) {
  expect_page_has(SLIPSTACK_ENERGY_PAGE, table());
}

}  // namespace
}  // namespace slipstack::energy

int main(int count, char** words) {
  return slipstack::print_table_or_run_tests(count, words, slipstack::energy::table);
}
