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
    force_ = {};
    for_each([&](auto& effect, auto& own, auto) {
      using E = std::remove_reference_t<decltype(effect)>;
      if (!own.enabled) return;
      effect.prepare(std::span<const Real, E::shape_count>(own.shapes), scales);
      if constexpr (requires { effect.prepare_weighted(own.gains); }) effect.prepare_weighted(own.gains);
    });
  }

  /// Forgets the motion so far: the hysteresis is virgin at this sample.
  void reset(const Sample<Real>& sample) {
    for_each([&](auto& effect, auto& own, auto) {
      if (own.enabled) effect.reset(sample);
    });
  }

  /// The force for this sample; advances the state of every enabled effect by one tick. The reference is to
  /// the model's own record of it, valid until the next call.
  const Force& step(Sample<Real> sample) {
    Real dry = Real(0);
    Real plain = Real(0);
    // Dry friction first, since the effects that modulate it want to know it.
    for_each([&](auto& effect, auto& own, auto index) {
      using E = std::remove_reference_t<decltype(effect)>;
      if constexpr (has<E>(Acts::dry)) {
        if (own.enabled) {
          const Sums sums = evaluate(effect, own, sample);
          dry += sums.dry;
          if constexpr (has<E>(Acts::force)) plain += sums.force;
          force_.by_effect_N[index] = sums.dry + sums.force;
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
          Real contribution = sums.force;
          if constexpr (has<E>(Acts::dry_scale)) {
            const Real added = modulated * sums.dry_scale;
            modulated += added;
            contribution += added;
          }
          if constexpr (has<E>(Acts::force)) plain += sums.force;
          force_.by_effect_N[index] = contribution;
          if constexpr (has<E>(Acts::total_scale)) {
            total_scale_[index] = sums.total_scale;
            total_factor *= Real(1) + sums.total_scale;
          }
        }
      }
    });
    force_.dry_friction_N = modulated;
    force_.total_N = (modulated + plain) * total_factor;
    share_total_scale(modulated + plain);
    return force_;
  }

  /// The force of the last step.
  const Force& force() const { return force_; }

  /// Takes over from a model of the same axis with other parameters what effects remember of the motion.
  /// Outside the tick; some 300 instructions.
  void carry_over(const FrictionModel& from) {
    [&]<std::size_t... I>(std::index_sequence<I...>) {
      (carry_one(std::get<I>(effects_), std::get<I>(from.effects_)), ...);
    }
    (std::index_sequence_for<Effects...>{});
  }

 private:
  template <class E>
  static void carry_one(E& to, const E& from) {
    if constexpr (requires { to.carry_over(from); }) to.carry_over(from);
  }

  struct Sums {
    Real force{};
    Real dry{};
    Real dry_scale{};
    Real total_scale{};

    void add(Acts acts, Real value) {
      if (acts == Acts::force) force += value;
      if (acts == Acts::dry) dry += value;
      if (acts == Acts::dry_scale) dry_scale += value;
      if (acts == Acts::total_scale) total_scale += value;
    }
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
    Sums sums;
    if constexpr (Weighted<E, Real>) {
      sums.add(E::gains[0].acts, effect.weighted(sample, own.gains));
    } else {
      std::array<Real, E::gain_count> basis;
      effect.basis(sample, basis);
      [&]<std::size_t... G>(std::index_sequence<G...>) {
        (sums.add(E::gains[G].acts, sum_of_group<E, G>(own.gains, basis)), ...);
      }
      (std::make_index_sequence<E::gains.size()>{});
    }
    return sums;
  }

  /// Gains times basis of the effect's group G, from left to right.
  template <class E, std::size_t G>
  static Real sum_of_group(const std::array<Real, E::gain_count>& gains,
                           const std::array<Real, E::gain_count>& basis) {
    constexpr std::size_t kFirst = [] {
      std::size_t first = 0;
      for (std::size_t g = 0; g < G; ++g) first += static_cast<std::size_t>(E::gains[g].count);
      return first;
    }();
    constexpr auto kEnd = kFirst + static_cast<std::size_t>(E::gains[G].count);
    Real sum = gains[kFirst] * basis[kFirst];
#pragma GCC unroll 16
    for (std::size_t i = kFirst + 1; i < kEnd; ++i) sum += gains[i] * basis[i];
    return sum;
  }

  /// Credits each total_scale effect with what its factor adds to the force before it.
  void share_total_scale(Real before) {
    for_each([&](auto& effect, auto& own, auto index) {
      using E = std::remove_reference_t<decltype(effect)>;
      if constexpr (has<E>(Acts::total_scale)) {
        if (own.enabled) {
          const Real added = before * total_scale_[index];
          force_.by_effect_N[index] += added;
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
  Force force_;
  std::array<Real, effect_count> total_scale_{};
};

}  // namespace slipstack
