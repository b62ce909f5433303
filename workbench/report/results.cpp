// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/results.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <optional>

#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/estimate/terms/reduce.h"
#include "workbench/estimate/terms/user_table.h"
#include "workbench/estimate/uncertainty/block_bootstrap.h"
#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

using nlohmann::json;

std::string newtons(double value_N) {
  return quantity(value_N, "N");
}

std::string interval_text(const FittedModel& fitted) {
  const ConfidenceInterval interval = holdout_interval(fitted);
  return newtons(interval.low) + " to " + newtons(interval.high);
}

json interval_json(const FittedModel& fitted) {
  const ConfidenceInterval interval = holdout_interval(fitted);
  return {number_json(interval.low), number_json(interval.high)};
}

std::string share(double value) {
  return fmt::format("{:.2f} %", 100.0 * value);
}

std::string sentence(std::string words) {
  if (!words.empty() && words[0] >= 'a' && words[0] <= 'z')
    words[0] = static_cast<char>(words[0] - 'a' + 'A');
  return words + ".";
}

std::string json_text(const json& value) {
  return value.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

json report_base(const std::string& command_line, const std::string& log, const std::string& command) {
  return {{"title", "slipstack " + command}, {"command", printable(command_line)}, {"log", printable(log)}};
}

json figures_json(const FittedModel& fitted, double floor_N) {
  return {{"noise_floor_N", number_json(floor_N)},
          {"train_rmse_N", number_json(fitted.train_rmse_N)},
          {"holdout_rmse_N", number_json(fitted.holdout_rmse_N)},
          {"relative_error", number_json(fitted.relative_error)}};
}

namespace {

const char* noise_method(const Measurement& measurement) {
  return measurement.force_noise_given() ? "given by --noise"
                                         : "from differences of sixth order of the force";
}

}  // namespace

std::string noise_line(const Measurement& measurement) {
  return fmt::format(
      "noise      {} in one sample of the force, {}; with the encoder's quantisation, by reading "
      "the motion on shifted grids\n",
      newtons(measurement.force_noise_N()), noise_method(measurement));
}

std::string repair_lines(const Measurement& measurement) {
  std::string text;
  for (const LogPart& part : measurement.parts()) {
    for (const std::string& note : part.repaired) {
      const std::string of = measurement.log_count() > 1 ? printable(part.path) + ": " : "";
      text += fmt::format("repaired   {}{}\n", of, note);
    }
  }
  return text;
}

json repairs_json(const Measurement& measurement) {
  json list = json::array();
  for (const LogPart& part : measurement.parts()) {
    for (const std::string& note : part.repaired) list.push_back({{"log", part.path}, {"what", note}});
  }
  return list;
}

std::string excerpt_line(const Measurement& measurement, std::string_view what) {
  if (!measurement.is_excerpt()) return "";
  return fmt::format("excerpt    {} in {} intervals, {} of {} samples; errors are those of all samples\n",
                     what, measurement.parts().size(), measurement.sample_count(),
                     measurement.whole_sample_count());
}

json noise_json(const Measurement& measurement) {
  return {{"force_noise_N", number_json(measurement.force_noise_N())},
          {"method", noise_method(measurement)},
          {"quantisation", "the motion read again on three shifted encoder grids"}};
}

json quality_json(const Measurement& measurement, const FittedModel& fitted, double floor_N) {
  json result = figures_json(fitted, floor_N);
  result["samples"] = measurement.whole_sample_count();
  result["searched_samples"] = measurement.sample_count();
  result["noise"] = noise_json(measurement);
  result["repaired"] = repairs_json(measurement);
  result["holdout_interval_N"] = interval_json(fitted);
  result["effects"] = ids_of(fitted.terms);
  result["parameters"] = parameters_json(fitted.terms);
  if (measurement.log_count() > 1) result["logs"] = logs_json(log_results(measurement, fitted));
  return result;
}

namespace {

/// Errors at the rows of one log.
LogErrors errors_at_rows(const Measurement& measurement, std::size_t log, const ForceRows& rows,
                         const FittedModel* fitted) {
  const auto [first, count] = measurement.rows_of_log(log);
  const Eigen::VectorXd weights = measurement.row_weights().segment(first, count);
  const Eigen::VectorXd usable = measurement.row_usable().segment(first, count);
  const Eigen::VectorXd residual_N = rows.residual_N().segment(first, count).cwiseProduct(usable);
  LogErrors errors;
  errors.rmse_N = std::sqrt(weights.dot(residual_N.cwiseAbs2()) / weights.sum());
  errors.relative_error =
      residual_N.norm() / std::max(rows.measured_N.segment(first, count).cwiseProduct(usable).norm(), 1e-300);
  if (fitted == nullptr) return errors;
  const LogPart& part = measurement.parts()[measurement.parts_of_log(log).first];
  double sum = 0.0;
  for (int block = part.first_block; block < part.first_block + part.block_count; ++block) {
    sum += fitted->block_squared_error[static_cast<std::size_t>(block)];
  }
  errors.holdout_rmse_N = std::sqrt(sum / weights.sum());
  return errors;
}

}  // namespace

std::vector<LogResult> log_results(const Measurement& measurement, const ForceRows& rows,
                                   const std::vector<double>& floors_N, const FittedModel* fitted,
                                   const std::vector<LogErrors>& whole) {
  std::vector<LogResult> results;
  results.reserve(measurement.log_count());
  for (std::size_t log = 0; log < measurement.log_count(); ++log) {
    const LogPart& part = measurement.parts()[measurement.parts_of_log(log).first];
    const LogErrors errors = whole.empty() ? errors_at_rows(measurement, log, rows, fitted) : whole[log];
    results.push_back(
        {errors, part.path, measurement.log_sample_count(log), floors_N[log], part.force_noise_N});
  }
  return results;
}

std::vector<LogResult> log_results(const Measurement& measurement, const FittedModel& fitted) {
  if (measurement.log_count() == 1) return {};
  const std::vector<double> floors_N = NoiseFloor(measurement).of_each_log(fitted.terms);
  return log_results(measurement, rows_of(fitted), floors_N, &fitted, fitted.log_errors);
}

json logs_json(const std::vector<LogResult>& logs) {
  json list = json::array();
  for (const LogResult& one : logs) {
    json entry{{"log", one.path},
               {"samples", one.samples},
               {"rmse_N", number_json(one.rmse_N)},
               {"noise_floor_N", number_json(one.noise_floor_N)},
               {"force_noise_N", number_json(one.force_noise_N)},
               {"relative_error", number_json(one.relative_error)}};
    if (one.holdout_rmse_N > 0.0) entry["holdout_rmse_N"] = one.holdout_rmse_N;
    list.push_back(std::move(entry));
  }
  return list;
}

void add_logs(json& report, const std::vector<LogResult>& logs) {
  if (logs.size() < 2) return;
  const bool held_out = logs.front().holdout_rmse_N > 0.0;
  json rows = json::array();
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const LogResult& one = logs[i];
    rows.push_back({fmt::format("{}", i + 1), printable(one.path), fmt::format("{}", one.samples),
                    newtons(held_out ? one.holdout_rmse_N : one.rmse_N), newtons(one.noise_floor_N),
                    share(one.relative_error)});
  }
  const auto column = [](const char* heading, bool number) {
    return json{{"heading", heading}, {"unit", ""}, {"number", number}};
  };
  report["tables"].push_back({{"title", "The logs one by one"},
                              {"columns",
                               {column("", true), column("Log", false), column("Samples", true),
                                column(held_out ? "Held-out error" : "Error", true),
                                column("Noise floor", true), column("Relative force error", true)}},
                              {"rows", rows}});
}

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

ForceRows rows_of(const FittedModel& fitted) {
  return {fitted.linearisation->measured_N(), fitted.linearisation->force_N()};
}

FittedModel on_controller(const Measurement& measurement, const FittedModel& fitted) {
  return with_standard_errors(measurement, reduce_hysteresis(measurement, fitted, kTargetElements));
}

Model model_of(const std::string& log, const Measurement& measurement, const FittedModel& fitted,
               const FittedModel& reduced, double floor_N) {
  Model model;
  model.source = {printable(log), static_cast<std::int64_t>(measurement.whole_sample_count()),
                  fitted.holdout_rmse_N, floor_N, fitted.relative_error};
  model.terms = averaged_over_logs(measurement, fitted.terms);
  model.target_terms = averaged_over_logs(measurement, reduced.terms);
  model.target_holdout_rmse_N = reduced.holdout_rmse_N;
  tabulate_user_effects(measurement, model, floor_N);
  return model;
}

namespace {
/// Of the noise floor: what a table may miss, at its worst place, before it shows in the error.
constexpr double kTableShare = 0.25;
}  // namespace

void tabulate_user_effects(const Measurement& measurement, Model& model, double floor_N) {
  Terms kept;
  std::optional<Term> table;
  for (const Term& term : model.target_terms) {
    if (!term.effect->is_user_defined()) {
      kept.push_back(term);
      continue;
    }
    Model::UserEffectOnTarget own;
    own.id = term.id();
    if (table) {
      own.why_not = "the controller has one table, and it is taken";
    } else if (const Tabulated made = tabulate(measurement, term, kTableShare * floor_N); made.table) {
      table = made.table->term;
      own = {term.id(),
             "",
             made.table->over_velocity ? "velocity" : "position",
             made.table->from,
             made.table->to,
             made.table->reversal_velocity_mps,
             made.table->largest_error_N,
             made.table->peak_N};
    } else {
      own.why_not = made.why_not;
    }
    model.target_user_effects.push_back(std::move(own));
  }
  if (model.target_user_effects.empty()) return;
  if (table) kept.push_back(std::move(*table));
  model.target_terms = std::move(kept);
  const Eigen::VectorXd left = measurement.force_N(measurement_dynamics_of(model.target_terms)) -
                               measurement.filtered(evaluate_force(measurement, model.target_terms).force_N);
  model.target_holdout_rmse_N = std::max(model.target_holdout_rmse_N, measurement.weighted_rms(left));
}

std::string user_effect_lines(const Model& model) {
  std::string text;
  for (const Model::UserEffectOnTarget& own : model.target_user_effects) {
    if (!own.why_not.empty()) {
      text += fmt::format(
          "controller without {}: {}; `slipstack effects --effect '...' --header FILE` makes it an effect of "
          "the "
          "catalogue\n",
          own.id, own.why_not);
      continue;
    }
    const char* unit = own.over == "velocity" ? "m/s" : "m";
    text += fmt::format(
        "controller {} as a table over {} from {} to {}{}: at most {} off ({} of its peak)\n", own.id,
        own.over, quantity(own.from, unit), quantity(own.to, unit),
        own.reversal_velocity_mps > 0.0
            ? fmt::format(" x direction (a slope below {})", quantity(own.reversal_velocity_mps, "m/s"))
            : "",
        newtons(own.largest_error_N), share(own.largest_error_N / own.peak_N));
  }
  return text;
}

json user_effects_json(const Model& model) {
  json list = json::array();
  for (const Model::UserEffectOnTarget& own : model.target_user_effects) {
    json entry{{"effect", own.id}, {"on_controller", own.why_not.empty()}};
    if (own.why_not.empty()) {
      entry["over"] = own.over;
      entry["from"] = own.from;
      entry["to"] = own.to;
      entry["reversal_velocity_mps"] = own.reversal_velocity_mps;
      entry["largest_error_N"] = own.largest_error_N;
      entry["peak_N"] = own.peak_N;
    } else {
      entry["why_not"] = own.why_not;
    }
    list.push_back(std::move(entry));
  }
  return list;
}

std::string hash_text(const Model& model) {
  return fmt::format("{:08x}", target_hash(model));
}

std::string model_lines(const std::string& path, const Model& model) {
  std::string text = fmt::format("\nmodel      {}, hash {}\n", printable(path), hash_text(model));
  if (find_term(model.terms, "presliding_hysteresis") != nullptr) {
    text +=
        fmt::format("controller {} hysteresis elements: held-out error {} instead of {}\n", kTargetElements,
                    newtons(model.target_holdout_rmse_N), newtons(model.source.holdout_rmse_N));
  }
  return text + user_effect_lines(model);
}

}  // namespace slipstack::workbench
