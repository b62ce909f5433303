// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/control/force/state_estimate.h"
#include "firmware/control/parameters/parameters.h"
#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// Adaptation of the friction's level, along the rail and as a whole, and of the moving mass. The level
/// differs from its nominal 1 because the preload does, with the place and with temperature ([1], [2]); the
/// mass because of the payload. Of the residual r, the force that the model misses,
///
///   r = (true level - level)(x) dry + (true mass - mass) a,   level(x) = whole + part(x),
///
/// part(x) linear between values kCell_m apart. Recursive least squares with a forgetting for each unknown i
/// and without their covariances, so that an update costs the same for any number of values:
///
///   k_i = P_i f_i / (1 + sum_j P_j f_j^2),   value_i += k_i r,   P_i <- P_i (1 - k_i f_i)(1 + w_i T /
///   memory_i),
///
/// f the factors of the unknowns in r, w_i how much of unknown i is seen (1, or the share of the place).
///
/// The residual shows what is missing through the low-pass of third order of the state estimate, so that dry
/// and a go through the same one, as in any identification by least squares, and what has been learned
/// within its lag is made up for (the augmented error, [3]):
///
///   r + F{level(x) dry + mass a} - level F{dry} - mass F{a}.
///
/// [3] Monopoli: Model reference adaptive control with an augmented error signal, IEEE TAC 19(5) 1974.
///
/// In the main loop, from what the ticks leave for it; level() is read in the tick.
///
/// Bounded whatever the input: values stay within their limits, 0 <= P <= Pmax, 0 <= sum k f < 1. The
/// compensator is evaluated on the reference, so that a wrong value is a bounded force and not a feedback:
/// docs/control.md.
class Adaptation {
 public:
  /// Of the level along the rail: values so far apart, and so many that differ. Longer rails have them again.
  static constexpr float kCell_m = 0.016F;
  static constexpr std::size_t kCells = 64;

  /// How one unknown is learned; all zero: it is not.
  struct Learning {
    float growth = 0.0F;  ///< of the variance in a tick
    float first = 0.0F;   ///< variance; more than it comes to by itself: what is not seen yet is learned fast
    float least = 0.0F;   ///< above zero, so that it never stops to learn
    float most = 0.0F;
  };
  /// Constants; made outside the tick.
  struct Bounds {
    float lowest = 1.0F;  ///< level
    float highest = 1.0F;
    float lightest_kg = 0.0F;  ///< of what is added to the mass
    float heaviest_kg = 0.0F;
    float cells_per_count = 0.0F;
    float pass = 1.0F;       ///< of the low-pass that the residual is seen through, in a tick
    float lag_ticks = 0.0F;  ///< of that low-pass
    Learning whole, part, mass;
  };
  /// `dry_N`: the dry friction beyond pre-sliding; `mass_kg` as the model has it.
  static Bounds bounds(const AxisParameters& axis, float dry_N, float mass_kg) {
    Bounds bound;
    set(bound, axis, dry_N, mass_kg);
    return bound;
  }
  /// The same in place: where parameters are prepared a copy would be on the deepest path of the stack.
  static void set(Bounds& bound, const AxisParameters& axis, float dry_N, float mass_kg) {
    // A place as soon as the residual shows it, since it is passed in a moment, but over an eighth of the way
    // at least, or a fast estimate's noise would be learned; the mass over three times as long, or the places
    // would take turns in following what it does there.
    constexpr float kMassInParts = 3.0F;
    bound.pass = StateEstimate::pass(axis.tick_s, axis.observer_bandwidth_rad_per_s);
    bound.lag_ticks = 3.0F * (1.0F - bound.pass) / bound.pass;
    const float lag_s = 3.0F / axis.observer_bandwidth_rad_per_s;
    const float passed_s = 0.125F * kCell_m / axis.velocity_limit_mps;
    const float part_s = lag_s > passed_s ? lag_s : passed_s;
    bound.lowest = axis.level_lowest;
    bound.highest = axis.level_highest;
    bound.cells_per_count = axis.encoder_resolution_m / kCell_m;
    const float typical_N = dry_N > 0.0F ? dry_N : 1.0F;
    const bool level = axis.adapt_level, mass = axis.adapt_mass;
    set(bound.whole, level, axis.tick_s / axis.level_memory_s, typical_N);
    // Not without the mass: a wrong one would be taken for friction where the axis accelerates.
    set(bound.part, level && mass, axis.tick_s / part_s, typical_N);
    set(bound.mass, mass, axis.tick_s / (kMassInParts * part_s), 0.5F * axis.acceleration_limit_mps2);
    bound.lightest_kg = mass ? -0.5F * mass_kg : 0.0F;
    bound.heaviest_kg = mass ? mass_kg : 0.0F;
  }

  /// Another model: nothing is known of what it misses.
  void begin(const Bounds& bound) {
    whole_ = {1.0F, bound.whole.first};
    parts_.fill({0.0F, bound.part.first});
    mass_ = {0.0F, bound.mass.first};
    seen_ = {};
    level_.store(1.0F, std::memory_order_relaxed);
  }

  /// What a tick says: where the reference was, the dry friction of the model at level 1, and the force that
  /// the model misses, not a number where it says nothing.
  struct Said {
    std::int32_t counts;
    float velocity;  ///< counts per tick
    float dry_N;
    float acceleration_mps2;
    float residual_N;
  };
  /// One tick. Learns only when all of it is finite.
  void step(const Bounds& bound, const Said& said) {
    seen_.step(bound.pass, said, level() * said.dry_N + mass_.value * said.acceleration_mps2);
    learn(bound, said, at(bound, said.counts, said.velocity * bound.lag_ticks));
    const float level = level_at(at(bound, said.counts, 0.0F));
    level_.store(approx::clamp(level, bound.lowest, bound.highest), std::memory_order_relaxed);
  }

  /// Brings level and mass within other bounds.
  void limit(const Bounds& bound) {
    level_.store(approx::clamp(level(), bound.lowest, bound.highest), std::memory_order_relaxed);
    mass_.value = approx::clamp(mass_.value, bound.lightest_kg, bound.heaviest_kg);
  }

  /// Where the reference was in the last step.
  float level() const { return level_.load(std::memory_order_relaxed); }
  /// To the mass of the model.
  float added_kg() const { return mass_.value; }
  /// Of the level as a whole.
  float variance_per_N2() const { return whole_.variance; }

 private:
  struct Unknown {
    float value = 0.0F;
    float variance = 0.0F;
  };
  /// Between two values along the rail.
  struct Place {
    Unknown& near;
    Unknown& far;
    float beyond;  ///< near
  };
  /// What the ticks said, through the low-pass of the residual.
  struct Seen {
    using Stages = std::array<float, 3>;
    Stages dry_N{}, acceleration_mps2{}, learned_N{};

    void step(float pass, const Said& said, float learned) {
      step(dry_N, pass, said.dry_N);
      step(acceleration_mps2, pass, said.acceleration_mps2);
      step(learned_N, pass, learned);
    }
    static void step(Stages& stages, float pass, float input) {
      float last = approx::is_finite(input) ? input : 0.0F;
      for (float& stage : stages) {
        last = stage + pass * (last - stage);
        stage = last = approx::is_finite(last) ? last : 0.0F;  // or it would never be finite again
      }
    }
  };

  /// `behind`: so many counts.
  Place at(const Bounds& bound, std::int32_t counts, float behind) {
    const float back = approx::is_finite(behind) ? behind * bound.cells_per_count : 0.0F;
    // Of any velocity: an integer must hold it.
    const float place = approx::clamp(static_cast<float>(counts) * bound.cells_per_count - back, -1e9F, 1e9F);
    const std::int32_t cell = approx::floor_to_int(place);
    return {parts_[static_cast<std::uint32_t>(cell) % kCells],
            parts_[static_cast<std::uint32_t>(cell + 1) % kCells], place - static_cast<float>(cell)};
  }
  float level_at(const Place& place) const {
    return whole_.value + (1.0F - place.beyond) * place.near.value + place.beyond * place.far.value;
  }

  static void set(Learning& learning, bool learns, float growth, float typical) {
    // What the variance comes to by itself where the factor is the typical one.
    const float settled = learns ? growth / (typical * typical) : 0.0F;
    learning.growth = growth;
    learning.first = 5.0F * settled;
    learning.least = 1.0e-3F * settled;
    learning.most = 10.0F * settled;
  }

  void learn(const Bounds& bound, const Said& said, const Place& place) {
    const float dry_N = seen_.dry_N.back(), acceleration_mps2 = seen_.acceleration_mps2.back();
    const float near_N = (1.0F - place.beyond) * dry_N, far_N = place.beyond * dry_N;
    const float seen = whole_.variance * dry_N * dry_N + place.near.variance * near_N * near_N +
                       place.far.variance * far_N * far_N +
                       mass_.variance * acceleration_mps2 * acceleration_mps2;
    const float now_N =
        approx::clamp(level_at(place), bound.lowest, bound.highest) * dry_N + mass_.value * acceleration_mps2;
    const float share = 1.0F / (1.0F + seen);
    const float gain = share * (said.residual_N + seen_.learned_N.back() - now_N);
    // Zero where the sum has overflown.
    if (!approx::is_finite(gain) || !(share > 0.0F)) return;
    const float most = bound.highest - bound.lowest;
    update(whole_, bound.whole, {dry_N, gain, share, 1.0F}, bound.lowest, bound.highest);
    update(place.near, bound.part, {near_N, gain, share, 1.0F - place.beyond}, -most, most);
    update(place.far, bound.part, {far_N, gain, share, place.beyond}, -most, most);
    update(mass_, bound.mass, {acceleration_mps2, gain, share, 1.0F}, bound.lightest_kg, bound.heaviest_kg);
  }

  struct Update {
    float factor;
    float gain;   // of all unknowns
    float share;  // 1 / (1 + sum P f^2)
    float seen;
  };
  static void update(Unknown& unknown, const Learning& learning, const Update& by, float lowest,
                     float highest) {
    const float weighted = unknown.variance * by.factor;
    unknown.value = approx::clamp(unknown.value + weighted * by.gain, lowest, highest);
    const float left = 1.0F - weighted * by.factor * by.share;
    unknown.variance = approx::clamp(unknown.variance * left * (1.0F + by.seen * learning.growth),
                                     learning.least, learning.most);
  }

  Unknown whole_{1.0F, 0.0F};
  Unknown mass_;
  std::array<Unknown, kCells> parts_{};
  Seen seen_;
  std::atomic<float> level_{1.0F};
};

}  // namespace slipstack
