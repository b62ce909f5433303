// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/reference_model.h"

#include <string>
#include <vector>

#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/estimate/terms/slip_grid.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

/// Whether the effect is a force of a period, over position or over time: no smooth curve describes it.
bool is_periodic(const EffectDescription& effect) {
  return effect.acts_as(Acts::force) &&
         (effect.has_shape(ShapeKind::pitch) || effect.has_shape(ShapeKind::frequency));
}

/// Whether the model has a mode that multiplies the noise of the encoder within the band: one that is true,
/// and below its end.
bool has_mode_within_band(const Measurement& measurement, const Terms& terms) {
  const Term* const mode = find_role(terms, Role::resonance);
  return !has_no_true_mode(terms) && mode->shape(ShapeKind::frequency).value() < measurement.bandwidth_Hz();
}

}  // namespace

FittedModel reference_model(Measurement& measurement) {
  const auto declared = measurement.parts().front().mass_kg;
  const bool weightless = declared && *declared == 0.0;
  std::vector<std::string> effects = default_baseline();
  effects.push_back(effect_with_role(Role::viscous_friction).id());
  if (declared && !weightless) effects.push_back(effect_with_role(Role::added_mass).id());
  FittedModel model = fit_effects(measurement, effects, {});
  if (const Term* hysteresis = find_role(model.terms, Role::hysteresis)) {
    measurement.set_slip_distances(refined_slip_distances(*hysteresis, measurement.encoder_resolution_m()));
    model = fit_effects(measurement, effects, {});
  }
  for (const EffectDescription& effect : catalogue()) {
    const bool of_mass = effect.has_role(Role::resonance);
    if (!is_periodic(effect) || !period_fits(measurement, effect) || (of_mass && weightless)) continue;
    const Trial trial = try_effect(measurement, model, effect, {});
    if (of_mass && !has_mode_within_band(measurement, trial.terms)) continue;
    model = fit_gains(measurement, trial.terms, &model);
  }
  return model;
}

}  // namespace slipstack::workbench
