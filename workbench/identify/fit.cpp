// SPDX-License-Identifier: Apache-2.0
#include "workbench/identify/fit.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string_view>

#include "workbench/identify/shape_search.h"
#include "workbench/identify/standard_errors.h"

namespace slipstack::workbench {
namespace {

constexpr int kGaussNewtonSteps = 4;
constexpr double kAsGoodPitch = 1.01;    ///< cost, over that of the best pitch
constexpr double kWorthRefining = 1.03;  ///< the same, before the pitch is refined
constexpr double kSettled = 1e-4;        ///< relative change of the force that ends the Gauss-Newton steps

void take_gains(Terms& terms, const Eigen::VectorXd& gains) {
  Eigen::Index next = 0;
  for (Term& term : terms) {
    for (double& gain : term.gains) gain = gains(next++);
  }
}

bool all_zero(const Term& term) {
  for (const double gain : term.gains) {
    if (gain != 0.0) return false;
  }
  return true;
}

bool dry_friction_known(const Terms& terms) {
  for (const Term& term : terms) {
    if (term.effect->acts_as(Acts::dry) && !all_zero(term)) return true;
  }
  return false;
}

/// Gains of the model without what multiplies: a place from which products can be linearised.
void fit_without_products(const Measurement& measurement, Terms& terms, double noise_N) {
  Terms plain;
  for (const Term& term : terms) {
    if (!multiplies(term)) plain.push_back(term);
  }
  const Linearisation linearisation(measurement, plain);
  const NormalEquations equations(measurement, linearisation.columns(), linearisation.target());
  take_gains(plain, equations.fit(constraints_of(plain, noise_N)).value);
  for (Term& term : terms) {
    if (const Term* fitted = find_term(plain, term.effect->text.id)) term.gains = fitted->gains;
  }
}

/// Whether an effect fades below the slowest speed that the log shows: then it stands for something that
/// happens at reversals, and the log does not show this effect.
bool below_visible(const EffectDescription& effect, const std::vector<ShapeRange>& ranges,
                   const std::vector<double>& shapes) {
  return std::any_of(ranges.begin(), ranges.end(), [&](const ShapeRange& range) {
    return effect.shapes[range.index].kind == ShapeKind::fading_velocity &&
           shapes[range.index] < 1.05 * range.lower;
  });
}

/// The start of lowest cost; among pitches that do as well, within 1 %, the shortest: harmonics of a pitch
/// are harmonics of its multiples too.
std::vector<double> best_start(const EffectDescription& effect,
                               const std::vector<std::vector<double>>& starts,
                               const std::function<double(const std::vector<double>&)>& cost) {
  std::vector<double> costs;
  costs.reserve(starts.size());
  for (const auto& shapes : starts) costs.push_back(cost(shapes));
  std::size_t best = static_cast<std::size_t>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  const double enough = 1.01 * costs[best];
  for (std::size_t shape = 0; shape < effect.shapes.size(); ++shape) {
    if (effect.shapes[shape].kind != ShapeKind::pitch) continue;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      if (costs[i] <= enough && starts[i][shape] < starts[best][shape]) best = i;
    }
  }
  return starts[best];
}

/// Unless a half or a third of the pitch does as well: noise in the harmonics that a multiple adds can make
/// it the best by a hair.
SearchResult with_shortest_pitch(const EffectDescription& effect, const std::vector<ShapeRange>& ranges,
                                 SearchResult found,
                                 const std::function<double(const std::vector<double>&)>& cost,
                                 int evaluations) {
  const double enough = kAsGoodPitch * found.cost;
  for (const ShapeRange& range : ranges) {
    if (effect.shapes[range.index].kind != ShapeKind::pitch) continue;
    for (const double part : {2.0, 3.0}) {
      std::vector<double> shapes = found.shapes;
      shapes[range.index] /= part;
      if (shapes[range.index] < range.lower || cost(shapes) > kWorthRefining * found.cost) continue;
      SearchResult shorter = refine_shapes(ranges, std::move(shapes), cost, evaluations / 2);
      if (shorter.cost <= enough) found = std::move(shorter);
    }
  }
  return found;
}

/// Starts of one valley each: a memory that fades with distance alone is far from one that fades with time.
std::vector<std::vector<std::vector<double>>> valleys(const EffectDescription& effect,
                                                      const std::vector<ShapeRange>& ranges,
                                                      std::vector<std::vector<double>> starts) {
  const auto distance = std::find_if(ranges.begin(), ranges.end(), [&](const ShapeRange& range) {
    return effect.shapes[range.index].kind == ShapeKind::lag_distance;
  });
  if (distance == ranges.end()) return {std::move(starts)};
  const auto by_distance = std::stable_partition(starts.begin(), starts.end(), [&](const auto& shapes) {
    return shapes[distance->index] == distance->upper;
  });
  std::vector<std::vector<std::vector<double>>> all{{starts.begin(), by_distance},
                                                    {by_distance, starts.end()}};
  std::erase_if(all, [](const auto& one) { return one.empty(); });
  return all;
}

/// A model at its gains as they are: what trials need, without a fit.
FittedModel linearised(const Measurement& measurement, Terms terms, double error_N) {
  FittedModel model;
  model.linearisation = std::make_shared<Linearisation>(measurement, terms);
  model.equations = std::make_shared<NormalEquations>(measurement, model.linearisation->columns(),
                                                      model.linearisation->target());
  model.constraints = constraints_of(terms, error_N);
  model.train_rmse_N = error_N;
  model.solution = model.equations->fit(model.constraints);
  model.terms = std::move(terms);
  return model;
}

/// Evaluations in the search of a shape that has a customary value, and the part of the held-out error that
/// it must leave at most to lose it.
constexpr int kCustomaryEvaluations = 25;  ///< for each shape
constexpr double kWantsAnotherShape = 0.998;

/// Equations of the model with `term` added to `base`, its shapes as they are.
NormalEquations equations_with(const Measurement& measurement, const FittedModel& base, const Term& term) {
  const Linearisation& linearisation = *base.linearisation;
  if (term.gains.empty()) {  // a lag moves the measured force
    const Eigen::VectorXd target =
        linearisation.target() - linearisation.measured_N() + measurement.force_N(lag_of({term}));
    return base.equations->with_target(measurement, linearisation.columns(), target);
  }
  return base.equations->with(measurement, linearisation.columns(), linearisation.columns_of(term),
                              linearisation.target());
}

/// Held-out error of the model with `term` added to `base`.
double held_out_with(const Measurement& measurement, const FittedModel& base, const Term& term) {
  Terms terms = base.terms;
  terms.push_back(term);
  std::vector<Rests> rests = base.solution.rests;
  rests.resize(rests.size() + term.gains.size(), Rests::free);
  return equations_with(measurement, base, term)
      .cross_validate(constraints_of(terms, base.train_rmse_N), rests)
      .rmse;
}

constexpr std::string_view kLag = "time_delay";
/// Steps with which the search for a low pass begins: of what all lag is together, or of a sample.
constexpr double kFirstFilter = 0.5;
constexpr double kFirstLag = 0.1;

/// What settle_customary_shapes() searches of a term. Beside a filter the delay is searched again, as the
/// sum of both: the log tells what they are together far better than either.
std::vector<ShapeRange> ranges_to_settle(const Measurement& measurement, const Term& term, bool viscous) {
  std::vector<ShapeRange> ranges = customary_shapes(measurement, *term.effect);
  if (viscous) {
    for (ShapeRange& range : ranges) range.lower = range.customary;
  }
  if (term.id() != kLag) return ranges;
  const double lag_s = std::max(std::abs(lag_of({term}).total_s()), measurement.tick_s());
  ranges.front().first_step = kFirstFilter * lag_s;
  ranges.push_back(searched_shapes(measurement, *term.effect).front());
  ranges.back().first_step = kFirstLag * lag_s;
  return ranges;
}

/// Shapes of a lag whose delay has so many filters more: one for the sum of both, minus one back from it.
std::vector<double> moved_delay(const Term& term, std::vector<double> shapes, double filters) {
  if (term.id() != kLag) return shapes;
  const ShapeSpec& delay = term.effect->shapes[0];
  shapes[0] = std::clamp(shapes[0] + filters * shapes[1], static_cast<double>(delay.lower),
                         static_cast<double>(delay.upper));
  return shapes;
}

/// The model with the customary shapes of one term back at their values.
FittedModel customary(const Measurement& measurement, const FittedModel& fitted, std::size_t t) {
  Terms terms = fitted.terms;
  terms[t].shapes = moved_delay(terms[t], std::move(terms[t].shapes), 1.0);
  for (const ShapeRange& range : customary_shapes(measurement, *terms[t].effect)) {
    terms[t].shapes[range.index] = range.customary;
  }
  return terms[t].shapes == fitted.terms[t].shapes ? fitted
                                                   : fit_gains(measurement, std::move(terms), &fitted);
}

using Cost = std::function<double(const Term&)>;

/// The model with what settle_customary_shapes() searches of a term where the cost is lowest.
FittedModel search_customary(const Measurement& measurement, const FittedModel& fitted, std::size_t t,
                             const Cost& cost) {
  const Term& term = fitted.terms[t];
  const std::vector<ShapeRange> ranges =
      ranges_to_settle(measurement, term, contains(fitted.terms, "viscous"));
  const auto cost_of_shapes = [&](const std::vector<double>& shapes) {
    Term moved = term;
    moved.shapes = moved_delay(term, shapes, -1.0);
    return cost(moved);
  };
  const int evaluations = kCustomaryEvaluations * static_cast<int>(ranges.size());
  const SearchResult found =
      refine_shapes(ranges, moved_delay(term, term.shapes, 1.0), cost_of_shapes, evaluations);
  Terms terms = fitted.terms;
  terms[t].shapes = moved_delay(term, found.shapes, -1.0);
  return fit_gains(measurement, std::move(terms), &fitted);
}

/// Those shapes of a term where held-out data want them.
FittedModel settle_customary_shapes_of(const Measurement& measurement, FittedModel fitted, std::size_t t) {
  if (customary_shapes(measurement, *fitted.terms[t].effect).empty()) return fitted;
  const FittedModel base =
      linearised(measurement, without(fitted.terms, fitted.terms[t].id()), fitted.train_rmse_N);
  const auto held_out_N = [&](const Term& term) { return held_out_with(measurement, base, term); };
  FittedModel plain = customary(measurement, fitted, t);
  FittedModel moved = search_customary(measurement, fitted, t, held_out_N);
  if (!(moved.holdout_rmse_N < kWantsAnotherShape * plain.holdout_rmse_N)) return plain;
  if (moved.terms[t].id() != kLag) return moved;
  // The inverse of a low pass makes the force's noise louder, and so the low pass too short. Whether there is
  // one was asked with that against it; how long it is, is asked without. The rows hold no more noise than
  // the model leaves.
  const double gain = measurement.force_noise_gain({});
  const double noise_N = std::min(measurement.force_noise_N(), moved.train_rmse_N / gain);
  return search_customary(measurement, moved, t, [&](const Term& term) {
    const double louder_N = noise_N * measurement.force_noise_gain(lag_of({term}));
    const double error_N = held_out_N(term);
    return std::sqrt(
        std::max(0.0, error_N * error_N - louder_N * louder_N + noise_N * noise_N * gain * gain));
  });
}

/// The model with the shapes of one term searched, the others' held: from `start`, or from everywhere. As it
/// was where that is no better.
FittedModel with_shapes_searched(const Measurement& measurement, FittedModel fitted, std::size_t t,
                                 const SearchEffort& effort, const std::vector<double>* start) {
  const EffectDescription& effect = *fitted.terms[t].effect;
  if (searched_shapes(measurement, effect).empty()) return fitted;
  const FittedModel base =
      linearised(measurement, without(fitted.terms, fitted.terms[t].id()), fitted.train_rmse_N);
  Terms terms = fitted.terms;
  terms[t].shapes = try_effect(measurement, base, effect, effort, start).term.shapes;
  FittedModel moved = fit_gains(measurement, std::move(terms), &fitted);
  if (moved.holdout_rmse_N < fitted.holdout_rmse_N) fitted = std::move(moved);
  return fitted;
}

}  // namespace

Term term_for_log(const Measurement& measurement, const EffectDescription& effect) {
  Term term = make_term(measurement, effect);
  if (term.id() == "inertia") give_mass(measurement, term);
  return term;
}

void give_mass(const Measurement& measurement, Term& inertia) {
  const auto& parts = measurement.parts();
  if (!parts.front().mass_kg) return;
  // Declared masses are each log's, whether the gain would be or not.
  while (inertia.gains.size() < measurement.log_count()) inertia.gains.push_back(0.0);
  inertia.lower.resize(inertia.gains.size());
  inertia.upper.resize(inertia.gains.size());
  for (const LogPart& part : parts) {
    inertia.gains[part.log] = inertia.lower[part.log] = inertia.upper[part.log] = *part.mass_kg;
  }
}

FittedModel fit_gains(const Measurement& measurement, Terms terms, const FittedModel* known) {
  const double noise_N = measurement.filtered_force_noise_N();
  const bool products = any_multiplies(terms);
  if (products && !dry_friction_known(terms)) fit_without_products(measurement, terms, noise_N);

  FittedModel fitted;
  double error_N = known == nullptr ? noise_N : known->train_rmse_N;
  std::shared_ptr<const Linearisation> linearisation;
  Eigen::VectorXd before = Eigen::VectorXd::Zero(measurement.row_count());
  for (int step = 0; step < kGaussNewtonSteps; ++step) {
    linearisation = std::make_shared<Linearisation>(measurement, terms,
                                                    known == nullptr ? nullptr : known->linearisation.get());
    fitted.equations =
        std::make_shared<NormalEquations>(measurement, linearisation->columns(), linearisation->target());
    fitted.constraints = constraints_of(terms, error_N);
    fitted.solution = fitted.equations->fit(fitted.constraints, fitted.solution.rests);
    error_N = std::sqrt(fitted.equations->squared_error(fitted.solution.value) / fitted.equations->weight());
    take_gains(terms, fitted.solution.value);
    if (!products) break;
    const Eigen::VectorXd now = linearisation->columns() * fitted.solution.value;
    const bool settled = (now - before).norm() <= kSettled * now.norm();
    before = now;
    if (settled) break;
  }
  // The state that belongs to the final gains: residuals and trials start from it.
  fitted.linearisation = std::make_shared<Linearisation>(*linearisation, terms);
  const auto judged = fitted.equations->cross_validate(fitted.constraints, fitted.solution.rests);
  fitted.holdout_rmse_N = judged.rmse;
  fitted.block_squared_error = judged.block_squared_error;
  fitted.block_weight.resize(judged.block_squared_error.size());
  for (int block = 0; block < fitted.equations->block_count(); ++block) {
    fitted.block_weight[static_cast<std::size_t>(block)] = fitted.equations->weight(block);
  }
  const Eigen::VectorXd residual = fitted.linearisation->residual_N();
  fitted.train_rmse_N = measurement.weighted_rms(residual);
  const Eigen::VectorXd& usable = measurement.row_usable();
  fitted.relative_error = residual.cwiseProduct(usable).norm() /
                          std::max(fitted.linearisation->measured_N().cwiseProduct(usable).norm(), 1e-300);
  fitted.terms = std::move(terms);
  return fitted;
}

Trial try_effect(const Measurement& measurement, const FittedModel& base, const EffectDescription& effect,
                 const SearchEffort& effort, const std::vector<double>* start) {
  const Linearisation& linearisation = *base.linearisation;
  Trial best;
  best.term = term_for_log(measurement, effect);
  best.terms = base.terms;
  best.terms.push_back(best.term);
  const NormalEquations::Constraints constraints = constraints_of(best.terms, base.train_rmse_N);
  std::vector<Rests> rests = base.solution.rests;
  for (std::size_t i = 0; i < best.term.gains.size(); ++i) rests.push_back(Rests::free);

  const auto equations_at = [&](const std::vector<double>& shapes) {
    Term term = best.term;
    term.shapes = shapes;
    return equations_with(measurement, base, term);
  };
  const auto judge = [&](const NormalEquations& equations) {
    return equations.cross_validate(constraints, rests);
  };
  const auto cost = [&](const std::vector<double>& shapes) { return judge(equations_at(shapes)).rmse; };

  const auto starts = start != nullptr
                          ? std::vector<std::vector<double>>{*start}
                          : starting_shapes(measurement, effect,
                                            linearisation.residual_N().cwiseProduct(measurement.row_usable()),
                                            linearisation.force_N());
  const std::vector<ShapeRange> ranges = searched_shapes(measurement, effect);
  // A user's own effect may have many shapes, and a narrow place to find.
  const int evaluations = effect.is_own() ? effort.evaluations * std::max(1, static_cast<int>(ranges.size()))
                                          : effort.evaluations;
  SearchResult lowest;
  for (const auto& valley : valleys(effect, ranges, starts)) {
    const std::vector<double> first = valley.size() > 1 ? best_start(effect, valley, cost) : valley.front();
    SearchResult found = with_shortest_pitch(effect, ranges, refine_shapes(ranges, first, cost, evaluations),
                                             cost, evaluations);
    if (lowest.shapes.empty() || found.cost < lowest.cost) lowest = std::move(found);
  }
  best.term.shapes = std::move(lowest.shapes);
  const NormalEquations equations = equations_at(best.term.shapes);
  const auto judged = judge(equations);
  best.terms.back() = best.term;
  take_gains(best.terms, equations.fit(constraints, rests).value);
  best.term = best.terms.back();
  best.holdout_rmse_N = judged.rmse;
  best.block_squared_error = judged.block_squared_error;
  if (below_visible(effect, ranges, best.term.shapes)) {
    best.holdout_rmse_N = base.holdout_rmse_N;
    best.block_squared_error = base.block_squared_error;
  }
  return best;
}

FittedModel fit_effects(const Measurement& measurement, const std::vector<std::string>& effects,
                        const SearchEffort& effort) {
  Terms fixed;
  std::vector<const EffectDescription*> searched;
  for (const std::string& id : effects) {
    const EffectDescription* effect = find_effect(id);
    if (searched_shapes(measurement, *effect).empty() && !effect->acts_as(Acts::dry_scale)) {
      fixed.push_back(term_for_log(measurement, *effect));
    } else {
      searched.push_back(effect);
    }
  }
  FittedModel fitted = fit_gains(measurement, fixed);
  // Dry friction before what modulates it.
  std::stable_sort(searched.begin(), searched.end(), [](const auto* a, const auto* b) {
    return a->acts_as(Acts::dry) && !b->acts_as(Acts::dry);
  });
  for (const EffectDescription* effect : searched) {
    fitted = fit_gains(measurement, try_effect(measurement, fitted, *effect, effort).terms, &fitted);
  }
  if (searched.size() > 1) fitted = polish_shapes(measurement, std::move(fitted), effort);
  // In the order that was asked for.
  Terms ordered;
  for (const std::string& id : effects) ordered.push_back(*find_term(fitted.terms, id));
  fitted = fit_gains(measurement, std::move(ordered), &fitted);
  return searched.empty() ? fitted : settle_shapes(measurement, std::move(fitted));
}

FittedModel polish_shapes(const Measurement& measurement, FittedModel fitted, const SearchEffort& effort) {
  for (std::size_t t = 0; t < fitted.terms.size(); ++t) {
    const std::vector<double> here = fitted.terms[t].shapes;
    fitted = with_shapes_searched(measurement, std::move(fitted), t, effort, &here);
  }
  return fitted;
}

FittedModel search_anew(const Measurement& measurement, FittedModel fitted,
                        const std::vector<std::string>& effects) {
  for (std::size_t t = 0; t < fitted.terms.size(); ++t) {
    if (std::find(effects.begin(), effects.end(), fitted.terms[t].id()) == effects.end()) continue;
    fitted = with_shapes_searched(measurement, std::move(fitted), t, {}, nullptr);
  }
  return fitted;
}

FittedModel settle_customary_shapes(const Measurement& measurement, FittedModel fitted) {
  for (std::size_t t = 0; t < fitted.terms.size(); ++t) {
    fitted = settle_customary_shapes_of(measurement, std::move(fitted), t);
  }
  return fitted;
}

FittedModel settle_lag(const Measurement& measurement, FittedModel fitted) {
  for (std::size_t t = 0; t < fitted.terms.size(); ++t) {
    if (fitted.terms[t].id() == kLag) fitted = settle_customary_shapes_of(measurement, std::move(fitted), t);
  }
  return fitted;
}

}  // namespace slipstack::workbench
