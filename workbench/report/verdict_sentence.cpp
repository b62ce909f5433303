// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/verdict_sentence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "workbench/base/axis_words.h"
#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/diagnose/detectability/ties.h"
#include "workbench/diagnose/diagnose.h"
#include "workbench/diagnose/evidence/criterion.h"
#include "workbench/diagnose/evidence/naming_rule.h"
#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/report/json_values.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {

using nlohmann::json;

namespace {

/// The candidate that the log supports and that is refused; null where there is none.
const json* refused(const json& result) {
  for (const json& one : result["candidates"]) {
    if (one["refusal"] != name_of(Refusal::none)) return &one;
  }
  return nullptr;
}

/// Why a candidate that the log supports has no name. Where the error is at the floor, and it would fall
/// below, the floor is in doubt too.
std::string why_not_named(const json& candidate, double floor_N) {
  if (candidate["refusal"] == name_of(Refusal::at_floor)) {
    std::string text = "the error is already that of the noise floor, within its uncertainty";
    if (number_of(candidate["holdout_rmse_N"]) * kUncertainFloor < floor_N) {
      text +=
          "; but it would fall below the floor, so this log's floor is estimated too high and may hide an "
          "effect";
    }
    return text + ".";
  }
  if (candidate["refusal"] == name_of(Refusal::superfluous))
    return "it adds nothing to what was chosen, or the log does not determine it.";
  const bool implausible = candidate["refusal"] == name_of(Refusal::implausible);
  return fmt::format("as fitted ({}) it is {}.", candidate["evidence"].get<std::string>(),
                     implausible ? "not plausible" : fmt::format("no larger than {}", kTooSmall));
}

/// Why a complete model names nothing. The table shows every candidate, so that one that lowers the error by
/// a share that is worth a name is not passed over in silence.
std::string nothing_named(const json& result, const EffectName& name) {
  const json* const best = refused(result);
  if (best == nullptr) return "No effect of the catalogue lowers the held-out error significantly.";
  return fmt::format("No effect is named, although {} would lower the held-out error by {}: {}",
                     name((*best)["effect"].get<std::string>()),
                     quantity_with_interval(number_of((*best)["error_reduction"]),
                                            2.0 * number_of((*best)["error_reduction_se"]), "1"),
                     why_not_named(*best, number_of(result["noise_floor_N"])));
}

/// An effect that alone leaves less than the first one that is named, or than all of them together, is not
/// passed over in silence either.
std::string better_alone(const json& result, const EffectName& name) {
  const json* const best = refused(result);
  if (best == nullptr) return "";
  if (!best->value("confounded_with", json::array()).empty()) return "";  // told as a tie
  const double alone_N = number_of((*best)["holdout_rmse_N"]);
  const json& steps = result["steps"];
  std::string than;
  if (!is_worth_a_name(number_of(steps.back()["holdout_rmse_N"]), alone_N)) {
    if (!is_worth_a_name(number_of(steps[1]["holdout_rmse_N"]), alone_N)) return "";
    than = " than " + name(steps[1]["effect"].get<std::string>());
  }
  return fmt::format(" {} alone would leave less{}, {}, but {}", name((*best)["effect"].get<std::string>()),
                     than, newtons(alone_N), why_not_named(*best, number_of(result["noise_floor_N"])));
}

/// What a model leaves beyond the noise floor, where that is more than the floor: its form is then not that
/// of the axis, though no structure is told of it.
std::string beyond_floor(const json& result) {
  const double left_N = number_of(result["discrepancy_N"]);
  const json& baseline = result["baseline"];
  const double relative = number_of(baseline["relative_error"]);
  if (!(left_N > number_of(result["noise_floor_N"])) || !(relative > 0.0)) return "";
  const double force_N = number_of(baseline["train_rmse_N"]) / relative;
  return fmt::format(" Beyond the floor it leaves {}, {} of the {}.", newtons(left_N),
                     share(left_N / force_N), force_word());
}

/// The effects of the steps from `first` on, separated by commas; empty where there is none.
std::string names_of_steps(const json& steps, std::size_t first, const EffectName& name) {
  std::string names;
  for (std::size_t i = first; i < steps.size(); ++i)
    names += (i > first ? ", " : "") + name(steps[i]["effect"].get<std::string>());
  return names;
}

/// The effects that this log cannot tell from a named one.
std::vector<std::string> ties_of(const json& result, const std::string& effect, const EffectName& name) {
  std::vector<std::string> others;
  for (const json& pair : result.value("cannot_separate", json::array())) {
    if (pair["effect"] == effect) others.push_back(name(pair["other"].get<std::string>()));
  }
  return others;
}

/// The ties of the steps from `first` on, each in a sentence.
std::string ties_of_steps(const json& result, std::size_t first, const EffectName& name) {
  std::string text;
  for (std::size_t i = first; i < result["steps"].size(); ++i) {
    const std::string id = result["steps"][i]["effect"];
    const std::vector<std::string> others = ties_of(result, id, name);
    if (!others.empty()) text += fmt::format(" This log {}.", tie_text(name(id), others));
  }
  return text;
}

/// The first effect as the headline names it: with the others that it may be in its place.
std::string first_named(const json& result, const EffectName& name) {
  const json& first = result["candidates"].front();
  const std::string title = first["title"];
  const std::vector<std::string> others = ties_of(result, first["effect"].get<std::string>(), name);
  return others.empty() ? title : fmt::format("{}; this log {}", title, tie_text("it", others));
}

}  // namespace

Headline headline_of(const json& result, const EffectName& name) {
  const auto error = [](const json& of) { return newtons(number_of(of["holdout_rmse_N"])); };
  const std::string floor = newtons(number_of(result["noise_floor_N"]));
  const std::string before = error(result["baseline"]);
  const json& unexplained = result["unexplained"];
  const std::string left = unexplained.is_null() ? "" : unexplained["description"].get<std::string>() + ".";
  if (result["verdict"] == name_of(Verdict::complete)) {
    return {fmt::format("Complete: held-out error {}, noise floor {}, both below {}.", before, floor,
                        quantity(number_of(result["bandwidth_Hz"]), "Hz")),
            nothing_named(result, name) + " The residual depends on no single coordinate." +
                beyond_floor(result)};
  }
  if (result["verdict"] == name_of(Verdict::unexplained)) {
    const std::string named = names_of_steps(result["steps"], 1, name);
    std::string detail = "No effect of the catalogue accounts for it";
    if (!named.empty()) {
      detail +=
          fmt::format(" all: with {} the held-out error is {}, but", named, error(result["steps"].back()));
      return {fmt::format("Unexplained: held-out error {}, noise floor {}.", before, floor),
              detail + (left.empty() ? " more is left." : " " + left) + ties_of_steps(result, 1, name)};
    }
    return {fmt::format("Unexplained: held-out error {}, noise floor {}.", before, floor),
            left.empty() ? detail + "." : detail + "; " + left};
  }
  const json& first = result["candidates"].front();
  Headline headline{
      fmt::format("Missing: {}. Adding it lowers the held-out error from {} to {}; noise floor {}.",
                  first_named(result, name), before, error(result["best"]), floor),
      ""};
  const json& steps = result["steps"];
  // Of several effects, each with its values beside the others: those that the step table shows.
  const json& why = steps.size() > 2 ? steps[1]["evidence"] : first["evidence"];
  headline.detail = "Why: " + why.get<std::string>() + ".";
  if (steps.size() > 2) {
    headline.detail += fmt::format(" Not alone: with {} the error falls to {}.",
                                   names_of_steps(steps, 2, name), error(steps.back()));
    headline.detail += ties_of_steps(result, 2, name);
  }
  headline.detail += left.empty() ? beyond_floor(result) : " Still open: " + left;
  headline.detail += better_alone(result, name);
  return headline;
}

}  // namespace slipstack::workbench
