// SPDX-License-Identifier: Apache-2.0
// Names of the effects, in the order of the design's catalogue, and one for everything outside it.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace slipstack::sim {

enum class EffectId : std::size_t {
  kInertia,
  kPreslidingHysteresis,
  kCoulomb,
  kViscous,
  kQuadraticDrag,
  kStribeck,
  kFrictionalLag,
  kPositionDependentPreload,
  kAccelerationDependentPreload,
  kDirectionAsymmetry,
  kForceRipple,
  kMotorConstantRipple,
  kOffsetForce,
  kCableChainStiffness,
  kPayloadMass,
  kStructuralResonance,
  kTimeDelay,
  kDrift,
  kOutside,  // everything outside the catalogue
  kCount
};

inline constexpr std::size_t kEffectCount = static_cast<std::size_t>(EffectId::kCount);

inline constexpr std::array<std::string_view, kEffectCount> kEffectNames = {
    "inertia",
    "presliding_hysteresis",
    "coulomb",
    "viscous",
    "quadratic_drag",
    "stribeck",
    "frictional_lag",
    "position_dependent_preload",
    "acceleration_dependent_preload",
    "direction_asymmetry",
    "force_ripple",
    "motor_constant_ripple",
    "offset_force",
    "cable_chain_stiffness",
    "payload_mass",
    "structural_resonance",
    "time_delay",
    "drift",
    "outside",
};

constexpr std::size_t index(EffectId id) {
  return static_cast<std::size_t>(id);
}
constexpr std::string_view name(EffectId id) {
  return kEffectNames[index(id)];
}

/// The effect of that name, or nothing.
constexpr std::optional<EffectId> effect_by_name(std::string_view wanted) {
  for (std::size_t i = 0; i < kEffectCount; ++i) {
    if (kEffectNames[i] == wanted) return static_cast<EffectId>(i);
  }
  return std::nullopt;
}

/// One number per effect; a force in N wherever the name says parts.
using PerEffect = std::array<double, kEffectCount>;

}  // namespace slipstack::sim
