// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "workbench/base/text.h"
#include "workbench/console/output.h"
#include "workbench/papers/analysis/transducer.h"
#include "workbench/papers/experiments.h"
#include "workbench/papers/load_step_file.h"
#include "workbench/papers/loop_tables.h"

namespace slipstack::workbench {
namespace {

/// The calibration, the readings to correct, and a first cycle without preloads where there is one.
struct Records {
  std::string title;
  StepRecord calibration;
  StepRecord readings;
  std::optional<StepRecord> first;
};

/// One way to correct the readings, and the remaining errors.
struct Method {
  std::string name;
  std::size_t elements;
  TransducerErrors errors;
};

std::vector<Method> methods_of(const Records& records) {
  std::vector<Method> methods;
  const auto add = [&](const std::string& name, const TransducerModel& model) {
    methods.push_back({name, model.slip_N().size(), errors_of(model, records.readings)});
  };
  add("line and linearity only", line_and_linearity(records.calibration));
  add("elements by the formula", extract_by_formula(records.calibration));
  add("elements by least squares", extract_by_least_squares(records.calibration));
  if (!records.first) return methods;
  // Elements of the first rise; line and linearity of a cycle after preloads.
  add("first rise, formula", with_line_of(extract_by_formula(*records.first), records.calibration));
  add("first rise, least squares",
      with_line_of(extract_by_least_squares(*records.first), records.calibration));
  return methods;
}

ExperimentTable methods_table(const std::vector<Method>& methods, double hysteresis, double full_N) {
  ExperimentTable table{"methods",
                        "Readings of the second record, corrected by bisection to 1e-9 of full scale",
                        {{"method", "", "", 1.0, 4},
                         {"elements", "elements", "", 1.0, 0},
                         {"largest_mV_per_V", "max error", "nV/V", 1e6, 3},
                         {"share_of_hysteresis", "of hysteresis", "%", 100.0, 3},
                         {"largest_load_N", "max error", "N", 1.0, 3},
                         {"rms_load_N", "rms error", "N", 1.0, 3},
                         {"uncertainty_N", "uncertainty", "N", 1.0, 3},
                         {"relative_uncertainty", "of full scale", "ppm", 1e6, 3}},
                        {}};
  for (const Method& method : methods) {
    const TransducerErrors& left = method.errors;
    table.rows.push_back({method.name, static_cast<double>(method.elements), left.largest_mV_per_V,
                          left.largest_mV_per_V / hysteresis, left.largest_load_N, left.rms_load_N,
                          left.uncertainty_N, left.uncertainty_N / full_N});
  }
  return table;
}

ExperimentTable levels_table(const Reversibility& found) {
  ExperimentTable table{"levels",
                        "The calibration, drift removed: linearity and hysteresis separated",
                        {{"load_N", "load", "kN", 1e-3, 4},
                         {"linearity_mV_per_V", "linearity", "nV/V", 1e6, 3},
                         {"hysteresis_mV_per_V", "hysteresis d_h", "nV/V", 1e6, 3}},
                        {}};
  for (std::size_t i = 0; i < found.load_N.size(); ++i) {
    table.rows.push_back({found.load_N[i], found.linearity[i], std::fabs(found.hysteresis[i])});
  }
  return table;
}

ExperimentChart errors_chart(const Records& records, const std::vector<Method>& methods) {
  ExperimentChart chart{"What the reading of every step is off",
                        {"Load", "kN", 1e-3, false},
                        {"Error", "nV/V", 1e6, false},
                        {},
                        {},
                        true};
  for (std::size_t i = 0; i < 3; ++i) {
    ChartCurve curve{methods[i].name, methods[i].errors.residual_mV_per_V, {}, "", i == 0};
    for (std::size_t j = records.readings.cycle; j < records.readings.steps.size(); ++j) {
      curve.x.push_back(records.readings.steps[j].load_N);
    }
    chart.curves.push_back(std::move(curve));
  }
  return chart;
}

ExperimentResult result_of(const Records& records) {
  const Reversibility calibration = reversibility(records.calibration);
  const double hysteresis = reversibility(records.readings).largest_hysteresis;
  const double full_N = records.readings.full_scale_N;
  const std::vector<Method> methods = methods_of(records);
  const auto share = [&](std::size_t i) { return methods[i].errors.largest_mV_per_V / hysteresis; };
  ExperimentResult result;
  result.experiment = "transducer";
  result.setup = records.title;
  result.headline = fmt::format(
      "Of a hysteresis of {:.3g} nV/V the formula's elements leave {:.0f} %, least squares {:.0f} %.",
      1e6 * hysteresis, 100.0 * share(1), 100.0 * share(2));
  result.detail = fmt::format(
      "Standard uncertainty from hysteresis: {:.3g} N before, {:.3g} N with the formula, {:.3g} N with least "
      "squares.",
      methods[0].errors.uncertainty_N, methods[1].errors.uncertainty_N, methods[2].errors.uncertainty_N);
  result.summary = {{"full_scale_N", full_N},
                    {"sensitivity_mV_per_V_per_N", calibration.sensitivity},
                    {"zero_drift_mV_per_V", calibration.zero_drift},
                    {"hysteresis_mV_per_V", hysteresis},
                    {"formula_share", share(1)},
                    {"least_squares_share", share(2)},
                    {"uncertainty_before_N", methods[0].errors.uncertainty_N},
                    {"uncertainty_formula_N", methods[1].errors.uncertainty_N},
                    {"uncertainty_least_squares_N", methods[2].errors.uncertainty_N}};
  result.tables.push_back(methods_table(methods, hysteresis, full_N));
  result.tables.push_back(levels_table(calibration));
  result.charts.push_back(errors_chart(records, methods));
  ExperimentChart separated{"Linearity and hysteresis",
                            {"Load", "kN", 1e-3, false},
                            {"Deviation", "nV/V", 1e6, false},
                            calibration.load_N,
                            {{"linearity", calibration.linearity, {}, "", false},
                             {"hysteresis", calibration.hysteresis, {}, "", false}},
                            false};
  result.charts.push_back(std::move(separated));
  if (records.first) {
    result.notes.push_back(
        "A first rise without preloads does not close its loop: drift removal takes a part of the "
        "hysteresis, and its "
        "elements by the formula leave more.");
  }
  return result;
}

Records records_of_files(const TransducerOptions& wanted) {
  Records records;
  records.title = wanted.calibration;
  prefix_errors(wanted.calibration,
                [&] { records.calibration = step_record(read_load_steps(wanted.calibration)); });
  records.readings = records.calibration;
  if (!wanted.readings.empty()) {
    prefix_errors(wanted.readings, [&] { records.readings = step_record(read_load_steps(wanted.readings)); });
    prefix_errors(wanted.readings, [&] { reversibility(records.readings); });
    records.title = fmt::format("{}, read again in {}", wanted.calibration, wanted.readings);
  }
  return records;
}

}  // namespace

void run_transducer(const std::string& command_line, const TransducerOptions& wanted) {
  const bool measured = !wanted.calibration.empty();
  std::vector<std::string> inputs = wanted.setup.inputs();
  if (measured) inputs = {wanted.calibration};
  if (!wanted.readings.empty()) inputs.push_back(wanted.readings);
  run_experiment(command_line, wanted.outputs, inputs, [&](Progress& progress) {
    progress.show("calibration");
    Records records;
    if (measured) {
      records = records_of_files(wanted);
    } else {
      const sim::ExperimentSetup setup = sim::read_setup(wanted.setup.name);
      if (!setup.transducer) {
        throw sim::SetupError(fmt::format("{}: is no transducer; name a set-up with a table [transducer]",
                                          printable(wanted.setup.name)));
      }
      const sim::SimulatedCalibration data = sim::simulate_calibration(*setup.transducer, wanted.seed);
      records = {setup.title, step_record(data.loops), step_record(data.repeat), step_record(data.virgin)};
    }
    ExperimentResult result;
    prefix_errors(measured ? wanted.calibration : wanted.setup.name, [&] { result = result_of(records); });
    return result;
  });
}

void write_simulated_calibration(const TransducerOptions& wanted) {
  Outputs outputs;
  outputs.claim(wanted.write_log);
  const sim::ExperimentSetup setup = sim::read_setup(wanted.setup.name);
  if (!setup.transducer) throw UsageError(fmt::format("{}: is no transducer", printable(wanted.setup.name)));
  const sim::SimulatedCalibration data = sim::simulate_calibration(*setup.transducer, wanted.seed);
  outputs.set(wanted.write_log, load_steps_text(fmt::format("simulated: {}", setup.title), data.loops));
  outputs.commit(fmt::format("wrote {} load steps\n", data.loops.size()));
}

}  // namespace slipstack::workbench
