// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/repeats.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/linear/force_trace.h"
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
/// at one place can be fitted by a ripple too, but does not recur one pitch further. `distance_m`: of the
/// rows, in traverses.
double share_beside_any_place(const Measurement& measurement, const Eigen::VectorXd& claimed_N,
                              const Eigen::VectorXd& left_N, double pitch_m,
                              const Eigen::VectorXd& distance_m) {
  const Eigen::VectorXd position_m = at_rows(measurement, measurement.position_m());
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

/// The force that a ripple claims at the samples. `others`: the force of the other terms.
std::vector<double> claimed_at_samples(const Measurement& measurement, const ForceTrace& others,
                                       const Term& ripple) {
  const std::vector<double>& measured_N = measurement.log().force_N;
  std::vector<double> claimed_N(measured_N.size(), 0.0);
  for (const Acts acts : {Acts::force, Acts::dry_scale, Acts::total_scale}) {
    if (!acts_with_gains(ripple, acts)) continue;
    std::vector<double> repeats(measured_N.size(), 0.0);
    add_contribution(measurement, ripple, acts, others.dry_N, repeats);
    for (std::size_t i = 0; i < repeats.size(); ++i) {
      // The acceleration of the samples, and with it the model's whole force, is noisy; the measured is not.
      const double of_N = acts == Acts::total_scale ? measured_N[i]
                          : acts == Acts::dry_scale ? others.dry_N[i] * factor_at(others.dry_factor, i) *
                                                          factor_at(others.total_factor, i)
                                                    : factor_at(others.total_factor, i);
      claimed_N[i] += repeats[i] * of_N;
    }
  }
  return claimed_N;
}

/// The share of a claimed force that the measurement has, and its standard error.
struct ShareAtSamples {
  double value = 0.0;
  double error = 0.0;
  bool is_present() const { return value >= kMajority && value > 2.0 * error; }
  bool is_lacking() const { return value + 2.0 * error < kMajority; }
};

/// That of `claimed_N` in the samples of rows in traverses: `distance_m` of each row, the distance since the
/// row before. Of no force it is neither present nor lacking.
ShareAtSamples share_at_samples(const Measurement& measurement, const std::vector<double>& claimed_N,
                                const std::vector<double>& others_N, const Eigen::VectorXd& distance_m) {
  const std::vector<double>& measured_N = measurement.log().force_N;
  const std::size_t stride = measurement.row_stride();
  double claimed_N2 = 0.0;
  double found_N2 = 0.0;
  double error_N4 = 0.0;
  for (Eigen::Index row = 0; row < distance_m.size(); ++row) {
    if (distance_m(row) == 0.0) continue;
    const std::size_t middle = measurement.row_samples()[static_cast<std::size_t>(row)];
    const std::size_t first = middle - std::min(middle, stride / 2);
    const std::size_t end = std::min(first + stride, claimed_N.size());
    for (std::size_t i = first; i < end; ++i) {
      const double left_N = measured_N[i] - others_N[i];
      claimed_N2 += distance_m(row) * squared(claimed_N[i]);
      found_N2 += distance_m(row) * claimed_N[i] * left_N;
      error_N4 += squared(distance_m(row) * claimed_N[i] * (left_N - claimed_N[i]));
    }
  }
  if (claimed_N2 == 0.0) return {0.0, 1.0};
  return {found_N2 / claimed_N2, std::sqrt(error_N4) / claimed_N2};
}

/// Whether the samples refute what the rows show of a ripple: they lack one of its harmonics and have none.
/// Of one of a short pitch the rows hold little but where the axis creeps, for elsewhere the axis passes it
/// above their bandwidth: what fits there claims a force elsewhere. Where the force was filtered before it
/// was recorded the samples know no more than the rows. `distance_m`: of the rows, in traverses.
bool refuted_by_samples(const Measurement& measurement, const FittedModel& model, std::size_t index,
                        const Eigen::VectorXd& distance_m) {
  if (measurement.force_cut_Hz() > 0.0) return false;
  const Term& ripple = model.terms[index];
  const Terms other_terms = without(model.terms, ripple.id());
  const std::vector<double>& dry_N = model.linearisation->sample_dry_N();  // a ripple is no dry friction
  const ForceTrace others =
      evaluate_force(measurement, other_terms, evaluate_dry(measurement, other_terms, &dry_N));
  bool lacking = false;
  for (std::size_t harmonic = 0; harmonic < ripple.gains_per_set(); harmonic += 2) {
    Term alone = ripple;
    for (std::size_t gain = 0; gain < alone.gains.size(); ++gain) {
      if (gain % alone.gains_per_set() / 2 != harmonic / 2) alone.gains[gain] = 0.0;
    }
    const ShareAtSamples share = share_at_samples(measurement, claimed_at_samples(measurement, others, alone),
                                                  others.force_N, distance_m);
    if (share.is_present()) return false;
    lacking = lacking || share.is_lacking();
  }
  return lacking;
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
    const Eigen::VectorXd distance_m = distance_in_traverses(measurement, *pitch_m);
    const double share = share_beside_any_place(measurement, force_of(model, i),
                                                model.linearisation->residual_N(), *pitch_m, distance_m);
    // True ripples show 0.99 to 1.03, others 0.4 at most (docs/theory.md).
    if (share < kMajority || refuted_by_samples(measurement, model, i, distance_m)) return true;
  }
  return false;
}

}  // namespace slipstack::workbench
