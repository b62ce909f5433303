// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/place_on_rail.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/quantity.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/held_out.h"
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

/// A value and half the width of its interval.
struct WithInterval {
  double value;
  double half_width;
  std::string text(const char* unit) const { return quantity_with_interval(value, half_width, unit); }
};

std::string describe(Side side, const WithInterval& where_m, int passes, WithInterval force_N) {
  if (side == Side::kAgainst) {
    const bool resists = force_N.value > 0.0;
    force_N.value = std::abs(force_N.value);
    return fmt::format(
        "what is left sits at one place of the rail, {}, and {} the motion in each of {} passes: {}",
        where_m.text("m"), resists ? "resists" : "eases", passes, force_N.text("N"));
  }
  return fmt::format(
      "what is left sits at one place of the rail, {}, and comes back in each of {} passes: {}",
      where_m.text("m"), passes, force_N.text("N"));
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
      const double error_N = errors_of_sums(columns, here_N, passes.halves, columns.row(peak).transpose())(0);
      // A free curve shows no place better than its knots lie.
      best.description =
          describe(side, {best.where, knots[1] - knots[0]}, passes.count, {force_N, 2.0 * error_N});
    }
  }
  return best;
}

}  // namespace slipstack::workbench
