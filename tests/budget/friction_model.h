// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <tuple>

#include "firmware/effects/model.h"

// The friction model of the controller with every effect of the catalogue enabled, with parameters of the
// size of the pick-and-place axis, driven by encoder counts: for measurements and traces.
namespace slipstack::budget {

// 1 um encoder, 10 kHz.
inline constexpr Scales<float> kScales{1.0e-4F, 1.0e-6F};

namespace detail {

// Lengths are those of the effect: one that gains a parameter does not compile here until it has a value.
template <class E>
void set(FrictionModel<float>::Parameters& all, const std::array<float, E::gain_count>& gains,
         const std::array<float, E::shape_count>& shapes) {
  std::get<EffectParameters<E, float>>(all) = {gains, shapes, true};
}

// An array of as many values as are written.
template <class... Value>
constexpr std::array<float, sizeof...(Value)> values(Value... value) {
  return {value...};
}

// Something else than zero within the bounds, for an effect that has no values below yet.
constexpr float some_gain(const GainGroup& group) {
  const bool scales = group.acts == Acts::dry_scale || group.acts == Acts::total_scale;
  const float wanted = scales ? 0.05F : 1.0F;
  return wanted < group.upper ? wanted : 0.5F * group.upper;
}

// As far above its lower bound as a hundredth of the range: no bound of the catalogue is a place to work at.
constexpr float some_shape(const ShapeSpec& shape) {
  return shape.lower + 0.01F * (shape.upper - shape.lower);
}

template <class E>
void set_unless_set(FrictionModel<float>::Parameters& all) {
  auto& own = std::get<EffectParameters<E, float>>(all);
  if (own.enabled) return;
  std::size_t gain = 0;
  for (const GainGroup& group : E::gains) {
    for (int i = 0; i < group.count; ++i) own.gains[gain++] = some_gain(group);
  }
  for (std::size_t i = 0; i < own.shapes.size(); ++i) own.shapes[i] = some_shape(E::shapes[i]);
  own.enabled = true;
}

template <class... Effects>
void set_the_rest(FrictionModel<float>::Parameters& all, const std::tuple<Effects...>*) {
  (set_unless_set<Effects>(all), ...);
}

}  // namespace detail

// A user-defined effect: a bump 4 mm wide, tabulated.
inline std::array<float, kUserTablePoints> bump_of_4_newtons() {
  std::array<float, kUserTablePoints> points{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float u = (static_cast<float>(i) - 16.0F) / 16.0F;
    points[i] = 4.0F * (1.0F - u * u) * (1.0F - u * u) + 0.01F;
  }
  return points;
}

// Every effect on, none of its gains zero. One that was just added has values by its bounds.
inline FrictionModel<float>::Parameters all_effects() {
  using detail::set;
  using detail::values;
  FrictionModel<float>::Parameters p{};
  set<Inertia<float>>(p, values(35.0F), values());
  set<PreslidingHysteresis<float>>(
      p, values(4.1e5F, 5.7e5F, 4.3e5F, 2.9e5F, 1.7e5F, 8.3e4F, 4.7e4F, 2.9e4F, 1.1e4F, 3.7e3F),
      values(1e-6F, 2e-6F, 3e-6F, 5e-6F, 8e-6F, 1.3e-5F, 2.1e-5F, 3.4e-5F, 5.5e-5F, 3e-4F));
  set<Coulomb<float>>(p, values(1.3F), values(2e-4F));
  set<Viscous<float>>(p, values(12.0F), values());
  set<QuadraticDrag<float>>(p, values(3.0F), values(1.9F));
  set<Stribeck<float>>(p, values(0.15F, 0.04F), values(3e-3F, 0.8F));
  set<FrictionalLag<float>>(p, values(0.1F, 0.03F), values(8e-3F, 1.3F, 0.02F, 0.004F));
  set<PositionDependentPreload<float>>(
      p,
      values(0.1F, -0.05F, 0.2F, 0.15F, -0.1F, 0.05F, 0.02F, 0.3F, -0.2F, 0.1F, 0.07F, -0.03F, 0.12F, 0.09F,
             -0.06F, 0.01F, 0.14F, -0.08F, 0.03F, 0.04F),
      values(0.0F, 0.4F));
  set<AccelerationDependentPreload<float>>(p, values(0.004F, 0.002F), values(50.0F));
  set<DirectionAsymmetry<float>>(p, values(0.05F, -0.02F, 2.0F), values(1e-4F));
  set<ForceRipple<float>>(p, values(1.1F, -0.6F, 0.4F, 0.3F, -0.2F, 0.1F, 0.05F, 0.08F), values(0.024F));
  set<MotorConstantRipple<float>>(p, values(0.02F, -0.01F, 0.01F, 0.005F, -0.004F, 0.003F, 0.002F, 0.001F),
                                  values(0.024F));
  set<OffsetForce<float>>(p, values(-0.7F), values());
  set<CableChainStiffness<float>>(p, values(6.0F, -1.1F, 0.15F, 0.3F), values(0.0F, 0.4F));
  set<PayloadMass<float>>(p, values(1.5F), values());
  set<StructuralResonance<float>>(p, values(1.2F, 0.1F, 0.3F), values(47.0F, 0.02F));
  set<TimeDelay<float>>(p, values(), values(2e-4F, 1e-4F));
  set<Drift<float>>(p, values(-0.1F), values(600.0F, 3600.0F));
  set<UserTable<float>>(p, bump_of_4_newtons(), values(-1e-3F, 8.0e3F, 0.0F, 0.0F, 1e-3F));
  detail::set_the_rest(p, static_cast<const Catalogue<float>*>(nullptr));
  return p;
}

// Encoder counts to samples: velocity and acceleration are differences of the counts.
class CountedMotion {
 public:
  void reset(std::int32_t x) {
    before_ = x;
    step_ = 0;
    ticks_ = 0;
    move(x);
  }

  void move(std::int32_t x) {
    const std::int32_t step = difference(x, before_);
    sample_.time_s = static_cast<float>(ticks_++) * kScales.tick_s;
    sample_.displacement = x;
    sample_.position_m = static_cast<float>(x) * kScales.metres_per_displacement;
    sample_.velocity_mps = static_cast<float>(step) * 1.0e-2F;
    sample_.acceleration_mps2 = static_cast<float>(difference(step, step_)) * 1.0e2F;
    before_ = x;
    step_ = step;
  }

  const Sample<float>& sample() const { return sample_; }

 private:
  Sample<float> sample_;
  std::int32_t before_ = 0;
  std::int32_t step_ = 0;
  std::int32_t ticks_ = 0;
};

}  // namespace slipstack::budget
