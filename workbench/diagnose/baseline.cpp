// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/baseline.h"

#include <utility>

#include "workbench/diagnose/evidence/criterion.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

bool moves_no_mass(const Measurement& measurement) {
  const auto declared = measurement.parts().front().mass_kg;
  return declared && *declared == 0.0;
}

}  // namespace

std::vector<std::string> chosen_baseline(const Measurement& measurement) {
  std::vector<std::string> mass;
  if (!moves_no_mass(measurement)) mass.push_back(effect_with_role(Role::inertia).id());
  const auto with = [](std::vector<std::string> effects, Role role) {
    effects.push_back(effect_with_role(role).id());
    return effects;
  };
  const auto fitted = [&](const std::vector<std::string>& effects) {
    return fit_effects(measurement, effects, {});
  };
  const Criterion criterion(measurement, {}, 1);
  std::vector<std::string> chosen = with(mass, Role::saturating_friction);
  FittedModel model = fitted(chosen);
  // Each alternative against what was chosen before it.
  for (std::vector<std::string> other : {with(mass, Role::hysteresis), with(chosen, Role::viscous_friction),
                                         with(with(mass, Role::hysteresis), Role::viscous_friction)}) {
    FittedModel better = fitted(other);
    if (!is_worth_a_name(model.holdout_rmse_N, better.holdout_rmse_N) ||
        !is_supported(criterion.difference(better, model))) {
      continue;
    }
    chosen = std::move(other);
    model = std::move(better);
  }
  return chosen;
}

}  // namespace slipstack::workbench
