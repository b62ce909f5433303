// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/results/simulation_result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "workbench/base/axis_units.h"
#include "workbench/base/axis_words.h"
#include "workbench/base/quantity.h"
#include "workbench/report/json_values.h"
#include "workbench/report/model_notes.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {
namespace {

/// Points of a chart; a screen resolves no more.
constexpr std::size_t kChartPoints = 4000;

/// Every so many values, so that no more than kChartPoints are left.
std::vector<double> thinned(const std::vector<double>& values, double scale = 1.0) {
  const std::size_t stride = std::max<std::size_t>(1, values.size() / kChartPoints);
  std::vector<double> few;
  for (std::size_t i = 0; i < values.size(); i += stride) few.push_back(scale * values[i]);
  return few;
}

std::vector<double> times(std::size_t count, double first_s, double rate_Hz) {
  std::vector<double> time_s(count);
  for (std::size_t i = 0; i < count; ++i) time_s[i] = first_s + static_cast<double>(i) / rate_Hz;
  return time_s;
}

std::string open_loop_csv(const OpenLoop& found, const std::vector<double>& time_s) {
  std::string text = fmt::format("time_s,{},measured_{}\n", axis_key("position_m"), axis_key("position_m"));
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    fmt::format_to(std::back_inserter(text), "{:.9g},{:.9f},{:.9f}\n", time_s[i], found.position_m[i],
                   found.measured_m[i]);
  }
  return text;
}

}  // namespace

ExperimentResult open_loop_result(const std::string& model_path, const Model& model, const std::string& log,
                                  const OpenLoop& found, double start_s, double rate_Hz) {
  ExperimentResult result;
  result.command = "simulate";
  result.experiment = "simulate";
  result.setup = fmt::format("{}, hash {}, on {}", model_path, hash_text(model), log);
  const double duration_s = static_cast<double>(found.position_m.size()) / rate_Hz;
  result.headline =
      fmt::format("From the measured {} alone the model follows the position within {} rms over {:.3g} s.",
                  force_word(), machine_length(found.rmse_m), duration_s);
  result.detail = fmt::format(
      "Largest error {}, at the end {}; {:.2f} % of the motion is followed. Open loop: nothing "
      "measured corrects it after the start, so errors of the {} add up twice.",
      machine_length(found.largest_m), machine_length(found.final_m), 100.0 * found.fit, force_word());
  result.summary = {{"log", log},
                    {"model", model_path},
                    {"hash", hash_text(model)},
                    {"effects", ids_of(model.terms)},
                    {"start_s", start_s},
                    {"duration_s", duration_s},
                    {"samples", found.position_m.size()},
                    {"rmse_m", found.rmse_m},
                    {"largest_error_m", found.largest_m},
                    {"final_error_m", found.final_m},
                    {"fit", found.fit},
                    {"steps_per_sample", static_cast<std::size_t>(found.steps_per_sample)}};
  const std::vector<double> time_s = times(found.position_m.size(), start_s, rate_Hz);
  std::vector<double> error_m(time_s.size());
  for (std::size_t i = 0; i < error_m.size(); ++i) error_m[i] = found.position_m[i] - found.measured_m[i];
  const DisplayUnit length = machine_length_unit();
  const ChartAxis time{"Time", "s", 1.0, false};
  result.charts.push_back({fmt::format("Position, measured and from the {} alone", force_word()),
                           time,
                           {"Position", length.label, length.per_si, false},
                           thinned(time_s),
                           {{"measured", thinned(found.measured_m), {}, "measured", false},
                            {"simulated", thinned(found.position_m), {}, "before", true}},
                           false});
  result.charts.push_back({"Error of the position",
                           time,
                           {"Error", length.label, length.per_si, false},
                           thinned(time_s),
                           {{"simulated - measured", thinned(error_m), {}, "before", false}},
                           false});
  result.notes.push_back(fmt::format(
      "Semi-implicit Euler, {} steps per sample; friction by the firmware's basis functions; position and "
      "velocity at the start from the log.",
      found.steps_per_sample));
  result.file = open_loop_csv(found, time_s);
  return result;
}

ExperimentResult demand_result(const std::string& model_path, const Model& model,
                               const std::string& set_points, const SetPoints& points,
                               const std::vector<double>& force_N) {
  double squares = 0.0;
  double peak_N = 0.0;
  for (const double force : force_N) {
    squares += force * force;
    peak_N = std::max(peak_N, std::abs(force));
  }
  const double rms_N = std::sqrt(squares / static_cast<double>(force_N.size()));
  ExperimentResult result;
  result.command = "simulate";
  result.experiment = "simulate";
  result.setup = fmt::format("{}, hash {}, along {}", model_path, hash_text(model), set_points);
  result.headline =
      fmt::format("The motion asks for {} rms and {} at most.", newtons(rms_N), newtons(peak_N));
  result.summary = {{"model", model_path},      {"hash", hash_text(model)}, {"effects", ids_of(model.terms)},
                    {"samples", points.size()}, {"rms_force_N", rms_N},     {"peak_force_N", peak_N}};
  const std::vector<double> time_s = times(points.size(), 0.0, points.rate_Hz);
  const DisplayUnit force = axis_is_rotary() ? display_unit("N", peak_N) : DisplayUnit{1.0, "N"};
  result.charts.push_back({"Force along the set points",
                           {"Time", "s", 1.0, false},
                           {axis_is_rotary() ? "Torque" : "Force", force.label, force.per_si, false},
                           thinned(time_s),
                           {{"model", thinned(force_N), {}, "before", false}},
                           false});
  result.file = fmt::format("time_s,{},{}\n", axis_key("position_m"), axis_key("force_N"));
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    fmt::format_to(std::back_inserter(result.file), "{:.9g},{:.9f},{:.6f}\n", time_s[i], points.position_m[i],
                   force_N[i]);
  }
  return result;
}

}  // namespace slipstack::workbench
