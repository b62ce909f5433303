// SPDX-License-Identifier: Apache-2.0
// What the browser can save.
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "workbench/analysis/compare_model.h"
#include "workbench/base/axis_units.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/c_export/friction_header.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/log/mat/write_mat.h"
#include "workbench/report/html/report_page.h"
#include "workbench/report/json_values.h"
#include "workbench/report/model_notes.h"
#include "workbench/report/parameters.h"
#include "workbench/serve/session/plain_file.h"
#include "workbench/serve/session/workspace.h"

namespace slipstack::workbench {

using nlohmann::json;

namespace {

using Columns = std::vector<std::pair<std::string, std::vector<double>>>;

/// The rows within [from_s, to_s], as the charts show them.
Columns columns_of(const Measurement& measurement, const Terms& terms, double from_s, double to_s) {
  const Eigen::VectorXd time_s = row_times(measurement);
  const ForceRows force = force_rows(measurement, terms);
  const std::vector<std::pair<const char*, Eigen::VectorXd>> all{
      {"time_s", time_s},
      {"position_m", at_rows(measurement, measurement.position_m())},
      {"velocity_mps", at_rows(measurement, measurement.velocity_mps())},
      {"acceleration_mps2", at_rows(measurement, measurement.acceleration_mps2())},
      {"measured_N", force.measured_N},
      {"model_N", force.model_N},
      {"residual_N", force.residual_N()}};
  Columns columns;
  for (const auto& [name, values] : all) {
    columns.emplace_back(axis_key(name), std::vector<double>{});
    for (Eigen::Index row = 0; row < values.size(); ++row) {
      if (time_s(row) < from_s || time_s(row) > to_s || measurement.row_usable()(row) == 0.0) continue;
      columns.back().second.push_back(values(row));
    }
  }
  return columns;
}

std::string csv_of(const Columns& columns) {
  std::string text;
  for (std::size_t c = 0; c < columns.size(); ++c) text += (c > 0 ? "," : "") + columns[c].first;
  text += '\n';
  for (std::size_t row = 0; row < columns[0].second.size(); ++row) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      fmt::format_to(std::back_inserter(text), "{}{:.9g}", c > 0 ? "," : "", columns[c].second[row]);
    }
    text += '\n';
  }
  return text;
}

json model_json(const Model& model) {
  json data{{"hash", hash_text(model)},
            {"log", printable(model.source.log)},
            {"samples", model.source.samples},
            {"holdout_rmse_N", number_json(model.source.holdout_rmse_N)},
            {"noise_floor_N", number_json(model.source.noise_floor_N)},
            {"effects", ids_of(model.terms)},
            {"parameters", parameters_json(model.terms)},
            {"history", history_json(model)}};
  return data;
}

}  // namespace

Download Workspace::download(const std::string& what, int version, const json& options) const {
  std::string path;
  std::string names;
  Model model;
  {
    const std::lock_guard lock(lock_);
    path = session_.model_path(version).string();
    model = session_.model(version);
    names = joined(session_.logs());
  }
  if (what == "toml")
    return {fmt::format("model-{}.toml", version), "application/toml",
            read_whole(path, std::size_t{64} << 20)};
  if (what == "header") return {"friction.h", "text/x-c", friction_header(model, {})};
  if (what == "json")
    return {fmt::format("model-{}.json", version), "application/json", json_text(model_json(model))};
  if (what == "report") {
    Progress progress([](const std::string&, double) {});
    LogSearch logs = search(progress);
    ComparisonResult result = compare_model(logs, model, progress);
    result.command_line = fmt::format("slipstack compare {} --model {}", names, path);
    result.log = names;
    result.model_path = path;
    return {"report.html", "text/html; charset=utf-8",
            render_report(comparison_page(logs.measurement(), result))};
  }
  if (what != "csv" && what != "mat") throw UsageError("what: toml, header, json, report, csv or mat");
  const std::shared_ptr<View> drawn = view();
  const Columns columns = columns_of(drawn->measurement(), model.terms, options.value("from_s", -HUGE_VAL),
                                     options.value("to_s", HUGE_VAL));
  if (what == "mat") return {"rows.mat", "application/octet-stream", mat_file(columns)};
  return {"rows.csv", "text/csv", csv_of(columns)};
}

}  // namespace slipstack::workbench
