// SPDX-License-Identifier: Apache-2.0
// The sentences of a verdict agree with the table of candidates that is printed below them.
#include "workbench/report/verdict_sentence.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace slipstack::workbench {
namespace {

using nlohmann::json;

std::string detail_of_complete(double baseline_N, double candidate_N, double criterion_difference) {
  const json candidate = {{"effect", "structural_resonance"},
                          {"evidence", "the residual rings at 2.4 Hz"},
                          {"holdout_rmse_N", candidate_N},
                          {"error_reduction", 1.0 - candidate_N / baseline_N},
                          {"criterion_difference", criterion_difference}};
  const json result = {{"verdict", "complete"},
                       {"noise_floor_N", 1.0},
                       {"bandwidth_Hz", 10.0},
                       {"baseline", {{"holdout_rmse_N", baseline_N}}},
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

}  // namespace
}  // namespace slipstack::workbench
