// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "workbench/model/effect_adapters/firmware_effects.h"

namespace slipstack::workbench {

/// One effect within a model that is being identified. Where its gains are fitted for each log separately,
/// `gains` holds one set per log, in the order of the logs.
struct Term {
  const EffectDescription* effect = nullptr;
  std::vector<double> shapes;
  std::vector<double> gains;
  std::vector<double> lower;  ///< bounds of the gains; equal where a gain is given
  std::vector<double> upper;
  // Standard errors of the fitted parameters, zero where a parameter was not free; empty before
  // with_standard_errors().
  std::vector<double> gain_standard_errors;
  std::vector<double> shape_standard_errors;
  /// Of the total of the gains (total_weights()), one for each set of them.
  std::vector<double> total_standard_errors;
  double lag_standard_error_s = 0.0;  ///< of delay and filter together

  std::string id() const { return effect->id(); }
  /// Value of the first shape of this kind.
  std::optional<double> shape(ShapeKind kind) const {
    const auto index = effect->find_shape(kind);
    return index ? std::optional(shapes[*index]) : std::nullopt;
  }
  /// Number of gains in one set, and number of sets.
  std::size_t gains_per_set() const { return static_cast<std::size_t>(effect->gain_count); }
  std::size_t gain_sets() const { return gains.empty() ? 1 : gains.size() / gains_per_set(); }
  /// Zero also before with_standard_errors().
  double gain_standard_error(std::size_t gain) const {
    return gain < gain_standard_errors.size() ? gain_standard_errors[gain] : 0.0;
  }
  double shape_standard_error(std::size_t shape) const {
    return shape < shape_standard_errors.size() ? shape_standard_errors[shape] : 0.0;
  }
  double total_standard_error(std::size_t set) const {
    // Whoever sets gains by hand clears their errors.
    return set < total_standard_errors.size() && !gain_standard_errors.empty() ? total_standard_errors[set]
                                                                               : 0.0;
  }
};

using Terms = std::vector<Term>;

/// Number of unknowns (gains) of all terms.
Eigen::Index unknown_count(const Terms& terms);
/// The gains of all terms, in order; and their setter.
Eigen::VectorXd gains_of(const Terms& terms);
void take_gains(Terms& terms, const Eigen::VectorXd& gains);
/// Whether a term modulates the force of others, and whether any term does. The force is then not linear in
/// all gains at once.
bool multiplies(const Term& term);
bool any_multiplies(const Terms& terms);
bool contains(const Terms& terms, std::string_view id);
const Term* find_term(const Terms& terms, std::string_view id);
/// The term of the effect with this role, or nullptr; and whether there is one.
const Term* find_role(const Terms& terms, Role role);
bool has_role(const Terms& terms, Role role);
/// All terms except that of this effect.
Terms without(Terms terms, std::string_view id);
/// Ids of the terms, in order.
std::vector<std::string> ids_of(const Terms& terms);

/// Whether the term is a mass of the axis: its gain times acceleration.
bool is_mass(const Term& term);
/// The mass of axis and payload in one of the logs.
double mass_kg(const Terms& terms, std::size_t log = 0);
/// The weight of each gain of a set in what they are together, which a log determines better than any of
/// them: the slip distances of a hysteresis, whose total is its level [N]; ones for friction that fades with
/// velocity, whose total is its share at standstill. Empty: the term has no such total.
std::vector<double> total_weights(const Term& term);
/// That total of one set of gains; the term must have one.
double total_of_gains(const Term& term, std::size_t set);
/// Level of a hysteresis: the sum of stiffness times slip distance of its elements [N]; of several logs with
/// levels of their own their mean, or that of one set of gains.
double hysteresis_level_N(const Term& hysteresis);
double hysteresis_level_N(const Term& hysteresis, std::size_t set);
/// Its mean slip distance, each weighted by the level of its element [m]; zero where the level is zero.
double mean_slip_m(const Term& hysteresis);
/// The travel after a reversal in which most of it has developed, four mean slip distances [m]: an element of
/// slip distance D slips again after 2 D (Masing's second rule), most of them by twice that of the mean one.
double presliding_travel_m(const Term& hysteresis);
/// Whether the inertia is fitted, because no log declares the mass.
bool mass_is_free(const Terms& terms);

/// Whether the terms have an implausible mode: of a damping that no structure has (a line in time takes the
/// form of a mode without any), of nearly all of the mass of the axis, or of a mass below zero: what a
/// passive structure adds to the mass at its driving point is positive in every mode (Foster 1924). The
/// parameters of a mode take such values when it fits something else: a delay, or, in slow motion of one
/// frequency, friction of another form.
bool has_no_true_mode(const Terms& terms);

}  // namespace slipstack::workbench
