// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <span>
#include <type_traits>

#include "firmware/effects/traits.h"

// The contract of a physical effect. An effect is one header: what it is called, its formula and where that
// comes from, its parameters with units and bounds, its basis, and what the workbench says about it. The
// firmware sums gains x basis in the tick; the workbench fits the gains to columns made by the same basis().
//
//   force = [ sum(force) + sum(dry) * prod_e(1 + sum(dry_scale of e)) ] * prod_e(1 + sum(total_scale of e))
//
// Gains enter linearly, so bounded least squares finds them; shapes do not, so a bounded search does.
namespace slipstack {

/// What one gain's basis multiplies.
enum class Acts : std::uint8_t {
  force,        ///< basis in N per gain unit, added
  dry,          ///< the same, and counted as dry friction, the level that dry_scale effects modulate
  dry_scale,    ///< dimensionless modulation of the dry friction: preload, velocity weakening, drift
  total_scale,  ///< dimensionless modulation of the whole force: a motor constant that varies
};

/// A run of `count` gains of the same kind.
struct GainGroup {
  const char* name;     ///< as in a model file
  const char* unit;     ///< of the gain, of a linear axis
  float lower;          ///< least value
  float upper;          ///< largest value
  int count;            ///< gains in the group
  Acts acts;            ///< what their basis multiplies
  bool smooth = false;  ///< neighbouring gains describe neighbouring places: a fit may expect a smooth map
};

/// The physical meaning of a shape parameter. From it the workbench derives the range over which a given log
/// can identify the parameter.
enum class ShapeKind : std::uint8_t {
  velocity,
  fading_velocity,  ///< speed over which an effect decays; not identifiable below the slowest speed of a log
  acceleration,
  exponent,
  /// Exponent of a law whose nominal value, the middle of the bounds, is known. It is held at that value
  /// until all other effects are identified, because a missing effect is mistaken for a change of the
  /// exponent.
  nominal_exponent,
  time_constant,
  duration,  ///< time at the end of the log: computed, never searched
  delay,
  filter,  ///< time constant of a low pass in series with a delay; held at 0 until all else is identified
  pitch,
  frequency,
  damping,
  position,
  travel,
  slip_distance,
  lag_distance,  ///< alternative to a time constant: memory that decays with distance
  user_defined,  ///< of a user-defined effect (host only): searched within its bounds or the range of the log
  table,         ///< position of a table: computed, never searched
};

/// A parameter that enters the basis non-linearly, with its physical bounds.
struct ShapeSpec {
  const char* name;  ///< as in a model file
  const char* unit;  ///< of a linear axis
  float lower;       ///< least value
  float upper;       ///< largest value
  ShapeKind kind;    ///< what it means
};

/// What people read about an effect.
struct EffectText {
  const char* id;        ///< as in a model file and on the command line
  const char* title;     ///< its name for people
  const char* formula;   ///< in ASCII
  const char* source;    ///< where the formula comes from
  const char* residual;  ///< what the residual of a model without it looks like
  /// The same as found in a log; {name} is replaced by the fitted value of a shape, a gain, or the amplitude
  /// of a group of gains.
  const char* evidence;
  /// The usual physical cause; as the experiment behind it, one text, or two alternatives between
  /// which " | " stands, of a linear axis and of a rotary one.
  const char* cause;
  const char* confirm;  ///< the experiment that confirms the cause
};

/// Largest magnitude a gain may take: far beyond any axis, small enough that sums stay finite in float.
inline constexpr float kUnbounded = 1.0e12f;

/// Whether Real computes what the controller computes: effects then take the forms that take less work there.
/// That is float, and a scalar that records what float would do (workbench/c_export).
template <class Real>
inline constexpr bool kOnTarget = std::is_same_v<Real, float>;

/// What an effect holds for a table of the controller: nothing where Real reads from no table.
struct NoTable {};
/// Table where Real computes what the controller computes, else NoTable.
template <class Table, class Real>
struct TableFor {
  using type = std::conditional_t<kOnTarget<Real>, Table, NoTable>;  ///< of the two
};

/// How displacement reaches the hysteresis: absolute encoder counts on the target (nothing accumulates, so
/// nothing drifts), metres in the workbench.
template <class Real>
using DisplacementOf = std::conditional_t<std::is_same_v<Real, float>, std::int32_t, Real>;

/// What an effect may know of one tick.
template <class Real>
struct Sample {
  Real time_s{};                        ///< since the axis runs
  DisplacementOf<Real> displacement{};  ///< encoder counts (float) or metres (double)
  Real position_m{};                    ///< on the rail
  Real velocity_mps{};                  ///< along +x
  Real acceleration_mps2{};             ///< along +x
  Real dry_friction_N{};  ///< sum of the `dry` forces of this tick, for effects that modulate it
  /// Of effects over position: 0 while nobody knows where on the rail the axis is. The controller's only.
  Real position_weight{1};
};

/// What an effect needs to turn its shapes into constants of the tick.
template <class Real>
struct Scales {
  Real tick_s{};                    ///< between two samples
  Real metres_per_displacement{1};  ///< encoder resolution on the target, 1 in the workbench
};

template <std::size_t N>
constexpr int total_count(const std::array<GainGroup, N>& groups) {
  int count = 0;
  for (const GainGroup& group : groups) count += group.count;
  return count;
}

/// Whether all gains multiply the same thing.
template <std::size_t N>
constexpr bool act_alike(const std::array<GainGroup, N>& groups) {
  for (const GainGroup& group : groups) {
    if (group.acts != groups[0].acts) return false;
  }
  return N > 0;
}

/// Whether no text was forgotten.
constexpr bool complete(const EffectText& text) {
  return text.id && text.title && text.formula && text.source && text.residual && text.evidence &&
         text.cause && text.confirm;
}

/// Every effect provides these. prepare() runs outside the tick, whenever parameters change; basis() runs in
/// it: bounded, branch-poor, no libm. basis() may advance the effect's own state, once per tick.
template <class E, class Real>
concept Effect = requires(E effect, const E constant, const Sample<Real> sample, const Scales<Real> scales,
                          std::span<const Real, E::shape_count> shapes, std::span<Real, E::gain_count> out) {
  { E::text } -> std::convertible_to<EffectText>;
  { E::gain_count } -> std::convertible_to<int>;
  { E::shape_count } -> std::convertible_to<int>;
  effect.prepare(shapes, scales);
  effect.reset(sample);
  effect.basis(sample, out);
};

/// An effect whose gains all act alike may offer sum(gains x basis) in a form that takes less work than its
/// basis, as where few gains act at once. The model then uses it. It agrees with basis() to rounding, or to
/// the error that its header states (tests/unit/effects/weighted_test.cpp).
template <class E, class Real>
concept Weighted = act_alike(E::gains) &&
    requires(E effect, const Sample<Real> sample, const std::array<Real, E::gain_count> gains) {
  { effect.weighted(sample, gains) } -> std::same_as<Real>;
};

/// An effect over the place along the rail: without a position reference it contributes nothing.
template <class E>
concept OverPosition = E::over_position && act_alike(E::gains);

/// A weighted form with constants that are made of the gains: after prepare(), outside the tick.
template <class E, class Real>
concept PreparesGains = requires(E effect, const std::array<Real, E::gain_count> gains) {
  effect.prepare_weighted(gains);
};

}  // namespace slipstack
