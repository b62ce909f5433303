// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/views/catalogue_json.h"

#include <nlohmann/json.hpp>

#include "workbench/base/axis_words.h"
#include "workbench/model/effect_adapters/firmware_effects.h"

namespace slipstack::workbench {

nlohmann::json catalogue_json() {
  nlohmann::json list = nlohmann::json::array();
  for (const EffectDescription& effect : catalogue()) {
    list.push_back({{"id", effect.id()},
                    {"title", effect.text.title},
                    {"formula", effect.text.formula},
                    {"source", effect.text.source},
                    {"residual", effect.text.residual},
                    {"cause", text_of_axis(effect.text.cause)},
                    {"confirm", text_of_axis(effect.text.confirm)},
                    {"plannable", effect.is_plannable()}});
  }
  return list;
}

}  // namespace slipstack::workbench
