// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "workbench/model/effects/effect_catalogue.h"

namespace slipstack::workbench {

/// One effect within a model that is being identified. Where its gains are each log's own, `gains` holds one
/// set after another, in the order of the logs.
struct Term {
  const EffectDescription* effect = nullptr;
  std::vector<double> shapes;
  std::vector<double> gains;
  std::vector<double> lower;  ///< bounds of the gains; equal where the gain is given
  std::vector<double> upper;
  // Standard errors of what the fit chose, zero where it was not free; empty until with_standard_errors().
  std::vector<double> gain_standard_errors;
  std::vector<double> shape_standard_errors;

  std::string id() const { return effect->id(); }
  /// Gains of one set, and how many sets there are.
  std::size_t gains_per_set() const { return static_cast<std::size_t>(effect->gain_count); }
  std::size_t gain_sets() const { return gains.empty() ? 1 : gains.size() / gains_per_set(); }
  /// Zero also before with_standard_errors().
  double gain_standard_error(std::size_t gain) const {
    return gain < gain_standard_errors.size() ? gain_standard_errors[gain] : 0.0;
  }
  double shape_standard_error(std::size_t shape) const {
    return shape < shape_standard_errors.size() ? shape_standard_errors[shape] : 0.0;
  }
};

using Terms = std::vector<Term>;

/// Unknowns (gains) of all terms, in order.
Eigen::Index unknown_count(const Terms& terms);
/// Puts such unknowns into the terms.
void take_gains(Terms& terms, const Eigen::VectorXd& gains);
/// Whether a term modulates what others give, and whether any of them does: the force is then no sum.
bool multiplies(const Term& term);
bool any_multiplies(const Terms& terms);
bool contains(const Terms& terms, std::string_view id);
const Term* find_term(const Terms& terms, std::string_view id);
/// The term of the effect with this role, or nullptr; and whether there is one.
const Term* find_role(const Terms& terms, Role role);
bool has_role(const Terms& terms, Role role);
/// All terms but that of this effect.
Terms without(Terms terms, std::string_view id);
/// Ids of the terms, in order.
std::vector<std::string> ids_of(const Terms& terms);

/// Whether the term is a mass of the axis: its gain times acceleration.
bool is_mass(const Term& term);
/// The mass that the terms give the axis in one of the logs.
double mass_kg(const Terms& terms, std::size_t log = 0);
/// Whether there is an inertia that is fitted, since no log declares the mass.
bool mass_is_free(const Terms& terms);

}  // namespace slipstack::workbench
