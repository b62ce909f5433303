// SPDX-License-Identifier: Apache-2.0
// Writes tests/budget/exported_friction.h: the model of friction_model.h, every effect on, as `slipstack
// export` writes it. The image for the emulator cannot make it itself.
//
//   make_exported_friction > FILE
#include <cstdio>

#include "tests/budget/friction_model.h"
#include "workbench/c_export/friction_header.h"
#include "workbench/model/effect_adapters/firmware_effects.h"

namespace {

using namespace slipstack;

template <class E>
workbench::Term term_of(const EffectParameters<E, float>& own) {
  workbench::Term term;
  term.effect = workbench::find_in_catalogue(E::text.id);
  if (term.effect == nullptr) term.effect = &workbench::controller_table();
  // The workbench has more elements of the hysteresis.
  term.gains.assign(static_cast<std::size_t>(term.effect->gain_count), 0.0);
  term.shapes.assign(term.effect->shapes.size(), 0.0);
  for (std::size_t i = 0; i < own.gains.size(); ++i) term.gains[i] = static_cast<double>(own.gains[i]);
  for (std::size_t i = 0; i < own.shapes.size(); ++i) term.shapes[i] = static_cast<double>(own.shapes[i]);
  return term;
}

template <class... Effects>
workbench::Model model_of(const std::tuple<EffectParameters<Effects, float>...>& parameters) {
  workbench::Model model;
  (model.target_terms.push_back(term_of<Effects>(std::get<EffectParameters<Effects, float>>(parameters))),
   ...);
  return model;
}

}  // namespace

int main() {
  workbench::FrictionHeaderOptions options;
  options.name = "exported";
  options.step_m = static_cast<double>(budget::kScales.metres_per_displacement);
  options.rate_Hz = 1.0 / static_cast<double>(budget::kScales.tick_s);
  const std::string header = workbench::friction_header(model_of(budget::all_effects()), options);
  return std::fwrite(header.data(), 1, header.size(), stdout) == header.size() ? 0 : 1;
}
