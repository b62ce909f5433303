// SPDX-License-Identifier: Apache-2.0
#include "workbench/simulate/free_parameters.h"

#include <algorithm>
#include <cmath>

namespace slipstack::workbench {
namespace {

/// Groups of more gains than this are maps, harmonics or the elements of the hysteresis, and get a common
/// factor. Chosen: the largest groups of unlike gains have two, the smallest map has more.
constexpr std::size_t kMostOwnGains = 2;
/// Step of the difference quotient, as a share of the rms force: far above the error of the integration, and
/// so small that the axis sticks and slips at the same places. Chosen.
constexpr double kStep = 1e-3;
/// A factor may change the whole group so much. Chosen.
constexpr double kLeastFactor = 0.2;
constexpr double kLargestFactor = 5.0;

/// Whether a fit moves the gain: neither given nor at its bound.
bool is_free(const Term& term, std::size_t gain) {
  return term.gains[gain] > term.lower[gain] && term.gains[gain] < term.upper[gain];
}

void add_group(const FittedModel& fitted, Eigen::Index column, FreeParameter parameter,
               std::vector<FreeParameter>& all) {
  const Term& term = fitted.terms[parameter.term];
  const double force_N = fitted.linearisation->measured_N().norm();
  for (std::size_t g = parameter.first; g < parameter.first + parameter.count; ++g, ++column) {
    if (!is_free(term, g)) continue;
    if (parameter.count > kMostOwnGains) {
      parameter.lower = kLeastFactor;
      parameter.upper = kLargestFactor;
      parameter.step = kStep;
      all.push_back(parameter);
      return;
    }
    const double per_unit_N = fitted.linearisation->columns().col(column).norm();
    if (per_unit_N == 0.0) continue;
    all.push_back({parameter.term, g, 1, term.lower[g], term.upper[g], kStep * force_N / per_unit_N});
  }
}

}  // namespace

std::vector<FreeParameter> free_parameters(const FittedModel& fitted) {
  std::vector<FreeParameter> all;
  Eigen::Index column = 0;
  for (std::size_t t = 0; t < fitted.terms.size(); ++t) {
    const Term& term = fitted.terms[t];
    std::size_t first = 0;
    for (std::size_t set = 0; set < term.gain_sets() && !term.gains.empty(); ++set) {
      for (const GainGroup& group : term.effect->gain_groups) {
        FreeParameter parameter;
        parameter.term = t;
        parameter.first = first;
        parameter.count = static_cast<std::size_t>(group.count);
        add_group(fitted, column, parameter, all);
        first += parameter.count;
        column += group.count;
      }
    }
  }
  return all;
}

double value_of(const FreeParameter& parameter, const Terms& terms, const Terms& reference) {
  const std::vector<double>& gains = terms[parameter.term].gains;
  if (!parameter.is_factor()) return gains[parameter.first];
  const std::vector<double>& units = reference[parameter.term].gains;
  std::size_t largest = parameter.first;
  for (std::size_t g = parameter.first; g < parameter.first + parameter.count; ++g) {
    if (std::abs(units[g]) > std::abs(units[largest])) largest = g;
  }
  return units[largest] != 0.0 ? gains[largest] / units[largest] : 1.0;
}

void set_value(const FreeParameter& parameter, double value, const Terms& reference, Terms& terms) {
  std::vector<double>& gains = terms[parameter.term].gains;
  value = std::clamp(value, parameter.lower, parameter.upper);
  if (!parameter.is_factor()) {
    gains[parameter.first] = value;
    return;
  }
  for (std::size_t g = parameter.first; g < parameter.first + parameter.count; ++g) {
    gains[g] = value * reference[parameter.term].gains[g];
  }
}

void keep_parts_within(Terms& terms) {
  for (Term& term : terms) {
    const PartOfAnother& part = term.effect->traits.part_of_another;
    const Term* whole = part.gain < 0 ? nullptr : find_role(terms, part.whole);
    if (whole == nullptr || whole->gain_sets() != term.gain_sets()) continue;
    for (std::size_t set = 0; set < term.gain_sets(); ++set) {
      const double most = std::abs(whole->gains[set * whole->gains_per_set()]);
      double& gain = term.gains[set * term.gains_per_set() + static_cast<std::size_t>(part.gain)];
      gain = std::clamp(gain, -most, most);
    }
  }
}

}  // namespace slipstack::workbench
