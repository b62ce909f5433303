// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/repeats.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/terms/search_ranges.h"

namespace slipstack::workbench {
namespace {

/// Of each traverse of at least `length_m` among rows [first, end) of `position_m`: writes by how much each
/// row goes further than all before it; moves back and forth within it are no distance. A traverse ends when
/// the axis has moved back by `length_m`, which is then one of its own.
void traverses_of_log(const Eigen::VectorXd& position_m, Eigen::Index first, Eigen::Index end,
                      double length_m, Eigen::VectorXd& distance_m) {
  Eigen::Index from = first;
  Eigen::Index farthest = first;
  const auto finish = [&] {
    if (std::abs(position_m(farthest) - position_m(from)) < length_m) return;
    const double side = position_m(farthest) >= position_m(from) ? 1.0 : -1.0;
    Eigen::Index start = 0;  // from where the axis goes all the way
    (side * position_m.segment(from, farthest - from + 1)).minCoeff(&start);
    double reached = side * position_m(from + start);
    for (Eigen::Index row = from + start + 1; row <= farthest; ++row) {
      distance_m(row) = std::max(0.0, side * position_m(row) - reached);
      reached = std::max(reached, side * position_m(row));
    }
  };
  for (Eigen::Index row = first + 1; row < end; ++row) {
    const double side = position_m(farthest) >= position_m(from) ? 1.0 : -1.0;
    const double further = side * (position_m(row) - position_m(farthest));
    if (further >= 0.0) {
      farthest = row;
    } else if (-further > length_m) {
      finish();
      from = farthest;
      farthest = row;
    }
  }
  finish();
}

/// The least share of `claimed_N` that traverses support when any one pitch of the rail is excluded: a force
/// at one place can be fitted by a ripple too, but does not recur one pitch further.
double share_beside_any_place(const Measurement& measurement, const Eigen::VectorXd& claimed_N,
                              const Eigen::VectorXd& left_N, double pitch_m) {
  const Eigen::VectorXd position_m = at_rows(measurement, measurement.position_m());
  const Eigen::VectorXd distance_m = distance_in_traverses(measurement, pitch_m);
  double least = share_supported(claimed_N, left_N, distance_m);
  const double last_m = position_m.maxCoeff();
  for (double first_m = position_m.minCoeff(); first_m < last_m; first_m += 0.5 * pitch_m) {
    const auto beside = (position_m.array() < first_m) || (position_m.array() > first_m + pitch_m);
    const Eigen::VectorXd elsewhere_m = beside.select(distance_m.array(), 0.0);
    if (elsewhere_m.sum() < pitch_m) continue;
    least = std::min(least, share_supported(claimed_N, left_N, elsewhere_m));
  }
  return least;
}

}  // namespace

Eigen::VectorXd force_of(const FittedModel& model, std::size_t index) {
  Eigen::Index first = 0;
  for (std::size_t i = 0; i < index; ++i) first += std::ssize(model.terms[i].gains);
  const auto& gains = model.terms[index].gains;
  const Eigen::Map<const Eigen::VectorXd> values(gains.data(), std::ssize(gains));
  return model.linearisation->columns().middleCols(first, values.size()) * values;
}

Eigen::VectorXd distance_in_traverses(const Measurement& measurement, double length_m) {
  const Eigen::VectorXd position_m = at_rows(measurement, measurement.position_m());
  Eigen::VectorXd distance_m = Eigen::VectorXd::Zero(position_m.size());
  for (const LogPart& part : measurement.parts()) {
    const auto first = static_cast<Eigen::Index>(part.first_row);
    const auto count = static_cast<Eigen::Index>(part.row_count);
    if (count > 0) traverses_of_log(position_m, first, first + count, length_m, distance_m);
  }
  // Samples that repair() left out hold no force of the axis.
  return distance_m.cwiseProduct(measurement.row_usable());
}

double share_supported(const Eigen::VectorXd& claimed_N, const Eigen::VectorXd& left_N,
                       const Eigen::VectorXd& weight) {
  const Eigen::VectorXd weighted_N = weight.cwiseProduct(claimed_N);
  const double energy = weighted_N.dot(claimed_N);
  return energy > 0.0 ? 1.0 + weighted_N.dot(left_N) / energy : 0.0;
}

bool ripple_not_supported(const Measurement& measurement, const FittedModel& model, const Terms& known) {
  for (std::size_t i = 0; i < model.terms.size(); ++i) {
    const auto pitch_m = model.terms[i].shape(ShapeKind::pitch);
    if (!pitch_m || is_about_one_turn(*pitch_m) || contains(known, model.terms[i].id())) continue;
    const double share =
        share_beside_any_place(measurement, force_of(model, i), model.linearisation->residual_N(), *pitch_m);
    // True ripples show 0.99 to 1.03, others 0.4 at most (docs/theory.md).
    if (share < kMajority) return true;
  }
  return false;
}

}  // namespace slipstack::workbench
