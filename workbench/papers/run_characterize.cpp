// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/text.h"
#include "workbench/papers/analysis/characterize.h"
#include "workbench/papers/experiments.h"
#include "workbench/papers/loop_tables.h"

namespace slipstack::workbench {
namespace {

/// [2], 4.4.2: typical values for design.
const std::vector<DampingPoint> kTypical{{1e-6, 0.021}, {2e-6, 0.03}, {10e-6, 0.06}};

RationalFit fit_of(const std::vector<AveragedLoop>& averaged) {
  std::vector<Loop> loops;
  loops.reserve(averaged.size());
  for (const AveragedLoop& loop : averaged) loops.push_back(loop.loop);
  return fit_rational(loops);
}

/// Largest difference of ζᵣ between the series, over the mean, loop by loop.
double damping_spread(const std::vector<LoopSeries>& series) {
  double spread = 0.0;
  for (std::size_t i = 0; i < series.front().loops.size(); ++i) {
    double least = HUGE_VAL;
    double most = 0.0;
    for (const LoopSeries& one : series) {
      if (i >= one.loops.size()) continue;
      least = std::min(least, one.loops[i].figures.damping_ratio);
      most = std::max(most, one.loops[i].figures.damping_ratio);
    }
    spread = std::max(spread, (most - least) / (0.5 * (most + least)));
  }
  return spread;
}

/// Tables and charts of loops, and the curve that was fitted to the first series.
ExperimentResult result_of(const std::vector<LoopSeries>& series, const std::string& title) {
  const RationalFit fit = fit_of(series.front().loops);
  const DisplayUnit unit = length_unit(fit.curve.length_m);
  ExperimentResult result;
  result.experiment = "characterize";
  result.setup = title;
  const auto& loops = series.front().loops;
  const auto [least, most] =
      std::minmax_element(loops.begin(), loops.end(), [](const AveragedLoop& a, const AveragedLoop& b) {
        return a.figures.amplitude_m < b.figures.amplitude_m;
      });
  result.headline = fmt::format("Damping ratio at resonance: {:.2g} % at {:.3g} µm, {:.2g} % at {:.3g} µm.",
                                100.0 * least->figures.damping_ratio, 1e6 * least->figures.amplitude_m,
                                100.0 * most->figures.damping_ratio, 1e6 * most->figures.amplitude_m);
  result.detail = fmt::format(
      "Virgin curve h0·(1 − (δ/(x+δ))²) by least squares: h0 = {:.4g} N, δ = {:.4g} {}, off by {:.2g} % of "
      "the "
      "force; k0 = {:.4g} N/µm.",
      fit.curve.level_N, fit.curve.length_m * unit.per_si, unit.label, 100.0 * fit.relative_error,
      1e-6 * fit.curve.initial_stiffness_N_per_m());
  result.summary = {{"level_N", fit.curve.level_N},
                    {"length_m", fit.curve.length_m},
                    {"relative_error", fit.relative_error},
                    {"initial_stiffness_N_per_m", fit.curve.initial_stiffness_N_per_m()}};
  if (series.size() > 1)
    result.summary.push_back({"damping_ratio_spread_over_preloads", damping_spread(series)});
  result.tables.push_back(figures_table(series, fit.curve));
  result.charts.push_back(loops_chart("Hysteresis loops", series));
  result.charts.push_back(damping_chart(series, fit.curve));
  if (fit.relative_error > 0.02) {
    result.notes.push_back("The closed forms are those of a curve that these loops do not follow well.");
  }
  return result;
}

/// The scaling law of [2] on the guideways of its authors: the loops before and after scaling.
void add_collapse(ExperimentResult& result, const sim::VirginCurve& curve, const LoopTest& test) {
  const BallContact reference;
  const auto tried = guideways_tried(curve, reference, test);
  ExperimentTable table{"scaling",
                        "Guideways as in [2]: one loop each before rolling, and scaled to 54 N, 90°, 6 mm",
                        {{"load_per_ball_N", "load", "N", 1.0, 3},
                         {"groove_angle_deg", "groove", "°", 1.0, 3},
                         {"ball_diameter_m", "ball", "mm", 1e3, 3},
                         {"amplitude_m", "A", "µm", 1e6, 4},
                         {"force_N", "F", "N", 1.0, 4},
                         {"scaled_amplitude_m", "A scaled", "µm", 1e6, 4},
                         {"scaled_force_N", "F scaled", "N", 1.0, 4},
                         {"damping_ratio", "ζ_r", "%", 100.0, 3}},
                        {}};
  std::vector<Loop> raw;
  std::vector<Loop> collapsed;
  std::vector<LoopSeries> drawn;
  for (const GuidewayLoop& one : tried) {
    raw.push_back(one.loop.loop);
    collapsed.push_back(scaled(one.loop.loop, scaling(one.contact, reference)));
    const LoopFigures then = figures_of(collapsed.back());
    const BallContact& of = one.contact;
    table.rows.push_back({of.load_per_ball_N, of.groove_angle_deg, of.ball_diameter_m,
                          one.loop.figures.amplitude_m, one.loop.figures.force_N, then.amplitude_m,
                          then.force_N, one.loop.figures.damping_ratio});
    const std::string name = fmt::format("{:.3g} N, {:.3g}°, {:.3g} mm", of.load_per_ball_N,
                                         of.groove_angle_deg, 1e3 * of.ball_diameter_m);
    drawn.push_back({name, {{collapsed.back(), 0.0, one.loop.count, 0, then, 0.0}}});
  }
  const double apart = loop_spread(raw);
  const double together = loop_spread(collapsed);
  result.summary.push_back({"loop_spread", apart});
  result.summary.push_back({"loop_spread_scaled", together});
  result.tables.push_back(std::move(table));
  result.charts.push_back(
      loops_chart("Loops of all guideways, scaled by load, groove angle and ball", drawn));
  result.notes.push_back(fmt::format(
      "The scaling law brings the loops of eight guideways from {:.2g} % of the force apart to {:.2g} %.",
      100.0 * apart, 100.0 * together));
}

ExperimentResult simulated(const CharacterizeOptions& wanted, Progress& progress) {
  const sim::ExperimentSetup setup = wanted.setup.axis();
  LoopTest test = loop_test_of(setup);
  sim::VirginCurve curve = setup.axis.curve;
  if (wanted.typical) {
    curve = curve_of_damping(kTypical, curve.force_N(10e-6));
    test.amplitudes_m = {1e-6, 2e-6, 5e-6, 10e-6};
    test.encoder_resolution_m = std::min(test.encoder_resolution_m, 1e-9);
    test.force_noise_N = std::min(test.force_noise_N, 1e-3 * curve.force_N(10e-6));
  }
  ExperimentResult result;
  prefix_errors(wanted.setup.name, [&] {
    progress.show("loops at every preload");
    std::vector<LoopSeries> series;
    for (auto& one : characterize_preloads(curve, test, wanted.preloads)) {
      series.push_back({fmt::format("preload × {:.3g}", one.preload), std::move(one.loops)});
    }
    result = result_of(
        series, wanted.typical ? setup.title + ", virgin curve of the typical ζ_r of [2]" : setup.title);
    if (series.size() > 1) {
      result.notes.push_back(
          fmt::format("ζ_r at {} preloads: at most {:.2g} % of it apart; stiffness and damping go with the "
                      "root of the preload.",
                      series.size(), 100.0 * damping_spread(series)));
    }
    if (wanted.typical) {
      result.notes.push_back(
          "Typical values of [2]: 2.1 % at 1 µm, 3 % at 2 µm, 6 % at 10 µm. The rational curve "
          "cannot pass through them; a sum of such curves does.");
      return;
    }
    if (test.encoder_resolution_m > 0.01 * curve.travel_m()) {
      result.notes.push_back(
          "The encoder is too coarse for loops of smaller balls: no comparison of guideways.");
      return;
    }
    progress.show("loops of other guideways");
    add_collapse(result, curve, test);
  });
  return result;
}

}  // namespace

void run_characterize(const std::string& command_line, const CharacterizeOptions& wanted) {
  const bool measured = !wanted.log.empty();
  const std::vector<std::string> inputs = measured ? std::vector{wanted.log} : wanted.setup.inputs();
  run_experiment(command_line, wanted.outputs, inputs, [&](Progress& progress) {
    if (!measured) return simulated(wanted, progress);
    progress.show("find the loops");
    const std::vector<LoopSeries> series{{"log", loops_of_log(wanted.log)}};
    ExperimentResult result;
    prefix_errors(wanted.log, [&] { result = result_of(series, wanted.log); });
    return result;
  });
}

}  // namespace slipstack::workbench
