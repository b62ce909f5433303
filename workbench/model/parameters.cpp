// SPDX-License-Identifier: Apache-2.0
#include <stdexcept>

#include "firmware/effects/model_hash.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {
namespace {

template <class E>
void take(const Terms& terms, EffectParameters<E, float>& parameters) {
  const Term* term = find_term(terms, E::text.id);
  if (term == nullptr) return;
  parameters.enabled = true;
  // The workbench has more hysteresis elements than the target; those beyond must be zero after the
  // reduction.
  for (std::size_t i = 0; i < parameters.shapes.size(); ++i)
    parameters.shapes[i] = static_cast<float>(term->shapes.at(i));
  for (std::size_t i = 0; i < parameters.gains.size(); ++i)
    parameters.gains[i] = static_cast<float>(term->gains.at(i));
  for (std::size_t i = parameters.gains.size(); i < term->gains.size(); ++i) {
    if (term->gains[i] != 0.0) throw std::logic_error("the model was not reduced to the target's elements");
  }
}

template <class... Effects>
void take_all(const Terms& terms, std::tuple<EffectParameters<Effects, float>...>& all) {
  (take<Effects>(terms, std::get<EffectParameters<Effects, float>>(all)), ...);
}

}  // namespace

TargetParameters target_parameters(const Terms& target_terms) {
  TargetParameters parameters;
  take_all(target_terms, parameters);
  return parameters;
}

std::uint32_t target_hash(const Model& model) {
  return model_hash(target_parameters(model.target_terms));
}

}  // namespace slipstack::workbench
