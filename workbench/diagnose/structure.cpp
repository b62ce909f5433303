// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/structure.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include "workbench/diagnose/quantity.h"
#include "workbench/identify/spectrum.h"

namespace slipstack::workbench {
namespace {

/// Knots of a free curve; each holds at least this many rows, so that noise alone explains little.
constexpr int kKnots = 40;
/// Rows of one piece when pieces are dealt in turn to fitting and judging: longer than the filter's memory.
constexpr Eigen::Index kPieceRows = 24;

/// Regressors with few entries a row, as a dense matrix: rows are at most some tens of thousands.
struct Judged {
  double error_reduction = 0.0;
  Eigen::VectorXd explained;
};

/// Ridge regression of the residual on `columns`, each half of the pieces judged by the other half.
Judged judge(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual) {
  const Eigen::Index count = columns.cols();
  std::array<Eigen::MatrixXd, 2> gram{Eigen::MatrixXd::Zero(count, count),
                                      Eigen::MatrixXd::Zero(count, count)};
  std::array<Eigen::VectorXd, 2> right{Eigen::VectorXd::Zero(count), Eigen::VectorXd::Zero(count)};
  for (Eigen::Index first = 0; first < columns.rows(); first += kPieceRows) {
    const Eigen::Index rows = std::min(kPieceRows, columns.rows() - first);
    const auto half = static_cast<std::size_t>(first / kPieceRows % 2);
    const auto part = columns.middleRows(first, rows);
    gram[half].noalias() += part.transpose() * part;
    right[half].noalias() += part.transpose() * residual.segment(first, rows);
  }
  const auto solve = [&](const Eigen::MatrixXd& normal, const Eigen::VectorXd& b) {
    Eigen::MatrixXd regular = normal;
    regular.diagonal().array() += 1.0 + 1e-6 * normal.diagonal().maxCoeff();
    return Eigen::VectorXd(regular.ldlt().solve(b));
  };
  const std::array<Eigen::VectorXd, 2> value{solve(gram[0], right[0]), solve(gram[1], right[1])};
  double error = 0.0;
  for (Eigen::Index first = 0; first < columns.rows(); first += kPieceRows) {
    const Eigen::Index rows = std::min(kPieceRows, columns.rows() - first);
    const auto other = static_cast<std::size_t>(1 - first / kPieceRows % 2);
    error += (residual.segment(first, rows) - columns.middleRows(first, rows) * value[other]).squaredNorm();
  }
  const double whole = std::max(residual.squaredNorm(), 1e-300);
  return {1.0 - std::sqrt(error / whole), columns * solve(gram[0] + gram[1], right[0] + right[1])};
}

/// Hat functions over the coordinate, knots at its quantiles so that each is supported by data.
Eigen::MatrixXd free_curve(const Eigen::VectorXd& coordinate) {
  std::vector<double> sorted(coordinate.begin(), coordinate.end());
  std::sort(sorted.begin(), sorted.end());
  std::vector<double> knots;
  for (int k = 0; k <= kKnots; ++k) {
    const double t = static_cast<double>(k) / kKnots;
    const double by_rank = sorted[static_cast<std::size_t>(t * static_cast<double>(sorted.size() - 1))];
    const double by_range = sorted.front() + t * (sorted.back() - sorted.front());
    // Half by quantile, half by range: neither a long dwell nor an empty stretch takes all knots.
    knots.push_back(0.5 * (by_rank + by_range));
  }
  knots.erase(std::unique(knots.begin(), knots.end()), knots.end());
  const auto count = static_cast<Eigen::Index>(knots.size());
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(coordinate.size(), count);
  for (Eigen::Index row = 0; row < coordinate.size(); ++row) {
    const double c = coordinate(row);
    const auto above = std::upper_bound(knots.begin(), knots.end(), c) - knots.begin();
    if (above == 0) {
      columns(row, 0) = 1.0;
    } else if (above == count) {
      columns(row, count - 1) = 1.0;
    } else {
      const auto i = static_cast<std::size_t>(above);
      const double t = (c - knots[i - 1]) / (knots[i] - knots[i - 1]);
      columns(row, above - 1) = 1.0 - t;
      columns(row, above) = t;
    }
  }
  return columns;
}

Eigen::VectorXd at_rows(const Measurement& measurement, const std::vector<double>& per_sample) {
  Eigen::VectorXd values(measurement.row_count());
  for (Eigen::Index row = 0; row < values.size(); ++row) {
    values(row) = per_sample[measurement.row_samples()[static_cast<std::size_t>(row)]];
  }
  return values;
}

Eigen::VectorXd row_times(const Measurement& measurement) {
  Eigen::VectorXd times(measurement.row_count());
  for (Eigen::Index row = 0; row < times.size(); ++row) {
    times(row) =
        static_cast<double>(measurement.row_samples()[static_cast<std::size_t>(row)]) * measurement.tick_s();
  }
  return times;
}

Structure over(const std::string& coordinate, const std::string& unit, const Eigen::VectorXd& values,
               const Eigen::VectorXd& residual) {
  const Judged judged = judge(free_curve(values), residual);
  Eigen::Index peak = 0;
  judged.explained.cwiseAbs().maxCoeff(&peak);
  return {coordinate, judged.error_reduction, values(peak),
          fmt::format("what is left depends on {}: {} at {}", coordinate,
                      quantity(judged.explained(peak), "N"), quantity(values(peak), unit)),
          judged.explained};
}

/// A line of constant frequency and phase.
Structure line_in_time(const Measurement& measurement, const Eigen::VectorXd& residual) {
  const double rate_Hz = measurement.sample_rate_Hz() / static_cast<double>(measurement.row_stride());
  const Eigen::VectorXd times = row_times(measurement);
  const std::span<const double> rows(residual.data(), static_cast<std::size_t>(residual.size()));
  const Spectrum spectrum = power_spectrum(rows, rate_Hz, 1024);
  Structure best{"frequency", 0.0, 0.0, "", Eigen::VectorXd::Zero(residual.size())};
  if (spectrum.density.empty()) return best;
  std::size_t peak = 2;
  for (std::size_t k = 2; k < spectrum.density.size(); ++k) {
    if (spectrum.density[k] > spectrum.density[peak]) peak = k;
  }
  // The phase must hold over the whole log: steps of a third of a turn over its length around the peak.
  const double step_Hz = 0.3 / measurement.duration_s();
  const double width_Hz = spectrum.frequency_Hz[1];
  const auto columns_at = [&](double frequency_Hz) {
    Eigen::MatrixXd columns(residual.size(), 2);
    const Eigen::ArrayXd phase = 2.0 * std::numbers::pi * frequency_Hz * times.array();
    columns.col(0) = phase.cos();
    columns.col(1) = phase.sin();
    return columns;
  };
  double strongest = 0.0;
  double frequency_Hz = spectrum.frequency_Hz[peak];
  for (double f = spectrum.frequency_Hz[peak] - width_Hz; f <= spectrum.frequency_Hz[peak] + width_Hz;
       f += step_Hz) {
    const double power = (columns_at(f).transpose() * residual).squaredNorm();
    if (power > strongest) {
      strongest = power;
      frequency_Hz = f;
    }
  }
  const Judged judged = judge(columns_at(frequency_Hz), residual);
  best.error_reduction = judged.error_reduction;
  best.where = frequency_Hz;
  best.explained_N = judged.explained;
  best.description =
      fmt::format("what is left is a line in time at {}, amplitude {}, whatever the motion",
                  quantity(frequency_Hz, "Hz"), quantity(judged.explained.cwiseAbs().maxCoeff(), "N"));
  return best;
}

/// Energy that sits in a few rows: an event, not an effect.
Structure event_in_time(const Measurement& measurement, const Eigen::VectorXd& residual) {
  std::vector<double> energy(static_cast<std::size_t>(residual.size()));
  for (Eigen::Index row = 0; row < residual.size(); ++row) {
    energy[static_cast<std::size_t>(row)] = residual(row) * residual(row);
  }
  const double whole = std::accumulate(energy.begin(), energy.end(), 1e-300);
  const auto loudest = std::max_element(energy.begin(), energy.end()) - energy.begin();
  std::vector<double> sorted = energy;
  const auto few = static_cast<std::ptrdiff_t>(sorted.size() / 100);
  std::nth_element(sorted.begin(), sorted.begin() + few, sorted.end(), std::greater<>());
  const double share = std::accumulate(sorted.begin(), sorted.begin() + few, 0.0) / whole;
  // One per cent of Gaussian rows holds 8.6 % of the energy.
  // What quantisation leaves at reversals holds some 30 %.
  constexpr double kUsual = 0.35;
  const double excess = std::max(0.0, (share - kUsual) / (1.0 - kUsual));
  const Eigen::VectorXd times = row_times(measurement);
  const double time_s = times(static_cast<Eigen::Index>(loudest));
  return {"time", 1.0 - std::sqrt(1.0 - excess), time_s,
          fmt::format("what is left sits in few moments: 1 % of the time holds {:.0f} % of it, most at {}",
                      100.0 * share, quantity(time_s, "s")),
          residual};
}

}  // namespace

std::vector<Structure> find_structure(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  std::vector<Structure> found;
  found.push_back(over("position", "m", at_rows(measurement, measurement.position_m()), residual_N));
  found.push_back(over("velocity", "m/s", at_rows(measurement, measurement.velocity_mps()), residual_N));
  found.push_back(
      over("acceleration", "m/s2", at_rows(measurement, measurement.acceleration_mps2()), residual_N));
  found.push_back(over("time", "s", row_times(measurement), residual_N));
  found.push_back(line_in_time(measurement, residual_N));
  Structure event = event_in_time(measurement, residual_N);
  if (event.error_reduction > found[3].error_reduction) found[3] = std::move(event);
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return a.error_reduction > b.error_reduction; });
  return found;
}

}  // namespace slipstack::workbench
