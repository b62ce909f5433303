// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "sim_host/experiments/guideway.h"
#include "workbench/base/text.h"
#include "workbench/log/log.h"
#include "workbench/papers/experiment.h"
#include "workbench/papers/loop_tables.h"
#include "workbench/papers/options.h"

namespace slipstack::workbench {
namespace {

constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

/// A guideway as the command line gives it; what is left out comes from elsewhere.
struct GivenContact {
  double load_N = kNotGiven;
  double angle_deg = kNotGiven;
  double diameter_m = kNotGiven;
  double balls = kNotGiven;
  std::string material;
};

struct GuidewayOptions {
  std::string log;
  GivenContact from;
  GivenContact to;
  double force_ratio = 1.0;
  ExperimentOutputs outputs;
};

sim::BallMaterial material_named(const std::string& word, const std::string& where) {
  const auto material = sim::ball_material(word);
  if (!material) {
    throw UsageError(fmt::format("{}: unknown material {}; known: steel, silicon_nitride, diamond_coated",
                                 printable(where), in_quotes(word)));
  }
  return *material;
}

/// The measured guideway: the command line over the log's header; refuses what neither says.
sim::BallContact measured_contact(const Log& log, const GivenContact& given) {
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
  sim::BallContact contact;
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

sim::BallContact wanted_contact(const sim::BallContact& from, const GivenContact& given) {
  sim::BallContact to = from;
  if (!std::isnan(given.load_N)) to.load_per_ball_N = given.load_N;
  if (!std::isnan(given.angle_deg)) to.groove_angle_deg = given.angle_deg;
  if (!std::isnan(given.diameter_m)) to.ball_diameter_m = given.diameter_m;
  if (!std::isnan(given.balls)) to.balls = given.balls;
  if (!given.material.empty()) to.material = material_named(given.material, "--to-material");
  return to;
}

ExperimentTable guideways_table(const sim::BallContact& from, const sim::BallContact& to,
                                const sim::AveragedLoop& measured, double k0,
                                const sim::GuidewayPrediction& found) {
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
  const auto row = [&](const std::string& name, const sim::BallContact& of, const sim::LoopFigures& is,
                       double stiffness) {
    table.rows.push_back({name, of.load_per_ball_N, of.groove_angle_deg, of.ball_diameter_m, of.balls,
                          std::string(sim::name(of.material)), is.amplitude_m, is.force_N, stiffness,
                          is.stiffness_N_per_m, is.damping_ratio});
  };
  row("measured", from, measured.figures, k0);
  row("predicted", to, found.figures, found.initial_stiffness_N_per_m);
  return table;
}

/// ζᵣ of both at the same amplitudes: that is what the designer compares.
ExperimentTable damping_table(const sim::PolygonCurve& measured, const sim::PolygonCurve& predicted) {
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
    const sim::LoopFigures a = sim::figures_of(sim::masing_loop(measured, A, 1000));
    const sim::LoopFigures b = sim::figures_of(sim::masing_loop(predicted, A, 1000));
    table.rows.push_back({A, a.damping_ratio, b.damping_ratio, a.stiffness_N_per_m, b.stiffness_N_per_m});
  }
  return table;
}

ExperimentResult guideway_result(const GuidewayOptions& wanted) {
  const Log log = read_log(wanted.log);
  const sim::BallContact from = measured_contact(log, wanted.from);
  const sim::BallContact to = wanted_contact(from, wanted.to);
  ExperimentResult result;
  said_of(wanted.log, [&] {
    const auto loops = sim::averaged_loops(log.position_m, log.force_N);
    const auto& largest = *std::max_element(loops.begin(), loops.end(),
                                            [](const sim::AveragedLoop& a, const sim::AveragedLoop& b) {
                                              return a.figures.amplitude_m < b.figures.amplitude_m;
                                            });
    const sim::PolygonFit fit = sim::fit_polygon(largest.loop);
    sim::Loop centred = largest.loop;
    for (double& x : centred.position_m) x -= largest.position_m;
    const sim::GuidewayPrediction found = sim::predict(centred, fit.curve, from, to, wanted.force_ratio);
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

void add_contact(CLI::App& command, const std::string& prefix, GivenContact& contact,
                 const std::string& whose) {
  const auto number = [&](const std::string& name, double& value, const std::string& kind,
                          const std::string& what) {
    command.add_option("--" + prefix + name, value, what + whose)->type_name(kind);
  };
  number("load-N", contact.load_N, "N", "load per ball");
  number("groove-angle-deg", contact.angle_deg, "DEG", "angle of the V-groove");
  number("ball-diameter-m", contact.diameter_m, "M", "ball diameter");
  number("balls", contact.balls, "COUNT", "number of balls");
  add_word(command, "--" + prefix + "material", contact.material, "NAME",
           "steel, silicon_nitride or diamond_coated" + whose);
}

}  // namespace

void define_guideway(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command =
      experiment.add_subcommand("guideway", "From one measured loop to the loop of another guideway ([2])");
  auto wanted = std::make_shared<GuidewayOptions>();
  add_word(*command, "LOG", wanted->log, "FILE", "measured loops; the largest is taken")->required();
  add_contact(*command, "", wanted->from, ", measured (default: the log's header)");
  add_contact(*command, "to-", wanted->to, ", asked for (default: as measured)");
  command->add_option("--force-ratio", wanted->force_ratio, "force level of the new material over the old")
      ->capture_default_str();
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] {
    deliver(command_line, wanted->outputs, {wanted->log}, [&](Progress& progress) {
      progress.show("find the loops");
      return guideway_result(*wanted);
    });
  });
}

}  // namespace slipstack::workbench
