// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/places.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/diagnose/held_out.h"
#include "workbench/diagnose/quantity.h"
#include "workbench/log/median.h"

namespace slipstack::workbench {
namespace {

/// Stretches that the travel is divided into: one is as short as a feature that is looked for.
constexpr int kBins = 400;
/// Half widths that are tried, in bins.
constexpr double kHalfWidths[] = {1.0, 2.0, 4.0, 8.0, 16.0};
constexpr int kKnotsPerPlace = 9;
constexpr int kFewestPasses = 4;

struct Bin {
  double energy = 0.0;
  double rows = 0.0;
};

/// The middle of the bin whose energy stands out most above what its rows would have anywhere else.
double loudest_place(const Eigen::VectorXd& position_m, const Eigen::VectorXd& residual_N, double first_m,
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
  std::size_t loudest = 0;
  double most = -1.0;
  for (std::size_t b = 0; b < bins.size(); ++b) {
    const double excess = bins[b].energy - usual_energy * bins[b].rows;
    if (excess > most) {
      most = excess;
      loudest = b;
    }
  }
  return first_m + (static_cast<double>(loudest) + 0.5) * width_m;
}

/// The rows within a stretch, and the half that each pass through it belongs to.
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

/// What the force at a place does: the same whichever way it is passed, or against the motion.
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

}  // namespace

Structure place_on_rail(const Eigen::VectorXd& position_m, const Eigen::VectorXd& velocity_mps,
                        const Eigen::VectorXd& residual_N) {
  Structure best{"position", 0.0, 0.0, "", Eigen::VectorXd::Zero(residual_N.size())};
  const double first_m = position_m.minCoeff();
  const double width_m = (position_m.maxCoeff() - first_m) / kBins;
  const double whole = residual_N.squaredNorm();
  if (!(width_m > 0.0) || !(whole > 0.0)) return best;
  const double middle_m = loudest_place(position_m, residual_N, first_m, width_m);
  for (const double half_width : kHalfWidths) {
    const double half_width_m = half_width * width_m;
    const Passes passes = passes_through(position_m, middle_m, half_width_m);
    if (passes.count < kFewestPasses) continue;
    std::vector<double> knots(kKnotsPerPlace);
    for (int k = 0; k < kKnotsPerPlace; ++k) {
      knots[static_cast<std::size_t>(k)] = middle_m + half_width_m * (2.0 * k / (kKnotsPerPlace - 1) - 1.0);
    }
    const Eigen::VectorXd here_N = residual_N(passes.rows);
    const Eigen::VectorXd way = velocity_mps(passes.rows).cwiseSign();
    const Eigen::MatrixXd hats = hat_functions(position_m(passes.rows), knots);
    for (const Side side : {Side::kEither, Side::kAgainst}) {
      const Eigen::MatrixXd columns = side == Side::kEither ? hats : Eigen::MatrixXd(way.asDiagonal() * hats);
      const HeldOut judged = held_out(columns, here_N, passes.halves);
      // Of all the log's residual, of which this stretch is a part.
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
      const double force_N = judged.explained(peak) * (side == Side::kAgainst ? way(peak) : 1.0);
      best.description = describe(side, best.where, passes.count, force_N);
    }
  }
  return best;
}

}  // namespace slipstack::workbench
