// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <slipstack/friction.h>

#include <cstdint>

// An axis with a 1 um encoder and a 10 kHz tick, as both examples beside this file run it.
namespace example {

inline constexpr slipstack::Scales<float> kScales{.tick_s = 1e-4F, .metres_per_displacement = 1e-6F};

/// Its effects: those that an axis does not have stay disabled.
inline slipstack::FrictionModel<float>::Parameters parameters() {
  using namespace slipstack;
  FrictionModel<float>::Parameters all;
  std::get<EffectParameters<PreslidingHysteresis<float>, float>>(all) = {
      .gains = {4.1e5F, 5.7e5F, 2.9e5F, 8.3e4F, 1.1e4F},  // N/m
      .shapes = {1e-6F, 2e-6F, 5e-6F, 1.3e-5F, 5.5e-5F},  // m
      .enabled = true};
  std::get<EffectParameters<Viscous<float>, float>>(all) = {.gains = {12.0F}, .shapes = {}, .enabled = true};
  return all;
}

/// Back and forth over 100 um, 2 counts a tick.
class Motion {
 public:
  slipstack::Sample<float> next() {
    constexpr std::int32_t kStep = 2;
    if (counts_ >= 100) direction_ = -1;
    if (counts_ <= 0) direction_ = 1;
    counts_ += kStep * direction_;
    slipstack::Sample<float> sample;
    sample.displacement = counts_;
    sample.position_m = static_cast<float>(counts_) * kScales.metres_per_displacement;
    sample.velocity_mps =
        static_cast<float>(kStep * direction_) * kScales.metres_per_displacement / kScales.tick_s;
    return sample;
  }

 private:
  std::int32_t counts_ = 0;
  std::int32_t direction_ = 1;
};

}  // namespace example
