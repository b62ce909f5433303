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
#include "workbench/estimate/terms/search_ranges.h"
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

/// Takes the first answer away at the end of its job.
class Workspace::Shown {
 public:
  Shown(Workspace& workspace, int id) : workspace_(workspace), id_(id) {}
  ~Shown() {
    const std::lock_guard lock(workspace_.lock_);
    if (workspace_.first_answer_ && workspace_.first_answer_->id == id_)
      workspace_.first_answer_->ended = true;
  }
  Shown(const Shown&) = delete;
  Shown& operator=(const Shown&) = delete;

 private:
  Workspace& workspace_;
  int id_;
};

Workspace::Shown Workspace::show_first(const Current& now, const std::string& what, const FirstGains& gains) {
  const std::shared_ptr<View> drawn = view();
  std::optional<View::Gains> first = gains(*drawn, View::key_of(now.version));
  const std::lock_guard lock(lock_);
  if (!first) return {*this, 0};
  const int id = -++first_answers_;
  first_answer_ = {id, now.version, what, std::move(*first), now.model.source.noise_floor_N};
  events_.tell();
  return {*this, id};
}

void Workspace::publish(int parent, const std::string& what, const Model& model, double before_N) {
  throw_if_cancelled();
  const std::lock_guard lock(lock_);
  session_.add(parent, what, model, before_N);
  if (first_answer_) first_answer_->ended = true;
}

/// The effect with the shapes that the diagnosis of this version has found for it, or that it always has.
std::optional<Term> Workspace::known_term(const Measurement& measurement, int version,
                                          const EffectDescription& effect) const {
  std::optional<json> diagnosis;
  {
    const std::lock_guard lock(lock_);
    diagnosis = session_.diagnosis(version);
  }
  if (diagnosis) {
    if (std::optional<Term> term = term_of_card(measurement, *diagnosis, effect.id())) return term;
  }
  if (searched_shapes(measurement, effect).empty()) return term_for_log(measurement, effect);
  return std::nullopt;
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
    LogSearch logs = search(progress);
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
    const std::string what = fmt::format("{} added", description.id());
    progress.show("fit the gains");
    const Shown first = show_first(now, what, [&](View& drawn, const std::string& key) {
      const std::optional<Term> term = known_term(drawn.measurement(), now.version, description);
      return term ? std::optional(drawn.added(key, now.model.terms, *term)) : std::nullopt;
    });
    Jobs::give_way();
    LogSearch logs = search(progress);
    const AdditionResult result = add_effect(logs, log_names(), now.model, description, progress);
    publish(now.version, what, result.model, result.before.holdout_rmse_N);
  });
}

void Workspace::remove(const std::string& effect) {
  const Current now = current("there is no model yet");
  jobs_.start(fmt::format("remove {}", printable(effect)), [this, now, effect](Progress& progress) {
    const std::string what = fmt::format("{} removed", effect);
    progress.show("fit the gains");
    const Shown first = show_first(now, what, [&](View& drawn, const std::string& key) {
      const bool possible = contains(now.model.terms, effect) && now.model.terms.size() > 1;
      return possible ? std::optional(drawn.removed(key, now.model.terms, effect)) : std::nullopt;
    });
    Jobs::give_way();
    LogSearch logs = search(progress);
    const Refit refit = remove_effect(logs, log_names(), now.model, effect, progress);
    publish(now.version, what, refit.model, refit.before_N);
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
    Jobs::give_way();
    LogSearch logs = search(progress);
    const json cards = diagnosis_cards(logs, path, user_effects, progress,
                                       [this](json card) { add_tried(std::move(card)); });
    throw_if_cancelled();
    const std::lock_guard lock(lock_);
    session_.set_diagnosis(version, cards);
  });
}

/// Best first; a repeated search replaces what it tries again.
void Workspace::add_tried(json card) {
  bool first = false;
  {
    const std::lock_guard lock(lock_);
    first = tried_.empty();
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
  if (first) {
    events_.tell();  // that something shows is not to wait
  } else {
    events_.tell_progress();
  }
}

void Workspace::keep_bent(int version, const json& changes) {
  Model model;
  {
    const std::lock_guard lock(lock_);
    model = session_.model(version);
  }
  const double before_N = model.source.holdout_rmse_N;
  jobs_.start("keep what was set by hand", [this, version, model, changes, before_N](Progress& progress) {
    LogSearch logs = search(progress);
    const Model changed = with_changes(logs, log_names(), model, changes, progress);
    publish(version, "set by hand", changed, before_N);
  });
}

}  // namespace slipstack::workbench
