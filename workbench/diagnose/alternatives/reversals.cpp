// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/reversals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "workbench/base/quantity.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {
namespace {

/// A reversal counts where the signal has left zero by this share of its rms on both sides.
constexpr double kLeavesZero = 0.1;
/// Lengths of what follows a reversal, that are tried [s].
constexpr double kLasting_s[] = {0.01, 0.02, 0.04, 0.08};
/// More rows than this, and what follows reversals is most of the log.
constexpr double kMostRows = 0.4;
/// Fewest reversals, and the share of them that must be needed for half of the energy.
constexpr std::size_t kFewestReversals = 10;
constexpr double kSpread = 0.05;
/// The same of the log's stretches that have reversals: a burst of noise crosses zero as often as it likes,
/// but all in one stretch, or over the border of two.
constexpr Eigen::Index kIntervals = 50;
constexpr double kSpreadInTime = 0.1;
constexpr std::ptrdiff_t kMoreThanOne = 3;

/// Rows at which a signal changes sign.
std::vector<Eigen::Index> sign_changes(const Eigen::VectorXd& signal) {
  const double rms =
      std::sqrt(signal.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, signal.size())));
  const double away = kLeavesZero * rms;
  std::vector<Eigen::Index> rows;
  double side = 0.0;
  Eigen::Index crossed = 0;
  for (Eigen::Index row = 0; row < signal.size(); ++row) {
    if (row > 0 && (signal(row) >= 0.0) != (signal(row - 1) >= 0.0)) crossed = row;
    if (std::abs(signal(row)) < away) continue;
    const double now = signal(row) > 0.0 ? 1.0 : -1.0;
    if (side != 0.0 && now != side) rows.push_back(crossed);
    side = now;
  }
  return rows;
}

/// Whether half of the energy needs more than a share of those that have any.
bool spread(std::vector<double> energies, double share) {
  std::sort(energies.begin(), energies.end(), std::greater<>());
  const double half = 0.5 * std::accumulate(energies.begin(), energies.end(), 0.0);
  double sum = 0.0;
  std::ptrdiff_t count = 0;
  while (count < std::ssize(energies) && sum < half) sum += energies[static_cast<std::size_t>(count++)];
  const auto any = std::count_if(energies.begin(), energies.end(), [](double one) { return one > 0.0; });
  return count >= kMoreThanOne && static_cast<double>(count) >= share * static_cast<double>(any);
}

}  // namespace

Structure after_reversals(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  Structure best{Coordinate::reversal, 0.0, 0.0, "", Eigen::VectorXd::Zero(residual_N.size())};
  const double whole = residual_N.squaredNorm();
  if (!(whole > 0.0)) return best;
  const double row_s = measurement.tick_s() * static_cast<double>(measurement.row_stride());
  // The filter spreads a knock to both sides.
  const auto smear = static_cast<Eigen::Index>(std::ceil(0.5 / (measurement.bandwidth_Hz() * row_s)));
  const std::pair<const char*, Eigen::VectorXd> signals[] = {
      {"velocity", at_rows(measurement, measurement.velocity_mps())},
      {"acceleration", at_rows(measurement, measurement.acceleration_mps2())},
      {"force", measurement.force_N()}};
  for (const auto& [name, signal] : signals) {
    const std::vector<Eigen::Index> changes = sign_changes(signal);
    if (changes.size() < kFewestReversals) continue;
    for (const double lasting_s : kLasting_s) {
      const auto length = std::max<Eigen::Index>(1, static_cast<Eigen::Index>(lasting_s / row_s)) + smear;
      std::vector<double> energies;
      energies.reserve(changes.size());
      std::vector<double> by_interval(kIntervals, 0.0);
      Eigen::VectorXd here = Eigen::VectorXd::Zero(residual_N.size());
      Eigen::Index next = 0;
      for (const Eigen::Index change : changes) {
        const Eigen::Index from = std::max(next, change - smear);
        next = std::max(next, std::min(residual_N.size(), change + length));
        energies.push_back(from < next ? residual_N.segment(from, next - from).squaredNorm() : 0.0);
        by_interval[static_cast<std::size_t>(change * kIntervals / residual_N.size())] += energies.back();
        if (from < next) here.segment(from, next - from).setOnes();
      }
      const double rows = here.sum() / static_cast<double>(residual_N.size());
      const double energy = std::accumulate(energies.begin(), energies.end(), 0.0) / whole;
      if (rows > kMostRows || !spread(std::move(energies), kSpread) ||
          !spread(std::move(by_interval), kSpreadInTime)) {
        continue;
      }
      const double reduction = reduction_beyond(energy, rows);
      if (reduction <= best.error_reduction) continue;
      Eigen::Index strongest = 0;
      residual_N.cwiseProduct(here).cwiseAbs().maxCoeff(&strongest);
      best.error_reduction = reduction;
      best.where = row_times(measurement)(strongest);
      best.explained_N = residual_N.cwiseProduct(here);
      best.description = fmt::format(
          "what is left comes after reversals of the {}: {:.0f} % of it in the {:.0f} % of the time that lie "
          "within {} of one of {} (play or a loose joint in the drive, or friction that reverses in a way of "
          "its own); most at {}",
          name, 100.0 * energy, 100.0 * rows, quantity(lasting_s, "s"), changes.size(),
          quantity(best.where, "s"));
    }
  }
  return best;
}

}  // namespace slipstack::workbench
