// SPDX-License-Identifier: Apache-2.0
// The sentences of a verdict agree with the table of candidates that is printed below them.
#include "workbench/report/verdict_sentence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// Of a log with a force of 20 N (rms), and a noise floor of 1 N.
std::string detail_of_complete(double baseline_N, double candidate_N, double criterion_difference) {
  const json candidate = {{"effect", "structural_resonance"},
                          {"evidence", "the residual rings at 2.4 Hz"},
                          {"holdout_rmse_N", candidate_N},
                          {"error_reduction", 1.0 - candidate_N / baseline_N},
                          {"criterion_difference", criterion_difference}};
  const json result = {{"verdict", "complete"},
                       {"noise_floor_N", 1.0},
                       {"bandwidth_Hz", 10.0},
                       {"discrepancy_N", std::sqrt(std::max(0.0, baseline_N * baseline_N - 1.0))},
                       {"baseline",
                        {{"holdout_rmse_N", baseline_N},
                         {"train_rmse_N", 0.9 * baseline_N},
                         {"relative_error", 0.9 * baseline_N / 20.0}}},
                       {"candidates", json::array({candidate})},
                       {"unexplained", nullptr}};
  return headline_of(result, [](const std::string& id) { return id; }).detail;
}

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(VerdictSentence, NothingLowersTheErrorWhereNothingDoes) {
  const std::string claim = "No effect of the catalogue lowers the held-out error significantly.";
  EXPECT_TRUE(says(detail_of_complete(1.05, 1.04, -600.0), claim));  // by a share that is not worth a name
  EXPECT_TRUE(says(detail_of_complete(1.05, 0.40, 3.0), claim));     // not supported by the log
  EXPECT_FALSE(says(detail_of_complete(1.05, 0.40, -600.0), claim));
  EXPECT_FALSE(says(detail_of_complete(1.50, 1.10, -600.0), claim));
}

TEST(VerdictSentence, SaysWhyAnEffectThatLowersTheErrorIsNotNamed) {
  const std::string below = detail_of_complete(1.05, 0.40, -600.0);
  EXPECT_TRUE(says(below, "although structural_resonance would lower the held-out error by 61.90 %"))
      << below;
  EXPECT_TRUE(says(below, "floor is estimated too high")) << below;
  const std::string at_floor = detail_of_complete(1.05, 0.98, -600.0);
  EXPECT_TRUE(says(at_floor, "already that of the noise floor")) << at_floor;
  EXPECT_FALSE(says(at_floor, "too high")) << at_floor;
  const std::string implausible = detail_of_complete(1.50, 1.10, -600.0);
  EXPECT_TRUE(says(implausible, "as fitted (the residual rings at 2.4 Hz) it is not plausible"))
      << implausible;
}

TEST(VerdictSentence, TellsWhatACompleteModelLeavesWhereThatIsMoreThanTheFloor) {
  const std::string told = "Beyond the floor it leaves";
  EXPECT_FALSE(says(detail_of_complete(1.40, 1.40, 3.0), told));
  const std::string above = detail_of_complete(std::sqrt(5.0), std::sqrt(5.0), 3.0);
  EXPECT_TRUE(says(above, "Beyond the floor it leaves 2.00 N, 10.00 % of the force.")) << above;
}

}  // namespace
}  // namespace slipstack::workbench
