// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/detectability/undecided.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/diagnose/candidates.h"
#include "workbench/diagnose/evidence/criterion.h"
#include "workbench/diagnose/evidence/naming_rule.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {
namespace {

double radians(double degrees) {
  return degrees * std::numbers::pi / 180.0;
}

/// The largest share of a column's length that is orthogonal to the known columns.
double share_left(const ResidualMaker& known, const Eigen::MatrixXd& columns) {
  const Eigen::VectorXd own = columns.colwise().norm();
  const Eigen::VectorXd left = known.beyond(columns).colwise().norm();
  double share = 0.0;
  for (Eigen::Index i = 0; i < own.size(); ++i) {
    if (own(i) > 0.0) share = std::max(share, std::min(1.0, left(i) / own(i)));
  }
  return share;
}

bool has_line_above_band(const Measurement& measurement, const Diagnosis& diagnosis) {
  return diagnosis.unexplained && diagnosis.unexplained->coordinate == Coordinate::frequency &&
         diagnosis.unexplained->where > measurement.bandwidth_Hz();
}

/// Whether `simpler` is a special case of `richer`, and this log would show what else `richer` can be, and
/// does not support it. Then that `richer` can imitate `simpler`, as in every log, is no reason to list the
/// pair. Tested with the middle of the shapes of `richer`, one gain at a time.
bool is_the_simpler_case(const Measurement& measurement, const Diagnosis& diagnosis, const Candidate& simpler,
                         const Candidate& richer) {
  const SpecialCase& special_case = richer.term.effect->traits.special_case;
  if (simpler.term.id() != special_case.id) return false;
  // Supported, though too small for a name: the simpler one was chosen for that.
  if (is_supported(richer.criterion_over_special_case) &&
      is_worth_a_name(simpler.holdout_rmse_N, richer.holdout_rmse_N)) {
    return false;
  }
  // What else a mode can be is its ringing: a line above the band may be that.
  if (richer.term.effect->has_shape(ShapeKind::frequency) && has_line_above_band(measurement, diagnosis))
    return false;
  const ResidualMaker baseline = baseline_residual_maker(measurement, diagnosis.baseline);
  const auto beyond = [&](const Term& term) {
    return baseline.beyond(weighted_columns(measurement, diagnosis.baseline, term));
  };
  const Eigen::MatrixXd force = beyond(simpler.term);
  const Term own = make_term(measurement, *richer.term.effect);
  const Eigen::MatrixXd columns = beyond(own);
  const Eigen::Index showing = special_case.gains > 0 ? special_case.gains : columns.cols();
  const double left = share_left(ResidualMaker(force), columns.leftCols(showing));
  const double explained_N =
      std::sqrt(std::max(0.0, explained_N2(diagnosis.baseline.holdout_rmse_N, simpler.holdout_rmse_N)));
  return std::asin(left) > radians(kSameDirection_deg) && left * explained_N > diagnosis.noise_floor_N;
}

/// The effects that reach most of the best reduction of the error.
Terms promising_effects(const std::vector<Candidate>& candidates) {
  double best = kLeastReduction;
  for (const Candidate& one : candidates) best = std::max(best, one.error_reduction);
  const double enough = std::max(kLeastReduction, kMajority * best);
  Terms promising;
  for (const Candidate& one : candidates) {
    if (one.error_reduction >= enough && !one.term.gains.empty()) promising.push_back(one.term);
  }
  return promising;
}

}  // namespace

void list_what_cannot_be_shown(const Measurement& measurement, Diagnosis& diagnosis) {
  const FittedModel& explained = diagnosis.explained;
  const double force_N = measurement.weighted_rms(explained.linearisation->measured_N());
  const ResidualMaker residual_maker = baseline_residual_maker(measurement, explained);
  std::vector<Visibility> all(diagnosis.candidates.size());
  parallel_for(all.size(), [&](std::size_t i) {
    const Term& term = diagnosis.candidates[i].term;
    if (contains(explained.terms, term.effect->text.id)) return;
    // An effect that lowers the error is not one that the log cannot show, whatever else explains the same.
    if (diagnosis.candidates[i].error_reduction >= kLeastShownReduction) return;
    all[i] = visibility_of(measurement, explained, residual_maker, term, kLeastReduction);
  });
  for (Visibility& one : all) {
    if (!one.effect.empty() && one.least_rms_N > kLargeShareOfForce * force_N)
      diagnosis.cannot_show.push_back(std::move(one));
  }
}

void list_what_cannot_be_separated(const Measurement& measurement, Diagnosis& diagnosis) {
  const Terms promising = promising_effects(diagnosis.candidates);
  if (promising.size() < 2) return;
  const auto end = diagnosis.candidates.end();
  const auto find = [&](auto from, const std::string& effect) {
    return std::find_if(from, end, [&](const Candidate& one) { return one.term.id() == effect; });
  };
  for (Separation& pair : separations(measurement, diagnosis.baseline, promising, diagnosis.noise_floor_N)) {
    const auto candidate = find(diagnosis.candidates.begin(), pair.effect);
    // Only whether the better one can be imitated counts: an effect that contains another imitates it always.
    const auto behind = find(candidate, pair.other);
    if (behind == end) continue;
    const auto& alike = candidate->confounded_with;
    const bool as_good = std::find(alike.begin(), alike.end(), pair.other) != alike.end();
    const bool same = pair.angle_deg < kSameDirection_deg &&
                      behind->holdout_rmse_N < kUncertainFloor * candidate->holdout_rmse_N;
    if (!as_good && !same) continue;
    if (is_the_simpler_case(measurement, diagnosis, *candidate, *behind)) {
      std::erase(candidate->confounded_with, pair.other);
      std::erase(behind->confounded_with, pair.effect);
      std::erase_if(diagnosis.cannot_show, [&](const Visibility& one) { return one.effect == pair.other; });
      continue;
    }
    if (!as_good) {
      candidate->confounded_with.push_back(pair.other);
      behind->confounded_with.push_back(pair.effect);
    }
    diagnosis.cannot_separate.push_back(std::move(pair));
  }
  std::stable_sort(diagnosis.cannot_separate.begin(), diagnosis.cannot_separate.end(),
                   [](const auto& a, const auto& b) { return a.angle_deg < b.angle_deg; });
}

}  // namespace slipstack::workbench
