// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// What an effect is to the other effects, where its basis does not say it. The workbench reads these traits
// instead of comparing names; the controller reads none of them, so they cost it nothing. An effect that is
// like any other states no traits: the defaults below hold.
namespace slipstack {

/// The role of an effect in rules about several effects, such as two that share one mass. At most one
/// effect of the catalogue has each role; most have none.
enum class Role : std::uint8_t {
  none,
  inertia,               ///< force of the moving mass, which a log may declare
  added_mass,            ///< mass beyond the declared one
  hysteresis,            ///< dry friction of elements, each with a stiffness and a slip distance
  saturating_friction,   ///< dry friction without memory: a level, saturated about standstill
  viscous_friction,      ///< proportional to velocity
  friction_memory,       ///< dry friction that follows its dependence on velocity late
  directional_friction,  ///< dry friction that differs between the directions
  resonance,             ///< a mass on a spring that swings against the axis
  constant_force,        ///< whatever the motion
  measurement_delay,     ///< no force of its own: force and motion are recorded at different times
};

/// Another effect that this one becomes in a limit. No log can exclude the more general one; it can show that
/// the axis has no more than the special case.
struct SpecialCase {
  const char* id = "";  ///< of the other effect
  int gains = 0;        ///< so many first gains of this effect show that it is more than that; 0: all of them
};

/// A gain that is a part of the first gain of another effect: at most as large in magnitude, and zero in a
/// model that lacks the other effect.
struct PartOfAnother {
  int gain = -1;
  Role whole = Role::none;
};

/// Values of a shape between which a fitted effect deserves its name.
struct PlausibleShape {
  int shape = -1;
  double lower = 0.0;
  double upper = 0.0;
};

/// What a fitted effect must keep to deserve its name, whatever the log says: physics beside the evidence.
/// The header of the effect gives each figure with its reason; what is zero is not asked for.
struct Plausibility {
  PlausibleShape shape{};
  /// Of the measured force (rms), what it must explain: clocks and gains of a recorder err by less.
  double least_share_of_force = 0.0;
  double least_samples = 0.0;       ///< of a time, in sampling intervals
  double least_share_of_dry = 0.0;  ///< of the dry friction, beside hysteresis
  double most_axis_masses = 0.0;    ///< of its mass, in masses of the part of the axis that does not swing
  /// Of what follows the velocity late: the least and the longest time it may take.
  double least_memory_s = 0.0;
  double most_memory_s = 0.0;
  /// Gain that hardly any axis has below zero: where it is, no mass may explain the same.
  int seldom_negative = -1;
};

/// The smallest force that a recorder can be trusted with, as a share of the measured force (rms): clocks of
/// current and encoder differ by a few per cent of a sample, sensors deviate from linearity by a per mille.
inline constexpr double kRecorderErrs = 1e-3;

struct EffectTraits {
  Role role = Role::none;
  bool in_default_baseline = false;  ///< in the model that is there before anything is known
  bool per_log = false;              ///< differs between logs of one axis: by default each has its own gains
  bool plannable = true;             ///< an experiment can be planned that shows it
  SpecialCase special_case{};
  PartOfAnother part_of_another{};
  int axis_mass_gain = -1;  ///< gain that is the same force as a mass of the axis: zero while that is fitted
  int constant_gain = -1;  ///< gain that is a constant force: zero beside the constant force of the catalogue
  Plausibility plausible{};
};

/// What an effect states about itself, or the defaults.
template <class E>
constexpr EffectTraits traits_of() {
  if constexpr (requires { E::traits; }) {
    return E::traits;
  } else {
    return {};
  }
}

}  // namespace slipstack
