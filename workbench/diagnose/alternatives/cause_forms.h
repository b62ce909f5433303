// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

// Causes outside the catalogue that have a form: they are tried, fitted and compared as effects are, so that
// an effect is named only where none of them describes the force better. No controller can compensate them.

enum class CauseForm : std::uint8_t {
  line_in_time,      ///< F = c cos(2 pi f t) + s sin(2 pi f t), a phase of its own in each log
  change_at_a_time,  ///< from one time to another or to the end, dry friction times 1 + level, another offset
  load_from_a_time,  ///< from one time to another or to the end, another mass
  /// F = (push + slope sin(pi u)) w, dry friction times 1 + level w, w = (1 + cos(pi u)) / 2 for |u| < 1,
  /// u = (x - x0) / half width
  force_at_a_place,
  force_over_time,  ///< a linear spline of the time
  gap_in_drive,     ///< backlash: F = carriage mass x GapInDrive (gap.h)
  /// F = d dz/dt, dz/dt = v / slip distance (1 - z sgn v): what friction adds by the velocity of its
  /// deflection z while it has not developed (sigma1 of LuGre: Canudas de Wit et al. 1995, equations 1 to 3)
  damped_deflection,
  /// F = level z, the deflection z as above: the friction of a bristle (Dahl 1968; Canudas de Wit et al.
  /// 1995; Bouc and Wen alike), which forgets a turning point as soon as the axis has turned back, so that
  /// small loops do not close. That of stop operators remembers it until it is passed again.
  bristle,
  /// F = side c(t) + load / deceleration e(t) for t < window: c and e linear splines of the time since the
  /// load of the drive changed its sign (LoadReversals)
  after_load_reversals,
  /// F = sum_h A_h cos(2 pi h x / p) + B_h sin(2 pi h x / p), h = 1, 2, beside a ripple of another pitch: a
  /// controller has one
  second_ripple,
  /// Dry friction times 1 + sum_h A_h cos(2 pi h x / p) + B_h sin(2 pi h x / p), h = 1, 2, with a pitch that
  /// the map over the position does not resolve
  friction_ripple,
  /// F = sum_k J_k (b_k(x) a + b_k'(x) v^2 / 2), b_k = cos(k pi u), u from 0 to 1 over the travel, k = 1 to
  /// 4: the mass that a link or a crank shows depends on where it is (Lagrange)
  mass_over_position,
  /// F = (c u + sum_k e_k (1 - exp(-k u)) / (1 - exp(-k))) v, k = 3 and 9, u from 0 to 1 over the rows: the
  /// lubricant warms, at any rate that the log shows
  viscous_over_time,
  /// F = c sgn(v) |v / v0|^p, v0 the largest speed, p below 1, beside viscous friction: a lubricant that
  /// thins with the rate of shear (Ostwald and de Waele; Carreau's law between its ends)
  power_of_velocity,
};

/// The largest half width of a place, as a share of the travel: a fifth of the rail spans several values of
/// the maps over the position, and what is wider is a map.
inline constexpr double kWidestPlace = 0.1;
/// Intervals between the knots of a free curve over a coordinate: four in the half width of the widest place,
/// so that what no map and no place describes shows in the curve.
inline constexpr int kCurveIntervals = static_cast<int>(4.0 / kWidestPlace);

/// Knots of the force after a load reversal: a blow rings for two or three periods.
inline constexpr int kKnotsAfterReversal = 8;
/// The exponents of lubricants that thin in shear (Carreau's law over two decades of the rate of shear):
/// below it the force is dry friction, above it viscous friction.
inline constexpr double kLeastExponent = 0.2;
inline constexpr double kMostExponent = 0.9;
/// Harmonics of a mass that depends on the place. Chosen: those of a crank or of two links fall off fast.
inline constexpr int kMassHarmonics = 4;
/// The longest time after a reversal within which play shows: a play of tens of micrometres is crossed within
/// tens of milliseconds, a drive that resonates above 10 Hz has rung for two periods, and the filter of the
/// rows spreads it by a period of the bandwidth. What lasts longer is no blow.
double longest_blow_s(const Measurement& measurement);

/// Those that this measurement can show beside `terms`; time that several logs do not share is no coordinate.
std::vector<const EffectDescription*> causes_to_try(const Measurement& measurement, const Terms& terms);

bool is_outside_catalogue(const EffectDescription& effect);

/// The form of an effect for which is_outside_catalogue() holds; and the cause of a form.
CauseForm form_of(const EffectDescription& cause);
const EffectDescription& cause_of(CauseForm form);
/// The term of the cause of this form, or nullptr.
const Term* find_cause(const Terms& terms, CauseForm form);
/// Whether the cause is a further part of what the effect describes, beside which alone it is tried: a second
/// ripple beside a first, a power of the velocity beside viscous friction. It takes no name from the effect.
bool supplements(const EffectDescription& cause, const EffectDescription& effect);
/// Whether the terms have a cause without the effect that it supplements.
bool lacks_supplemented(const Terms& terms);
/// Whether the shapes of the cause are found by fits of the model with it, not from the residual.
bool is_fitted_jointly(const EffectDescription& cause);
/// Whether its shapes are searched as those of effects are, and not by shapes_of_cause().
bool is_searched_as_effect(const EffectDescription& cause);

/// The basis of a force at one place, for a position in half widths from its middle: two forces, and a factor
/// of the dry friction.
std::array<double, 3> place_basis(double from_middle);

}  // namespace slipstack::workbench
