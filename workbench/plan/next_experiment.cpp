// SPDX-License-Identifier: Apache-2.0
#include "workbench/plan/next_experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "workbench/diagnose/detectability/ties.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

/// One experiment is planned for at most so many effects, as `experiment plan` is documented for.
constexpr std::size_t kMostEffects = 3;

bool can_be_planned(const std::string& id) {
  const EffectDescription* effect = find_effect(id);
  return effect != nullptr && effect->is_plannable();
}

std::string shell_quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// What to find out next, without what stands beside it.
std::optional<NextExperiment> question_of(const Diagnosis& diagnosis) {
  if (diagnosis.candidates.empty()) return {};
  const std::string first = diagnosis.candidates.front().term.id();
  // Pairs with the first candidate come before the others.
  std::vector<Separation> pairs = diagnosis.cannot_separate;
  std::stable_partition(pairs.begin(), pairs.end(),
                        [&](const Separation& pair) { return pair.effect == first; });
  for (const Separation& pair : pairs) {
    if (!can_be_planned(pair.effect) || !can_be_planned(pair.other)) continue;
    return NextExperiment{NextExperiment::Purpose::separate, {pair.effect, pair.other}, pair.angle_deg};
  }
  if (diagnosis.verdict == Verdict::missing_effect && can_be_planned(first)) {
    return NextExperiment{NextExperiment::Purpose::confirm, {first}};
  }
  std::vector<std::string> unobserved;
  for (const Visibility& one : diagnosis.cannot_show) {
    if (can_be_planned(one.effect) && unobserved.size() < kMostEffects) unobserved.push_back(one.effect);
  }
  if (unobserved.empty()) return {};
  return NextExperiment{NextExperiment::Purpose::rule_out, std::move(unobserved)};
}

}  // namespace

std::optional<NextExperiment> next_experiment(const Diagnosis& diagnosis) {
  std::optional<NextExperiment> next = question_of(diagnosis);
  if (!next) return next;
  for (const Term& term : diagnosis.explained.terms) {
    const std::string id = term.id();
    if (std::find(next->effects.begin(), next->effects.end(), id) == next->effects.end())
      next->beside.push_back(id);
  }
  return next;
}

std::string reason_text(const NextExperiment& next, const EffectName& name) {
  std::vector<std::string> names;
  names.reserve(next.effects.size());
  for (const std::string& id : next.effects) names.push_back(name(id));
  switch (next.purpose) {
    case NextExperiment::Purpose::separate:
      return "this log " + tie_text(names[0], names[1], next.angle_deg);
    case NextExperiment::Purpose::confirm:
      return fmt::format("it would confirm {} where it shows most", names[0]);
    case NextExperiment::Purpose::rule_out:
      return fmt::format("this log does not rule out {}", fmt::join(names, ", "));
  }
  return "";
}

std::string plan_command(const NextExperiment& next, const PlanBasis& basis) {
  std::string text = "slipstack experiment plan --log";
  for (const std::string& log : basis.logs) text += fmt::format(" {}", shell_quoted(log));
  std::vector<std::string> used = next.effects;
  if (!basis.model.empty()) {
    text += " --model " + shell_quoted(basis.model);
  } else if (!next.beside.empty() && next.beside != default_baseline()) {
    text += fmt::format(" --effects {}", fmt::join(next.beside, ","));
    used.insert(used.end(), next.beside.begin(), next.beside.end());
  }
  for (const std::string& id : used) {
    const EffectDescription& effect = *find_effect(id);
    if (effect.is_user_defined()) text += " --effect " + shell_quoted(effect.definition);
  }
  return text + fmt::format(" --for {} --out setpoints.csv", fmt::join(next.effects, ","));
}

}  // namespace slipstack::workbench
