// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <tuple>
#include <utility>

#include "firmware/effects/catalogue.h"
#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// Gains and shapes of one effect, and whether the model contains it.
template <class E, class Real>
struct EffectParameters {
  std::array<Real, E::gain_count> gains{};    ///< in the order and the units of E::gains
  std::array<Real, E::shape_count> shapes{};  ///< of E::shapes
  bool enabled = false;                       ///< the model contains the effect
};

/// The force of a set of effects at one tick: the sum that effect.h defines, by effect.
///
/// Work per tick is fixed: in float by the catalogue, in double by which effects are enabled. State: that of
/// the effects.
template <class Real, class EffectList = Catalogue<Real>>
class FrictionModel;

/// FrictionModel of the effects of a tuple.
template <class Real, class... Effects>
class FrictionModel<Real, std::tuple<Effects...>> {
 public:
  static constexpr std::size_t effect_count = sizeof...(Effects);     ///< enabled or not
  using Parameters = std::tuple<EffectParameters<Effects, Real>...>;  ///< of each effect, in that order
  /// Of one tick, positive towards +x.
  struct Force {
    Real total_N{};                                ///< what friction and inertia take
    Real dry_friction_N{};                         ///< after modulation
    std::array<Real, effect_count> by_effect_N{};  ///< in the order of the catalogue; sums to total_N
  };

  /// Takes new parameters: outside the tick. On the controller the hysteresis then starts unloaded: prepare a
  /// second model and carry_over() what this one remembers.
  void prepare(const Parameters& parameters, const Scales<Real>& scales) {
    parameters_ = parameters;
    force_ = {};
    for_each([&](auto& effect, auto& own, auto) {
      using E = std::remove_reference_t<decltype(effect)>;
      if (!own.enabled) {
        if constexpr (!kEveryEffect) return;
        own.gains = {};
        for (std::size_t i = 0; i < own.shapes.size(); ++i)
          own.shapes[i] = static_cast<Real>(E::shapes[i].lower);
      }
      effect.prepare(std::span<const Real, E::shape_count>(own.shapes), scales);
      if constexpr (PreparesGains<E, Real>) effect.prepare_weighted(own.gains);
    });
  }

  /// Forgets the motion so far: the hysteresis is virgin at this sample.
  void reset(const Sample<Real>& sample) {
    for_each([&](auto& effect, auto& own, auto) {
      if (kEveryEffect || own.enabled) effect.reset(sample);
    });
  }

  /// The force for this sample; advances the state of every enabled effect by one tick. The reference is to
  /// the model's own record of it, valid until the next call.
  const Force& step(const Sample<Real>& given) {
    if constexpr (kEveryEffect) refresh(given.time_s);
    return advance(given);
  }

  /// What follows time alone. On the controller outside the tick, again and again; step() does it itself.
  void refresh(Real time_s) {
    for_each([&](auto& effect, auto&, auto) {
      if constexpr (requires { effect.refresh(time_s); }) effect.refresh(time_s);
    });
  }

  /// step() without refresh(): the controller's tick.
  const Force& advance(const Sample<Real>& given) {
    Sample<Real> sample = given;
    sample.dry_friction_N = Real(0);
    Total total;
    // Dry friction first: the effects that modulate it need it, by its sign or by its level.
    for_each([&](auto& effect, auto& own, auto index) __attribute__((always_inline)) {
      using E = std::remove_reference_t<decltype(effect)>;
      if constexpr (has<E>(Acts::dry)) {
        static_assert(!has<E>(Acts::dry_scale) && !has<E>(Acts::total_scale));
        if (kEveryEffect || own.enabled) {
          const Sums sums = evaluate(effect, own, sample);
          total.dry += sums.dry;
          force_.by_effect_N[index] = sums.dry;
          if constexpr (has<E>(Acts::force)) {
            total.force += sums.force;
            force_.by_effect_N[index] += sums.force;
          }
        }
      }
    });
    sample.dry_friction_N = total.dry;
    for_each([&](auto& effect, auto& own, auto index) __attribute__((always_inline)) {
      using E = std::remove_reference_t<decltype(effect)>;
      if constexpr (!has<E>(Acts::dry) && E::gain_count > 0) {
        if (kEveryEffect || own.enabled) {
          const Sums sums = evaluate(effect, own, sample);
          Real added = sums.force;
          if constexpr (has<E>(Acts::force)) total.force += sums.force;
          if constexpr (has<E>(Acts::dry_scale)) {
            const Real modulation = total.dry * sums.dry_scale;
            total.dry += modulation;
            added = has<E>(Acts::force) ? added + modulation : modulation;
          }
          force_.by_effect_N[index] = added;
          if constexpr (has<E>(Acts::total_scale)) total.scale[index] = sums.total_scale;
        }
      }
    });
    force_.dry_friction_N = total.dry;
    force_.total_N = scale_total(total.dry + total.force, total.scale);
    return force_;
  }

  /// Another value of one gain. Outside the tick, which sees the old one or the new one.
  template <class E>
  void set_gain(std::size_t gain, Real value) {
    std::get<EffectParameters<E, Real>>(parameters_).gains[gain] = value;
  }

  /// The force of the last step.
  const Force& force() const { return force_; }

  /// Takes over from a model of the same axis with other parameters what effects remember of the motion.
  /// Outside the tick.
  void carry_over(const FrictionModel& from) {
    [&]<std::size_t... I>(std::index_sequence<I...>) __attribute__((always_inline)) {
      (carry_one(std::get<I>(effects_), std::get<I>(from.effects_)), ...);
    }
    (std::index_sequence_for<Effects...>{});
  }

 private:
  // The controller evaluates every effect, with zero gains those that are disabled: a tick takes the same
  // work whatever the model, and the state of every effect follows the motion.
  static constexpr bool kEveryEffect = std::is_same_v<Real, float>;

  /// Gains times basis of one effect, by what they act on. What an effect does not act on is left out at
  /// compile time: adding zero takes an instruction, since -0 + 0 is not -0.
  struct Sums {
    Real force{};
    Real dry{};
    Real dry_scale{};
    Real total_scale{};

    template <Acts kActs>
    constexpr Real& of() {
      if constexpr (kActs == Acts::force) return force;
      if constexpr (kActs == Acts::dry) return dry;
      if constexpr (kActs == Acts::dry_scale) return dry_scale;
      if constexpr (kActs == Acts::total_scale) return total_scale;
    }
    template <Acts kActs, bool kFirst>
    constexpr void add(Real term) {
      of<kActs>() = kFirst ? term : of<kActs>() + term;
    }
  };

  /// What the effects make together.
  struct Total {
    Real dry{};
    Real force{};
    std::array<Real, effect_count> scale{};
  };

  template <class E>
  static void carry_one(E& to, const E& from) {
    if constexpr (requires { to.carry_over(from); }) to.carry_over(from);
  }

  template <class E>
  static constexpr bool has(Acts acts) {
    for (const GainGroup& group : E::gains) {
      if (group.acts == acts) return true;
    }
    return false;
  }

  /// What each gain of an effect acts on.
  template <class E>
  static constexpr std::array<Acts, E::gain_count> acts_of() {
    std::array<Acts, E::gain_count> acts{};
    std::size_t gain = 0;
    for (const GainGroup& group : E::gains) {
      for (int i = 0; i < group.count; ++i) acts[gain++] = group.acts;
    }
    return acts;
  }

  /// Whether no gain before this one acts on the same.
  template <std::size_t kCount>
  static constexpr bool is_first(const std::array<Acts, kCount>& acts, std::size_t gain) {
    for (std::size_t i = 0; i < gain; ++i) {
      if (acts[i] == acts[gain]) return false;
    }
    return true;
  }

  template <class E>
  [[gnu::always_inline]] static Sums evaluate(E& effect, const EffectParameters<E, Real>& own,
                                              const Sample<Real>& sample) {
    Sums sums;
    if constexpr (Weighted<E, Real>) {
      sums.template of<E::gains[0].acts>() = effect.weighted(sample, own.gains);
    } else {
      std::array<Real, E::gain_count> basis;
      if constexpr (kEveryEffect && requires { effect.refreshed_basis(basis); }) {
        effect.refreshed_basis(basis);
      } else {
        effect.basis(sample, basis);
      }
      static constexpr auto kActs = acts_of<E>();
      [&]<std::size_t... I>(std::index_sequence<I...>) __attribute__((always_inline)) {
        (sums.template add<kActs[I], is_first(kActs, I)>(own.gains[I] * basis[I]), ...);
      }
      (std::make_index_sequence<E::gain_count>{});
    }
    if constexpr (kEveryEffect && OverPosition<E>) {
      sums.template of<E::gains[0].acts>() *= sample.position_weight;
    }
    return sums;
  }

  /// The force times all the factors 1 + scale; each effect is credited with what its factor adds to the
  /// force before it.
  [[gnu::always_inline]] Real scale_total(Real force, const std::array<Real, effect_count>& scale) {
    Real factor = Real(1);
    Real before = force;
    for_each([&](auto& effect, auto& own, auto index) __attribute__((always_inline)) {
      using E = std::remove_reference_t<decltype(effect)>;
      if constexpr (has<E>(Acts::total_scale)) {
        if (kEveryEffect || own.enabled) {
          factor *= Real(1) + scale[index];
          const Real added = before * scale[index];
          force_.by_effect_N[index] += added;
          before += added;
        }
      }
    });
    return force * factor;
  }

  template <class F>
  [[gnu::always_inline]] void for_each(F&& visit) {
    [&]<std::size_t... I>(std::index_sequence<I...>) __attribute__((always_inline)) {
      (visit(std::get<I>(effects_), std::get<I>(parameters_), std::integral_constant<std::size_t, I>{}), ...);
    }
    (std::index_sequence_for<Effects...>{});
  }

  // The gains before the tables of the effects: a single load instruction reaches them (1020 bytes, Armv7E-M
  // VLDR).
  Force force_;
  Parameters parameters_;
  std::tuple<Effects...> effects_;
};

}  // namespace slipstack
