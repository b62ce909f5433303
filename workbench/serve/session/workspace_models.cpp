// SPDX-License-Identifier: Apache-2.0
// The jobs that make versions of the model, and the diagnosis of one.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "workbench/analysis/add_effect.h"
#include "workbench/analysis/fit_model.h"
#include "workbench/analysis/remove_effect.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/model/effect_adapters/user_effect.h"
#include "workbench/serve/session/hand_changes.h"
#include "workbench/serve/session/workspace.h"
#include "workbench/serve/views/diagnosis_cards.h"

namespace slipstack::workbench {

using nlohmann::json;

namespace {

/// An effect of the catalogue, or the one that a definition declares.
const EffectDescription& effect_of(const std::string& text) {
  return is_definition(text) ? declare_effect(text) : effect_named(text);
}

}  // namespace

void Workspace::publish(int parent, const std::string& what, const Model& model, double before_N) {
  throw_if_cancelled();
  const std::lock_guard lock(lock_);
  session_.add(parent, what, model, before_N);
}

Workspace::Current Workspace::current(const char* none) {
  const std::lock_guard lock(lock_);
  const Version* now = session_.current();
  if (now == nullptr) throw UsageError(none);
  return {now->id, session_.model(now->id)};
}

void Workspace::fit(const std::vector<std::string>& effects) {
  if (effects.empty()) throw UsageError("choose at least one effect to fit");
  for (const std::string& effect : effects) static_cast<void>(effect_of(effect));
  jobs_.start("fit", [this, effects](Progress& progress) {
    LogSearch logs(request(), progress);
    std::vector<std::string> ids;
    ids.reserve(effects.size());
    for (const std::string& effect : effects) ids.push_back(effect_of(effect).id());
    const FitResult result = fit_model(logs, {log_names(), ids, false, 0.0}, progress);
    publish(0, fmt::format("{} fitted", joined(ids)), result.model, 0.0);
  });
}

void Workspace::add(const std::string& effect) {
  const EffectDescription& description = effect_of(effect);
  const Current now = current("fit a first model before an effect is added");
  if (contains(now.model.terms, description.id())) {
    throw UsageError(fmt::format("the model already contains {}", description.id()));
  }
  jobs_.start(fmt::format("add {}", description.id()), [this, now, &description](Progress& progress) {
    LogSearch logs(request(), progress);
    const AdditionResult result = add_effect(logs, log_names(), now.model, description, progress);
    publish(now.version, fmt::format("{} added", result.effect), result.model, result.before.holdout_rmse_N);
  });
}

void Workspace::remove(const std::string& effect) {
  const Current now = current("there is no model yet");
  jobs_.start(fmt::format("remove {}", printable(effect)), [this, now, effect](Progress& progress) {
    LogSearch logs(request(), progress);
    const Refit refit = remove_effect(logs, log_names(), now.model, effect, progress);
    publish(now.version, fmt::format("{} removed", effect), refit.model, refit.before_N);
  });
}

void Workspace::diagnose(const std::vector<std::string>& user_effects) {
  if (jobs_.running()) throw UsageError("a job is still running; cancel it or wait");
  int version = 0;
  std::string path;
  {
    const std::lock_guard lock(lock_);
    const Version* now = session_.current();
    if (now == nullptr) throw UsageError("fit a first model before it is diagnosed");
    tried_ = json::array();
    version = now->id;
    path = session_.model_path(version).string();
  }
  declare_effects(user_effects);
  jobs_.start(kDiagnosis, [this, version, path, user_effects](Progress& progress) {
    const json cards = diagnosis_cards(request(), path, user_effects, progress,
                                       [this](json card) { add_tried(std::move(card)); });
    throw_if_cancelled();
    const std::lock_guard lock(lock_);
    session_.set_diagnosis(version, cards);
  });
}

/// Best first; a repeated search replaces what it tries again.
void Workspace::add_tried(json card) {
  {
    const std::lock_guard lock(lock_);
    std::vector<json> all;
    for (json& one : tried_) {
      if (one["effect"] != card["effect"]) all.push_back(std::move(one));
    }
    all.push_back(std::move(card));
    const auto error_N = [](const json& one) {
      const json& error = one["holdout_rmse_N"];
      return error.is_number() ? error.get<double>() : HUGE_VAL;
    };
    std::stable_sort(all.begin(), all.end(),
                     [&](const json& a, const json& b) { return error_N(a) < error_N(b); });
    tried_ = std::move(all);
  }
  events_.tell();
}

void Workspace::keep_bent(int version, const json& changes) {
  Model model;
  {
    const std::lock_guard lock(lock_);
    model = session_.model(version);
  }
  const double before_N = model.source.holdout_rmse_N;
  jobs_.start("keep what was set by hand", [this, version, model, changes, before_N](Progress& progress) {
    LogSearch logs(request(), progress);
    const Model changed = with_changes(logs, log_names(), model, changes, progress);
    publish(version, "set by hand", changed, before_N);
  });
}

}  // namespace slipstack::workbench
