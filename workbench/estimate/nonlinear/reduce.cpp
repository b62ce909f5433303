// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/reduce.h"

#include <algorithm>
#include <cmath>

namespace slipstack::workbench {
namespace {

struct Element {
  double slip_m;
  double stiffness_N_per_m;
  double level_N() const { return slip_m * stiffness_N_per_m; }
};

Element merged(const Element& a, const Element& b) {
  const double stiffness = a.stiffness_N_per_m + b.stiffness_N_per_m;
  return {(a.level_N() + b.level_N()) / stiffness, stiffness};
}

/// Largest change of the virgin curve when two neighbours are merged; it occurs at the merged slip distance.
double cost(const Element& a, const Element& b) {
  const Element one = merged(a, b);
  return b.stiffness_N_per_m * (b.slip_m - one.slip_m);
}

/// Rounds slip distances to whole encoder steps, at least one, preserving the level of each element, and
/// merges elements whose distances are then equal. The target counts in steps; its own rounding would change
/// the level.
std::vector<Element> in_whole_steps(std::vector<Element> elements, double step_m) {
  if (step_m > 0.0) {
    for (Element& element : elements) {
      const double slip_m = step_m * std::max(1.0, std::round(element.slip_m / step_m));
      element = {slip_m, element.level_N() / slip_m};
    }
  }
  std::sort(elements.begin(), elements.end(),
            [](const Element& a, const Element& b) { return a.slip_m < b.slip_m; });
  std::vector<Element> distinct;
  for (const Element& element : elements) {
    if (!distinct.empty() && element.slip_m - distinct.back().slip_m <= 0.5 * step_m) {
      distinct.back().stiffness_N_per_m += element.stiffness_N_per_m;
    } else {
      distinct.push_back(element);
    }
  }
  return distinct;
}

}  // namespace

FittedModel reduce_hysteresis(const Measurement& measurement, const FittedModel& fitted,
                              std::size_t elements) {
  Terms terms = fitted.terms;
  const auto term = std::find_if(terms.begin(), terms.end(),
                                 [](const Term& t) { return t.effect->has_role(Role::hysteresis); });
  if (term == terms.end()) return fitted;
  // Of several logs the mean, since the slip distances are a property of the axis.
  const Term mean = averaged_over_logs(measurement, {*term}).front();
  std::vector<Element> all;
  for (std::size_t i = 0; i < mean.gains.size(); ++i) {
    if (mean.gains[i] > 0.0 && mean.shapes[i] > 0.0) all.push_back({mean.shapes[i], mean.gains[i]});
  }
  all = in_whole_steps(std::move(all), measurement.encoder_resolution_m());
  while (all.size() > elements) {
    std::size_t cheapest = 0;
    for (std::size_t i = 1; i + 1 < all.size(); ++i) {
      if (cost(all[i], all[i + 1]) < cost(all[cheapest], all[cheapest + 1])) cheapest = i;
    }
    all[cheapest] = merged(all[cheapest], all[cheapest + 1]);
    all.erase(all.begin() + static_cast<std::ptrdiff_t>(cheapest) + 1);
  }
  all = in_whole_steps(std::move(all), measurement.encoder_resolution_m());
  for (std::size_t i = 0; i < term->gains.size(); ++i) {
    const std::size_t element = i % term->gains_per_set();
    const bool used = element < all.size();
    term->shapes[element] = used ? all[element].slip_m : 0.0;
    term->gains[i] = used ? all[element].stiffness_N_per_m : 0.0;
    if (!used) term->lower[i] = term->upper[i] = 0.0;
  }
  return fit_gains(measurement, std::move(terms));
}

}  // namespace slipstack::workbench
