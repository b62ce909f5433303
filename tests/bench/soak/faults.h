// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "tests/bench/soak/axis.h"

namespace slipstack::soak {

/// What the bus and the master's computer do to the master's frames.
struct BusState {
  double lost = 0.0;  ///< of its frames
  bool held = false;  ///< frames wait, and come at once at the end
  bool no_sync = false;
  bool silent = false;  ///< the master is dead
  bool bus_off = false;
};

/// Faults that begin at random and last for a random time, none, one or several at once.
class Faults {
 public:
  enum Kind : std::uint8_t {
    kEncoderReversed,
    kEncoderStuck,
    kEncoderLosesCounts,
    kEncoderInvalid,
    kEncoderJump,
    kIndexNoise,
    kCurrentInvalid,
    kCurrentFalse,
    kOverCurrent,
    kAmplifierFault,
    kAmplifierNotReady,
    kAmplifierDead,
    kNegativeSwitch,
    kPositiveSwitch,
    kHomeSwitch,
    kTickLate,
    kMainLoopDead,
    kFramesLost,
    kFramesHeld,
    kSyncLost,
    kMasterDead,
    kBusOff,
    kHot,
    kTemperatureWire,
    kLinkLow,
    kLinkDead,
    kLinkHigh,
    kKinds
  };
  static constexpr std::array<const char*, kKinds> kNames = {
      "encoder reversed", "encoder stuck",       "encoder loses counts",
      "encoder invalid",  "encoder jump",        "index noise",
      "current invalid",  "current false",       "over-current",
      "amplifier fault",  "amplifier not ready", "amplifier dead",
      "negative switch",  "positive switch",     "home switch",
      "tick late",        "main loop dead",      "frames lost",
      "frames held",      "SYNC lost",           "master dead",
      "bus-off",          "motor hot",           "temperature wire",
      "link low",         "link dead",           "link high"};

  /// Every `mean_s` seconds one begins.
  Faults(sim::Rng& rng, double mean_s) : rng_(rng), per_tick_(kTick_s / mean_s) {}

  /// In every tick; which kind began, or kKinds.
  Kind step() {
    for (std::size_t i = 0; i < kKinds; ++i) left_[i] = left_[i] > 0 ? left_[i] - 1 : 0;
    broken.jump_counts = 0;
    if (!rng_.chance(per_tick_)) {
      apply();
      return kKinds;
    }
    const auto kind = static_cast<Kind>(rng_.below(kKinds));
    // From a tick to a second; a tick is what many faults of wires are.
    left_[kind] = static_cast<std::int32_t>(rng_.log_uniform(1.0, 1e4));
    ++begun[kind];
    how_ = static_cast<Broken::Switch>(1 + rng_.below(3));
    if (kind == kEncoderJump) {
      broken.jump_counts = static_cast<std::int32_t>(rng_.sign() * rng_.log_uniform(1.0, 3e6));
      left_[kind] = 0;
    }
    apply();
    return kind;
  }

  bool active(Kind kind) const { return left_[kind] > 0; }
  bool encoder_fails() const { return broken.encoder != Broken::Encoder::kWell || broken.jump_counts != 0; }
  bool amplifier_fails() const {
    return broken.amplifier_dead || broken.amplifier_fault || broken.amplifier_not_ready ||
           broken.link_dead() || broken.link_V > kHighest_V;
  }

  Broken broken;
  BusState bus;
  std::array<std::uint32_t, kKinds> begun{};

 private:
  void apply() {
    using Encoder = Broken::Encoder;
    broken.encoder = active(kEncoderInvalid)       ? Encoder::kInvalid
                     : active(kEncoderReversed)    ? Encoder::kReversed
                     : active(kEncoderStuck)       ? Encoder::kStuck
                     : active(kEncoderLosesCounts) ? Encoder::kLosesCounts
                                                   : Encoder::kWell;
    broken.index_noise = active(kIndexNoise) && rng_.chance(0.01);
    broken.current_invalid = active(kCurrentInvalid);
    broken.current_false = active(kCurrentFalse);
    broken.over_current = active(kOverCurrent);
    broken.amplifier_fault = active(kAmplifierFault);
    broken.amplifier_not_ready = active(kAmplifierNotReady);
    broken.amplifier_dead = active(kAmplifierDead);
    keep(broken.negative, kNegativeSwitch);
    keep(broken.positive, kPositiveSwitch);
    keep(broken.home, kHomeSwitch);
    broken.tick_late = active(kTickLate) && rng_.chance(0.1);
    broken.main_loop_dead = active(kMainLoopDead);
    broken.temperature_C = active(kHot) ? kHot_C + 10.0 : 40.0;
    broken.temperature_invalid = active(kTemperatureWire);
    broken.link_V = active(kLinkHigh)   ? kHighest_V + 5.0
                    : active(kLinkDead) ? 2.0
                    : active(kLinkLow)  ? kLowest_V - 4.0
                                        : kLink_V;
    bus.lost = active(kFramesLost) ? 0.2 : 0.0;
    bus.held = active(kFramesHeld);
    bus.no_sync = active(kSyncLost);
    bus.silent = active(kMasterDead);
    bus.bus_off = active(kBusOff);
  }

  // How a switch fails is drawn when it begins to.
  void keep(Broken::Switch& state, Kind kind) {
    if (!active(kind)) {
      state = Broken::Switch::kWell;
    } else if (state == Broken::Switch::kWell) {
      state = how_;
    }
  }

  sim::Rng& rng_;
  double per_tick_;
  std::array<std::int32_t, kKinds> left_{};
  Broken::Switch how_ = Broken::Switch::kOpen;
};

}  // namespace slipstack::soak
