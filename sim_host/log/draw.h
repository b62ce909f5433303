// SPDX-License-Identifier: Apache-2.0
// Random axes, with effects of a strength that is observable in a measurement.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "sim_host/motion/programme.h"
#include "sim_host/plant/axis.h"
#include "sim_host/plant/effects/effect_id.h"
#include "sim_host/rng.h"

namespace slipstack::sim {

enum class Setup { kPickAndPlace, kRandom };
enum class OutsideKind { kLine, kBump, kBacklash, kBurst, kSlip, kRing, kForceFilter };
/// line, bump, backlash, burst, slip, ring, force_filter; none for any other word.
std::optional<OutsideKind> outside_by_name(std::string_view word);

/// A test bench: the axis and its sensors.
struct Bench {
  Axis axis;
  ProgrammeOptions programme;
  double rate_Hz = 2000.0;
};

/// A bench without further effects: inertia and pre-sliding hysteresis only.
///   pick_and_place  [1] set-up 3: 35.45 kg, 1 µm encoder, ±15 N, loops of ±40 µm, two rails, each with a
///                   virgin curve of its own, linear motor. The paper does not give pitch, motor constant or
///                   stroke; ours are a 24 mm pitch, 60 N/A, 0.4 m. Curve lengths and noise vary with the
///                   seed.
///   random          1–60 kg, 1–30 N, 1–50 µm, and so on
Bench draw_bench(Setup setup, std::uint64_t seed);

/// The test programme of a bench, its random parts from the seed.
MotionProgramme draw_programme(const Bench& bench, std::uint64_t seed);

/// The effects that are drawn when none is named: those that a log of the test programme distinguishes.
const std::vector<EffectId>& drawable_effects();

/// `count` different effects of drawable_effects(), at most one of stribeck and frictional_lag.
std::vector<EffectId> draw_effect_ids(std::size_t count, std::uint64_t seed);

/// Adds the effects with random formulas and shapes. Each one's gain is set so that its contribution over the
/// programme has a root mean square of `strength` × the noise floor (force noise, and encoder steps seen
/// through the friction's stiffness); strength 0 draws it between 1.5 and 15, evenly in the logarithm. A gain
/// stays within plausible bounds of such an axis; where that makes the effect too weak, the force noise is
/// lowered. Cost: three short simulations per effect. Effects that may not be chosen (inertia,
/// presliding_hysteresis, outside) throw std::invalid_argument.
void add_effects(Axis& axis, const std::vector<EffectId>& effects, const MotionProgramme& programme,
                 double rate_Hz, double strength, std::uint64_t seed);

/// Adds an effect outside the catalogue, of comparable strength. A ring is drawn from 1 to 4 noise floors
/// where no strength is given, and is less where the whole force makes less; what a force filter takes
/// follows from its cut. Cost of a ring: a simulation.
void add_outside(Axis& axis, OutsideKind kind, const MotionProgramme& programme, double rate_Hz,
                 double strength, std::uint64_t seed);

/// Force noise and encoder steps seen through the pre-sliding stiffness, N.
double noise_floor_N(const Axis& axis);

}  // namespace slipstack::sim
