// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/effect_adapters/firmware_effects.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// One shape of an effect that is searched, and the range within which this log can identify it.
struct ShapeRange {
  std::size_t index = 0;  ///< among the effect's shapes
  double lower = 0.0;
  double upper = 0.0;
  bool logarithmic = true;  ///< whether the search moves in the logarithm of the shape
  double first_step = 0.0;  ///< initial step of the search; 0: a fraction of the range
  /// Of a pitch the travel within which it repeats, else 0: its first step moves it by an eighth of a period
  /// at the end of the travel, beyond which another minimum begins.
  double repeats_over_m = 0.0;
  double nominal = 0.0;  ///< of nominal_shapes() only: the value held until all else is identified
};

/// The range of the first shape of this kind, or nullptr where none of the ranges is of it.
const ShapeRange* find_range(const std::vector<ShapeRange>& ranges, const EffectDescription& effect,
                             ShapeKind kind);

/// Whether a pitch of a rotary axis is that of gravity or of an eccentric part: one turn.
bool is_about_one_turn(double pitch_m);

/// Whether the terms have a force over the position that is a line with a bend over less than a turn, or
/// that of one turn: which of both it is, not how much there is of each, is what the log can tell.
bool bends_like_one_turn(const Measurement& measurement, const Terms& terms);

/// Whether a pitch is exactly one turn, as settle_pitch() makes it.
bool is_one_turn(double pitch_m);

/// Makes a pitch that does not fit into the travel of a rotary axis twice one turn exactly, the only one that
/// needs no repetition (searched_shapes()). Harmonics of a ripple that do not fit twice are held at zero, the
/// others freed: over less than a turn gravity has its fundamental alone. No other effect is touched.
void settle_pitch(const Measurement& measurement, Term& term);

/// Whether a search ended at an end of the range with this value, but for rounding.
bool is_at_bound(const ShapeRange& range, double value);

/// `count` values strictly inside the range, evenly spaced in the coordinate of the search.
std::vector<double> spread(const ShapeRange& range, std::size_t count);

/// The middle of a range, in the coordinate of the search.
double middle_of(const ShapeRange& range);

/// Shapes of the effect that the search moves, with the bounds of the catalogue narrowed to what the log can
/// show: no velocity above its fastest, no pitch longer than half its stroke (on a rotary axis that moves
/// over more than half a turn, than one turn; for a force an eighth suffices), no frequency beyond 1.2 times
/// its bandwidth. Grids and maps (slip distances, places) are set by default_shapes() and not searched.
std::vector<ShapeRange> searched_shapes(const Measurement& measurement, const EffectDescription& effect);

/// Whether this log can show the period of the effect: it must fit into the travel twice. True for effects
/// without a period over position.
bool period_fits(const Measurement& measurement, const EffectDescription& effect);

/// Shapes that are held at their nominal value until refine_nominal_shapes() (nonlinear/nominal_shapes.h):
/// exponents at the middle of their bounds, a filter at 0.
std::vector<ShapeRange> nominal_shapes(const Measurement& measurement, const EffectDescription& effect);

/// Values of all shapes with which make_term() builds a term.
std::vector<double> default_shapes(const Measurement& measurement, const EffectDescription& effect);

/// `count` slip distances from shortest to longest, evenly spaced in the logarithm, filled up with zeros to
/// `capacity`.
std::vector<double> slip_distances(double shortest_m, double longest_m, std::size_t count,
                                   std::size_t capacity);

}  // namespace slipstack::workbench
