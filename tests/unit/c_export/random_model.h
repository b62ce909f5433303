// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string_view>
#include <vector>

#include "firmware/effects/catalogue.h"
#include "tests/unit/draw.h"
#include "tests/unit/effects/effect_support.h"
#include "workbench/model/effect_adapters/firmware_effects.h"
#include "workbench/model/model.h"

namespace slipstack::test {

/// A term of this effect with random parameters within its bounds, exact in float.
template <class E>
workbench::Term random_term(Draw& draw) {
  workbench::Term term;
  term.effect = workbench::find_in_catalogue(E::text.id);
  if (term.effect == nullptr) term.effect = &workbench::controller_table();
  const auto shapes = random_shapes<E>(draw);
  term.shapes.assign(shapes.begin(), shapes.end());
  for (const GainGroup& group : E::gains) {
    const bool is_stiffness = std::string_view(group.unit) == "N/m" && group.count > 1;
    for (int i = 0; i < group.count; ++i) {
      double gain = is_stiffness ? draw.log_uniform(1e3, 1e6) : draw.uniform(0.02, 0.3);
      if (group.lower < 0.0F) gain *= draw.sign();
      term.gains.push_back(static_cast<double>(static_cast<float>(gain)));
    }
  }
  // What a reduction leaves to the controller.
  if constexpr (requires { E::traits; }) {
    if (E::traits.role == Role::hysteresis) {
      std::fill(term.gains.begin() + kTargetElements, term.gains.end(), 0.0);
      std::fill(term.shapes.begin() + kTargetElements, term.shapes.end(), 0.0);
    }
  }
  return term;
}

/// Terms of the effects that `wanted` returns true for.
template <class Wanted>
workbench::Model random_model(Draw& draw, Wanted wanted) {
  workbench::Model model;
  for_each_effect<double>([&]<class E>(std::type_identity<E>) {
    workbench::Term term = random_term<E>(draw);
    if (wanted(E::text)) model.target_terms.push_back(std::move(term));
  });
  return model;
}

/// The same parameters for the firmware's model in float or double.
template <class Real>
typename FrictionModel<Real>::Parameters parameters_of(const workbench::Model& model) {
  typename FrictionModel<Real>::Parameters parameters;
  for_each_effect<Real>([&]<class E>(std::type_identity<E>) {
    const workbench::Term* const term = workbench::find_term(model.target_terms, E::text.id);
    if (term == nullptr) return;
    auto& own = std::get<EffectParameters<E, Real>>(parameters);
    own.enabled = true;
    for (std::size_t i = 0; i < own.shapes.size(); ++i) own.shapes[i] = static_cast<Real>(term->shapes[i]);
    for (std::size_t i = 0; i < own.gains.size(); ++i) own.gains[i] = static_cast<Real>(term->gains[i]);
  });
  return parameters;
}

}  // namespace slipstack::test
