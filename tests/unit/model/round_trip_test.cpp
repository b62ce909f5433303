// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/model/model_support.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench::test {
namespace {

void expect_equal(const Terms& is, const Terms& should) {
  ASSERT_EQ(is.size(), should.size());
  for (std::size_t t = 0; t < is.size(); ++t) {
    const Term& a = is[t];
    const Term& b = should[t];
    EXPECT_EQ(a.effect, b.effect);
    EXPECT_EQ(a.shapes, b.shapes) << a.id();  // to the last bit
    EXPECT_EQ(a.gains, b.gains) << a.id();
    EXPECT_EQ(a.lower, b.lower) << a.id();
    EXPECT_EQ(a.upper, b.upper) << a.id();
    EXPECT_EQ(a.gain_standard_errors, b.gain_standard_errors) << a.id();
    EXPECT_EQ(a.shape_standard_errors, b.shape_standard_errors) << a.id();
  }
}

TEST(ModelFile, IsReadAsItWasWritten) {
  const TemporaryFile file;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Model written = full_model(seed);
    const Model read = read_model(file.write(to_toml(written)));
    expect_equal(read.terms, written.terms);
    expect_equal(read.target_terms, written.target_terms);
    EXPECT_EQ(read.source.log, written.source.log);
    EXPECT_EQ(read.source.samples, written.source.samples);
    EXPECT_EQ(read.source.holdout_rmse_N, written.source.holdout_rmse_N);
    EXPECT_EQ(read.source.noise_floor_N, written.source.noise_floor_N);
    EXPECT_EQ(read.source.relative_error, written.source.relative_error);
    EXPECT_EQ(read.target_holdout_rmse_N, written.target_holdout_rmse_N);
    EXPECT_EQ(target_hash(read), target_hash(written));
    EXPECT_EQ(to_toml(read), to_toml(written));
  }
}

TEST(ModelFile, KeepsEveryEffectAlone) {
  const TemporaryFile file;
  std::mt19937_64 random(3);
  for (const EffectDescription& effect : catalogue()) {
    for (const std::size_t elements : {1u, 4u, 10u}) {
      Model written;
      written.terms = {random_term(effect, random, elements, true)};
      written.target_terms = {random_term(effect, random, elements, false)};
      const Model read = read_model(file.write(to_toml(written)));
      expect_equal(read.terms, written.terms);
      expect_equal(read.target_terms, written.target_terms);
    }
  }
}

// Bounds are float, values double: a value on its bound must not be refused for its last bit.
TEST(ModelFile, TakesValuesOnTheirBounds) {
  const TemporaryFile file;
  std::mt19937_64 random(4);
  for (const bool upper : {false, true}) {
    Model model;
    for (const EffectDescription& effect : catalogue()) {
      Term term = random_term(effect, random, kTargetElements, false);
      for (std::size_t i = 0; i < term.gains.size(); ++i)
        term.gains[i] = upper ? term.upper[i] : term.lower[i];
      for (std::size_t i = 0; i < term.shapes.size(); ++i) {
        const ShapeSpec& spec = effect.shapes[i];
        if (spec.kind == ShapeKind::slip_distance && i >= kTargetElements) continue;
        term.shapes[i] = static_cast<double>(upper ? spec.upper : spec.lower);
      }
      if (term.id() == "presliding_hysteresis") {
        for (std::size_t i = kTargetElements; i < term.gains.size(); ++i) term.gains[i] = 0.0;
      }
      model.terms.push_back(term);
    }
    model.target_terms = model.terms;
    EXPECT_EQ(refusal(file.write(to_toml(model))), "");
  }
}

TEST(ModelFile, KeepsWhatIsGiven) {
  const TemporaryFile file;
  std::mt19937_64 random(5);
  Model model;
  Term inertia = random_term(*find_effect("inertia"), random, 0, false);
  inertia.gains[0] = inertia.lower[0] = inertia.upper[0] = 35.45;
  model.terms = {inertia, random_term(*find_effect("viscous"), random, 0, false)};
  model.target_terms = model.terms;
  const Model read = read_model(file.write(to_toml(model)));
  expect_equal(read.terms, model.terms);
  EXPECT_EQ(read.terms[0].lower[0], 35.45);
  EXPECT_LT(read.terms[1].lower[0], read.terms[1].upper[0]);
}

TEST(ModelFile, TheHashIsTheControllers) {
  const Model model = full_model(8);
  const TargetParameters parameters = target_parameters(model.target_terms);
  const auto& hysteresis = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(parameters);
  EXPECT_TRUE(hysteresis.enabled);
  for (std::size_t i = 0; i < hysteresis.gains.size(); ++i) {
    EXPECT_EQ(hysteresis.gains[i], static_cast<float>(model.target_terms[1].gains[i]));
    EXPECT_EQ(hysteresis.shapes[i], static_cast<float>(model.target_terms[1].shapes[i]));
  }
  // Effects that are not on the controller do not enter the hash.
  Model other = model;
  other.terms[0].gains[0] += 1.0;
  EXPECT_EQ(target_hash(other), target_hash(model));
  other.target_terms[0].gains[0] *= 1.001;
  EXPECT_NE(target_hash(other), target_hash(model));
}

TEST(ModelFile, AnEffectThatIsAbsentIsOff) {
  const Model model = full_model(9);
  Terms few{model.target_terms[2], model.target_terms[12]};
  const TargetParameters parameters = target_parameters(few);
  int enabled = 0;
  std::apply([&](const auto&... own) { enabled = (0 + ... + (own.enabled ? 1 : 0)); }, parameters);
  EXPECT_EQ(enabled, 2);
}

// The file is for people too: single values as numbers, and the controller's part separate.
TEST(ModelFile, IsReadable) {
  std::mt19937_64 random(6);
  Model model;
  model.source.log = "run.csv";
  model.terms = {random_term(*find_effect("viscous"), random, 0, false)};
  model.terms[0].gains[0] = 12.5;
  model.target_terms = model.terms;
  const std::string text = to_toml(model);
  EXPECT_EQ(text.substr(0, 2), "# ");
  for (const char* part : {"format = ", "slipstack model 1", "hash = ", "[[effect]]", "[[target.effect]]",
                           "viscous", "N s/m", "value = 12.5", "run.csv"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << '\n' << text;
  }
  EXPECT_EQ(text.back(), '\n');
}

}  // namespace
}  // namespace slipstack::workbench::test
