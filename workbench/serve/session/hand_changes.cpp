// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/session/hand_changes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "workbench/analysis/compare_model.h"
#include "workbench/base/axis_units.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/estimate/nonlinear/reduce.h"
#include "workbench/model/effect_adapters/shape_parameter.h"
#include "workbench/report/fitted_model_file.h"
#include "workbench/report/json_values.h"
#include "workbench/report/model_notes.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

constexpr double kLargestFactor = 100.0;  // of a group; more is another model

json entry(const Term& term, const char* kind, std::size_t index, const char* name, const char* unit) {
  return {{"effect", term.id()}, {"title", term.effect->text.title}, {"kind", kind}, {"index", index},
          {"name", name},        {"unit", axis_unit(unit)}};
}

void list_shapes(const Term& term, json& list) {
  if (term.effect->has_role(Role::hysteresis)) return;  // a grid of slip distances
  for (std::size_t i = 0; i < term.shapes.size(); ++i) {
    const ShapeSpec& spec = term.effect->shapes[i];
    const ShapeBounds bounds = bounds_of(spec);
    if (!(bounds.upper > bounds.lower)) continue;
    json one = entry(term, "shape", i, spec.name, spec.unit);
    one["value"] = term.shapes[i];
    one["lower"] = number_json(bounds.lower);
    one["upper"] = number_json(bounds.upper);
    one["standard_error"] = number_json(term.shape_standard_error(i));
    list.push_back(std::move(one));
  }
}

void list_gains(const Term& term, json& list) {
  std::size_t first = 0;
  for (const GainGroup& group : term.effect->gain_groups) {
    const auto count = static_cast<std::size_t>(group.count);
    if (first + count > term.gains.size()) return;
    if (count > 1) {
      json one = entry(term, "factor", first, group.name, "1");
      one["value"] = 1.0;
      one["lower"] = 0.0;
      one["upper"] = 2.0;
      one["standard_error"] = nullptr;
      one["count"] = count;
      list.push_back(std::move(one));
    } else if (term.lower[first] < term.upper[first]) {
      json one = entry(term, "gain", first, group.name, group.unit);
      one["value"] = term.gains[first];
      one["lower"] = number_json(term.lower[first]);
      one["upper"] = number_json(term.upper[first]);
      one["standard_error"] = number_json(term.gain_standard_error(first));
      list.push_back(std::move(one));
    }
    first += count;
  }
}

void set_gain(Term& term, std::size_t index, double value) {
  term.gains[index] = std::clamp(value, term.lower[index], term.upper[index]);
}

void apply(Term& term, const std::string& kind, std::size_t index, double value) {
  if (kind == "shape" && index < term.shapes.size()) {
    const ShapeBounds bounds = bounds_of(term.effect->shapes[index]);
    term.shapes[index] = std::clamp(value, bounds.lower, bounds.upper);
  } else if (kind == "gain" && index < term.gains.size()) {
    set_gain(term, index, value);
  } else if (kind == "factor" && index < term.gains.size() && std::abs(value) <= kLargestFactor) {
    const auto count = static_cast<std::size_t>(term.effect->group_of_gain(static_cast<int>(index)).count);
    for (std::size_t i = index; i < std::min(index + count, term.gains.size()); ++i) {
      set_gain(term, i, term.gains[i] * value);
    }
  } else {
    throw UsageError(fmt::format("{} has no such parameter", term.id()));
  }
}

}  // namespace

json adjustable(const Terms& terms) {
  json list = json::array();
  for (const Term& term : terms) {
    list_shapes(term, list);
    list_gains(term, list);
  }
  return list;
}

void apply_changes(Terms& terms, const json& changes) {
  for (const json& change : changes) {
    const std::string id = change.at("effect");
    const double value = change.at("value");
    if (!std::isfinite(value)) throw UsageError("a parameter must be a finite number");
    const auto term =
        std::find_if(terms.begin(), terms.end(), [&](const Term& one) { return one.id() == id; });
    if (term == terms.end()) throw UsageError(fmt::format("the model does not contain {}", in_quotes(id)));
    apply(*term, change.at("kind"), change.at("index"), value);
    term->gain_standard_errors.clear();
    term->shape_standard_errors.clear();
  }
}

Model with_changes(LogSearch& logs, const std::string& log, const Model& model, const json& changes,
                   Progress& progress) {
  Model changed = model;
  apply_changes(changed.terms, changes);
  const ComparisonResult compared = compare_model(logs, changed, progress);
  FittedModel as_it_is;
  as_it_is.terms = terms_on(logs.measurement(), changed.terms);
  as_it_is.holdout_rmse_N = compared.rmse_N;  // nothing was fitted: all data are unseen
  as_it_is.relative_error = compared.relative_error;
  progress.show("reduce to the controller");
  const FittedModel linear = linearised(logs.measurement(), as_it_is.terms, compared.rmse_N);
  as_it_is.linearisation = linear.linearisation;
  as_it_is.equations = linear.equations;
  as_it_is.constraints = linear.constraints;
  const FittedModel reduced = on_controller(logs.measurement(), as_it_is);
  Model file = model_of(log, logs.measurement(), as_it_is, reduced, compared.noise_floor_N);
  file.history = model.history;
  file.history.push_back(
      change_of(log, {"set by hand"}, model.source.holdout_rmse_N, compared.rmse_N, compared.noise_floor_N));
  return file;
}

}  // namespace slipstack::workbench
