// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/reversals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "workbench/base/quantity.h"
#include "workbench/diagnose/alternatives/cause_forms.h"
#include "workbench/diagnose/evidence/chance.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/uncertainty/friction_each_way.h"

namespace slipstack::workbench {
namespace {

/// The rows at which a signal changes its sign. A change counts if the signal exceeds its rms on both sides.
std::vector<Eigen::Index> sign_changes(const Eigen::VectorXd& signal) {
  const double away =
      std::sqrt(signal.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, signal.size())));
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

/// The changes without those that the signal takes back within `pulse` rows: a disturbance that changes the
/// sign of the force for a moment is no reversal of the load.
std::vector<Eigen::Index> lasting(const std::vector<Eigen::Index>& changes, Eigen::Index pulse) {
  std::vector<Eigen::Index> kept;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (i + 1 < changes.size() && changes[i + 1] - changes[i] <= pulse) {
      ++i;
    } else {
      kept.push_back(changes[i]);
    }
  }
  return kept;
}

/// One for each row from `smear` before a change to `length` after it, zero for others.
Eigen::VectorXd rows_after(const std::vector<Eigen::Index>& changes, Eigen::Index smear, Eigen::Index length,
                           Eigen::Index rows) {
  Eigen::VectorXd here = Eigen::VectorXd::Zero(rows);
  for (const Eigen::Index change : changes) {
    const Eigen::Index from = std::max<Eigen::Index>(0, change - smear);
    const Eigen::Index end = std::min(rows, change + length);
    if (from < end) here.segment(from, end - from).setOnes();
  }
  return here;
}

/// Standard error of the share of the energy in the rows `here`, by the jackknife over the blocks of the log.
double error_of_share(const Measurement& measurement, const Eigen::VectorXd& squares,
                      const Eigen::VectorXd& here) {
  std::vector<double> all(static_cast<std::size_t>(measurement.block_count()), 0.0);
  std::vector<double> within = all;
  for (Eigen::Index row = 0; row < squares.size(); ++row) {
    const auto block = static_cast<std::size_t>(measurement.row_blocks()[static_cast<std::size_t>(row)]);
    all[block] += squares(row);
    within[block] += squares(row) * here(row);
  }
  const double whole = squares.sum();
  const double whole_within = squares.dot(here);
  std::vector<double> shares;
  for (std::size_t b = 0; b < all.size(); ++b) {
    if (all[b] > 0.0 && whole > all[b]) shares.push_back((whole_within - within[b]) / (whole - all[b]));
  }
  return jackknife_error(shares);
}

/// Whether the energy beyond the expected share is that of few blocks: then it is an event in time, and does
/// not belong to reversals, which all blocks have.
bool is_an_event(const Measurement& measurement, const Eigen::VectorXd& squares, const Eigen::VectorXd& here,
                 double expected) {
  std::vector<double> excess(static_cast<std::size_t>(measurement.block_count()), 0.0);
  for (Eigen::Index row = 0; row < squares.size(); ++row) {
    const int block = measurement.row_blocks()[static_cast<std::size_t>(row)];
    excess[static_cast<std::size_t>(block)] += squares(row) * (here(row) - expected);
  }
  return mean_is_chance(excess);
}

/// A share in per cent, without the unit.
std::string share_with_interval(double share, double error) {
  return error > 0.0 ? number_with_interval(100.0 * share, 200.0 * error)
                     : fmt::format("{:.0f}", 100.0 * share);
}

}  // namespace

Structure after_reversals(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  Structure best{Coordinate::reversal, 0.0, 0.0, "", Eigen::VectorXd::Zero(residual_N.size()), true};
  const Eigen::VectorXd squares = residual_N.cwiseAbs2();
  const double whole = squares.sum();
  if (!(whole > 0.0)) return best;
  const double row_s = measurement.tick_s() * static_cast<double>(measurement.row_stride());
  // The filter spreads an impact to both sides.
  const auto smear = static_cast<Eigen::Index>(std::ceil(0.5 / (measurement.bandwidth_Hz() * row_s)));
  // The noise floor is highest at reversals, where one encoder step is a large force.
  const Eigen::VectorXd noise = measurement.row_weights().cwiseProduct(measurement.noise_variance());
  const std::pair<const char*, Eigen::VectorXd> signals[] = {
      {"velocity", at_rows(measurement, measurement.velocity_mps())},
      {"acceleration", at_rows(measurement, measurement.acceleration_mps2())},
      {"force", measurement.force_N()}};
  for (const auto& [name, signal] : signals) {
    // Two periods of the bandwidth: a force that moves the axis there and back takes longer.
    const std::vector<Eigen::Index> changes = lasting(sign_changes(signal), 4 * smear);
    const auto longest = static_cast<Eigen::Index>(longest_blow_s(measurement) / row_s);
    for (Eigen::Index length = 2 * smear; length <= longest; length *= 2) {
      const Eigen::VectorXd here = rows_after(changes, smear, length, residual_N.size());
      const double rows = here.mean();
      if (rows == 0.0 || rows > kMajority) break;  // else these are no moments
      const double energy = squares.dot(here) / whole;
      // Of noise alone, so much would lie there; of anything that has nothing to do with reversals, `rows`.
      const double expected = std::max(rows, noise.dot(here) / std::max(noise.sum(), 1e-300));
      if (is_an_event(measurement, squares, here, expected)) continue;
      const double reduction = reduction_beyond(energy, expected);
      if (reduction <= best.error_reduction) continue;
      best.error_reduction = reduction;
      best.explained_N = residual_N.cwiseProduct(here);
      Eigen::Index strongest = 0;
      best.explained_N.cwiseAbs().maxCoeff(&strongest);
      best.where = row_times(measurement)(strongest);
      best.description = fmt::format(
          "what is left comes after reversals of the {}: {} % of it in the {:.0f} % of the time that lie "
          "within {} of one of {} (backlash or a loose joint in the drive, or friction with another form at "
          "reversals); most at {}",
          name, share_with_interval(energy, error_of_share(measurement, squares, here)), 100.0 * rows,
          quantity(static_cast<double>(length) * row_s, "s"), changes.size(),
          when_of(measurement, best.where, spread_of_moment_s(measurement)));
    }
  }
  return best;
}

}  // namespace slipstack::workbench
