// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/model_notes.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <nlohmann/json.hpp>
#include <utility>

#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/estimate/nonlinear/reduce.h"
#include "workbench/report/json_values.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {

using nlohmann::json;

Model::Change change_of(const std::string& log, const std::vector<std::string>& added, double before_N,
                        double after_N, double floor_N) {
  std::time_t now = std::time(nullptr);
  if (const char* epoch = std::getenv("SOURCE_DATE_EPOCH")) now = std::strtoll(epoch, nullptr, 10);
  return {fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now)),
          fmt::format("{}", fmt::join(added, ", ")),
          printable(log),
          before_N,
          after_N,
          floor_N};
}

json history_json(const Model& model) {
  json list = json::array();
  for (const Model::Change& change : model.history) {
    list.push_back({{"date", change.date},
                    {"added", change.added},
                    {"log", change.log},
                    {"before_N", change.before_N > 0.0 ? json(change.before_N) : json(nullptr)},
                    {"after_N", number_json(change.after_N)},
                    {"noise_floor_N", number_json(change.noise_floor_N)}});
  }
  return list;
}

void add_history(json& report, const Model& model) {
  if (model.history.empty()) return;
  const auto column = [](const char* heading, bool number) {
    return json{{"heading", heading}, {"unit", ""}, {"number", number}};
  };
  json rows = json::array();
  for (const Model::Change& change : model.history) {
    rows.push_back({printable(change.date), printable(change.added), printable(change.log),
                    change.before_N > 0.0 ? newtons(change.before_N) : "–", newtons(change.after_N),
                    newtons(change.noise_floor_N)});
  }
  report["tables"].push_back(
      {{"title", "History of the model"},
       {"columns",
        {column("When", false), column("Added", false), column("On the log", false),
         column("Held-out error before", true), column("after", true), column("Noise floor", true)}},
       {"rows", rows}});
}

std::string user_effect_lines(const Model& model) {
  std::string text;
  for (const Model::UserEffectOnTarget& effect : model.target_user_effects) {
    if (!effect.why_not.empty()) {
      text += fmt::format(
          "controller without {}: {}; `slipstack effects --effect '...' --header FILE` makes it an effect of "
          "the "
          "catalogue\n",
          effect.id, effect.why_not);
      continue;
    }
    const char* unit = effect.over == "velocity" ? "m/s" : "m";
    text += fmt::format(
        "controller {} as a table over {} from {} to {}{}: at most {} off ({} of its peak)\n", effect.id,
        effect.over, quantity(effect.from, unit), quantity(effect.to, unit),
        effect.reversal_velocity_mps > 0.0
            ? fmt::format(" x direction (a slope below {})", quantity(effect.reversal_velocity_mps, "m/s"))
            : "",
        newtons(effect.largest_error_N), share(effect.largest_error_N / effect.peak_N));
  }
  return text;
}

json user_effects_json(const Model& model) {
  json list = json::array();
  for (const Model::UserEffectOnTarget& effect : model.target_user_effects) {
    json entry{{"effect", effect.id}, {"on_controller", effect.why_not.empty()}};
    if (effect.why_not.empty()) {
      entry["over"] = effect.over;
      entry["from"] = effect.from;
      entry["to"] = effect.to;
      entry["reversal_velocity_mps"] = effect.reversal_velocity_mps;
      entry["largest_error_N"] = effect.largest_error_N;
      entry["peak_N"] = effect.peak_N;
    } else {
      entry["why_not"] = effect.why_not;
    }
    list.push_back(std::move(entry));
  }
  return list;
}

std::string hash_text(const Model& model) {
  return fmt::format("{:08x}", target_hash(model));
}

std::string model_lines(const std::string& path, const Model& model) {
  std::string text = path.empty()
                         ? std::string("\nmodel      not written; --model FILE writes it\n")
                         : fmt::format("\nmodel      {}, hash {}\n", printable(path), hash_text(model));
  if (const Term* const hysteresis = find_role(model.target_terms, Role::hysteresis)) {
    const auto elements = std::count_if(hysteresis->gains.begin(), hysteresis->gains.end(),
                                        [](double stiffness) { return stiffness > 0.0; });
    text += fmt::format("controller {} hysteresis {}: held-out error {} instead of {}\n", elements,
                        elements == 1 ? "element" : "elements", newtons(model.target_holdout_rmse_N),
                        newtons(model.source.holdout_rmse_N));
  }
  return text + user_effect_lines(model);
}

}  // namespace slipstack::workbench
