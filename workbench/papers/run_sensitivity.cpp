// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim_host/experiments/sensitivity.h"
#include "workbench/papers/experiments.h"
#include "workbench/papers/sweep_file.h"

namespace slipstack::workbench {
namespace {

/// From here on a response belongs to the sensitive region: it changes three times as much as the level.
constexpr double kSensitive = 3.0;
/// Shades of the map: none where the response changes less than the level, dark at ten times as much.
constexpr double kPale = 1.0;
constexpr double kDark = 10.0;

std::string resume_part(const std::string& path, const char* part) {
  return path.empty() ? path : fmt::format("{}.{}", path, part);
}

/// Rows of frequency, columns of force: the map as it is printed.
ExperimentTable map_table(const std::vector<sim::SensitivityPoint>& points,
                          const sim::SteppedSineRequest& request) {
  ExperimentTable table{"map",
                        "Relative change of the response over relative change of the saturation level",
                        {{"frequency_Hz", "frequency", "Hz", 1.0, 5}},
                        {}};
  for (const double force_N : request.forces_N) {
    table.columns.push_back(
        {fmt::format("at_{:g}_N", force_N), fmt::format("{:g} N", force_N), "", 1.0, 3, kPale, kDark});
  }
  const std::size_t frequencies = request.frequencies_Hz.size();
  for (std::size_t k = 0; k < frequencies; ++k) {
    std::vector<Cell> row = {request.frequencies_Hz[k]};
    for (std::size_t i = 0; i < request.forces_N.size(); ++i)
      row.emplace_back(points[i * frequencies + k].sensitivity);
    table.rows.push_back(std::move(row));
  }
  return table;
}

ExperimentTable levels_table(const std::vector<sim::SensitivityPoint>& points,
                             const sim::ExperimentSetup& setup, const sim::SteppedSineRequest& request) {
  ExperimentTable table{"levels",
                        "Sensitive region by force level",
                        {{"force_N", "force", "N", 1.0, 5},
                         {"force_over_level", "force/saturation", "", 1.0, 3},
                         {"largest", "largest", "", 1.0, 3},
                         {"largest_at_Hz", "at", "Hz", 1.0, 4},
                         {"from_Hz", "sensitive from", "Hz", 1.0, 4},
                         {"to_Hz", "to", "Hz", 1.0, 4}},
                        {}};
  const std::size_t frequencies = request.frequencies_Hz.size();
  for (std::size_t i = 0; i < request.forces_N.size(); ++i) {
    double largest = 0.0;
    double at_Hz = std::nan("");
    double from_Hz = std::nan("");
    double to_Hz = std::nan("");
    for (std::size_t k = 0; k < frequencies; ++k) {
      const sim::SensitivityPoint& point = points[i * frequencies + k];
      if (point.sensitivity > largest) {
        largest = point.sensitivity;
        at_Hz = point.frequency_Hz;
      }
      if (point.sensitivity <= kSensitive) continue;
      if (std::isnan(from_Hz)) from_Hz = point.frequency_Hz;
      to_Hz = point.frequency_Hz;
    }
    table.rows.push_back({request.forces_N[i], request.forces_N[i] / setup.axis.curve.saturation_N(), largest,
                          at_Hz, from_Hz, to_Hz});
  }
  return table;
}

ExperimentResult sensitivity_result(const sim::ExperimentSetup& setup, const sim::SteppedSineRequest& request,
                                    const std::vector<sim::SensitivityPoint>& points, double share) {
  const auto most = std::max_element(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return a.sensitivity < b.sensitivity;
  });
  ExperimentResult result;
  result.experiment = "sensitivity";
  result.setup = setup.title;
  result.headline = fmt::format(
      "Most sensitive at {:g} N ({:.2g} of the saturation level) and {:.3g} Hz: 1 % of level moves the "
      "response by {:.3g} %.",
      most->force_N, most->force_N / setup.axis.curve.saturation_N(), most->frequency_Hz, most->sensitivity);
  result.detail = fmt::format(
      "Level changed by ±{:g} %, first slope as it is. Above {:g} a response belongs to the sensitive "
      "region.",
      100.0 * share, kSensitive);
  result.summary = {{"share", share},
                    {"largest", most->sensitivity},
                    {"largest_force_N", most->force_N},
                    {"largest_frequency_Hz", most->frequency_Hz},
                    {"saturation_N", setup.axis.curve.saturation_N()}};
  result.tables = {levels_table(points, setup, request), map_table(points, request)};
  ExperimentChart chart{"Sensitivity of the response to the saturation level",
                        {"Frequency", "Hz", 1.0, true},
                        {"Relative change over relative change", "", 1.0, true},
                        request.frequencies_Hz,
                        {},
                        false};
  const std::size_t frequencies = request.frequencies_Hz.size();
  for (std::size_t i = 0; i < request.forces_N.size(); ++i) {
    ChartCurve curve{fmt::format("{:g} N", request.forces_N[i]), {}, {}, "", false};
    for (std::size_t k = 0; k < frequencies; ++k) curve.y.push_back(points[i * frequencies + k].sensitivity);
    chart.curves.push_back(std::move(curve));
  }
  result.charts.push_back(std::move(chart));
  return result;
}

}  // namespace

void run_sensitivity(const std::string& command_line, const SensitivityOptions& wanted) {
  run_experiment(command_line, wanted.sine.outputs, wanted.sine.setup.inputs(), [&](Progress& progress) {
    const sim::ExperimentSetup setup = wanted.sine.setup.axis();
    const sim::SteppedSineRequest request = wanted.sine.request(setup);
    const auto sweep = [&](const sim::ExperimentSetup& changed, const char* part, const char* stage) {
      return run_kept_sweep(resume_part(wanted.sine.resume, part), changed, request,
                            control_of(progress, stage, wanted.sine.threads), true);
    };
    const auto plain = sweep(setup, "plain", "level as it is");
    const auto raised = sweep(sim::with_level(setup, wanted.share), "raised", "level raised");
    const auto lowered = sweep(sim::with_level(setup, -wanted.share), "lowered", "level lowered");
    for (const char* part : {"plain", "raised", "lowered"}) {
      SweepFile(resume_part(wanted.sine.resume, part), "").remove();
    }
    return sensitivity_result(setup, request, sim::sensitivity(plain, raised, lowered, wanted.share),
                              wanted.share);
  });
}

}  // namespace slipstack::workbench
