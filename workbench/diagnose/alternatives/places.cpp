// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/places.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/quantity.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/chance.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/signal/free_curve.h"

namespace slipstack::workbench {
namespace {

/// The travel is divided into so many bins; a bin is as short as the shortest feature that is searched.
/// Chosen.
constexpr int kBins = 400;
/// Half widths of the feature that are tried, in bins.
constexpr double kHalfWidths[] = {1.0, 2.0, 4.0, 8.0, 16.0};
constexpr int kKnotsPerPlace = 9;

struct Bin {
  double energy = 0.0;
  double rows = 0.0;
};

/// The middle of the bin whose energy most exceeds that of as many rows in the median bin.
double strongest_place(const Eigen::VectorXd& position_m, const Eigen::VectorXd& residual_N, double first_m,
                       double width_m) {
  std::vector<Bin> bins(kBins);
  for (Eigen::Index row = 0; row < position_m.size(); ++row) {
    const double place = (position_m(row) - first_m) / width_m;
    Bin& bin = bins[static_cast<std::size_t>(std::clamp(place, 0.0, kBins - 1.0))];
    bin.energy += residual_N(row) * residual_N(row);
    bin.rows += 1.0;
  }
  std::vector<double> usual;
  for (const Bin& bin : bins) {
    if (bin.rows > 0.0) usual.push_back(bin.energy / bin.rows);
  }
  const double usual_energy = median(std::move(usual));
  std::size_t strongest = 0;
  double most = -1.0;
  for (std::size_t b = 0; b < bins.size(); ++b) {
    const double excess = bins[b].energy - usual_energy * bins[b].rows;
    if (excess > most) {
      most = excess;
      strongest = b;
    }
  }
  return first_m + (static_cast<double>(strongest) + 0.5) * width_m;
}

/// The rows within a section of the rail, and for each the half that its pass belongs to.
struct Passes {
  std::vector<Eigen::Index> rows;
  Halves halves;
  int count = 0;
};

Passes passes_through(const Eigen::VectorXd& position_m, double middle_m, double half_width_m) {
  Passes passes;
  for (Eigen::Index row = 0; row < position_m.size(); ++row) {
    if (std::abs(position_m(row) - middle_m) > half_width_m) continue;
    if (passes.rows.empty() || passes.rows.back() != row - 1) ++passes.count;
    passes.rows.push_back(row);
    passes.halves.push_back(static_cast<std::uint8_t>(passes.count % 2));
  }
  return passes;
}

/// The sign of the force at a place: the same in both directions of motion, or opposite to the motion.
enum class Side { kEither, kAgainst };

std::string describe(Side side, double where_m, int passes, double force_N) {
  if (side == Side::kAgainst) {
    return fmt::format(
        "what is left sits at one place of the rail, {}, and {} the motion in each of {} passes: {}",
        quantity(where_m, "m"), force_N > 0.0 ? "resists" : "eases", passes,
        quantity(std::abs(force_N), "N"));
  }
  return fmt::format(
      "what is left sits at one place of the rail, {}, and comes back in each of {} passes: {}",
      quantity(where_m, "m"), passes, quantity(force_N, "N"));
}

/// Half widths within which the energy of passes is summed, in bins.
constexpr double kStrongHalfWidths[] = {4.0, 8.0, 16.0, 32.0};
/// Rows slower than this share of the speed at the middle do not belong to a pass: the axis stops or reverses
/// there, which has other causes of error.
constexpr double kAtSpeed = 0.2;
/// Rows at either end of a pass over which the filter spreads an impact.
constexpr Eigen::Index kSmear = 2;
constexpr std::size_t kFewestStrongPasses = 3;
/// Passes that take more than this share of all rows are most of the motion, not a short feature. Chosen.
constexpr double kShortPlace = 0.15;

/// Median of the squares of Gaussian noise, over its variance.
constexpr double kMedianOfSquares = 0.455;
/// A curve is reported instead of the energy if it explains this share of what the energy explains. Chosen.
constexpr double kCurveHolds = 0.8;

/// Rows in which the axis passes a place, and its speed there.
struct Pass {
  Eigen::Index first;
  Eigen::Index count;
  double speed_mps;
};

/// The passes through `middle_m` from one side to the other at speed, within half a width of it. A fast pass
/// may have only one or two rows.
std::vector<Pass> passes_at_speed(const Eigen::VectorXd& position_m, const Eigen::VectorXd& velocity_mps,
                                  double middle_m, double half_width_m) {
  std::vector<Pass> passes;
  const Eigen::Index rows = position_m.size();
  Eigen::Index free_from = 0;
  for (Eigen::Index row = 0; row + 1 < rows; ++row) {
    if ((position_m(row) < middle_m) == (position_m(row + 1) < middle_m)) continue;
    const double velocity = velocity_mps(row);
    const auto belongs = [&](Eigen::Index other) {
      return std::abs(position_m(other) - middle_m) < half_width_m &&
             velocity_mps(other) / velocity > kAtSpeed;
    };
    Eigen::Index first = row;
    Eigen::Index last = row + 1;
    while (first > 0 && belongs(first - 1)) --first;
    while (last + 1 < rows && belongs(last + 1)) ++last;
    first = std::max(free_from, first - kSmear);
    last = std::min(rows - 1, last + kSmear);
    free_from = last + 1;
    if (first <= last) passes.push_back({first, last - first + 1, std::abs(velocity)});
  }
  return passes;
}

/// The energy of the residual in the passes of one place, of which nearly each must have its share. Fast
/// passes have one or two rows, in which the same feature has another form at each speed, so that no curve
/// over the place fits all of them.
Structure strong_passes(const Eigen::VectorXd& position_m, const Eigen::VectorXd& velocity_mps,
                        const Eigen::VectorXd& residual_N, double middle_m, double width_m) {
  Structure best{Coordinate::position, 0.0, middle_m, "", Eigen::VectorXd::Zero(residual_N.size())};
  const Eigen::VectorXd squares = residual_N.cwiseAbs2();
  const double usual = median({squares.begin(), squares.end()}) / kMedianOfSquares;
  for (const double half_width : kStrongHalfWidths) {
    const auto passes = passes_at_speed(position_m, velocity_mps, middle_m, half_width * width_m);
    if (passes.size() < kFewestStrongPasses) continue;
    Eigen::VectorXd here_N = Eigen::VectorXd::Zero(residual_N.size());
    std::vector<double> energies;
    double rows = 0.0;
    for (const auto& [first, count, speed_mps] : passes) {
      here_N.segment(first, count) = residual_N.segment(first, count);
      energies.push_back(speed_mps *
                         (squares.segment(first, count).sum() - usual * static_cast<double>(count)));
      rows += static_cast<double>(count) / static_cast<double>(residual_N.size());
    }
    // Energy times speed, because a slow pass has more rows; that of the noise is subtracted.
    if (mean_is_chance(energies) || rows > kShortPlace) continue;
    const double energy = here_N.squaredNorm() / residual_N.squaredNorm();
    const double reduction = reduction_beyond(energy, rows);
    if (reduction <= best.error_reduction) continue;
    best.error_reduction = reduction;
    best.explained_N = here_N;
    best.description = fmt::format(
        "what is left sits at one place of the rail, {}: {:.0f} % of it in the {:.2g} % of the time in which "
        "the axis passes there, in each of {} passes",
        quantity(middle_m, "m"), 100.0 * energy, 100.0 * rows, passes.size());
  }
  return best;
}

}  // namespace

int passes_of_place(const Eigen::VectorXd& position_m, double middle_m, double half_width_m) {
  return passes_through(position_m, middle_m, half_width_m).count;
}

Structure place_on_rail(const Eigen::VectorXd& position_m, const Eigen::VectorXd& velocity_mps,
                        const Eigen::VectorXd& residual_N) {
  Structure best{Coordinate::position, 0.0, 0.0, "", Eigen::VectorXd::Zero(residual_N.size())};
  const double first_m = position_m.minCoeff();
  const double width_m = (position_m.maxCoeff() - first_m) / kBins;
  const double whole = residual_N.squaredNorm();
  if (!(width_m > 0.0) || !(whole > 0.0)) return best;
  const double middle_m = strongest_place(position_m, residual_N, first_m, width_m);
  for (const double half_width : kHalfWidths) {
    const double half_width_m = half_width * width_m;
    const Passes passes = passes_through(position_m, middle_m, half_width_m);
    if (passes.count < kFewestPasses) continue;
    std::vector<double> knots(kKnotsPerPlace);
    for (int k = 0; k < kKnotsPerPlace; ++k) {
      knots[static_cast<std::size_t>(k)] = middle_m + half_width_m * (2.0 * k / (kKnotsPerPlace - 1) - 1.0);
    }
    const Eigen::VectorXd here_N = residual_N(passes.rows);
    const Eigen::VectorXd direction = velocity_mps(passes.rows).cwiseSign();
    const Eigen::MatrixXd hats = hat_functions(position_m(passes.rows), knots);
    for (const Side side : {Side::kEither, Side::kAgainst}) {
      const Eigen::MatrixXd columns =
          side == Side::kEither ? hats : Eigen::MatrixXd(direction.asDiagonal() * hats);
      const HeldOut judged = held_out(columns, here_N, passes.halves);
      // Relative to the residual of the whole log, of which this section is a part.
      const double kept =
          here_N.squaredNorm() * (1.0 - judged.error_reduction) * (1.0 - judged.error_reduction);
      const double reduction = 1.0 - std::sqrt(std::max(0.0, whole - here_N.squaredNorm() + kept) / whole);
      if (judged.error_reduction <= 0.0 || reduction <= best.error_reduction) continue;
      Eigen::Index peak = 0;
      judged.explained.cwiseAbs().maxCoeff(&peak);
      best.error_reduction = reduction;
      best.where = position_m(passes.rows[static_cast<std::size_t>(peak)]);
      best.explained_N.setZero();
      best.explained_N(passes.rows) = judged.explained;
      const double force_N = judged.explained(peak) * (side == Side::kAgainst ? direction(peak) : 1.0);
      best.description = describe(side, best.where, passes.count, force_N);
    }
  }
  Structure energy = strong_passes(position_m, velocity_mps, residual_N, middle_m, width_m);
  if (energy.error_reduction <= best.error_reduction) return best;
  // A curve is the more specific description.
  if (best.error_reduction < kCurveHolds * energy.error_reduction) return energy;
  best.error_reduction = energy.error_reduction;
  return best;
}

}  // namespace slipstack::workbench
