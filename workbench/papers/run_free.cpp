// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "sim_host/experiments/free_response.h"
#include "workbench/papers/experiments.h"

namespace slipstack::workbench {
namespace {

ExperimentTable turning_points_table(const sim::FreeResponse& found, const DisplayUnit& unit) {
  ExperimentTable table{
      "turning_points",
      "Turning points",
      {{"number", "#", "", 1.0, 0},
       {"time_s", "time", "ms", 1e3, 6},
       {"position_m", "position", unit.label, unit.per_si, 6},
       {"hysteresis_N", "hysteresis", "N", 1.0, 6},
       {"check_m", found.exact ? "energy balance" : "coarser steps", unit.label, unit.per_si, 6},
       {"difference", "difference", "", 1.0, 2}},
      {}};
  const double scale_m = found.position_m.front();
  for (std::size_t i = 0; i < found.turning_points.size(); ++i) {
    const sim::TurningPoint& point = found.turning_points[i];
    table.rows.push_back({static_cast<double>(i + 1), point.time_s, point.position_m, point.force_N,
                          point.check_m, std::fabs(point.position_m - point.check_m) / scale_m});
  }
  return table;
}

// The middle of the last swing; without oscillation the last position.
double rest_place_m(const sim::FreeResponse& found) {
  if (found.turning_points.size() < 2) return found.position_m.back();
  return 0.5 * (found.turning_points.back().position_m +
                found.turning_points[found.turning_points.size() - 2].position_m);
}

std::string how_exact(const sim::FreeResponse& found, double worst) {
  if (found.exact) {
    return fmt::format(
        "Every swing ends where the energy balance of its branch says, within {:.1e} of the release; "
        "the energy audit closes to {:.1e}.",
        worst, std::fabs(found.imbalance_J) / found.start_energy_J);
  }
  return fmt::format(
      "Integrated with the set-up's other effects; steps a hundred times coarser in error turn round "
      "within {:.1e} of the release of the same places.",
      worst);
}

ExperimentResult free_result(const sim::ExperimentSetup& setup, const sim::FreeResponse& found) {
  const DisplayUnit unit = length_unit(found.position_m.front());
  ExperimentResult result;
  result.experiment = "free";
  result.setup = setup.title;
  double worst = 0.0;
  for (const sim::TurningPoint& point : found.turning_points) {
    worst = std::max(worst, std::fabs(point.position_m - point.check_m) / found.position_m.front());
  }
  const double rest_m = rest_place_m(found);
  result.headline =
      fmt::format("Let go from {:.4g} {}, it comes to rest near {:.4g} {}, not at zero.",
                  found.position_m.front() * unit.per_si, unit.label, rest_m * unit.per_si, unit.label);
  result.detail = how_exact(found, worst);
  result.summary = {
      {"release_m", found.position_m.front()}, {"rest_m", rest_m}, {"worst_turn_difference", worst}};
  if (found.exact) {
    result.summary.push_back({"energy_imbalance", std::fabs(found.imbalance_J) / found.start_energy_J});
  }
  result.tables.push_back(turning_points_table(found, unit));
  result.charts.push_back(motion_chart("Free response", found.time_s, found.position_m, unit));
  return result;
}

}  // namespace

void run_free(const std::string& command_line, const FreeOptions& wanted) {
  run_experiment(command_line, wanted.outputs, wanted.setup.inputs(), [&](Progress& progress) {
    const sim::ExperimentSetup setup = wanted.setup.axis();
    const double release_m = wanted.release_m != 0.0 ? wanted.release_m : setup.defaults.release_m;
    progress.show("free response");
    return free_result(setup,
                       sim::run_free(setup, release_m, static_cast<std::size_t>(wanted.turning_points)));
  });
}

}  // namespace slipstack::workbench
