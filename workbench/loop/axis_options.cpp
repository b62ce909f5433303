// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/axis_options.h"

#include <fmt/format.h>

#include "workbench/base/text.h"
#include "workbench/console/output.h"

namespace slipstack::workbench {

std::vector<sim::EffectId> effects_of(const std::string& list) {
  std::vector<sim::EffectId> ids;
  if (list == "none") return ids;
  for (const std::string_view field : split_fields(list)) {
    const auto id = sim::effect_by_name(field);
    if (!id || *id == sim::EffectId::kInertia || *id == sim::EffectId::kPreslidingHysteresis ||
        *id == sim::EffectId::kOutside) {
      throw UsageError(
          fmt::format("--effects: {} is no effect that an axis can be given; see `slipstack-sim effects`",
                      in_quotes(field)));
    }
    ids.push_back(*id);
  }
  return ids;
}

std::vector<sim::EffectId> effects_by_seed(const std::string& list, std::uint64_t seed) {
  return list == "random" ? sim::draw_effect_ids(1, seed) : effects_of(list);
}

std::string names_of(const std::vector<sim::EffectId>& effects) {
  std::vector<std::string> names;
  names.reserve(effects.size());
  for (const sim::EffectId effect : effects) names.emplace_back(sim::name(effect));
  return names.empty() ? "none" : joined(names);
}

sim::Setup setup_named(const std::string& name) {
  if (name == "pick_and_place") return sim::Setup::kPickAndPlace;
  if (name == "random") return sim::Setup::kRandom;
  throw UsageError(fmt::format("--setup: {} is neither pick_and_place nor random", in_quotes(name)));
}

std::uint64_t seed_of(std::int64_t seed) {
  if (seed < 0) throw UsageError("--seed: must not be negative");
  return static_cast<std::uint64_t>(seed);
}

void check_strength(double strength) {
  if (!(strength >= 0.0 && strength <= 1000.0)) {
    throw UsageError("--strength: must be a positive multiple of the noise floor, at most 1000");
  }
}

}  // namespace slipstack::workbench
