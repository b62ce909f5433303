// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/views/loop_damping.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <stdexcept>

#include "workbench/base/axis_units.h"
#include "workbench/papers/analysis/loop_figures.h"
#include "workbench/papers/analysis/loop_log.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

constexpr double kLargestAmplitude_m = 2e-4;  // as the pre-sliding loops that are drawn (report/pictures.cpp)
constexpr double kClosed = 0.05;              // of the height; as in loop_log.h
constexpr double kOneAmplitude = 1.1;         // largest over smallest of one group; chosen
constexpr std::size_t kFewestRows = 8;        // of a loop: the rows then have its third harmonic
constexpr int kFiner = 8;                     // points for each row

struct OneLoop {
  double amplitude_m = 0.0;
  std::vector<double> ratio;
};

/// Rows with points between them, by cubics that pass through the rows (Catmull and Rom): the rows are
/// filtered, and the polygon through a dozen of them would miss a tenth of the area.
std::vector<double> finer(const Eigen::VectorXd& all, const RowRange& rows) {
  std::vector<double> points;
  points.reserve(static_cast<std::size_t>(kFiner * rows.count));
  const auto at = [&all](Eigen::Index row) { return all(std::clamp<Eigen::Index>(row, 0, all.size() - 1)); };
  for (Eigen::Index row = rows.first; row < rows.first + rows.count; ++row) {
    const double before = at(row - 1), from = at(row), to = at(row + 1), after = at(row + 2);
    for (int k = 0; k < kFiner; ++k) {
      const double u = static_cast<double>(k) / kFiner;
      points.push_back(from + 0.5 * u *
                                  (to - before +
                                   u * (2.0 * before - 5.0 * from + 4.0 * to - after +
                                        u * (3.0 * (from - to) + after - before))));
    }
  }
  return points;
}

std::optional<OneLoop> loop_of(const Eigen::VectorXd& position_m,
                               const std::vector<Eigen::VectorXd>& forces_N, const RowRange& rows) {
  OneLoop found;
  for (const Eigen::VectorXd& force_N : forces_N) {
    try {
      const LoopFigures figures = figures_of({finer(position_m, rows), finer(force_N, rows)});
      found.amplitude_m = figures.amplitude_m;
      found.ratio.push_back(figures.damping_ratio);
    } catch (const std::invalid_argument&) {
      return std::nullopt;
    }
  }
  return found;
}

std::vector<OneLoop> loops_in(const Measurement& measurement, const std::vector<Eigen::VectorXd>& forces_N) {
  const Eigen::VectorXd position_m = measurement.filtered(measurement.position_m());
  const Eigen::VectorXd& usable = measurement.row_usable();
  std::vector<OneLoop> loops;
  for (const LogPart& part : measurement.parts()) {
    if (part.row_count < kFewestRows) continue;
    const std::span<const double> positions(position_m.data() + part.first_row, part.row_count);
    const double threshold_m =
        std::max(motion_threshold_m(positions), 4.0 * measurement.encoder_resolution_m());
    const std::vector<std::size_t> turns = turning_points(positions, threshold_m);
    for (std::size_t i = 0; i + 2 < turns.size(); ++i) {
      const double begin_m = positions[turns[i]];
      const double height_m = std::abs(positions[turns[i + 1]] - begin_m);
      const std::size_t count = turns[i + 2] - turns[i];
      if (height_m > axis_length(2.0 * kLargestAmplitude_m) || count < kFewestRows) continue;
      if (std::abs(positions[turns[i + 2]] - begin_m) > kClosed * height_m) continue;
      const RowRange rows{static_cast<Eigen::Index>(part.first_row + turns[i]),
                          static_cast<Eigen::Index>(count)};
      if (usable.segment(rows.first, rows.count).minCoeff() == 0.0) continue;
      if (auto loop = loop_of(position_m, forces_N, rows)) loops.push_back(std::move(*loop));
    }
  }
  std::sort(loops.begin(), loops.end(),
            [](const OneLoop& a, const OneLoop& b) { return a.amplitude_m < b.amplitude_m; });
  return loops;
}

LoopDamping mean_of(std::span<const OneLoop> loops) {
  LoopDamping mean;
  mean.loops = loops.size();
  const auto count = static_cast<double>(loops.size());
  for (const OneLoop& loop : loops) mean.amplitude_m += loop.amplitude_m / count;
  for (std::size_t force = 0; force < loops.front().ratio.size(); ++force) {
    double sum = 0.0;
    for (const OneLoop& loop : loops) sum += loop.ratio[force];
    double squares = 0.0;
    for (const OneLoop& loop : loops) squares += std::pow(loop.ratio[force] - sum / count, 2);
    mean.ratio.push_back(sum / count);
    mean.deviation.push_back(std::sqrt(squares / std::max(count - 1.0, 1.0)));
  }
  return mean;
}

}  // namespace

std::vector<LoopDamping> loop_damping(const Measurement& measurement,
                                      const std::vector<Eigen::VectorXd>& forces_N) {
  const std::vector<OneLoop> loops = loops_in(measurement, forces_N);
  std::vector<LoopDamping> groups;
  for (std::size_t first = 0; first < loops.size();) {
    std::size_t end = first + 1;
    while (end < loops.size() && loops[end].amplitude_m <= kOneAmplitude * loops[first].amplitude_m) ++end;
    groups.push_back(mean_of(std::span(loops).subspan(first, end - first)));
    first = end;
  }
  return groups;
}

void add_loop_damping(json& data, const Measurement& measurement, const Eigen::VectorXd& inertia_N,
                      const ForceRows& before, const ForceRows* after) {
  std::vector<Eigen::VectorXd> forces_N{before.measured_N - inertia_N, before.model_N - inertia_N};
  if (after != nullptr) forces_N.emplace_back(after->model_N - inertia_N);
  const std::vector<LoopDamping> groups = loop_damping(measurement, forces_N);
  if (groups.empty()) return;
  json damping = {{"amplitude_m", json::array()},
                  {"measured", json::array()},
                  {"deviation", json::array()},
                  {"model", json::array()},
                  {"loops", json::array()}};
  for (const LoopDamping& group : groups) {
    damping["amplitude_m"].push_back(group.amplitude_m);
    damping["measured"].push_back(group.ratio[0]);
    damping["deviation"].push_back(group.deviation[0]);
    damping["model"].push_back(group.ratio[1]);
    if (after != nullptr) damping["after"].push_back(group.ratio[2]);
    damping["loops"].push_back(group.loops);
  }
  data["damping"] = std::move(damping);
}

}  // namespace slipstack::workbench
