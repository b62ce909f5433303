// SPDX-License-Identifier: Apache-2.0
// What is fitted is what runs: the workbench's evaluation of a model against the firmware's tick.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <span>
#include <tuple>
#include <type_traits>
#include <vector>

#include "firmware/effects/catalogue.h"
#include "firmware/effects/model.h"
#include "tests/unit/estimate/estimate_support.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

using test::Draw;

TEST(WhatRuns, EvaluatesAsTheFirmwareDoes) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Measurement measurement(test::wandering_log(seed, 2000.0, 9000));
    const Terms terms = test::full_model(measurement, seed);
    const ForceTrace trace = evaluate_force(measurement, terms);
    FrictionModel<double> model;
    model.prepare(test::parameters_of<double>(terms),
                  {.tick_s = measurement.tick_s(), .metres_per_displacement = 1.0});
    model.reset(measurement.sample(0));
    double size = 0.0;
    double worst = 0.0;
    for (std::size_t i = 0; i < measurement.sample_count(); ++i) {
      const auto& force = model.step(measurement.sample(i));
      worst = std::max(worst, std::abs(force.total_N - trace.force_N[i]));
      size = std::max(size, std::abs(force.total_N));
    }
    EXPECT_LT(worst, 1e-12 * size) << seed;
    EXPECT_GT(size, 5.0);
  }
}

// Each effect by itself, so that no error is hidden by the others.
TEST(WhatRuns, EvaluatesEachEffectAsTheFirmwareDoes) {
  const Measurement measurement(test::wandering_log(11, 2000.0, 4000));
  Draw draw(12);
  const Term coulomb = test::random_term(measurement, "coulomb", draw);
  for (const EffectDescription& effect : catalogue()) {
    Terms terms{test::random_term(measurement, effect.text.id, draw)};
    if (effect.id() != "coulomb") terms.push_back(coulomb);  // something to modulate
    const ForceTrace trace = evaluate_force(measurement, terms);
    FrictionModel<double> model;
    model.prepare(test::parameters_of<double>(terms), {.tick_s = measurement.tick_s()});
    model.reset(measurement.sample(0));
    double apart = 0.0;
    for (std::size_t i = 0; i < measurement.sample_count(); ++i) {
      const double is = model.step(measurement.sample(i)).total_N;
      ASSERT_NEAR(is, trace.force_N[i], 1e-11 * (1.0 + std::abs(is))) << effect.id() << ' ' << i;
      apart = std::max(apart, std::abs(is - coulomb.gains[0] * (i % 2 == 0 ? 1.0 : -1.0)));
    }
    EXPECT_GT(apart, 0.0);
  }
}

/// The basis of one effect at every sample, one sample after the other.
template <class E>
std::vector<double> one_by_one(const Measurement& measurement, const std::vector<double>& shapes) {
  E effect{};
  effect.prepare(std::span(shapes).template first<E::shape_count>(), {.tick_s = measurement.tick_s()});
  effect.reset(measurement.sample(0));
  std::vector<double> basis(measurement.sample_count() * E::gain_count);
  for (std::size_t i = 0; i < measurement.sample_count(); ++i) {
    effect.basis(measurement.sample(i),
                 std::span<double, E::gain_count>(basis.data() + i * E::gain_count, E::gain_count));
  }
  return basis;
}

// The workbench runs many samples at once, in as wide vectors as the machine has: no bit may depend on that.
TEST(WhatRuns, GivesTheSameBitsByVectorsAsOneByOne) {
  const Measurement measurement(test::wandering_log(21, 2000.0, 3001));
  Draw draw(22);
  std::vector<Sample<double>> samples;
  for (std::size_t i = 0; i < measurement.sample_count(); ++i) samples.push_back(measurement.sample(i));
  std::size_t effects = 0;
  const auto compare = [&]<class E>(std::type_identity<E>) {
    const EffectDescription* effect = find_effect(E::text.id);
    if (effect == nullptr || E::gain_count == 0) return;  // user_table, and a delay, which has no basis
    const Term term = test::random_term(measurement, E::text.id, draw);
    const auto basis = effect->make();
    basis->prepare(term.shapes, {.tick_s = measurement.tick_s()});
    basis->reset(samples.front());
    std::vector<double> at_once(samples.size() * E::gain_count);
    basis->run(samples, at_once.data());
    const std::vector<double> expected = one_by_one<E>(measurement, term.shapes);
    EXPECT_EQ(std::memcmp(at_once.data(), expected.data(), at_once.size() * sizeof(double)), 0) << E::text.id;
    ++effects;
  };
  [&]<class... E>(std::type_identity<std::tuple<E...>>) {
    (compare(std::type_identity<E>{}), ...);
  }(std::type_identity<Catalogue<double>>{});
  EXPECT_GE(effects, 15u);
}

/// The controller's version of a model: ten elements with slip distances of whole counts.
Terms on_counts(Terms terms, double resolution_m) {
  for (Term& term : terms) {
    if (term.id() != "presliding_hysteresis") continue;
    for (std::size_t i = 0; i < term.gains.size(); ++i) {
      const bool used = i < kTargetElements;
      term.shapes[i] = used ? resolution_m * std::round(2.0 * std::pow(2.2, static_cast<double>(i))) : 0.0;
      term.gains[i] = used ? 0.8 / term.shapes[i] : 0.0;
    }
  }
  return terms;
}

/// Allowed error of single precision, 16-bit stiffnesses and tables, relative to the sum of all parts'
/// magnitudes.
constexpr double kTargetLoss = 9e-4;

TEST(WhatRuns, TheControllerAgreesInSinglePrecision) {
  constexpr double kResolution_m = 1e-7;
  double worst = 0.0;
  double squares = 0.0;
  double samples = 0.0;
  for (std::uint64_t seed = 20; seed < 26; ++seed) {
    const Measurement measurement(test::wandering_log(seed, 2000.0, 8000));
    const Terms terms = on_counts(test::full_model(measurement, seed), kResolution_m);
    FrictionModel<double> model;
    FrictionModel<float> target;
    const double tick_s = measurement.tick_s();
    model.prepare(test::parameters_of<double>(terms), {.tick_s = tick_s, .metres_per_displacement = 1.0});
    target.prepare(
        test::parameters_of<float>(terms),
        {.tick_s = static_cast<float>(tick_s), .metres_per_displacement = static_cast<float>(kResolution_m)});
    for (std::size_t i = 0; i < measurement.sample_count(); ++i) {
      Sample<double> sample = measurement.sample(i);
      const auto count = static_cast<std::int32_t>(std::lround(sample.displacement / kResolution_m));
      sample.displacement = count * kResolution_m;
      Sample<float> ticked;
      ticked.time_s = static_cast<float>(sample.time_s);
      ticked.displacement = count;
      ticked.position_m = static_cast<float>(sample.position_m);
      ticked.velocity_mps = static_cast<float>(sample.velocity_mps);
      ticked.acceleration_mps2 = static_cast<float>(sample.acceleration_mps2);
      if (i == 0) {
        model.reset(sample);
        target.reset(ticked);
      }
      const auto& is = model.step(sample);
      const double error_N = std::abs(static_cast<double>(target.step(ticked).total_N) - is.total_N);
      double size_N = 0.0;
      for (const double part_N : is.by_effect_N) size_N += std::abs(part_N);
      worst = std::max(worst, error_N / size_N);
      squares += error_N * error_N / (size_N * size_N);
      samples += 1.0;
    }
  }
  EXPECT_LT(worst, kTargetLoss);
  EXPECT_GT(worst, 0.1 * kTargetLoss);
  EXPECT_LT(std::sqrt(squares / samples), 0.25 * kTargetLoss);
}

// The hysteresis alone, in counts: an error of half a bit of sixteen in each stiffness, at the end as at the
// start.
TEST(WhatRuns, TheHysteresisDoesNotDriftApart) {
  constexpr double kResolution_m = 1e-6;
  const Measurement measurement(test::wandering_log(30, 2000.0, 20'000));
  Draw draw(31);
  const Terms terms =
      on_counts({test::random_term(measurement, "presliding_hysteresis", draw)}, kResolution_m);
  FrictionModel<double> model;
  FrictionModel<float> target;
  model.prepare(test::parameters_of<double>(terms), {.tick_s = 5e-4, .metres_per_displacement = 1.0});
  target.prepare(test::parameters_of<float>(terms), {.tick_s = 5e-4F, .metres_per_displacement = 1e-6F});
  const auto count_of = [&](std::size_t i) {
    return static_cast<std::int32_t>(std::lround(measurement.sample(i).displacement / kResolution_m));
  };
  model.reset({.displacement = count_of(0) * kResolution_m});
  target.reset({.displacement = count_of(0)});
  double early_N = 0.0;
  double late_N = 0.0;
  for (std::size_t i = 0; i < measurement.sample_count(); ++i) {
    const double is_N = model.step({.displacement = count_of(i) * kResolution_m}).total_N;
    const double on_target_N = static_cast<double>(target.step({.displacement = count_of(i)}).total_N);
    double& window_N = i < measurement.sample_count() / 2 ? early_N : late_N;
    window_N = std::max(window_N, std::abs(on_target_N - is_N));
  }
  const std::vector<double>& gains = terms[0].gains;
  double travel_m = 0.0;
  for (const double slip_m : terms[0].shapes) travel_m += slip_m;
  const double allowed_N = 0.5 * *std::max_element(gains.begin(), gains.end()) / 32767.0 * travel_m;
  EXPECT_LT(late_N, 1.01 * allowed_N);
  EXPECT_GT(late_N, 0.1 * allowed_N);
  EXPECT_LT(late_N, 1.5 * early_N);
}

}  // namespace
}  // namespace slipstack::workbench
