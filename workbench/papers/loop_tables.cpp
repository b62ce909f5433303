// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/loop_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "workbench/log/log.h"
#include "workbench/papers/experiment.h"

namespace slipstack::workbench {
namespace {

double largest_amplitude(const std::vector<LoopSeries>& series) {
  double largest = 0.0;
  for (const LoopSeries& one : series) {
    for (const AveragedLoop& loop : one.loops) largest = std::max(largest, loop.figures.amplitude_m);
  }
  return largest;
}

}  // namespace

std::vector<AveragedLoop> loops_of_log(const std::string& path) {
  const Log log = read_guideway_log(path);
  std::vector<AveragedLoop> loops;
  prefix_errors(path, [&] { loops = averaged_loops(log.position_m, log.force_N); });
  return loops;
}

ExperimentTable figures_table(const std::vector<LoopSeries>& series, const RationalCurve& curve) {
  const DisplayUnit unit = length_unit(largest_amplitude(series));
  ExperimentTable table{"loops",
                        "Loops, and the closed forms of the fitted curve ([2], eqs. 15 to 17)",
                        {{"series", "loops", "", 1.0, 4},
                         {"amplitude_m", "A", unit.label, unit.per_si, 4},
                         {"force_N", "F", "N", 1.0, 4},
                         {"averaged", "mean of", "", 1.0, 0},
                         {"stiffness_N_per_m", "k_e", "N/µm", 1e-6, 4},
                         {"fundamental_stiffness_N_per_m", "a1/A", "N/µm", 1e-6, 4},
                         {"closed_stiffness_N_per_m", "closed", "N/µm", 1e-6, 4},
                         {"damping_N_per_m", "c_e·ω", "N/µm", 1e-6, 3},
                         {"closed_damping_N_per_m", "closed", "N/µm", 1e-6, 3},
                         {"damping_ratio", "ζ_r", "%", 100.0, 3},
                         {"damping_ratio_spread", "±", "%", 100.0, 2},
                         {"closed_damping_ratio", "closed", "%", 100.0, 3}},
                        {}};
  for (const LoopSeries& one : series) {
    for (const AveragedLoop& loop : one.loops) {
      const LoopFigures& is = loop.figures;
      // The curve is that of the first series; another preload scales stiffness and damping, not their ratio.
      const LoopFigures closed = curve.closed_form(is.amplitude_m);
      const bool same = &one == &series.front();
      const double none = std::numeric_limits<double>::quiet_NaN();
      table.rows.push_back({one.name, is.amplitude_m, is.force_N, static_cast<double>(loop.count),
                            is.stiffness_N_per_m, is.fundamental_stiffness_N_per_m,
                            same ? closed.stiffness_N_per_m : none, is.damping_N_per_m,
                            same ? closed.damping_N_per_m : none, is.damping_ratio, loop.damping_ratio_spread,
                            closed.damping_ratio});
    }
  }
  return table;
}

ExperimentChart loops_chart(const std::string& title, const std::vector<LoopSeries>& series) {
  const DisplayUnit unit = length_unit(largest_amplitude(series));
  ExperimentChart chart{
      title, {"Position", unit.label, unit.per_si, false}, {"Force", "N", 1.0, false}, {}, {}, true};
  for (std::size_t i = 0; i < series.size(); ++i) {
    const LoopSeries& one = series[i];
    for (const AveragedLoop& loop : one.loops) {
      ChartCurve curve{one.name, loop.loop.force_N, {}, palette_role(i), false};
      if (series.size() == 1) {
        curve.name += fmt::format(", {:.3g} {}", loop.figures.amplitude_m * unit.per_si, unit.label);
        curve.role.clear();
      }
      for (const double x : loop.loop.position_m) curve.x.push_back(x - loop.position_m);
      curve.x.push_back(curve.x.front());
      curve.y.push_back(curve.y.front());
      chart.curves.push_back(std::move(curve));
    }
  }
  return chart;
}

ExperimentChart damping_chart(const std::vector<LoopSeries>& series, const RationalCurve& curve) {
  const DisplayUnit unit = length_unit(largest_amplitude(series));
  ExperimentChart chart{"Damping ratio at resonance",
                        {"Amplitude", unit.label, unit.per_si, true},
                        {"ζ_r", "%", 100.0, false},
                        {},
                        {},
                        false};
  // One x for all: every series is drawn over the range of its loops, linear between them.
  std::set<double> places;
  for (const LoopSeries& one : series) {
    for (const AveragedLoop& loop : one.loops) places.insert(loop.figures.amplitude_m);
  }
  chart.x.assign(places.begin(), places.end());
  for (const LoopSeries& one : series) {
    ChartCurve line{one.name, {}, {}, "", false};
    std::vector<std::pair<double, double>> points;
    for (const AveragedLoop& loop : one.loops) {
      points.emplace_back(loop.figures.amplitude_m, loop.figures.damping_ratio);
    }
    std::sort(points.begin(), points.end());
    for (const double x : chart.x) {
      const auto above = std::lower_bound(points.begin(), points.end(), std::pair(x, -1.0));
      if (above == points.end() || (above == points.begin() && above->first > x)) {
        line.y.push_back(std::numeric_limits<double>::quiet_NaN());
        continue;
      }
      if (above->first == x || above == points.begin()) {
        line.y.push_back(above->second);
        continue;
      }
      const auto below = above - 1;
      const double share = std::log(x / below->first) / std::log(above->first / below->first);
      line.y.push_back(below->second + share * (above->second - below->second));
    }
    chart.curves.push_back(std::move(line));
  }
  ChartCurve closed{"closed form", {}, {}, "reference", false};
  for (const double x : chart.x) closed.y.push_back(curve.closed_form(x).damping_ratio);
  chart.curves.push_back(std::move(closed));
  return chart;
}

}  // namespace slipstack::workbench
