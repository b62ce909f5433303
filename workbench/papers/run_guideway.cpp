// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/text.h"
#include "workbench/log/log.h"
#include "workbench/papers/analysis/guideway.h"
#include "workbench/papers/experiments.h"
#include "workbench/papers/loop_tables.h"

namespace slipstack::workbench {
namespace {

BallMaterial material_named(const std::string& word, const std::string& where) {
  const auto material = ball_material(word);
  if (!material) {
    throw UsageError(fmt::format("{}: unknown material {}; known: steel, silicon_nitride, diamond_coated",
                                 printable(where), in_quotes(word)));
  }
  return *material;
}

/// The measured guideway: options take precedence over the log's header; throws when a value is in neither.
BallContact measured_contact(const Log& log, const GivenContact& given) {
  const auto value = [&](double option, const char* key, const char* flag) {
    if (!std::isnan(option)) return option;
    const auto entry = log.header.find(key);
    double number = 0.0;
    if (entry == log.header.end()) {
      throw InputError(fmt::format("{}: does not say {}; add the line '# {}: value' or give {}",
                                   printable(log.path), key, key, flag));
    }
    const std::string_view text = trimmed(entry->second);
    if (const std::string fault = number_fault(text); !fault.empty()) {
      throw InputError(fmt::format("{}: {} {}; write a number", printable(log.path), key, fault));
    }
    parse_double(text.data(), text.data() + text.size(), number);
    return number;
  };
  BallContact contact;
  contact.load_per_ball_N = value(given.load_N, "load_per_ball_N", "--load-N");
  contact.groove_angle_deg = value(given.angle_deg, "groove_angle_deg", "--groove-angle-deg");
  contact.ball_diameter_m = value(given.diameter_m, "ball_diameter_m", "--ball-diameter-m");
  contact.balls = value(given.balls, "balls", "--balls");
  if (!given.material.empty()) {
    contact.material = material_named(given.material, "--material");
  } else if (const auto entry = log.header.find("ball_material"); entry != log.header.end()) {
    contact.material = material_named(entry->second, log.path);
  }
  return contact;
}

BallContact wanted_contact(const BallContact& from, const GivenContact& given) {
  BallContact to = from;
  if (!std::isnan(given.load_N)) to.load_per_ball_N = given.load_N;
  if (!std::isnan(given.angle_deg)) to.groove_angle_deg = given.angle_deg;
  if (!std::isnan(given.diameter_m)) to.ball_diameter_m = given.diameter_m;
  if (!std::isnan(given.balls)) to.balls = given.balls;
  if (!given.material.empty()) to.material = material_named(given.material, "--to-material");
  return to;
}

ExperimentTable guideways_table(const BallContact& from, const BallContact& to, const AveragedLoop& measured,
                                double k0, const GuidewayPrediction& found) {
  ExperimentTable table{"guideways",
                        "The guideway that was measured and the one that is asked for",
                        {{"guideway", "guideway", "", 1.0, 4},
                         {"load_per_ball_N", "load", "N", 1.0, 4},
                         {"groove_angle_deg", "groove", "°", 1.0, 4},
                         {"ball_diameter_m", "ball", "mm", 1e3, 4},
                         {"balls", "balls", "", 1.0, 0},
                         {"material", "material", "", 1.0, 4},
                         {"amplitude_m", "A", "µm", 1e6, 4},
                         {"force_N", "F", "N", 1.0, 4},
                         {"initial_stiffness_N_per_m", "k0", "N/µm", 1e-6, 3},
                         {"stiffness_N_per_m", "k_e", "N/µm", 1e-6, 4},
                         {"damping_ratio", "ζ_r", "%", 100.0, 3}},
                        {}};
  const auto row = [&](const std::string& guideway, const BallContact& of, const LoopFigures& is,
                       double stiffness) {
    table.rows.push_back({guideway, of.load_per_ball_N, of.groove_angle_deg, of.ball_diameter_m, of.balls,
                          std::string(name(of.material)), is.amplitude_m, is.force_N, stiffness,
                          is.stiffness_N_per_m, is.damping_ratio});
  };
  row("measured", from, measured.figures, k0);
  row("predicted", to, found.figures, found.initial_stiffness_N_per_m);
  return table;
}

/// ζᵣ of both at the same amplitudes, for comparison in design.
ExperimentTable damping_table(const PolygonCurve& measured, const PolygonCurve& predicted) {
  ExperimentTable table{"damping",
                        "At the same amplitude",
                        {{"amplitude_m", "A", "µm", 1e6, 3},
                         {"measured_damping_ratio", "ζ_r measured", "%", 100.0, 3},
                         {"predicted_damping_ratio", "ζ_r predicted", "%", 100.0, 3},
                         {"measured_stiffness_N_per_m", "k_e measured", "N/µm", 1e-6, 3},
                         {"predicted_stiffness_N_per_m", "k_e predicted", "N/µm", 1e-6, 3}},
                        {}};
  const double reach_m = std::min(measured.reach_m(), predicted.reach_m());
  for (const double share : {0.1, 0.2, 0.4, 0.7, 1.0}) {
    const double A = share * reach_m;
    const LoopFigures a = figures_of(masing_loop(measured, A, 1000));
    const LoopFigures b = figures_of(masing_loop(predicted, A, 1000));
    table.rows.push_back({A, a.damping_ratio, b.damping_ratio, a.stiffness_N_per_m, b.stiffness_N_per_m});
  }
  return table;
}

ExperimentResult guideway_result(const GuidewayOptions& wanted) {
  const Log log = read_guideway_log(wanted.log);
  const BallContact from = measured_contact(log, wanted.from);
  const BallContact to = wanted_contact(from, wanted.to);
  ExperimentResult result;
  prefix_errors(wanted.log, [&] {
    const auto loops = averaged_loops(log.position_m, log.force_N);
    const auto& largest =
        *std::max_element(loops.begin(), loops.end(), [](const AveragedLoop& a, const AveragedLoop& b) {
          return a.figures.amplitude_m < b.figures.amplitude_m;
        });
    const PolygonFit fit = fit_polygon(largest.loop);
    Loop centred = largest.loop;
    for (double& x : centred.position_m) x -= largest.position_m;
    const GuidewayPrediction found = predict(centred, fit.curve, from, to, wanted.force_ratio);
    const double k0 = fit.curve.initial_stiffness_N_per_m();
    result.experiment = "guideway";
    result.setup = wanted.log;
    result.headline =
        fmt::format("Predicted: F = {:.3g} N at {:.3g} µm, k0 = {:.3g} N/µm, damping ratio {:.2g} %.",
                    found.figures.force_N, 1e6 * found.figures.amplitude_m,
                    1e-6 * found.initial_stiffness_N_per_m, 100.0 * found.figures.damping_ratio);
    result.detail = fmt::format("Force × {:.4g}, displacement × {:.4g}, stiffness × {:.4g} ([2], eq. 19).",
                                found.scaling.force, found.scaling.displacement, found.scaling.stiffness());
    result.summary = {{"force_factor", found.scaling.force},
                      {"displacement_factor", found.scaling.displacement},
                      {"stiffness_factor", found.scaling.stiffness()},
                      {"initial_stiffness_N_per_m", found.initial_stiffness_N_per_m},
                      {"damping_ratio", found.figures.damping_ratio},
                      {"curve_relative_error", fit.relative_error}};
    result.tables.push_back(guideways_table(from, to, largest, k0, found));
    result.tables.push_back(damping_table(fit.curve, found.curve));
    result.charts.push_back(
        loops_chart("Loops", {{"measured", {{centred, 0.0, largest.count, 0, largest.figures, 0.0}}},
                              {"predicted", {{found.loop, 0.0, largest.count, 0, found.figures, 0.0}}}}));
  });
  if (from.material != to.material && wanted.force_ratio == 1.0) {
    result.notes.push_back(
        "Material: the damping ratio of steel is 22 % lower ([2]); the force level of other materials is not "
        "printed "
        "there and is left as it was. --force-ratio changes it.");
  }
  return result;
}

}  // namespace

void run_guideway(const std::string& command_line, const GuidewayOptions& wanted) {
  run_experiment(command_line, wanted.outputs, {wanted.log}, [&](Progress& progress) {
    progress.show("find the loops");
    return guideway_result(wanted);
  });
}

}  // namespace slipstack::workbench
