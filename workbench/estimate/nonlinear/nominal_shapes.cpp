// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/nominal_shapes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "workbench/estimate/nonlinear/minimise.h"
#include "workbench/estimate/nonlinear/trial.h"
#include "workbench/estimate/terms/search_ranges.h"

namespace slipstack::workbench {
namespace {

constexpr int kNominalEvaluations = 25;  ///< of the search, for each shape; chosen
/// A shape leaves its nominal value only if the held-out error falls below this fraction of the error at the
/// nominal value. Chosen.
constexpr double kLeavesNominal = 0.998;

bool is_delay(const Term& term) {
  return term.effect->has_role(Role::measurement_delay);
}

/// Initial steps of the search for a low pass and for the total lag, as fractions of the total lag. Chosen.
constexpr double kFirstFilter = 0.5;
constexpr double kFirstLag = 0.1;

/// Held-out error of the model with `term` added to `base`.
double held_out_with(const Measurement& measurement, const FittedModel& base, const Term& term) {
  Terms terms = base.terms;
  terms.push_back(term);
  std::vector<BoundState> bound_states = base.solution.bound_states;
  bound_states.resize(bound_states.size() + term.gains.size(), BoundState::free);
  return equations_with(measurement, *base.linearisation, *base.equations, term)
      .cross_validate(constraints_of(terms, base.train_rmse_N), bound_states)
      .rmse;
}

/// The shapes of a term that refine_nominal_shapes() searches. Together with a filter the delay is searched
/// again, as the sum of both, because the log determines their sum far better than either of them.
std::vector<ShapeRange> ranges_to_refine(const Measurement& measurement, const Term& term, bool viscous) {
  std::vector<ShapeRange> ranges = nominal_shapes(measurement, *term.effect);
  if (viscous) {
    for (ShapeRange& range : ranges) range.lower = range.nominal;
  }
  if (!is_delay(term)) return ranges;
  const double lag_s = std::max(std::abs(measurement_dynamics_of({term}).total_s()), measurement.tick_s());
  ranges.front().first_step = kFirstFilter * lag_s;
  ranges.push_back(searched_shapes(measurement, *term.effect).front());
  ranges.back().first_step = kFirstLag * lag_s;
  return ranges;
}

/// Shapes of a lag with `filters` times the filter's time constant added to its delay: +1 turns the delay
/// into the sum of both, -1 turns the sum back into the delay.
std::vector<double> moved_delay(const Term& term, std::vector<double> shapes, double filters) {
  if (!is_delay(term)) return shapes;
  const ShapeSpec& delay = term.effect->shapes[0];
  shapes[0] = std::clamp(shapes[0] + filters * shapes[1], static_cast<double>(delay.lower),
                         static_cast<double>(delay.upper));
  return shapes;
}

/// The model with the nominal shapes of one term set back to their nominal values.
FittedModel nominal(const Measurement& measurement, const FittedModel& fitted, std::size_t t) {
  Terms terms = fitted.terms;
  terms[t].shapes = moved_delay(terms[t], std::move(terms[t].shapes), 1.0);
  for (const ShapeRange& range : nominal_shapes(measurement, *terms[t].effect)) {
    terms[t].shapes[range.index] = range.nominal;
  }
  return terms[t].shapes == fitted.terms[t].shapes ? fitted
                                                   : fit_gains(measurement, std::move(terms), &fitted);
}

using Cost = std::function<double(const Term&)>;

/// The model with the searched shapes of one term (ranges_to_refine()) at the lowest cost.
FittedModel search_nominal(const Measurement& measurement, const FittedModel& fitted, std::size_t t,
                           const Cost& cost) {
  const Term& term = fitted.terms[t];
  const std::vector<ShapeRange> ranges =
      ranges_to_refine(measurement, term, has_role(fitted.terms, Role::viscous_friction));
  const auto cost_of_shapes = [&](const std::vector<double>& shapes) {
    Term moved = term;
    moved.shapes = moved_delay(term, shapes, -1.0);
    return cost(moved);
  };
  const int evaluations = kNominalEvaluations * static_cast<int>(ranges.size());
  const SearchResult found =
      refine_shapes(ranges, moved_delay(term, term.shapes, 1.0), cost_of_shapes, {evaluations});
  Terms terms = fitted.terms;
  terms[t].shapes = moved_delay(term, found.shapes, -1.0);
  return fit_gains(measurement, std::move(terms), &fitted);
}

/// Whether a term is a low pass beside a negative delay, which takes most of its lag back: a force that was
/// filtered is late. What is left of both is a lead that grows with frequency, of an elastic drive or of the
/// encoder.
bool is_lead(const Term& term) {
  return is_delay(term) && term.shapes[1] > 0.0 && term.shapes[0] < -0.5 * term.shapes[1];
}

/// Releases the nominal shapes of one term, where the held-out error demands it.
FittedModel refine_nominal_shapes_of(const Measurement& measurement, FittedModel fitted, std::size_t t) {
  if (nominal_shapes(measurement, *fitted.terms[t].effect).empty()) return fitted;
  const FittedModel base =
      linearised(measurement, without(fitted.terms, fitted.terms[t].id()), fitted.train_rmse_N, &fitted);
  const auto held_out_N = [&](const Term& term) { return held_out_with(measurement, base, term); };
  FittedModel plain = nominal(measurement, fitted, t);
  FittedModel moved = search_nominal(measurement, fitted, t, held_out_N);
  if (!(moved.holdout_rmse_N < kLeavesNominal * plain.holdout_rmse_N) || is_lead(moved.terms[t]))
    return plain;
  if (!is_delay(moved.terms[t])) return moved;
  // The inverse of a low pass amplifies the noise of the force, which biases the estimated low pass towards
  // zero. The decision whether there is one was taken above with this bias, which is on the safe side. Its
  // time constant is estimated here with the amplified noise subtracted. The rows cannot hold more noise than
  // the residual.
  const double gain = measurement.force_noise_gain({});
  const double noise_N = std::min(measurement.force_noise_N(), moved.train_rmse_N / gain);
  FittedModel filtered = search_nominal(measurement, moved, t, [&](const Term& term) {
    const double amplified_N = noise_N * measurement.force_noise_gain(measurement_dynamics_of({term}));
    const double error_N = held_out_N(term);
    return std::sqrt(
        std::max(0.0, error_N * error_N - amplified_N * amplified_N + noise_N * noise_N * gain * gain));
  });
  return is_lead(filtered.terms[t]) ? plain : filtered;
}

}  // namespace

FittedModel refine_nominal_shapes(const Measurement& measurement, FittedModel fitted) {
  for (std::size_t t = 0; t < fitted.terms.size(); ++t) {
    fitted = refine_nominal_shapes_of(measurement, std::move(fitted), t);
  }
  return fitted;
}

FittedModel refine_delay(const Measurement& measurement, FittedModel fitted) {
  for (std::size_t t = 0; t < fitted.terms.size(); ++t) {
    if (is_delay(fitted.terms[t])) fitted = refine_nominal_shapes_of(measurement, std::move(fitted), t);
  }
  return fitted;
}

}  // namespace slipstack::workbench
