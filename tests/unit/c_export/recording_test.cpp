// SPDX-License-Identifier: Apache-2.0
// What cannot be recorded is refused, never exported wrong; and what the header says of itself.
#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "tests/unit/c_export/random_model.h"
#include "workbench/base/errors.h"
#include "workbench/c_export/friction_header.h"
#include "workbench/c_export/recorder.h"

namespace slipstack {
namespace {

using workbench::ExportScales;
using workbench::InputError;
using workbench::NotRecordable;
using workbench::Recorded;

/// An effect with one gain and what `Basis` computes.
template <class Real, class Basis>
class OneGain {
 public:
  static constexpr EffectText text{.id = "one_gain",
                                   .title = "t",
                                   .formula = "f",
                                   .source = "s",
                                   .residual = "r",
                                   .evidence = "e",
                                   .cause = "c",
                                   .confirm = "c"};
  static constexpr std::array<GainGroup, 1> gains{{{"gain", "N", 0.0F, 1.0F, 1, Acts::force}}};
  static constexpr std::array<ShapeSpec, 0> shapes{{}};
  static constexpr int gain_count = 1;
  static constexpr int shape_count = 0;
  void prepare(std::span<const Real, 0>, const Scales<Real>&) {}
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, 1> out) { out[0] = basis_(sample.velocity_mps); }

 private:
  Basis basis_;
};

struct Choice {
  template <class Real>
  Real operator()(const Real& v) {
    return v < Real(0) ? Real(1) : v;
  }
};
struct WholeNumber {
  template <class Real>
  Real operator()(const Real& v) {
    return v * static_cast<Real>(static_cast<std::int32_t>(v));
  }
};
struct Counter {
  int calls = 0;
  template <class Real>
  Real operator()(const Real& v) {
    return v * static_cast<Real>(++calls);
  }
};
struct Selection {
  template <class Real>
  Real operator()(const Real& v) {
    return approx::select(v < Real(0) || v > Real(2), Real(1), v);
  }
};
/// A sum over time that the force depends on, and one that it does not.
struct TwoSums {
  template <class Real>
  struct Of {
    Real used{}, unused{};
    Real operator()(const Real& v) {
      used += v;
      unused += v * v;
      return used;
    }
  };
};

template <class Basis>
workbench::RecordedModel record() {
  using E = OneGain<Recorded<float>, Basis>;
  workbench::EffectDescription description;
  description.text = E::text;
  workbench::Term term;
  term.effect = &description;
  term.gains = {0.5};
  return workbench::Recorder<float, std::tuple<E>>({term}, ExportScales{}).record();
}

template <class Basis>
std::string refusal() {
  try {
    record<Basis>();
  } catch (const NotRecordable& error) {
    return error.what();
  }
  return "none";
}

TEST(Recording, RefusesWhatItCannotFollow) {
  EXPECT_NE(refusal<Choice>().find("chooses by ?:"), std::string::npos) << refusal<Choice>();
  EXPECT_NE(refusal<WholeNumber>().find("whole number"), std::string::npos) << refusal<WholeNumber>();
  EXPECT_NE(refusal<Counter>().find("remembers something else"), std::string::npos) << refusal<Counter>();
  EXPECT_EQ(refusal<Selection>(), "none");
}

TEST(Recording, KeepsOnlyTheStateThatTheForceDependsOn) {
  const workbench::RecordedModel model = record<TwoSums::Of<Recorded<float>>>();
  ASSERT_EQ(model.memory.size(), 1U);
  EXPECT_NE(model.memory[0].next, model.memory[0].now);
}

TEST(Recording, TheSameOperationOnTheSameOperandsIsOneValue) {
  workbench::ComputationRecord recording;
  const auto x = Recorded<float>::of(recording.leaf("x"));
  EXPECT_TRUE((x * x + x).same_as(x * x + x));
  EXPECT_FALSE((x * x).same_as(x + x));
  EXPECT_TRUE((Recorded<float>(2) * Recorded<float>(0.25)).is(0.5F));
}

workbench::Model some_model(std::string_view id, std::string_view second = "") {
  test::Draw draw(5);
  return test::random_model(draw, [&](const EffectText& text) { return text.id == id || text.id == second; });
}

std::string header_refusal(const workbench::Model& model, const workbench::FrictionHeaderOptions& options) {
  try {
    workbench::friction_header(model, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(FrictionHeader, WantsARateWhereAnEffectDependsOnIt) {
  EXPECT_NE(header_refusal(some_model("structural_resonance"), {}).find("--rate"), std::string::npos);
  EXPECT_NE(header_refusal(some_model("frictional_lag", "coulomb"), {}).find("--rate"), std::string::npos);
  EXPECT_EQ(header_refusal(some_model("frictional_lag"), {}), "none")
      << "without dry friction it adds nothing";
  EXPECT_EQ(header_refusal(some_model("drift"), {}), "none");
  workbench::FrictionHeaderOptions options;
  options.rate_Hz = 1e4;
  EXPECT_EQ(header_refusal(some_model("structural_resonance"), options), "none");
}

TEST(FrictionHeader, RefusesAStepThatDoesNotHoldTheSlipDistances) {
  workbench::Model model = some_model("presliding_hysteresis");
  auto& slip_m = model.target_terms[0].shapes;
  std::fill(slip_m.begin(), slip_m.end(), 0.0);
  slip_m[0] = 2e-6;
  slip_m[1] = 3e-4;
  workbench::FrictionHeaderOptions options;
  options.step_m = slip_m[1] / 16384.0;
  EXPECT_NE(header_refusal(model, options).find("give 1.83"), std::string::npos)
      << header_refusal(model, options);
  options.step_m = 1.01 * slip_m[0];
  EXPECT_NE(header_refusal(model, options).find("less than one step"), std::string::npos);
  options.step_m = slip_m[0];
  EXPECT_EQ(header_refusal(model, options), "none");
  // Chosen by itself: the finest of 1, 2, 5 that holds them.
  EXPECT_NE(workbench::friction_header(model, {}).find("#define FRICTION_STEP_M 2e-08F"), std::string::npos);
}

// An effect without a force of its own is not forgotten: its parameters are there for the caller.
TEST(FrictionHeader, StatesTheDelayThatItLeavesToTheCaller) {
  const workbench::Model model = some_model("time_delay");
  const std::string header = workbench::friction_header(model, {});
  const std::string value = workbench::c_literal(static_cast<float>(model.target_terms[0].shapes[0]));
  EXPECT_NE(header.find("#define FRICTION_TIME_DELAY_DELAY " + value), std::string::npos) << header;
}

}  // namespace
}  // namespace slipstack
