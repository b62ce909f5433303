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
std::string detail_of_complete(double baseline_N, double candidate_N, const char* refusal) {
  const json candidate = {
      {"effect", "structural_resonance"}, {"evidence", "the residual rings at 2.4 Hz"},
      {"holdout_rmse_N", candidate_N},    {"error_reduction", 1.0 - candidate_N / baseline_N},
      {"error_reduction_se", 0.016},      {"refusal", refusal}};
  const json result = {{"verdict", "complete"},
                       {"noise_floor_N", 1.0},
                       {"bandwidth_Hz", 10.0},
                       {"discrepancy_N", std::sqrt(std::max(0.0, baseline_N * baseline_N - 1.0))},
                       {"baseline",
                        {{"holdout_rmse_N", baseline_N},
                         {"train_rmse_N", 0.9 * baseline_N},
                         {"relative_error", 0.9 * baseline_N / 20.0}}},
                       {"candidates", json::array({candidate})},
                       {"steps", json::array({{{"effect", "baseline"}, {"holdout_rmse_N", baseline_N}}})},
                       {"unexplained", nullptr}};
  return headline_of(result, [](const std::string& id) { return id; }).detail;
}

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(VerdictSentence, NothingLowersTheErrorWhereNothingDoes) {
  const std::string claim = "No effect of the catalogue lowers the held-out error significantly.";
  EXPECT_TRUE(says(detail_of_complete(1.05, 0.40, ""), claim));
  EXPECT_FALSE(says(detail_of_complete(1.05, 0.40, "at_floor"), claim));
  EXPECT_FALSE(says(detail_of_complete(1.50, 1.10, "implausible"), claim));
}

TEST(VerdictSentence, SaysWhyAnEffectThatLowersTheErrorIsNotNamed) {
  const std::string below = detail_of_complete(1.05, 0.40, "at_floor");
  EXPECT_TRUE(says(below, "although structural_resonance would lower the held-out error by 61.9 +- 3.2 %"))
      << below;
  EXPECT_TRUE(says(below, "floor is estimated too high")) << below;
  const std::string at_floor = detail_of_complete(1.05, 0.98, "at_floor");
  EXPECT_TRUE(says(at_floor, "already that of the noise floor")) << at_floor;
  EXPECT_FALSE(says(at_floor, "too high")) << at_floor;
  const std::string implausible = detail_of_complete(1.50, 1.10, "implausible");
  EXPECT_TRUE(says(implausible, "as fitted (the residual rings at 2.4 Hz) it is not plausible."))
      << implausible;
  const std::string small = detail_of_complete(1.50, 1.10, "too_small");
  EXPECT_TRUE(says(small, "as fitted (the residual rings at 2.4 Hz) it is no larger than")) << small;
}

TEST(VerdictSentence, TellsWhatACompleteModelLeavesWhereThatIsMoreThanTheFloor) {
  const std::string told = "Beyond the floor it leaves";
  EXPECT_FALSE(says(detail_of_complete(1.40, 1.40, ""), told));
  const std::string above = detail_of_complete(std::sqrt(5.0), std::sqrt(5.0), "");
  EXPECT_TRUE(says(above, "Beyond the floor it leaves 2.00 N, 10.00 % of the force.")) << above;
}

/// The baseline leaves 3 N of a force of 30 N (rms), viscous friction 2 N of them, at a noise floor of 1 N.
json result_of_viscous(const json& candidates) {
  return {{"verdict", "missing_effect"},
          {"noise_floor_N", 1.0},
          {"discrepancy_N", 0.5},
          {"baseline", {{"holdout_rmse_N", 3.0}, {"train_rmse_N", 3.0}, {"relative_error", 0.1}}},
          {"best", {{"holdout_rmse_N", 2.0}}},
          {"candidates", candidates},
          {"steps", json::array({{{"effect", "baseline"}, {"holdout_rmse_N", 3.0}},
                                 {{"effect", "viscous"}, {"holdout_rmse_N", 2.0}, {"evidence", "as told"}}})},
          {"unexplained", nullptr}};
}

/// A candidate that leaves `left_N` of the baseline's 3 N.
json candidate(const std::string& effect, double left_N) {
  return {{"effect", effect},
          {"title", effect},
          {"evidence", "as told"},
          {"holdout_rmse_N", left_N},
          {"error_reduction", 1.0 - left_N / 3.0},
          {"refusal", "implausible"}};
}

/// `other_N`: what another candidate than viscous friction leaves alone.
std::string detail_beside_viscous(const std::string& other, double other_N) {
  json viscous = candidate("viscous", 2.0);
  viscous["refusal"] = "";
  const json result = result_of_viscous(json::array({viscous, candidate(other, other_N)}));
  return headline_of(result, [](const std::string& id) { return id; }).detail;
}

TEST(VerdictSentence, TellsOfAnEffectThatAloneLeavesLessThanAllThatAreNamed) {
  EXPECT_TRUE(
      says(detail_beside_viscous("coulomb", 1.80), "coulomb alone would leave less, 1.80 N, but as fitted"));
  EXPECT_FALSE(says(detail_beside_viscous("coulomb", 1.99), "coulomb"));  // by less than is worth a name
}

TEST(VerdictSentence, TellsWhatNamedEffectsLeaveWhereThatIsMoreThanTheFloor) {
  json result = result_of_viscous(json::array({candidate("viscous", 2.0)}));
  result["candidates"][0]["refusal"] = "";
  const auto detail = [&result] {
    return headline_of(result, [](const std::string& id) { return id; }).detail;
  };
  EXPECT_FALSE(says(detail(), "Beyond the floor")) << detail();
  result["discrepancy_N"] = 1.5;
  EXPECT_TRUE(says(detail(), "Beyond the floor it leaves 1.50 N, 5.00 % of the force.")) << detail();
}

TEST(VerdictSentence, TellsATieInTheHeadline) {
  const auto pair = [](const char* effect, const char* other) {
    return json{{"effect", effect}, {"other", other}, {"angle_deg", 3.0}};
  };
  json result = result_of_viscous(json::array({candidate("viscous", 2.0), candidate("offset_force", 2.0)}));
  result["steps"].push_back({{"effect", "offset_force"}, {"holdout_rmse_N", 1.5}});
  result["cannot_separate"] = json::array({pair("viscous", "quadratic_drag"), pair("viscous", "drift"),
                                           pair("offset_force", "cable_chain_stiffness")});
  const Headline told = headline_of(result, [](const std::string& id) { return id; });
  EXPECT_TRUE(
      says(told.line, "Missing: viscous; this log cannot tell it from quadratic_drag or drift. Adding"))
      << told.line;
  EXPECT_TRUE(says(told.detail, "This log cannot tell offset_force from cable_chain_stiffness."))
      << told.detail;
  result["cannot_separate"] = json::array();
  const Headline alone = headline_of(result, [](const std::string& id) { return id; });
  EXPECT_FALSE(says(alone.line + alone.detail, "cannot tell")) << alone.line << alone.detail;
}

}  // namespace
}  // namespace slipstack::workbench
