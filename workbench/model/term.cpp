// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/term.h"

#include <algorithm>
#include <numeric>

namespace slipstack::workbench {

Eigen::Index unknown_count(const Terms& terms) {
  Eigen::Index count = 0;
  for (const Term& term : terms) count += static_cast<Eigen::Index>(term.gains.size());
  return count;
}

Eigen::VectorXd gains_of(const Terms& terms) {
  Eigen::VectorXd gains(unknown_count(terms));
  Eigen::Index next = 0;
  for (const Term& term : terms) {
    for (const double gain : term.gains) gains(next++) = gain;
  }
  return gains;
}

void take_gains(Terms& terms, const Eigen::VectorXd& gains) {
  Eigen::Index next = 0;
  for (Term& term : terms) {
    for (double& gain : term.gains) gain = gains(next++);
  }
}

bool multiplies(const Term& term) {
  return term.effect->acts_as(Acts::dry_scale) || term.effect->acts_as(Acts::total_scale);
}

bool any_multiplies(const Terms& terms) {
  return std::any_of(terms.begin(), terms.end(), multiplies);
}

const Term* find_term(const Terms& terms, std::string_view id) {
  for (const Term& term : terms) {
    if (id == term.effect->text.id) return &term;
  }
  return nullptr;
}

bool contains(const Terms& terms, std::string_view id) {
  return find_term(terms, id) != nullptr;
}

const Term* find_role(const Terms& terms, Role role) {
  for (const Term& term : terms) {
    if (term.effect->has_role(role)) return &term;
  }
  return nullptr;
}

bool has_role(const Terms& terms, Role role) {
  return find_role(terms, role) != nullptr;
}

Terms without(Terms terms, std::string_view id) {
  std::erase_if(terms, [&](const Term& term) { return term.id() == id; });
  return terms;
}

bool is_mass(const Term& term) {
  return term.effect->has_role(Role::inertia) || term.effect->has_role(Role::added_mass);
}

double mass_kg(const Terms& terms, std::size_t log) {
  double mass = 0.0;
  for (const Term& term : terms) {
    if (!is_mass(term)) continue;
    mass += term.gains[term.gain_sets() > 1 ? log : 0];
  }
  return mass;
}

std::vector<double> total_weights(const Term& term) {
  if (term.gains.empty()) return {};
  if (term.effect->has_role(Role::hysteresis))
    return {term.shapes.begin(), term.shapes.begin() + term.effect->gain_count};
  if (term.effect->has_shape(ShapeKind::fading_velocity)) return std::vector(term.gains_per_set(), 1.0);
  return {};
}

double total_of_gains(const Term& term, std::size_t set) {
  const std::vector<double> weights = total_weights(term);
  const auto first = term.gains.begin() + static_cast<std::ptrdiff_t>(set * term.gains_per_set());
  return std::inner_product(weights.begin(), weights.end(), first, 0.0);
}

double hysteresis_level_N(const Term& hysteresis) {
  double level_N = 0.0;
  for (std::size_t set = 0; set < hysteresis.gain_sets(); ++set)
    level_N += hysteresis_level_N(hysteresis, set);
  return level_N / static_cast<double>(hysteresis.gain_sets());
}

double hysteresis_level_N(const Term& hysteresis, std::size_t set) {
  return total_of_gains(hysteresis, set);
}

double mean_slip_m(const Term& hysteresis) {
  const double level_N = hysteresis_level_N(hysteresis);
  if (level_N == 0.0) return 0.0;
  double sum_Nm = 0.0;
  for (std::size_t i = 0; i < hysteresis.gains.size(); ++i) {
    const double slip_m = hysteresis.shapes[i % hysteresis.gains_per_set()];
    sum_Nm += hysteresis.gains[i] * slip_m * slip_m;
  }
  return sum_Nm / (level_N * static_cast<double>(hysteresis.gain_sets()));
}

double presliding_travel_m(const Term& hysteresis) {
  return 2.0 * 2.0 * mean_slip_m(hysteresis);
}

bool mass_is_free(const Terms& terms) {
  const Term* inertia = find_role(terms, Role::inertia);
  return inertia != nullptr && inertia->lower[0] < inertia->upper[0];
}

bool has_no_true_mode(const Terms& terms) {
  const Term* mode = find_role(terms, Role::resonance);
  if (mode == nullptr) return false;
  const double moving_kg = mass_kg(terms);
  const EffectTraits& traits = mode->effect->traits;
  const PlausibleShape& damping = traits.plausible.shape;
  const double damping_ratio = mode->shapes[static_cast<std::size_t>(damping.shape)];
  const bool implausibly_damped = damping_ratio < damping.lower || damping_ratio > damping.upper;
  const double rigid_kg = mode->gains[static_cast<std::size_t>(traits.axis_mass_gain)];
  // Where the mass is declared, the mode takes its own from it; where it is fitted, the mode has no rigid
  // part.
  const double axis_kg = mass_is_free(terms) ? moving_kg : moving_kg + std::min(0.0, rigid_kg);
  double modal_kg = mode->gains[0];
  for (std::size_t set = 1; set < mode->gain_sets(); ++set)
    modal_kg = std::min(modal_kg, mode->gains[set * mode->gains_per_set()]);
  return implausibly_damped || modal_kg < 0.0 ||
         std::hypot(mode->gains[0], mode->gains[1]) > traits.plausible.most_axis_masses * axis_kg;
}

std::vector<std::string> ids_of(const Terms& terms) {
  std::vector<std::string> ids;
  for (const Term& term : terms) ids.push_back(term.id());
  return ids;
}

}  // namespace slipstack::workbench
