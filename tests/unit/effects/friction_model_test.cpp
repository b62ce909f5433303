// SPDX-License-Identifier: Apache-2.0
// The sum that the tick evaluates, against the product formula of effect.h worked out one effect at a time.
#include "firmware/effects/model.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "tests/unit/effects/effect_support.h"

namespace slipstack {
namespace {

using test::Draw;
using Model = FrictionModel<double>;
constexpr Scales<double> kScales{.tick_s = test::kTick_s, .metres_per_displacement = 1.0};

/// Gains that make every effect matter beside the others.
template <class E>
void draw_gains(Draw& draw, EffectParameters<E, double>& own) {
  own.shapes = test::random_shapes<E>(draw);
  std::size_t g = 0;
  for (const GainGroup& group : E::gains) {
    for (int i = 0; i < group.count; ++i, ++g) {
      double gain = draw.uniform(0.2, 1.0);
      if (group.acts == Acts::dry) gain *= group.count > 1 ? 1e5 : 3.0;
      if (group.acts == Acts::dry_scale) gain *= 0.3;
      if (group.acts == Acts::total_scale) gain *= 0.1;
      if (group.lower < 0.0F) gain *= draw.sign();
      own.gains[g] = gain;
    }
  }
}

template <class Visit>
void for_each_parameter(Model::Parameters& parameters, Visit visit) {
  std::apply([&](auto&... own) { (visit(own), ...); }, parameters);
}

Model::Parameters random_parameters(Draw& draw, double share_enabled) {
  Model::Parameters parameters;
  for_each_parameter(parameters, [&](auto& own) {
    draw_gains(draw, own);
    own.enabled = draw.uniform(0.0, 1.0) < share_enabled;
  });
  return parameters;
}

/// The contract's formula with effects of its own, each asked by itself.
class WrittenOut {
 public:
  struct Sums {
    double force = 0.0, dry = 0.0, dry_factor = 1.0, total_factor = 1.0;
    double total() const { return (force + dry * dry_factor) * total_factor; }
  };

  WrittenOut(const Model::Parameters& parameters, const Sample<double>& start) : parameters_(parameters) {
    visit([&](auto& effect, const auto& own) {
      effect.prepare(own.shapes, kScales);
      effect.reset(start);
    });
  }

  Sums at(Sample<double> sample) {
    Sums sums;
    visit([&](auto& effect, const auto& own) { add(effect, own, sample, sums, true); });
    sample.dry_friction_N = sums.dry;
    visit([&](auto& effect, const auto& own) { add(effect, own, sample, sums, false); });
    return sums;
  }

 private:
  template <class E, class Own>
  static void add(E& effect, const Own& own, const Sample<double>& sample, Sums& sums, bool dry_pass) {
    bool dry = false;
    for (const GainGroup& group : E::gains) dry |= group.acts == Acts::dry;
    if (!own.enabled || dry != dry_pass || E::gain_count == 0) return;
    std::array<double, E::gain_count> basis{};
    effect.basis(sample, basis);
    double dry_scale = 0.0;
    double total_scale = 0.0;
    std::size_t g = 0;
    for (const GainGroup& group : E::gains) {
      double sum = 0.0;
      for (int i = 0; i < group.count; ++i, ++g) sum += own.gains[g] * basis[g];
      if (group.acts == Acts::force) sums.force += sum;
      if (group.acts == Acts::dry) sums.dry += sum;
      if (group.acts == Acts::dry_scale) dry_scale += sum;
      if (group.acts == Acts::total_scale) total_scale += sum;
    }
    sums.dry_factor *= 1.0 + dry_scale;
    sums.total_factor *= 1.0 + total_scale;
  }
  template <class Visit>
  void visit(Visit each) {
    [&]<std::size_t... I>(std::index_sequence<I...>) {
      (each(std::get<I>(effects_), std::get<I>(parameters_)), ...);
    }
    (std::make_index_sequence<Model::effect_count>{});
  }

  Catalogue<double> effects_;
  Model::Parameters parameters_;
};

TEST(FrictionModel, IsTheDocumentedProduct) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Draw draw(seed);
    const Model::Parameters parameters = random_parameters(draw, seed < 4 ? 1.0 : 0.6);
    const auto motion = test::random_motion(seed + 100, 1500);
    Model model;
    model.prepare(parameters, kScales);
    model.reset(motion[0]);
    WrittenOut formula(parameters, motion[0]);
    for (const Sample<double>& sample : motion) {
      const Model::Force is = model.step(sample);
      const WrittenOut::Sums should = formula.at(sample);
      const double scale = 1.0 + std::abs(should.force) + std::abs(should.dry);
      ASSERT_NEAR(is.total_N, should.total(), 1e-12 * scale) << seed;
      ASSERT_NEAR(is.dry_friction_N, should.dry * should.dry_factor, 1e-12 * scale) << seed;
    }
  }
}

TEST(FrictionModel, EffectsAddUpToTheTotal) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Draw draw(seed + 50);
    const Model::Parameters parameters = random_parameters(draw, 0.7);
    const auto motion = test::random_motion(seed, 1000);
    Model model;
    model.prepare(parameters, kScales);
    model.reset(motion[0]);
    for (const Sample<double>& sample : motion) {
      const Model::Force force = model.step(sample);
      double sum = 0.0;
      double size = 1.0;
      for (const double part : force.by_effect_N) {
        sum += part;
        size += std::abs(part);
      }
      ASSERT_NEAR(sum, force.total_N, 1e-14 * size) << seed;
    }
  }
}

// Whatever lies in the parameters of an effect that is off, even rubbish, is not looked at.
TEST(FrictionModel, DisabledEffectsContributeNothing) {
  Draw draw(77);
  Model::Parameters parameters = random_parameters(draw, 0.5);
  Model::Parameters rubbish = parameters;
  std::array<bool, Model::effect_count> enabled{};
  std::size_t place = 0;
  for_each_parameter(rubbish, [&](auto& own) {
    enabled[place++] = own.enabled;
    if (own.enabled) return;
    own.gains.fill(std::numeric_limits<double>::quiet_NaN());
    own.shapes.fill(0.0);
  });
  const auto motion = test::random_motion(9, 1000);
  Model model;
  Model other;
  model.prepare(parameters, kScales);
  other.prepare(rubbish, kScales);
  model.reset(motion[0]);
  other.reset(motion[0]);
  std::array<double, Model::effect_count> seen{};
  for (const Sample<double>& sample : motion) {
    const Model::Force force = model.step(sample);
    ASSERT_EQ(force.total_N, other.step(sample).total_N);
    for (std::size_t e = 0; e < seen.size(); ++e) seen[e] += std::abs(force.by_effect_N[e]);
  }
  int on = 0;
  for (std::size_t e = 0; e < seen.size(); ++e) {
    on += enabled[e] ? 1 : 0;
    if (!enabled[e]) {
      EXPECT_EQ(seen[e], 0.0) << e;
    }
  }
  EXPECT_GE(on, 5);
  EXPECT_LE(on, 14);
}

TEST(FrictionModel, AnEmptyModelIsZero) {
  Model model;
  model.prepare({}, kScales);
  model.reset({});
  const Model::Force force = model.step({.velocity_mps = 1.0, .acceleration_mps2 = 1.0});
  EXPECT_EQ(force.total_N, 0.0);
  EXPECT_EQ(force.dry_friction_N, 0.0);
}

// Worked by hand: 2 kg at 3 m/s2, 10 N of Coulomb friction doubled by Stribeck at standstill and then raised
// by a tenth for the direction, 4 N s/m to either side, and a motor constant 5 % off.
TEST(FrictionModel, WorkedExample) {
  Model::Parameters parameters;
  auto& inertia = std::get<EffectParameters<Inertia<double>, double>>(parameters);
  inertia = {.gains = {2.0}, .shapes = {}, .enabled = true};
  auto& coulomb = std::get<EffectParameters<Coulomb<double>, double>>(parameters);
  coulomb = {.gains = {10.0}, .shapes = {1e-6}, .enabled = true};
  auto& stribeck = std::get<EffectParameters<Stribeck<double>, double>>(parameters);
  stribeck = {.gains = {1.0}, .shapes = {1.0, 1.0}, .enabled = true};
  auto& asymmetry = std::get<EffectParameters<DirectionAsymmetry<double>, double>>(parameters);
  asymmetry = {.gains = {0.1, 0.2, 4.0}, .shapes = {1e-4}, .enabled = true};
  auto& ripple = std::get<EffectParameters<MotorConstantRipple<double>, double>>(parameters);
  ripple = {.gains = {0.05}, .shapes = {0.01}, .enabled = true};
  Model model;
  model.prepare(parameters, kScales);
  model.reset({});
  const Model::Force force = model.step({.velocity_mps = 1e-5, .acceleration_mps2 = 3.0});
  const double stribeck_factor = 1.0 + std::exp(-1e-5);
  const double by_motion = 0.2 * (1.5 * 0.1 - 0.5 * 0.001);
  const double dry_N = 10.0 * stribeck_factor * (1.1 + by_motion);
  const double plain_N = 6.0 + 4e-5;
  EXPECT_NEAR(force.dry_friction_N, dry_N, 1e-6);
  EXPECT_NEAR(force.total_N, (dry_N + plain_N) * 1.05, 1e-6);
  EXPECT_NEAR(force.by_effect_N[0], 6.0, 1e-12);                                               // inertia
  EXPECT_NEAR(force.by_effect_N[2], 10.0, 1e-12);                                              // coulomb
  EXPECT_NEAR(force.by_effect_N[5], 10.0 * (stribeck_factor - 1.0), 1e-6);                     // stribeck
  EXPECT_NEAR(force.by_effect_N[9], 10.0 * stribeck_factor * (0.1 + by_motion) + 4e-5, 1e-6);  // direction
  EXPECT_NEAR(force.by_effect_N[11], 0.05 * (dry_N + plain_N), 1e-6);  // motor constant
}

// Parameters may be sent again in motion; the hysteresis goes on from where it is.
TEST(FrictionModel, PreparingAgainKeepsTheState) {
  Draw draw(31);
  const Model::Parameters parameters = random_parameters(draw, 1.0);
  const auto motion = test::random_motion(32, 2000);
  Model steady;
  Model renewed;
  steady.prepare(parameters, kScales);
  renewed.prepare(parameters, kScales);
  steady.reset(motion[0]);
  renewed.reset(motion[0]);
  for (std::size_t i = 0; i < motion.size(); ++i) {
    if (i % 100 == 50) renewed.prepare(parameters, kScales);
    ASSERT_EQ(steady.step(motion[i]).total_N, renewed.step(motion[i]).total_N) << i;
  }
}

}  // namespace
}  // namespace slipstack
