// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/commission/commission.h"

namespace slipstack::workbench {
namespace {

constexpr double kBar = 30.0;  // characters of the first step

double mean(const std::vector<double>& values) {
  return values.empty() ? std::nan("") : spread_of(values).mean;
}

std::string bar(double value, double whole) {
  if (!std::isfinite(value)) return "";
  return std::string(static_cast<std::size_t>(std::clamp(std::round(kBar * value / whole), 1.0, 1.3 * kBar)),
                     '#');
}

ExperimentTable stages_table(const CommissionResult& result) {
  ExperimentTable table{
      "stages",
      "What was done",
      {{"stage", "stage", "", 1.0, 0}, {"axis_s", "axis", "s", 1.0, 3}, {"found", "found", "", 1.0, 0}},
      {}};
  for (const StageReport& stage : result.stages)
    table.rows.push_back({stage.stage, stage.axis_s, stage.found});
  return table;
}

ExperimentTable trials_table(const CommissionResult& result) {
  ExperimentTable table{"steps",
                        "Each model on the same motion, which no fit has seen",
                        {{"added", "added", "", 1.0, 0},
                         {"tracking_rms_m", "tracking", "µm", 1e6, 3},
                         {"tracking_se_m", "±", "µm", 1e6, 2},
                         {"reversal_rms_m", "after reversals", "µm", 1e6, 3},
                         {"prediction_rms_N", "force", "N", 1.0, 3},
                         {"kept", "kept", "", 1.0, 0},
                         {"bar", "tracking", "", 1.0, 0}},
                        {}};
  const double whole = mean(result.trials.front().rms_m);
  for (const ModelTrial& trial : result.trials) {
    const double tracking = mean(trial.rms_m);
    table.rows.push_back({trial.added, tracking, spread_of(trial.rms_m).standard_error,
                          mean(trial.reversal_rms_m), trial.prediction_rms_N,
                          std::string(trial.kept ? "yes" : "taken back"), bar(tracking, whole)});
  }
  return table;
}

/// The errors over the steps, as shares of those with the mass alone.
ExperimentChart falling_chart(const CommissionResult& result) {
  ExperimentChart chart{"Errors with each step, over those with the mass alone",
                        {"Step", "", 1.0, false},
                        {"Error", "%", 100.0, true},
                        {},
                        {},
                        false};
  ChartCurve tracking{"tracking", {}, {}};
  ChartCurve reversal{"tracking after reversals", {}, {}};
  ChartCurve prediction{"prediction of the force", {}, {}, "measured"};
  const ModelTrial& first = result.trials.front();
  for (std::size_t i = 0; i < result.trials.size(); ++i) {
    const ModelTrial& trial = result.trials[i];
    chart.x.push_back(static_cast<double>(i));
    tracking.y.push_back(mean(trial.rms_m) / mean(first.rms_m));
    reversal.y.push_back(mean(trial.reversal_rms_m) / mean(first.reversal_rms_m));
    prediction.y.push_back(trial.prediction_rms_N / first.prediction_rms_N);
  }
  chart.curves = {tracking, reversal, prediction};
  return chart;
}

std::string headline_of(const CommissionResult& result) {
  const double before_um = 1e6 * mean(result.trials.front().rms_m);
  if (result.deployed == 0)
    return fmt::format(
        "The axis runs with its mass alone and follows to {:.3g} µm rms; no model makes it "
        "follow better.",
        before_um);
  const double after_um = 1e6 * mean(result.trials[result.deployed].rms_m);
  return fmt::format(
      "The axis follows to {:.3g} µm rms, {:.3g} times better than with its mass alone ({:.3g} µm).",
      after_um, before_um / after_um, before_um);
}

}  // namespace

ExperimentResult commission_result(const std::string& axis_title, const CommissionResult& result) {
  const ModelTrial& first = result.trials.front();
  const ModelTrial& deployed = result.trials[result.deployed];
  ExperimentResult shown;
  shown.experiment = "commission";
  shown.setup = axis_title;
  shown.headline = headline_of(result);
  shown.detail = fmt::format("{:.0f} s of the axis.", result.axis_s);
  std::vector<std::string> found;
  for (const ModelTrial& trial : result.trials) {
    if (!trial.effect.empty()) found.push_back(trial.effect);
  }
  shown.summary = {{"verdict", result.verdict},
                   {"effects", found},
                   {"deployed", deployed.added},
                   {"axis_s", result.axis_s},
                   {"mass_kg", result.mass_kg},
                   {"tracking_rms_m", mean(deployed.rms_m)},
                   {"tracking_rms_mass_alone_m", mean(first.rms_m)},
                   {"reversal_rms_m", mean(deployed.reversal_rms_m)},
                   {"reversal_rms_mass_alone_m", mean(first.reversal_rms_m)},
                   {"prediction_rms_N", deployed.prediction_rms_N},
                   {"prediction_rms_mass_alone_N", first.prediction_rms_N}};
  shown.tables = {stages_table(result), trials_table(result)};
  shown.charts.push_back(falling_chart(result));
  shown.notes = result.notes;
  shown.command = "commission";
  return shown;
}

}  // namespace slipstack::workbench
