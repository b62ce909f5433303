// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <tuple>
#include <utility>

#include "firmware/effects/catalogue.h"

namespace slipstack {

/// Gains and shapes of one effect, and whether the model contains it.
template <class E, class Real>
struct EffectParameters {
  std::array<Real, E::gain_count> gains{};
  std::array<Real, E::shape_count> shapes{};
  bool enabled = false;
};

/// The force of a set of effects at one tick: the sum that effect.h defines, by effect.
///
/// Work per tick is fixed by which effects are enabled, never by the motion. State: that of the effects.
template <class Real, class EffectList = Catalogue<Real>>
class FrictionModel;

template <class Real, class... Effects>
class FrictionModel<Real, std::tuple<Effects...>> {
 public:
  static constexpr std::size_t effect_count = sizeof...(Effects);
  using Parameters = std::tuple<EffectParameters<Effects, Real>...>;

  struct Force {
    Real total_N{};
    Real dry_friction_N{};                         ///< after modulation
    std::array<Real, effect_count> by_effect_N{};  ///< in the order of the catalogue; sums to total_N
  };

  /// Takes new parameters: outside the tick. State is kept where the effect itself keeps it.
  void prepare(const Parameters& parameters, const Scales<Real>& scales) {
    parameters_ = parameters;
    for_each([&](auto& effect, auto& own, auto) {
      using E = std::remove_reference_t<decltype(effect)>;
      if (own.enabled) effect.prepare(std::span<const Real, E::shape_count>(own.shapes), scales);
    });
  }

  /// Forgets the motion so far: the hysteresis is virgin at this sample.
  void reset(const Sample<Real>& sample) {
    for_each([&](auto& effect, auto& own, auto) {
      if (own.enabled) effect.reset(sample);
    });
  }

  /// The force for this sample; advances the state of every enabled effect by one tick.
  Force step(Sample<Real> sample) {
    Force force;
    Real dry = Real(0);
    Real plain = Real(0);
    // Dry friction first, since the effects that modulate it want to know it.
    for_each([&](auto& effect, auto& own, auto index) {
      using E = std::remove_reference_t<decltype(effect)>;
      if constexpr (has<E>(Acts::dry)) {
        if (own.enabled) {
          const Sums sums = evaluate(effect, own, sample);
          dry += sums.dry;
          plain += sums.force;
          force.by_effect_N[index] = sums.dry + sums.force;
        }
      }
    });
    sample.dry_friction_N = dry;
    Real total_factor = Real(1);
    Real modulated = dry;
    for_each([&](auto& effect, auto& own, auto index) {
      using E = std::remove_reference_t<decltype(effect)>;
      if constexpr (!has<E>(Acts::dry) && E::gain_count > 0) {
        if (own.enabled) {
          const Sums sums = evaluate(effect, own, sample);
          const Real added = modulated * sums.dry_scale;
          modulated += added;
          plain += sums.force;
          force.by_effect_N[index] = added + sums.force;
          total_scale_[index] = sums.total_scale;
          total_factor *= Real(1) + sums.total_scale;
        }
      }
    });
    force.dry_friction_N = modulated;
    force.total_N = (modulated + plain) * total_factor;
    share_total_scale(force, modulated + plain);
    return force;
  }

 private:
  struct Sums {
    Real force{};
    Real dry{};
    Real dry_scale{};
    Real total_scale{};
  };

  template <class E>
  static constexpr bool has(Acts acts) {
    for (const GainGroup& group : E::gains) {
      if (group.acts == acts) return true;
    }
    return false;
  }

  template <class E>
  static Sums evaluate(E& effect, const EffectParameters<E, Real>& own, const Sample<Real>& sample) {
    std::array<Real, E::gain_count> basis{};
    effect.basis(sample, basis);
    Sums sums;
    std::size_t gain = 0;
    for (const GainGroup& group : E::gains) {
      Real sum = Real(0);
      for (int i = 0; i < group.count; ++i, ++gain) sum += own.gains[gain] * basis[gain];
      if (group.acts == Acts::force) sums.force += sum;
      if (group.acts == Acts::dry) sums.dry += sum;
      if (group.acts == Acts::dry_scale) sums.dry_scale += sum;
      if (group.acts == Acts::total_scale) sums.total_scale += sum;
    }
    return sums;
  }

  /// Credits each total_scale effect with what its factor adds to the force before it.
  void share_total_scale(Force& force, Real before) {
    for_each([&](auto& effect, auto& own, auto index) {
      using E = std::remove_reference_t<decltype(effect)>;
      if constexpr (has<E>(Acts::total_scale)) {
        if (own.enabled) {
          const Real added = before * total_scale_[index];
          force.by_effect_N[index] += added;
          before += added;
        }
      }
    });
  }

  template <class F>
  void for_each(F&& visit) {
    [&]<std::size_t... I>(std::index_sequence<I...>) {
      (visit(std::get<I>(effects_), std::get<I>(parameters_), std::integral_constant<std::size_t, I>{}), ...);
    }
    (std::index_sequence_for<Effects...>{});
  }

  std::tuple<Effects...> effects_;
  Parameters parameters_;
  std::array<Real, effect_count> total_scale_{};
};

}  // namespace slipstack
