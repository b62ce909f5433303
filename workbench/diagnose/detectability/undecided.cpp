// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/detectability/undecided.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/diagnose/candidates.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {
namespace {

/// A log cannot show an effect that would be named only if its peak were this share of the force (rms).
/// Chosen.
constexpr double kCannotShow = 0.2;

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

/// Whether `simpler` is a special case of `richer`, and this log would show what else `richer` can be. Then
/// that `richer` can imitate `simpler`, as in every log, is no tie. Tested with the middle of the shapes of
/// `richer`, one gain at a time.
bool is_the_simpler_case(const Measurement& measurement, const Diagnosis& diagnosis, const Candidate& simpler,
                         const Candidate& richer) {
  const SpecialCase& special_case = richer.term.effect->traits.special_case;
  if (simpler.term.id() != special_case.id) return false;
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
  return left * explained_N > diagnosis.noise_floor_N;
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
    if (!one.effect.empty() && one.least_N > kCannotShow * force_N)
      diagnosis.cannot_show.push_back(std::move(one));
  }
}

void list_what_cannot_be_separated(const Measurement& measurement, Diagnosis& diagnosis) {
  const auto candidate = [&](const std::string& id) -> Candidate& {
    return *std::find_if(diagnosis.candidates.begin(), diagnosis.candidates.end(),
                         [&](const Candidate& one) { return one.term.id() == id; });
  };
  std::erase_if(diagnosis.ties, [&](const Tie& tie) {
    return is_the_simpler_case(measurement, diagnosis, candidate(tie.effect), candidate(tie.other));
  });
  Terms tied;
  for (const Tie& tie : diagnosis.ties) {
    candidate(tie.effect).confounded_with.push_back(tie.other);
    candidate(tie.other).confounded_with.push_back(tie.effect);
    for (const std::string& id : {tie.effect, tie.other}) {
      if (!contains(tied, id)) tied.push_back(candidate(id).term);
    }
  }
  for (Separation& pair : separations(measurement, diagnosis.baseline, tied, diagnosis.noise_floor_N)) {
    const bool listed = std::any_of(diagnosis.ties.begin(), diagnosis.ties.end(), [&](const Tie& tie) {
      return tie.effect == pair.effect && tie.other == pair.other;
    });
    if (listed) diagnosis.cannot_separate.push_back(std::move(pair));
  }
  std::stable_sort(diagnosis.cannot_separate.begin(), diagnosis.cannot_separate.end(),
                   [](const auto& a, const auto& b) { return a.angle_deg < b.angle_deg; });
}

}  // namespace slipstack::workbench
