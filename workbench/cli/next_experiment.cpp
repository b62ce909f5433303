// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/next_experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/model/effects/effect_catalogue.h"
#include "workbench/model/effects/effect_registry.h"
#include "workbench/report/results.h"
#include "workbench/report/sections.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// As many effects as one experiment is planned for.
constexpr std::size_t kMostEffects = 3;

/// In a sentence.
std::string title_of(const std::string& id) {
  const EffectDescription* effect = find_effect(id);
  return effect == nullptr ? id : in_sentence(effect->text.title);
}

bool can_be_planned(const std::string& id) {
  const EffectDescription* effect = find_effect(id);
  return effect != nullptr && effect->is_plannable();
}

std::string shell_quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string command_for(const Options& options, const std::vector<std::string>& effects) {
  std::string text = "slipstack experiment plan --log";
  for (const std::string& log : options.logs) text += fmt::format(" {}", shell_quoted(log));
  if (!options.model.empty()) text += " --model " + shell_quoted(options.model);
  if (!options.effects.empty()) text += " --effects " + options.effects;
  for (const std::string& id : effects) {
    const EffectDescription& effect = *find_effect(id);
    if (effect.is_user_defined()) text += " --effect " + shell_quoted(effect.definition);
  }
  return text + fmt::format(" --for {} --out setpoints.csv", fmt::join(effects, ","));
}

NextExperiment planned(const Options& options, std::vector<std::string> effects, std::string why) {
  std::string command = command_for(options, effects);
  return {std::move(effects), std::move(why), std::move(command)};
}

json table(const char* title, const std::vector<std::pair<const char*, bool>>& columns, json rows) {
  json heads = json::array();
  for (const auto& [heading, number] : columns) {
    heads.push_back({{"heading", heading}, {"unit", ""}, {"number", number}});
  }
  return {{"title", title}, {"columns", std::move(heads)}, {"rows", std::move(rows)}};
}

}  // namespace

std::optional<NextExperiment> next_experiment(const Options& options, const Diagnosis& diagnosis,
                                              bool by_title) {
  if (diagnosis.candidates.empty()) return {};
  const auto name = [by_title](const std::string& id) { return by_title ? title_of(id) : id; };
  const std::string first = diagnosis.candidates.front().term.id();
  // The pair with the first candidate in it before the others.
  std::vector<Separation> pairs = diagnosis.cannot_separate;
  std::stable_partition(pairs.begin(), pairs.end(),
                        [&](const Separation& pair) { return pair.effect == first; });
  for (const Separation& pair : pairs) {
    if (!can_be_planned(pair.effect) || !can_be_planned(pair.other)) continue;
    return planned(options, {pair.effect, pair.other},
                   fmt::format("this log cannot separate {} from {}: their forces are {:.0f} degrees apart",
                               name(pair.effect), name(pair.other), pair.angle_deg));
  }
  if (diagnosis.verdict == Verdict::missing_effect && can_be_planned(first)) {
    return planned(options, {first}, fmt::format("it would confirm {} where it shows most", name(first)));
  }
  std::vector<std::string> unobserved;
  for (const Visibility& one : diagnosis.cannot_show) {
    if (can_be_planned(one.effect) && unobserved.size() < kMostEffects) unobserved.push_back(one.effect);
  }
  if (unobserved.empty()) return {};
  std::vector<std::string> names;
  names.reserve(unobserved.size());
  for (const std::string& id : unobserved) names.push_back(name(id));
  return planned(options, unobserved, fmt::format("this log does not rule out {}", fmt::join(names, ", ")));
}

void add_limits(json& result, const Options& options, const Diagnosis& diagnosis) {
  json cannot_show = json::array();
  for (const Visibility& one : diagnosis.cannot_show) {
    cannot_show.push_back({{"effect", one.effect},
                           {"least_visible_N", number_json(one.least_N)},
                           {"share_told_apart", one.share}});
  }
  result["cannot_show"] = cannot_show;
  json cannot_separate = json::array();
  for (const Separation& pair : diagnosis.cannot_separate) {
    cannot_separate.push_back(
        {{"effect", pair.effect}, {"other", pair.other}, {"angle_deg", number_json(pair.angle_deg)}});
  }
  result["cannot_separate"] = cannot_separate;
  result["next_experiment"] = nullptr;
  if (const auto next = next_experiment(options, diagnosis)) {
    result["next_experiment"] = {
        {"for", next->effects}, {"why", next->why}, {"command", printable(next->command)}};
  }
}

std::string limits_text(const Options& options, const Diagnosis& diagnosis) {
  std::string text;
  if (!diagnosis.cannot_show.empty()) {
    std::vector<std::string> ids;
    for (const Visibility& one : diagnosis.cannot_show) ids.push_back(one.effect);
    text += fmt::format("\nthis log cannot show   {}\n", fmt::join(ids, ", "));
  }
  for (const Separation& pair : diagnosis.cannot_separate) {
    text += fmt::format("{}cannot separate        {} from {}: {:.1f} degrees apart\n",
                        &pair == &diagnosis.cannot_separate.front() && text.empty() ? "\n" : "", pair.effect,
                        pair.other, pair.angle_deg);
  }
  if (const auto next = next_experiment(options, diagnosis)) {
    text += fmt::format("\nnext experiment        {}:\n  {}\n", next->why, printable(next->command));
  }
  return text;
}

void add_limits_report(json& report, const Options& options, const Diagnosis& diagnosis) {
  const auto heading = [](const std::string& id) {
    const EffectDescription* effect = find_effect(id);
    return effect == nullptr ? id : fmt::format("{} ({})", effect->text.title, id);
  };
  json unobserved = json::array();
  for (const Visibility& one : diagnosis.cannot_show) {
    unobserved.push_back({heading(one.effect), std::isfinite(one.least_N) ? newtons(one.least_N) : "no force",
                          share(one.share)});
  }
  if (!unobserved.empty()) {
    report["tables"].push_back(table("What this log cannot show",
                                     {{"Effect", false},
                                      {"Seen from a peak force of", true},
                                      {"Share of it that nothing else imitates", true}},
                                     std::move(unobserved)));
  }
  json pairs = json::array();
  for (const Separation& pair : diagnosis.cannot_separate) {
    pairs.push_back({heading(pair.effect), heading(pair.other), fmt::format("{:.1f}°", pair.angle_deg)});
  }
  if (!pairs.empty()) {
    report["tables"].push_back(
        table("What this log cannot separate",
              {{"Effect", false}, {"From", false}, {"Angle between their forces", true}}, std::move(pairs)));
  }
  if (const auto next = next_experiment(options, diagnosis, true)) {
    report["next_experiment"] = {{"why", sentence(next->why)}, {"command", printable(next->command)}};
  }
}

}  // namespace slipstack::workbench
