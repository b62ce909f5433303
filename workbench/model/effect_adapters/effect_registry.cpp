// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/effect_adapters/effect_registry.h"

#include <fmt/format.h>

#include <algorithm>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/model/effect_adapters/user_effect.h"

namespace slipstack::workbench {

const std::vector<std::string>& default_baseline() {
  static const std::vector<std::string> ids = [] {
    std::vector<std::string> found;
    for (const EffectDescription& description : catalogue()) {
      if (description.traits.in_default_baseline) found.push_back(description.id());
    }
    return found;
  }();
  return ids;
}

std::string default_baseline_list() {
  return fmt::format("{}", fmt::join(default_baseline(), ","));
}

const EffectDescription* find_effect(std::string_view id) {
  const EffectDescription* effect = find_in_catalogue(id);
  return effect != nullptr ? effect : find_user_effect(id);
}

const EffectDescription& effect_named(std::string_view id) {
  const EffectDescription* effect = find_effect(id);
  if (effect == nullptr) {
    throw UsageError(fmt::format("unknown effect {}; known: {}", in_quotes(id), known_effects()));
  }
  return *effect;
}

std::string known_effects() {
  std::string list;
  for (const EffectDescription& description : catalogue()) {
    list += (list.empty() ? "" : ", ") + description.id();
  }
  return list;
}

std::vector<std::string> parse_effects(const std::string& list) {
  std::vector<std::string> ids;
  for (const std::string_view field : split_fields(list)) {
    const std::string id = effect_named(field).id();
    if (std::find(ids.begin(), ids.end(), id) != ids.end()) {
      throw UsageError(fmt::format("effect '{}' is named twice; name it once", id));
    }
    ids.push_back(id);
  }
  return ids;
}

std::vector<const EffectDescription*> declare_effects(const std::vector<std::string>& definitions) {
  std::vector<const EffectDescription*> effects;
  for (const std::string& text : definitions) {
    if (!is_definition(text)) {
      throw UsageError(
          fmt::format("--effect: {} defines no effect; write 'name = expression; parameter: unit; ...'",
                      in_quotes(text)));
    }
    const EffectDescription* effect = &declare_effect(text);
    if (std::find(effects.begin(), effects.end(), effect) != effects.end()) {
      throw UsageError(fmt::format("effect '{}' is given twice; give it once", effect->id()));
    }
    effects.push_back(effect);
  }
  return effects;
}

}  // namespace slipstack::workbench
