// SPDX-License-Identifier: Apache-2.0
#include "workbench/plan/expected_evidence.h"

#include <algorithm>
#include <cmath>

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

int free_parameters(const Term& term) {
  return term.effect->parameter_count();
}

std::vector<ExpectedEvidence> evidence_of(const Information& information, const Terms& effects) {
  std::vector<ExpectedEvidence> all;
  const auto put = [&](std::size_t i, const std::string& other, const Information::Figure& figure, int more) {
    const double n = std::max(figure.rows, 2.0);
    all.push_back({effects[i].id(), other, figure.angle_deg, figure.chi_squared,
                   n * std::log1p(figure.chi_squared / n) - more * std::log(n)});
  };
  for (std::size_t i = 0; i < effects.size(); ++i) {
    put(i, "", information.alone(i), free_parameters(effects[i]));
    for (std::size_t j = 0; j < effects.size(); ++j) {
      if (i == j) continue;
      const int more = std::max(0, free_parameters(effects[i]) - free_parameters(effects[j]));
      put(i, effects[j].id(), information.against(i, j), more);
    }
  }
  return all;
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

std::vector<ExpectedEvidence> expected_evidence(const Measurement& measurement, const FittedModel& base,
                                                const Terms& effects) {
  const std::vector<int> groups(measurement.row_samples().size(), 0);
  Terms on_logs;
  for (const Term& term : effects) {
    const bool each = measurement.gain_sets(term.effect->text.id) > 1;
    on_logs.push_back(each ? with_gain_sets(measurement, term) : term);
  }
  std::vector<Information> all = Information::of(measurement, base, expected_effects(measurement, on_logs),
                                                 groups, 1, measurement.noise_floor_N());
  if (measurement.is_excerpt()) {
    all.front().repeat(static_cast<double>(measurement.whole_sample_count()) /
                       static_cast<double>(measurement.sample_count()));
  }
  return evidence_of(all.front(), effects);
}

}  // namespace slipstack::workbench
