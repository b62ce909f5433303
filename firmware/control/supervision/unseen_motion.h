// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/parameters/parameters.h"
#include "firmware/control/tick_history.h"
#include "firmware/effects/numerics/approx.h"
#include "firmware/friction/displacement.h"

namespace slipstack {

/// Finds an encoder that stands still while the axis cannot. As long as the counts stay within one count of
/// where they last moved, an axis of the model's mass and with a little more than its friction is moved by
/// what the current has changed since then:
///
///   v' = (I - I_then) Kt / m, less the friction;   x' = v
///
/// When that would have gone a given way, the encoder is not to be believed. The motor has then done at most
/// largest force times that way of work, and what it does below that friction, whatever the mass is.
///
/// Not taken for it: an axis that presses against a stop, since a stop gives way and the counts move while
/// the force rises (only where two counts of it are more than the friction, and the force rises from below
/// that, nothing tells one from the other); one that is slow, or has more friction than the model, since a
/// guideway is elastic before it slips, by many counts.
class UnseenMotion {
 public:
  /// Constants of the tick; made outside it.
  struct Settings {
    float counts_per_A = 0.0F;  ///< per tick^2: what a current does to the free axis
    float friction = 0.0F;      ///< counts per tick^2
    float pressed = 0.0F;       ///< the same where the axis pressed against something when it moved last
    float friction_A = 0.0F;    ///< the current that makes good for the friction
    float most_counts = 1.0e30F;
  };

  /// A quarter more friction than that of the model, and a hundredth of the peak; without dry friction in the
  /// model, the current that the check of the direction may need. At least eight counts of way, so that a
  /// coarse encoder has seen the motion begin.
  static Settings settings(const AxisParameters& axis, const ModelParameters& model) {
    Settings settings;
    if (!(axis.unseen_motion_m > 0.0F)) return settings;
    constexpr float kFewest = 8.0F;
    // Of steel on steel, or a clamp: a column of 10 cm2 and 1 m has 210 N/um, with its joints a tenth.
    constexpr float kStop_N_per_m = 2.0e7F;
    const float counts = axis.unseen_motion_m / axis.encoder_resolution_m;
    settings.most_counts = counts > kFewest ? counts : kFewest;
    const float per_A = 1.0F / axis.motor_constant_N_per_A;
    const float per_mps2 = axis.tick_s * axis.tick_s / axis.encoder_resolution_m;
    settings.counts_per_A = axis.motor_constant_N_per_A / mass_kg(model) * per_mps2;
    const float dry_A = dry_friction_N(model) * per_A;
    settings.friction_A = dry_A > 0.0F ? 1.25F * dry_A + 0.01F * axis.current_limit_A : axis.check_current_A;
    const float stop_A = 2.0F * axis.encoder_resolution_m * kStop_N_per_m * per_A;
    settings.friction = settings.friction_A * settings.counts_per_A;
    settings.pressed = (settings.friction_A + stop_A) * settings.counts_per_A;
    return settings;
  }

  /// In every pass of the main loop, over the ticks since the last one: true once the encoder has missed such
  /// a motion; then it begins anew. `now()`: the tick now; `free`: current may move the axis.
  template <class Now>
  bool follow(const Settings& settings, const TickHistory& history, Now&& now, bool free) {
    bool found = false;
    history.follow(seen_, now(), now, [&](const TickHistory::Entry& tick, std::uint32_t missed) {
      found |= step(settings, tick.reading, free && missed == 0);
    });
    return found;
  }

 private:
  bool step(const Settings& settings, const TickHistory::Reading& now, bool free) {
    const std::int32_t step = difference(now.counts, last_counts_);
    last_counts_ = now.counts;
    if (still_ < kLongStill) ++still_;
    const std::int32_t moved = difference(now.counts, counts_);
    if (moved <= 1 && moved >= -1 && free) return goes_unseen(settings, now.counts, now.current_A);
    // A count after some ticks without is a fraction of one per tick: a coarse encoder at rest is not fast.
    begin(now.counts, static_cast<float>(moved) / static_cast<float>(still_),
          step > 1 || step < -1 ? 0.0F : now.current_A);
    return false;
  }

  // One that stops dead has been moving, and whatever moved it still does: nothing of it is held.
  void begin(std::int32_t counts, float velocity, float held_A) {
    counts_ = counts;
    velocity_ = velocity;
    still_ = 0;
    way_ = 0.0F;
    held_A_ = held_A;
  }

  // Whether the free axis would have gone further than may go unseen.
  bool goes_unseen(const Settings& settings, std::int32_t counts, float current_A) {
    // What pushes back against nothing any more holds nothing.
    if (held_A_ * current_A < 0.0F) held_A_ = 0.0F;
    const float change_A = current_A - held_A_;
    // Less force than before is no drive against it.
    const float driving_A = change_A * current_A > 0.0F ? change_A : 0.0F;
    const float velocity = velocity_ + settings.counts_per_A * driving_A;
    const bool pressed = approx::absolute(held_A_) > settings.friction_A;
    const float slowed = approx::absolute(velocity) - (pressed ? settings.pressed : settings.friction);
    velocity_ = slowed > 0.0F ? (velocity > 0.0F ? slowed : -slowed) : 0.0F;
    way_ += velocity_;
    if (approx::absolute(way_) <= settings.most_counts) return false;
    begin(counts, 0.0F, current_A);
    return true;
  }

  static constexpr std::int32_t kLongStill = 1 << 20;

  std::uint32_t seen_ = 0;  // the last tick that was followed
  std::int32_t last_counts_ = 0;
  std::int32_t counts_ = 0;  // where they moved last
  std::int32_t still_ = 0;   // ticks since
  float held_A_ = 0.0F;      // what held the axis there
  float velocity_ = 0.0F;    // counts per tick
  float way_ = 0.0F;
};

}  // namespace slipstack
