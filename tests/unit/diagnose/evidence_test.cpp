// SPDX-License-Identifier: Apache-2.0
// The evidence text: values of a fitted effect as the log has shown them.
#include "workbench/diagnose/evidence/evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/unit/estimate/estimate_support.h"
#include "workbench/estimate/linear/force_trace.h"
#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/uncertainty/friction_each_way.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/model/effect_adapters/effect_registry.h"

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

TEST(EvidenceOf, SaysWhichShapeABoundHasDetermined) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  Term mode = make_term(measurement, *find_effect("structural_resonance"));
  mode.gains = {1.0, 0.1, -1.0};
  mode.shapes = {50.0, 0.02};
  mode.gain_standard_errors = {0.1, 0.1, 0.1};
  mode.shape_standard_errors = {0.0, 0.001};
  const std::string text = evidence_of(mode, {mode});
  EXPECT_TRUE(says(text, "damping 2.00 +- 0.20 %")) << text;
  EXPECT_TRUE(says(text, "frequency is at an end of its search, not identified")) << text;
  EXPECT_FALSE(says(text, "damping is at an end")) << text;
}

// Whatever the log determines is told: each place of the text that stands for a shape or a gain, with its
// interval. What is told in another form (a map, an amplitude, friction each way) has tests of its own.
TEST(EvidenceOf, TellsEveryValueThatIsDetermined) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  const auto count = [](std::string_view text, std::string_view part) {
    int found = 0;
    for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++found;
    return found;
  };
  for (const EffectDescription& effect : catalogue()) {
    if (effect.has_shape(ShapeKind::travel) || effect.has_shape(ShapeKind::pitch) ||
        effect.id() == "direction_asymmetry") {
      continue;
    }
    Term term = make_term(measurement, effect);
    for (std::size_t i = 0; i < term.shapes.size(); ++i)
      term.shapes[i] = 0.4 * static_cast<double>(effect.shapes[i].lower + effect.shapes[i].upper);
    term.shape_standard_errors.assign(term.shapes.size(), 1e-9);
    term.gains.assign(term.gains.size(), 0.25);
    term.gain_standard_errors.assign(term.gains.size(), 1e-3);
    term.total_standard_errors.assign(1, 1e-3);
    const std::string text = evidence_of(term, {term});
    EXPECT_EQ(count(text, " +- "), count(effect.text.evidence, "{")) << effect.id() << ": " << text;
  }
}

// One part of the friction that fades may stand for the other: their total is told, a part only where it is
// no zero.
TEST(EvidenceOf, TellsFrictionThatFadesByItsTotal) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  Term stribeck = make_term(measurement, *find_effect("stribeck"));
  stribeck.shapes = {0.012, 1.5};
  stribeck.shape_standard_errors = {0.002, 0.2};
  stribeck.gains = {0.3, 0.1};
  stribeck.gain_standard_errors = {0.06, 0.06};
  stribeck.total_standard_errors = {0.01};
  EXPECT_TRUE(says(evidence_of(stribeck, {stribeck}), "by 40.0 +- 2.0 % of that level"));
  EXPECT_FALSE(says(evidence_of(stribeck, {stribeck}), "tail"));
  stribeck.gain_standard_errors = {0.04, 0.04};
  EXPECT_TRUE(says(evidence_of(stribeck, {stribeck}), "by 40.0 +- 2.0 % of that level, 10.0 +- 8.0 % of"));
}

// Two gains that nearly cancel, b + e, are told as what they do to the friction each way.
TEST(EvidenceOf, TellsAnAsymmetryAsTheFrictionEachWay) {
  Log log = test::wandering_log(5, 1000.0, 20'000);
  Measurement measurement(log);
  Terms truth{make_term(measurement, *find_effect("coulomb")),
              make_term(measurement, *find_effect("viscous")),
              make_term(measurement, *find_effect("direction_asymmetry"))};
  truth[0].gains = {10.0};
  truth[1].gains = {20.0};
  truth[2].gains = {0.3, -0.2, 4.0};
  const std::vector<double> force_N = evaluate_force(measurement, truth).force_N;
  test::Draw draw(6);
  for (std::size_t i = 0; i < force_N.size(); ++i) log.force_N[i] = force_N[i] + 0.5 * draw.normal();
  measurement = Measurement(log);
  const FittedModel fitted = with_standard_errors(measurement, fit_gains(measurement, truth));
  const FrictionEachWay value =
      friction_each_way(fitted.terms, *find_role(fitted.terms, Role::directional_friction));
  const FrictionEachWay error = standard_errors_each_way(fitted, "direction_asymmetry");
  EXPECT_NEAR(value.dry_forward_N, 11.0, 4.0 * error.dry_forward_N);
  EXPECT_NEAR(value.dry_backward_N, 9.0, 4.0 * error.dry_backward_N);
  EXPECT_NEAR(value.slope_forward, 24.0, 4.0 * error.slope_forward);
  EXPECT_NEAR(value.slope_backward, 16.0, 4.0 * error.slope_backward);
  EXPECT_GT(error.dry_forward_N, 0.0);
  EXPECT_LT(error.dry_forward_N, 1.0);
  const std::string text = evidence_of(fitted, "direction_asymmetry");
  EXPECT_TRUE(says(text, " +- ") && says(text, " N forward and ")) << text;
}

// A constant force adds to one way what it takes from the other: the sum of both is what a log shows.
TEST(EvidenceOf, TellsAnAsymmetryWithTheConstantForceBesideIt) {
  const Measurement measurement(test::wandering_log(5, 1000.0, 20'000));
  Terms model{make_term(measurement, *find_effect("coulomb")),
              make_term(measurement, *find_effect("direction_asymmetry"))};
  model[0].gains = {10.0};
  model[1].gains = {0.2, 0.0, 0.0};
  EXPECT_FALSE(says(evidence_of(model[1], model), "constant force"));
  model.push_back(make_term(measurement, *find_effect("offset_force")));
  model[2].gains = {-1.5};
  const std::string text = evidence_of(model[1], model);
  EXPECT_TRUE(says(text,
                   "dry friction is 12.0 N forward and 8.00 N backward, and with the constant force it "
                   "takes 10.5 N forward and 9.50 N backward"))
      << text;
}

TEST(EvidenceOf, TellsAMassBelowTheDeclaredOne) {
  const Measurement measurement(test::wandering_log(5, 1000.0, 20'000));
  Term payload = make_term(measurement, *find_effect("payload_mass"));
  payload.gains = {2.0};
  EXPECT_TRUE(says(evidence_of(payload, {payload}), "2.00 kg beyond what the log declares"));
  payload.gains = {-2.0};
  EXPECT_TRUE(
      says(evidence_of(payload, {payload}), "-2.00 kg, so the log declares more mass than the axis has"));
}

// Zero of the position may be far from the travel.
TEST(EvidenceOf, TellsTheForceOfASpringInTheMiddleOfTheTravel) {
  const Measurement measurement(test::wandering_log(5, 1000.0, 20'000));
  Term spring = make_term(measurement, *find_effect("cable_chain_stiffness"));
  spring.shapes = {10.0, 0.5};
  spring.gains = {4.0, -40.0, 0.0, 0.0};
  const std::string text = evidence_of(spring, {spring});
  EXPECT_TRUE(says(text, "4.00 N/m, 1.00 N in the middle of the travel")) << text;
}

// An offset in the model is the same force as that of the spring at zero: all of it is the offset's, and both
// are told in the middle of the travel.
TEST(EvidenceOf, TellsTheForceOfASpringBesideAnOffset) {
  Log log = test::wandering_log(5, 1000.0, 20'000);
  Measurement measurement(log);
  Terms terms{make_term(measurement, *find_effect("offset_force")),
              make_term(measurement, *find_effect("cable_chain_stiffness"))};
  const double middle_m = terms[1].shapes[0] + 0.5 * terms[1].shapes[1];
  test::Draw draw(6);
  for (std::size_t i = 0; i < log.force_N.size(); ++i)
    log.force_N[i] = 3.0 + 40.0 * (log.position_m[i] - middle_m) + 0.05 * draw.normal();
  measurement = Measurement(log);
  const FittedModel fitted = with_standard_errors(measurement, fit_gains(measurement, terms));
  EXPECT_NEAR(fitted.terms[0].gains[0], 3.0 - 40.0 * middle_m, 0.1);
  EXPECT_EQ(fitted.terms[1].gains[1], 0.0);
  const std::string text = evidence_of(fitted, "cable_chain_stiffness");
  const std::size_t at = text.find(", ", text.find("N/m")) + 2;
  EXPECT_NEAR(std::stod(text.substr(at)), 3.0, 0.1) << text;
}

// Over a log that is short against the time constant, the gain and the time constant are determined only
// together; their product with what the log has seen of it is determined well.
TEST(EvidenceOf, TellsADriftByItsChangeOverTheLog) {
  Log log = test::wandering_log(7, 1000.0, 20'000);
  Measurement measurement(log);
  Terms truth{make_term(measurement, *find_effect("coulomb")), make_term(measurement, *find_effect("drift"))};
  truth[0].gains = {10.0};
  truth[1].shapes = {100.0, 20.0};
  const double told = 0.3;
  truth[1].gains = {told};
  const std::vector<double> force_N = evaluate_force(measurement, truth).force_N;
  test::Draw draw(8);
  for (std::size_t i = 0; i < force_N.size(); ++i) log.force_N[i] = force_N[i] + 1.0 * draw.normal();
  measurement = Measurement(log);
  const FittedModel fitted = with_standard_errors(measurement, fit_gains(measurement, truth));
  const Term& drift = *find_term(fitted.terms, "drift");
  EXPECT_NEAR(drift.gains.front(), told, 4.0 * drift.gain_standard_error(0));
  EXPECT_GT(drift.gain_standard_error(0), 0.0);
  EXPECT_LT(drift.gain_standard_error(0) / told,
            0.5 * drift.shape_standard_error(0) / drift.shapes.front());  // it does not lean on that
  const std::string text = evidence_of(fitted, "drift");
  EXPECT_TRUE(says(text, "of itself within 20.0 s, with a time constant of ")) << text;
}

// The catalogue serves rotary axes too: where a text names parts of a slide it names those of a joint.
TEST(EvidenceOf, TextsHoldForARotaryAxis) {
  for (const EffectDescription& effect : catalogue()) {
    const std::string evidence(effect.text.evidence);
    EXPECT_FALSE(says(evidence, "rail") || says(evidence, "slide") || says(evidence, "carriage")) << evidence;
    EXPECT_FALSE(says(std::string(effect.text.title), "rail")) << effect.text.title;
  }
  const auto cause = [](const char* id) { return std::string(find_effect(id)->text.cause); };
  EXPECT_TRUE(says(cause("cable_chain_stiffness"), "gravity of a link over part of a turn"));
  EXPECT_TRUE(says(cause("force_ripple"), "gravity of a link (once a turn)"));
  EXPECT_TRUE(says(cause("structural_resonance"), "gear or belt"));
}

}  // namespace
}  // namespace slipstack::workbench
