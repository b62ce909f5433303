// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/trial.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/estimate/nonlinear/minimise.h"
#include "workbench/estimate/nonlinear/starting_shapes.h"
#include "workbench/estimate/terms/search_ranges.h"

namespace slipstack::workbench {
namespace {

// Largest ratio of a pitch's cost to that of the best pitch at which the two count as equally good. Chosen.
constexpr double kAsGoodPitch = 1.01;
constexpr double kNearBestBeforeRefining = 1.03;  ///< the same, before the pitch is refined

/// Whether an effect decays below the slowest speed that the log can show. The search has then fitted
/// something that happens at reversals, and the log contains no evidence for this effect.
bool below_visible(const EffectDescription& effect, const std::vector<ShapeRange>& ranges,
                   const std::vector<double>& shapes) {
  const ShapeRange* velocity = find_range(ranges, effect, ShapeKind::fading_velocity);
  return velocity != nullptr && shapes[velocity->index] < 1.05 * velocity->lower;
}

/// Whether the effect is a map over a travel, or repeats within one, in which friction develops after a
/// reversal. Such an effect is another form of the hysteresis.
bool within_presliding(const Measurement& measurement, const Terms& base, const EffectDescription& effect,
                       const std::vector<double>& shapes) {
  const Term* hysteresis = find_role(base, Role::hysteresis);
  if (hysteresis == nullptr) return false;
  const double develops_m = presliding_travel_m(*hysteresis);
  for (std::size_t i = 0; i < effect.shapes.size(); ++i) {
    const ShapeKind kind = effect.shapes[i].kind;
    if (kind == ShapeKind::travel && measurement.position_range_m().length() < develops_m) return true;
    if (kind == ShapeKind::pitch && shapes[i] < develops_m) return true;
  }
  return false;
}

/// The starting point of lowest cost; among pitches that are equally good (kAsGoodPitch), the shortest,
/// because the harmonics of a pitch are harmonics of its multiples too.
std::vector<double> best_start(const EffectDescription& effect,
                               const std::vector<std::vector<double>>& starts,
                               const std::function<double(const std::vector<double>&)>& cost) {
  std::vector<double> costs(starts.size());
  parallel_for(starts.size(), [&](std::size_t i) { costs[i] = cost(starts[i]); });
  std::size_t best = static_cast<std::size_t>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  const double enough = kAsGoodPitch * costs[best];
  for (std::size_t shape = 0; shape < effect.shapes.size(); ++shape) {
    if (effect.shapes[shape].kind != ShapeKind::pitch) continue;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      if (costs[i] <= enough && starts[i][shape] < starts[best][shape]) best = i;
    }
  }
  return starts[best];
}

/// `found`, with its pitch replaced by a half or a third where that is equally good. A multiple of the true
/// pitch has additional harmonics, and they can fit the noise slightly better.
SearchResult with_shortest_pitch(const EffectDescription& effect, const std::vector<ShapeRange>& ranges,
                                 SearchResult found,
                                 const std::function<double(const std::vector<double>&)>& cost,
                                 const SearchEffort& effort) {
  const SearchEffort half{effort.evaluations / 2, effort.tolerance};
  const double enough = kAsGoodPitch * found.cost;
  for (const ShapeRange& range : ranges) {
    if (effect.shapes[range.index].kind != ShapeKind::pitch) continue;
    for (const double part : {2.0, 3.0}) {
      std::vector<double> shapes = found.shapes;
      shapes[range.index] /= part;
      if (shapes[range.index] < range.lower || cost(shapes) > kNearBestBeforeRefining * found.cost) continue;
      SearchResult shorter = refine_shapes(ranges, std::move(shapes), cost, half);
      if (shorter.cost <= enough) found = std::move(shorter);
    }
  }
  return found;
}

/// The starting points in groups that are searched separately. The cost has one minimum where the memory
/// decays with distance and another where it decays with time, far apart.
std::vector<std::vector<std::vector<double>>> groups_of_starts(const EffectDescription& effect,
                                                               const std::vector<ShapeRange>& ranges,
                                                               std::vector<std::vector<double>> starts) {
  const ShapeRange* distance = find_range(ranges, effect, ShapeKind::lag_distance);
  if (distance == nullptr) return {std::move(starts)};
  const auto by_distance = std::stable_partition(starts.begin(), starts.end(), [&](const auto& shapes) {
    return shapes[distance->index] == distance->upper;
  });
  std::vector<std::vector<std::vector<double>>> all{{starts.begin(), by_distance},
                                                    {by_distance, starts.end()}};
  std::erase_if(all, [](const auto& one) { return one.empty(); });
  return all;
}

/// The measured force shifted by a delay, which acts on it and not on the model.
Eigen::VectorXd delayed_target(const Measurement& measurement, const Linearisation& linearisation,
                               const Term& delay) {
  return linearisation.target() - linearisation.measured_N() +
         measurement.force_N(measurement_dynamics_of({delay}));
}

/// The constraints of base and `term`, with the bounds that its pitch gives to its harmonics
/// (settle_pitch()). The gains of other effects may be coupled to the base.
NormalEquations::Constraints with_bounds_of(const Term& term, NormalEquations::Constraints constraints) {
  if (!term.shape(ShapeKind::pitch)) return constraints;
  const auto count = std::ssize(term.gains);
  constraints.lower.tail(count) = Eigen::Map<const Eigen::VectorXd>(term.lower.data(), count);
  constraints.upper.tail(count) = Eigen::Map<const Eigen::VectorXd>(term.upper.data(), count);
  return constraints;
}

/// The costs of an effect's shapes: the error of base and effect fitted jointly. What was evaluated once is
/// not evaluated again, since a search begins with the best starting point and the trial ends with the best
/// shapes. May be called by several threads.
class ShapeCosts {
 public:
  ShapeCosts(const Measurement& measurement, const FittedModel& base, Term term,
             const NormalEquations::Constraints& constraints, const std::vector<BoundState>& bound_states)
      : measurement_(measurement),
        base_(base),
        term_(std::move(term)),
        constraints_(constraints),
        bound_states_(bound_states) {}

  double of(const std::vector<double>& shapes) {
    if (const auto known = known_cost(shapes)) return *known;
    Term term = term_;
    term.shapes = shapes;
    settle_pitch(measurement_, term);
    Eigen::MatrixXd columns;
    if (!term.gains.empty()) columns = base_.linearisation->columns_of(term);
    const double cost =
        sum_with(term, columns).training_error(with_bounds_of(term, constraints_), bound_states_);
    const std::lock_guard lock(lock_);
    costs_.push_back({shapes, cost});
    if (cost < lowest_) {
      lowest_ = cost;
      lowest_shapes_ = term.shapes;
      lowest_columns_ = std::move(columns);
    }
    return cost;
  }

  /// equations_with() at these shapes.
  NormalEquations equations(const Term& term) const {
    const Linearisation& linearisation = *base_.linearisation;
    if (term.gains.empty() || term.shapes != lowest_shapes_)
      return equations_with(measurement_, linearisation, *base_.equations, term);
    return base_.equations->with(measurement_, linearisation.columns(), lowest_columns_,
                                 linearisation.target());
  }

 private:
  std::optional<double> known_cost(const std::vector<double>& shapes) const {
    const std::lock_guard lock(lock_);
    for (const SearchResult& one : costs_) {
      if (one.shapes == shapes) return one.cost;
    }
    return {};
  }

  /// equations_with() without the blocks.
  NormalEquations sum_with(const Term& term, const Eigen::MatrixXd& columns) const {
    const Linearisation& linearisation = *base_.linearisation;
    if (term.gains.empty()) {
      return base_.equations->sum_with_target(measurement_, linearisation.columns(),
                                              delayed_target(measurement_, linearisation, term));
    }
    return base_.equations->sum_with(measurement_, linearisation.columns(), columns, linearisation.target());
  }

  const Measurement& measurement_;
  const FittedModel& base_;
  const Term term_;
  const NormalEquations::Constraints& constraints_;
  const std::vector<BoundState>& bound_states_;
  mutable std::mutex lock_;
  std::vector<SearchResult> costs_;
  double lowest_ = HUGE_VAL;
  std::vector<double> lowest_shapes_;
  Eigen::MatrixXd lowest_columns_;
};

/// Narrows the range of a pitch to what repeats within the travel, with the starting points.
void leave_out_one_turn(const Measurement& measurement, const EffectDescription& effect,
                        std::vector<ShapeRange>& ranges, std::vector<std::vector<double>>& starts) {
  for (ShapeRange& range : ranges) {
    if (effect.shapes[range.index].kind != ShapeKind::pitch) continue;
    const double repeats_m = 0.5 * measurement.position_range_m().length();
    range.upper = std::max(range.lower, std::min(range.upper, repeats_m));
    for (std::vector<double>& one : starts) one[range.index] = std::min(one[range.index], range.upper);
  }
}

}  // namespace

NormalEquations equations_with(const Measurement& measurement, const Linearisation& linearisation,
                               const NormalEquations& equations, const Term& term) {
  if (term.gains.empty()) {
    return equations.with_target(measurement, linearisation.columns(),
                                 delayed_target(measurement, linearisation, term));
  }
  return equations.with(measurement, linearisation.columns(), linearisation.columns_of(term),
                        linearisation.target());
}

std::vector<double> jointly_best_shapes(const Measurement& measurement, const FittedModel& base,
                                        const EffectDescription& effect,
                                        const std::vector<std::vector<double>>& starts,
                                        const std::vector<ShapeRange>& ranges, const SearchEffort& effort) {
  const Term term = term_for_log(measurement, effect);
  Terms terms = base.terms;
  terms.push_back(term);
  const NormalEquations::Constraints constraints = constraints_of(terms, base.train_rmse_N);
  std::vector<BoundState> bound_states = base.solution.bound_states;
  bound_states.resize(bound_states.size() + term.gains.size(), BoundState::free);
  ShapeCosts costs(measurement, base, term, constraints, bound_states);
  const auto cost = [&](const std::vector<double>& shapes) { return costs.of(shapes); };
  return refine_shapes(ranges, best_start(effect, starts, cost), cost, effort).shapes;
}

Trial try_effect(const Measurement& measurement, const FittedModel& base, const EffectDescription& effect,
                 const SearchEffort& effort, const std::vector<double>* start) {
  const Linearisation& linearisation = *base.linearisation;
  Trial best;
  best.term = term_for_log(measurement, effect);
  best.terms = base.terms;
  best.terms.push_back(best.term);
  const NormalEquations::Constraints constraints = constraints_of(best.terms, base.train_rmse_N);
  std::vector<BoundState> bound_states = base.solution.bound_states;
  for (std::size_t i = 0; i < best.term.gains.size(); ++i) bound_states.push_back(BoundState::free);

  // Shapes are chosen by the data that the gains are fitted to (variable projection, Golub and Pereyra 1973);
  // the held-out error judges what was chosen.
  ShapeCosts costs(measurement, base, best.term, constraints, bound_states);
  const auto cost = [&](const std::vector<double>& shapes) { return costs.of(shapes); };

  const std::vector<double> none;
  const bool repeats = effect.has_shape(ShapeKind::pitch);
  auto starts =
      start != nullptr
          ? std::vector<std::vector<double>>{*start}
          : starting_shapes(measurement, effect,
                            linearisation.residual_N().cwiseProduct(measurement.row_usable()),
                            linearisation.force_N(), repeats ? linearisation.sample_force_N() : none);
  std::vector<ShapeRange> ranges = searched_shapes(measurement, effect);
  if (bends_like_one_turn(measurement, base.terms)) leave_out_one_turn(measurement, effect, ranges, starts);
  // A user-defined effect may have many shapes, and a narrow minimum.
  SearchEffort own = effort;
  if (effect.is_user_defined()) own.evaluations *= std::max(1, static_cast<int>(ranges.size()));
  const auto groups = groups_of_starts(effect, ranges, starts);
  std::vector<SearchResult> found(groups.size());
  parallel_for(groups.size(), [&](std::size_t i) {
    const std::vector<double> first =
        groups[i].size() > 1 ? best_start(effect, groups[i], cost) : groups[i].front();
    found[i] = with_shortest_pitch(effect, ranges, refine_shapes(ranges, first, cost, own), cost, own);
  });
  SearchResult lowest = std::move(found.front());
  for (std::size_t i = 1; i < found.size(); ++i) {
    if (found[i].cost < lowest.cost) lowest = std::move(found[i]);
  }
  best.term.shapes = std::move(lowest.shapes);
  settle_pitch(measurement, best.term);
  const NormalEquations equations = costs.equations(best.term);
  const NormalEquations::Constraints held = with_bounds_of(best.term, constraints);
  const auto judged = equations.cross_validate(held, bound_states);
  best.terms.back() = best.term;
  take_gains(best.terms, equations.fit(held, bound_states).value);
  best.term = best.terms.back();
  best.holdout_rmse_N = judged.rmse;
  best.block_squared_error = judged.block_squared_error;
  best.below_visible = below_visible(effect, ranges, best.term.shapes) ||
                       within_presliding(measurement, base.terms, effect, best.term.shapes);
  if (best.below_visible) {
    best.holdout_rmse_N = base.holdout_rmse_N;
    best.block_squared_error = base.block_squared_error;
  }
  return best;
}

}  // namespace slipstack::workbench
