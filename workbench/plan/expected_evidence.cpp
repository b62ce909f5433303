// SPDX-License-Identifier: Apache-2.0
#include "workbench/plan/expected_evidence.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/criterion.h"
#include "workbench/diagnose/search/forward_selection.h"
#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/nonlinear/starting_shapes.h"
#include "workbench/estimate/terms/search_ranges.h"

namespace slipstack::workbench {
namespace {

/// Most columns of one effect as an alternative explanation of others: bounds the cost. Chosen.
constexpr int kMostAlternativeColumns = 24;

/// Shapes at which an effect may explain another: a few of the starting points of its own search.
std::vector<std::vector<double>> alternative_shapes_of(const Measurement& measurement, const Term& term) {
  if (term.gains.empty() || searched_shapes(measurement, *term.effect).empty()) return {};
  const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(measurement.row_count());
  const auto points = starting_shapes(measurement, *term.effect, nothing, nothing);
  const auto most = static_cast<std::size_t>(std::max(1, kMostAlternativeColumns / term.effect->gain_count));
  const std::size_t stride = std::max<std::size_t>(1, points.size() / most);
  std::vector<std::vector<double>> few;
  for (std::size_t i = 0; i < points.size() && few.size() < most; i += stride) few.push_back(points[i]);
  return few;
}

/// The complexity of the baseline with an effect that acts: its gains are at no bound, wherever they are in
/// this measurement.
Complexity complexity_with(const Measurement& measurement, const Criterion& criterion,
                           const FittedModel& base, const Term& effect) {
  Terms terms = base.terms;
  terms.push_back(effect);
  FittedModel fitted = fit_gains(measurement, std::move(terms), &base);
  const auto& bounds = fitted.constraints;
  for (std::size_t i = fitted.solution.bound_states.size() - effect.gains.size();
       i < fitted.solution.bound_states.size(); ++i) {
    const auto unknown = static_cast<Eigen::Index>(i);
    if (bounds.lower(unknown) < bounds.upper(unknown)) fitted.solution.bound_states[i] = BoundState::free;
  }
  return criterion.complexity_of(fitted);
}

std::vector<ExpectedEvidence> evidence_of(const Information& information, const Terms& effects,
                                          const Complexity& base, const std::vector<Complexity>& with) {
  std::vector<ExpectedEvidence> all;
  const auto put = [&](std::size_t i, const std::string& other, const Information::Figure& figure,
                       const Complexity& in_its_place) {
    const double n = std::max(figure.rows, 2.0);
    // That the other has more parameters speaks for the effect whatever the motion: no evidence of a motion.
    const double more = std::max(0.0, with[i].cost(n) - in_its_place.cost(n));
    all.push_back({effects[i].id(), other, figure.angle_deg, figure.chi_squared,
                   n * std::log1p(figure.chi_squared / n) - more});
  };
  for (std::size_t i = 0; i < effects.size(); ++i) {
    put(i, "", information.alone(i), base);
    for (std::size_t j = 0; j < effects.size(); ++j) {
      if (i != j) put(i, effects[j].id(), information.against(i, j), with[j]);
    }
  }
  return all;
}

/// The number of effects of which `diagnose` would choose one.
std::size_t choices_beside(const Measurement& measurement, const Terms& baseline) {
  return choices_of(measurement, DiagnoseOptions{}, baseline);
}

}  // namespace

std::optional<LeastEvidence> least_evidence(const std::vector<ExpectedEvidence>& log,
                                            const std::vector<ExpectedEvidence>& plan) {
  std::optional<LeastEvidence> least;
  for (const ExpectedEvidence& planned : plan) {
    const auto same = std::find_if(log.begin(), log.end(), [&](const ExpectedEvidence& one) {
      return one.effect == planned.effect && one.other == planned.other;
    });
    if (same == log.end() || std::max(same->evidence, planned.evidence) < kDecisive) continue;
    if (!least) least = {same->evidence, planned.evidence};
    least = {std::min(least->log, same->evidence), std::min(least->plan, planned.evidence)};
  }
  return least;
}

std::vector<Information::Expected> expected_effects(const Measurement& measurement, const Terms& effects) {
  std::vector<Information::Expected> expected;
  for (const Term& term : effects) expected.push_back({term, alternative_shapes_of(measurement, term)});
  return expected;
}

ResidualScale at_rows_of(const Measurement& measurement, const ExpectedScatter& scatter) {
  return {std::hypot(measurement.noise_floor_N(), scatter.discrepancy_N), scatter.inflation};
}

ExpectedScatter scatter_of(const Measurement& measurement, const FittedModel& base, const Terms& effects) {
  Terms terms = base.terms;
  for (const Term& effect : effects) terms.push_back(effect);
  const FittedModel all = fit_gains(measurement, std::move(terms), &base);
  const ResidualScale scale = Criterion(measurement, base.terms, 1).residual_scale(all);
  const double beyond_N2 = squared(scale.rms_N) - squared(measurement.noise_floor_N());
  return {std::sqrt(std::max(0.0, beyond_N2)), scale.inflation};
}

std::vector<ExpectedEvidence> expected_evidence(const Measurement& measurement, const FittedModel& base,
                                                const Terms& effects, const ExpectedScatter& scatter) {
  const std::vector<int> groups(measurement.row_samples().size(), 0);
  const Criterion criterion(measurement, base.terms, choices_beside(measurement, base.terms));
  Terms on_logs;
  std::vector<Complexity> with;
  for (const Term& term : effects) {
    const bool each = measurement.gain_sets(term.effect->text.id) > 1;
    on_logs.push_back(each ? with_gain_sets(measurement, term) : term);
    with.push_back(complexity_with(measurement, criterion, base, on_logs.back()));
  }
  std::vector<Information> all = Information::of(measurement, base, expected_effects(measurement, on_logs),
                                                 groups, 1, at_rows_of(measurement, scatter));
  if (measurement.is_excerpt()) {
    all.front().repeat(static_cast<double>(measurement.whole_sample_count()) /
                       static_cast<double>(measurement.sample_count()));
  }
  return evidence_of(all.front(), effects, criterion.complexity_of(base), with);
}

}  // namespace slipstack::workbench
