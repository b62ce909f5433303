// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/control/force/rail_least_squares.h"
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
/// part(x) linear between values kCell_m apart. All of them are the least squares estimate with forgetting,
/// with their covariances (rail_least_squares.h): within one pass a wrong mass cannot be told from the level
/// of the places where the axis accelerates, the pass back tells them apart, and corrects what the first one
/// had taken for the other.
///
/// A payload is taken up or put down while the axis rests. Then the error of the next move is at once far
/// above the largest of the two moves before, one each way, or beyond what a level explains; what is known of
/// the mass is given up, and not what is known of the rail, so that the first ramp tells the new mass.
///
/// The residual shows what is missing through the low-pass of third order of the state estimate, so that dry
/// and a go through the same one, as in any identification by least squares, and what has been learned
/// within its lag is made up for (the augmented error, [3]):
///
///   r + F{level(x) dry + mass a} - level F{dry} - mass F{a}.
///
/// [3] Monopoli: Model reference adaptive control with an augmented error signal, IEEE TAC 19(5) 1974.
///
/// In the main loop, from what the ticks leave for it; level() is read in the tick. The estimate is solved
/// for every kTogether ticks: some 60 times kCells instructions.
///
/// Bounded whatever the input: values stay within their limits. The compensator is evaluated on the
/// reference, so that a wrong value is a bounded force and not a feedback: docs/control.md.
class Adaptation {
 public:
  /// Of the level along the rail: values so far apart, and so many that differ. Longer rails have them again.
  static constexpr float kCell_m = 0.008F;
  static constexpr std::size_t kCells = 128;
  /// Ticks that are learned from at once.
  static constexpr int kTogether = 10;
  using LeastSquares = RailLeastSquares<kCells>;

  /// Constants; made outside the tick.
  struct Bounds {
    float lowest = 1.0F;  ///< level
    float highest = 1.0F;
    float lightest_kg = 0.0F;  ///< of what is added to the mass
    float heaviest_kg = 0.0F;
    float cells_per_count = 0.0F;
    float pass = 1.0F;       ///< of the low-pass that the residual is seen through, in a tick
    float lag_ticks = 0.0F;  ///< of that low-pass
    int rest_ticks = 1;      ///< without a measurement, from which on the axis may have got another payload
    bool whole = false;      ///< learned, as the next two
    bool part = false;
    bool mass = false;
    float typical_N = 1.0F;  ///< dry friction whose measurement counts as one
    float typical_mps2 = 1.0F;
    LeastSquares::Priors priors;
  };
  /// `dry_N`: the dry friction beyond pre-sliding; `mass_kg` as the model has it.
  static Bounds bounds(const AxisParameters& axis, float dry_N, float mass_kg) {
    Bounds bound;
    set(bound, axis, dry_N, mass_kg);
    return bound;
  }
  /// The same in place: where parameters are prepared a copy would be on the deepest path of the stack.
  static void set(Bounds& bound, const AxisParameters& axis, float dry_N, float mass_kg) {
    // A place within its second pass, the mass within a few ramps of a move: a payload changes between two
    // moves. Counted in ticks that show them, so that nothing is forgotten while the axis does not show it.
    constexpr float kPartInLags = 4.0F;
    constexpr float kMassInLags = 40.0F;
    // What is common to the rail before what differs along it: one number for what each place would have to
    // learn by itself, the ends of the travel last, which are passed slowly and in part.
    constexpr float kWholeFirst = 0.25F;
    constexpr float kRest_s = 0.02F;
    bound.pass = StateEstimate::pass(axis.tick_s, axis.observer_bandwidth_rad_per_s);
    bound.lag_ticks = 3.0F * (1.0F - bound.pass) / bound.pass;
    bound.rest_ticks = static_cast<int>(kRest_s / axis.tick_s);
    bound.lowest = axis.level_lowest;
    bound.highest = axis.level_highest;
    bound.cells_per_count = axis.encoder_resolution_m / kCell_m;
    bound.typical_N = dry_N > 0.0F ? dry_N : 1.0F;
    bound.typical_mps2 = 0.5F * axis.acceleration_limit_mps2;
    const bool level = axis.adapt_level, mass = axis.adapt_mass;
    bound.whole = level;
    // Not without the mass: a wrong one would be taken for friction where the axis accelerates.
    bound.part = level && mass;
    bound.mass = mass;
    // At least over half of the way between two values, or a fast estimate's noise would be learned.
    const float lag_s = 3.0F / axis.observer_bandwidth_rad_per_s;
    const float passed_s = 0.125F * kCell_m / axis.velocity_limit_mps;
    const float ticks = (lag_s > passed_s ? lag_s : passed_s) / axis.tick_s;
    bound.priors.part = prior(kPartInLags * ticks);
    bound.priors.whole = scaled(bound.priors.part, kWholeFirst);
    bound.priors.whole.forgets = axis.tick_s / axis.level_memory_s;
    // Level and mass may be wrong by about the same share: the less it is in newtons, the better is it known.
    const float to_inertia = bound.typical_N / (mass_kg * bound.typical_mps2);
    bound.priors.mass = scaled(bound.priors.part, approx::clamp(to_inertia * to_inertia, 1.0e-3F, 1.0e3F));
    bound.priors.mass.forgets = 1.0F / (kMassInLags * ticks);
    bound.lightest_kg = mass ? -0.5F * mass_kg : 0.0F;
    bound.heaviest_kg = mass ? mass_kg : 0.0F;
  }

  /// Another model: nothing is known of what it misses.
  void begin(const Bounds& bound) {
    whole_ = 1.0F;
    mass_kg_ = 0.0F;
    parts_.fill(0.0F);
    squares_.begin(bound.priors);
    typical_mps2_ = bound.typical_mps2;
    ticks_ = 0;
    learned_ = false;
    moves_ = {};
    seen_ = {};
    compensate(1.0F);
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
    seen_.step(bound.pass, said, level() * said.dry_N + mass_kg_ * said.acceleration_mps2);
    learn(bound, said, at(bound, said.counts, said.velocity * bound.lag_ticks));
    compensate(approx::clamp(level_at(at(bound, said.counts, 0.0F)), bound.lowest, bound.highest));
  }

  /// Brings level and mass within other bounds.
  void limit(const Bounds& bound) {
    // In other units nothing is known of how they go together.
    if (bound.typical_mps2 != typical_mps2_) squares_.begin(bound.priors);
    typical_mps2_ = bound.typical_mps2;
    compensate(approx::clamp(learned_level_, bound.lowest, bound.highest));
    mass_kg_ = approx::clamp(mass_kg_, bound.lightest_kg, bound.heaviest_kg);
  }

  /// From the next step() or limit() on only this part of the level is in force, 0 to 1. What is learned
  /// stays: it is told from what was in force.
  void lower(float part) { part_ = part; }

  /// In force where the reference was in the last step.
  float level() const { return level_.load(std::memory_order_relaxed); }
  /// To the mass of the model.
  float added_kg() const { return mass_kg_; }

 private:
  /// Between two values along the rail.
  struct Place {
    std::uint32_t cell;
    float beyond;
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

  /// Of an unknown that is forgotten within so many ticks: at first hardly anything is known of it.
  static LeastSquares::Prior prior(float memory_ticks) {
    return {.first = 1.0e-2F * memory_ticks, .least = 1.0e-3F * memory_ticks, .forgets = 1.0F / memory_ticks};
  }
  static LeastSquares::Prior scaled(LeastSquares::Prior prior, float by) {
    prior.first *= by;
    prior.least *= by;
    return prior;
  }

  /// `behind`: so many counts.
  static Place at(const Bounds& bound, std::int32_t counts, float behind) {
    const float back = approx::is_finite(behind) ? behind * bound.cells_per_count : 0.0F;
    // Of any velocity: an integer must hold it.
    const float place = approx::clamp(static_cast<float>(counts) * bound.cells_per_count - back, -1e9F, 1e9F);
    const std::int32_t cell = approx::floor_to_int(place);
    return {static_cast<std::uint32_t>(cell) % std::uint32_t{kCells}, place - static_cast<float>(cell)};
  }
  float level_at(const Place& place) const {
    return whole_ + (1.0F - place.beyond) * parts_[place.cell] +
           place.beyond * parts_[(place.cell + 1) % kCells];
  }

  /// The errors of the moves, to tell one after which something is another.
  struct Moves {
    float largest = 0.0F;  // squares of errors, of this move
    float last = 0.0F;
    float before_last = 0.0F;
    float settling_ticks = 0.0F;
    int rested_ticks = 0;
    bool told = false;

    /// Once in a move: it misses more than three times what the two before missed at most. What it misses
    /// once that has been learned, `settles_ticks` later, is what the next ones are compared with: a payload
    /// that comes and goes surprises each time, what the mass does not explain surprises once.
    bool surprises(float error_N, float by_level_N, float settles_ticks) {
      constexpr float kMany = 3.0F;
      rested_ticks = 0;
      if (settling_ticks > 0.0F) {
        settling_ticks -= 1.0F;
        return false;
      }
      const float square = error_N * error_N;
      if (square > largest) largest = square;
      const float most = last > before_last ? last : before_last;
      const bool known = last > 0.0F && before_last > 0.0F;
      const bool surprise =
          (known && largest > kMany * kMany * most) || approx::absolute(error_N) > by_level_N;
      if (told || !surprise) return false;
      largest = 0.0F;
      settling_ticks = settles_ticks;
      return told = true;
    }
    void rests(int enough_ticks) {
      if (rested_ticks >= enough_ticks || ++rested_ticks < enough_ticks) return;
      settling_ticks = 0.0F;
      told = false;
      if (!(largest > 0.0F)) return;
      before_last = last;
      last = largest;
      largest = 0.0F;
    }
  };

  void learn(const Bounds& bound, const Said& said, const Place& place) {
    const float dry_N = seen_.dry_N.back(), acceleration_mps2 = seen_.acceleration_mps2.back();
    // Of the values as they are: only what the tick reads is kept within the bounds of the level.
    const float now_N = level_at(place) * dry_N + mass_kg_ * acceleration_mps2;
    const float error_N = said.residual_N + seen_.learned_N.back() - now_N;
    const float dry = dry_N / bound.typical_N, acceleration = acceleration_mps2 / bound.typical_mps2;
    // Far beyond what an axis does nothing is learned: its squares would drown all others.
    constexpr float kMost = 1.0e3F;
    if (approx::absolute(dry) < kMost && approx::absolute(acceleration) < kMost &&
        approx::absolute(error_N) < kMost * bound.typical_N) {
      squares_.add(bound.priors, {.whole = bound.whole ? dry : 0.0F,
                                  .part = bound.part ? dry : 0.0F,
                                  .mass = bound.mass ? acceleration : 0.0F,
                                  .cell = place.cell,
                                  .beyond = place.beyond,
                                  .error = error_N});
      learned_ = true;
      constexpr float kLeftOfMass = 0.01F;
      constexpr float kSettlesInLags = 4.0F;
      constexpr float kKnown = 10.0F;  // times what is taken to be known before the first measurement
      // What no level there explains; half of it where the level is known already.
      const bool known = squares_.known(place.cell, place.beyond) > kKnown * bound.priors.part.first;
      const float by_level_N = (known ? 0.5F : 1.0F) * (bound.highest - bound.lowest) * bound.typical_N;
      if (moves_.surprises(error_N, by_level_N, kSettlesInLags * bound.lag_ticks))
        squares_.doubt_mass(kLeftOfMass);
    } else {
      moves_.rests(bound.rest_ticks);
    }
    if (!learned_ || ++ticks_ < kTogether) return;
    ticks_ = 0;
    learned_ = false;
    solve(bound);
  }

  void compensate(float level) {
    learned_level_ = level;
    level_.store(part_ * level, std::memory_order_relaxed);
  }

  void solve(const Bounds& bound) {
    const float most = bound.highest - bound.lowest;
    const LeastSquares::Change change = squares_.solve(
        bound.priors,
        {.whole_least = (bound.lowest - whole_) * bound.typical_N,
         .whole_most = (bound.highest - whole_) * bound.typical_N,
         .mass_least = (bound.lightest_kg - mass_kg_) * bound.typical_mps2,
         .mass_most = (bound.heaviest_kg - mass_kg_) * bound.typical_mps2},
        [&](std::size_t i, float change_N) { add(parts_[i], change_N / bound.typical_N, -most, most); });
    add(whole_, change.whole / bound.typical_N, bound.lowest, bound.highest);
    add(mass_kg_, change.mass / bound.typical_mps2, bound.lightest_kg, bound.heaviest_kg);
  }
  static void add(float& value, float change, float lowest, float highest) {
    if (approx::is_finite(change)) value = approx::clamp(value + change, lowest, highest);
  }

  float whole_ = 1.0F;
  float mass_kg_ = 0.0F;
  std::array<float, kCells> parts_{};
  LeastSquares squares_;
  float typical_mps2_ = 0.0F;  // that it goes by
  Moves moves_;
  int ticks_ = 0;  // since the first one behind the last solve()
  bool learned_ = false;
  Seen seen_;
  float learned_level_ = 1.0F;  // where the reference was
  float part_ = 1.0F;           // of it that is in force
  std::atomic<float> level_{1.0F};
};

}  // namespace slipstack
