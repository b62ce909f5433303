// SPDX-License-Identifier: Apache-2.0
// The evidence text: values of a fitted effect as the log has shown them.
#include "workbench/diagnose/evidence/evidence.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/unit/estimate/estimate_support.h"
#include "workbench/model/effects/effect_registry.h"

namespace slipstack::workbench {
namespace {

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(EvidenceOf, AMapByItsValuesOverTheTravelAndNotByItsGains) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  Term map = make_term(measurement, *find_effect("position_dependent_preload"));
  map.gains.front() = -0.9;  // its spline is 1/6 at the end of the travel, and less everywhere else
  const std::string text = evidence_of(map, {map});
  EXPECT_TRUE(says(text, "by up to 15.0 %")) << text;
  map.gains.assign(map.gains.size(), 0.3);  // the splines add up to one
  EXPECT_TRUE(says(evidence_of(map, {map}), "by up to 30.0 %"));
}

TEST(EvidenceOf, SaysWhichGainABoundHasDetermined) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  Term asymmetry = make_term(measurement, *find_effect("direction_asymmetry"));
  asymmetry.gains = {0.1, 0.0, 4.0};
  Term viscous = make_term(measurement, *find_effect("viscous"));
  viscous.gains = {5.0};
  EXPECT_FALSE(says(evidence_of(asymmetry, {viscous, asymmetry}), "bound"));
  viscous.gains = {4.0};  // one direction without any viscous friction
  EXPECT_TRUE(says(evidence_of(asymmetry, {viscous, asymmetry}), "viscous_asymmetry is at its bound"));
  asymmetry.gains[0] = asymmetry.upper[0];
  EXPECT_TRUE(says(evidence_of(asymmetry, {viscous, asymmetry}), "level_asymmetry is at its bound"));
}

}  // namespace
}  // namespace slipstack::workbench
