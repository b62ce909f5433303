// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <tuple>
#include <utility>

#include "firmware/effects/approx.h"
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
/// Work per tick is fixed: in float by the catalogue, in double by which effects are enabled. State: that of
/// the effects.
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

  /// Takes new parameters: outside the tick. On the controller the hysteresis then starts unloaded: prepare a
  /// second model and carry_over() what this one remembers.
  void prepare(const Parameters& parameters, const Scales<Real>& scales) {
    parameters_ = parameters;
    force_ = {};
    for_each([&](auto& effect, auto& own, auto index) __attribute__((always_inline)) {
      using E = std::remove_reference_t<decltype(effect)>;
      if (!own.enabled) {
        if constexpr (!kEveryEffect) return;
        own.gains = {};
        for (std::size_t i = 0; i < own.shapes.size(); ++i)
          own.shapes[i] = static_cast<Real>(E::shapes[i].lower);
      }
      effect.prepare(std::span<const Real, E::shape_count>(own.shapes), scales);
      if constexpr (Weighted<E, Real>) effect.prepare_weighted(own.gains, std::get<index>(tables_));
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
  [[gnu::noinline]] const Force& step(const Sample<Real>& given) {
    // Member by member, so that the compiler keeps it in registers.
    Sample<Real> sample{.time_s = given.time_s,
                        .displacement = given.displacement,
                        .position_m = given.position_m,
                        .velocity_mps = given.velocity_mps,
                        .acceleration_mps2 = given.acceleration_mps2,
                        .dry_friction_N = Real(0)};
    std::array<Real, effect_count> total_scale{};
    Real dry = Real(0);
    Real plain = Real(0);
    // Dry friction first, since the effects that modulate it want to know it.
    for_each([&](auto& effect, auto& own, auto index) __attribute__((always_inline)) {
      using E = std::remove_reference_t<decltype(effect)>;
      if constexpr (has<E>(Acts::dry)) {
        static_assert(!has<E>(Acts::dry_scale) && !has<E>(Acts::total_scale));
        if (kEveryEffect || own.enabled) {
          const auto sums = evaluate(effect, own, sample, std::get<index>(tables_));
          Real contribution = sum_of<E, Acts::dry>(sums);
          add<index == first_dry()>(dry, contribution);
          if constexpr (has<E>(Acts::force)) {
            add<index == first_plain()>(plain, sum_of<E, Acts::force>(sums));
            contribution += sum_of<E, Acts::force>(sums);
          }
          force_.by_effect_N[index] = contribution;
        }
      }
    });
    sample.dry_friction_N = dry;
    Real total_factor = Real(1);
    Real modulated = dry;
    for_each([&](auto& effect, auto& own, auto index) __attribute__((always_inline)) {
      using E = std::remove_reference_t<decltype(effect)>;
      if constexpr (!has<E>(Acts::dry) && E::gain_count > 0) {
        if (kEveryEffect || own.enabled) {
          const auto sums = evaluate(effect, own, sample, std::get<index>(tables_));
          Real contribution = Real(0);
          if constexpr (has<E>(Acts::dry_scale)) {
            contribution = modulated * sum_of<E, Acts::dry_scale>(sums);
            modulated += contribution;
          }
          if constexpr (has<E>(Acts::force)) {
            const Real force = sum_of<E, Acts::force>(sums);
            add<index == first_plain()>(plain, force);
            contribution = has<E>(Acts::dry_scale) ? contribution + force : force;
          }
          if constexpr (!only_total_scale<E>()) force_.by_effect_N[index] = contribution;
          if constexpr (has<E>(Acts::total_scale)) {
            total_scale[index] = sum_of<E, Acts::total_scale>(sums);
            total_factor *= Real(1) + total_scale[index];
          }
        }
      }
    });
    force_.dry_friction_N = modulated;
    force_.total_N = (modulated + plain) * total_factor;
    share_total_scale(modulated + plain, total_scale);
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
  // The controller evaluates every effect, with zero gains those that are off: a tick costs the same whatever
  // the model, and asks no questions.
  static constexpr bool kEveryEffect = std::is_same_v<Real, float>;

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

  /// Whether the effect's force is known only once the whole force is.
  template <class E>
  static constexpr bool only_total_scale() {
    return has<E>(Acts::total_scale) && !has<E>(Acts::force) && !has<E>(Acts::dry_scale);
  }

  /// The first effect of the catalogue that adds to the dry friction, and to the rest, in the order of
  /// step(): only where every effect is evaluated.
  static constexpr std::size_t first_dry() {
    constexpr std::array<bool, effect_count> kIs{has<Effects>(Acts::dry)...};
    return first_true(kIs);
  }
  static constexpr std::size_t first_plain() {
    constexpr std::array<bool, effect_count> kEarly{
        (has<Effects>(Acts::dry) && has<Effects>(Acts::force))...};
    constexpr std::array<bool, effect_count> kLate{has<Effects>(Acts::force)...};
    return first_true(kEarly) < effect_count ? first_true(kEarly) : first_true(kLate);
  }
  static constexpr std::size_t first_true(const std::array<bool, effect_count>& is) {
    std::size_t i = 0;
    while (i < is.size() && !is[i]) ++i;
    return kEveryEffect ? i : effect_count;
  }

  /// Nothing is added to a zero: it costs an instruction, and the compiler must keep it (0 + -0 is 0).
  template <bool kFirst>
  [[gnu::always_inline]] static void add(Real& sum, Real value) {
    if constexpr (kFirst) {
      sum = value;
    } else {
      sum += value;
    }
  }

  /// Sums of gains times basis by what they act on, indexed by Acts.
  using Sums = std::array<Real, 4>;

  template <class E>
  [[gnu::always_inline]] static Sums evaluate(E& effect, const EffectParameters<E, Real>& own,
                                              const Sample<Real>& sample, const TableOf<E>& table) {
    Sums sums{};
    if constexpr (Weighted<E, Real>) {
      sums[static_cast<std::size_t>(E::gains[0].acts)] = effect.weighted(sample, own.gains, table);
    } else {
      std::array<Real, E::gain_count> basis;
      effect.basis(sample, basis);
      [&]<std::size_t... A>(std::index_sequence<A...>) {
        ((sums[A] = sum_over<E, static_cast<Acts>(A)>(own.gains, basis)), ...);
      }
      (std::make_index_sequence<std::tuple_size_v<Sums>>{});
    }
    return sums;
  }

  template <class E, Acts kActs>
  static Real sum_of(const Sums& sums) {
    static_assert(has<E>(kActs));
    return sums[static_cast<std::size_t>(kActs)];
  }

  /// Gains times basis over the groups that act so, from left to right.
  template <class E, Acts kActs>
  [[gnu::always_inline]] static Real sum_over(const std::array<Real, E::gain_count>& gains,
                                              const std::array<Real, E::gain_count>& basis) {
    Real sum = Real(0);
    bool first = true;
    std::size_t i = 0;
#pragma GCC unroll 4
    for (const GainGroup& group : E::gains) {
      const std::size_t end = i + static_cast<std::size_t>(group.count);
#pragma GCC unroll 16
      for (; i < end; ++i) {
        if (group.acts != kActs) continue;
        sum = first ? gains[i] * basis[i] : approx::multiply_add(gains[i], basis[i], sum);
        first = false;
      }
    }
    return sum;
  }

  /// Credits each total_scale effect with what its factor adds to the force before it.
  [[gnu::always_inline]] void share_total_scale(Real before,
                                                const std::array<Real, effect_count>& total_scale) {
    for_each([&](auto& effect, auto& own, auto index) __attribute__((always_inline)) {
      using E = std::remove_reference_t<decltype(effect)>;
      if constexpr (has<E>(Acts::total_scale)) {
        if (kEveryEffect || own.enabled) {
          const Real added = before * total_scale[index];
          add<only_total_scale<E>()>(force_.by_effect_N[index], added);
          before += added;
        }
      }
    });
  }

  // Inlined before anything else is looked at, so that what the visitor refers to stays in registers.
  template <class F>
  [[gnu::always_inline]] void for_each(F&& visit) {
    [&]<std::size_t... I>(std::index_sequence<I...>) __attribute__((always_inline)) {
      (visit(std::get<I>(effects_), std::get<I>(parameters_), std::integral_constant<std::size_t, I>{}), ...);
    }
    (std::index_sequence_for<Effects...>{});
  }

  // In reach of one base address, the first 1020 bytes: what every effect writes, its state, most gains (a
  // tuple begins with its last element, the hysteresis and its unused stiffnesses come last).
  Force force_;
  std::tuple<Effects...> effects_;
  Parameters parameters_;
  std::tuple<TableOf<Effects>...> tables_;  // last: large
};

}  // namespace slipstack
