// SPDX-License-Identifier: Apache-2.0
#include "workbench/simulate/two_criteria.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "workbench/base/axis_words.h"
#include "workbench/base/errors.h"
#include "workbench/base/statistics.h"
#include "workbench/base/text.h"
#include "workbench/simulate/output_error.h"
#include "workbench/simulate/run_intervals.h"

namespace slipstack::workbench {
namespace {

void check_can_be_simulated(const std::string& logs, const Measurement& measurement, const Terms& terms) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(fmt::format("{}: --criterion simulation: {}", printable(logs), why));
  };
  for (std::size_t log = 0; log < measurement.log_count(); ++log) {
    if (!(mass_kg(terms, log) > 0.0)) {
      refuse(
          fmt::format("the model has no {} that the {} could drive; a motion that is prescribed is fitted by "
                      "inverse dynamics",
                      mass_word(), force_word()));
    }
  }
  const std::vector<double>& force_N = measurement.log().force_N;
  const auto [low, high] = std::minmax_element(force_N.begin(), force_N.end());
  if (*low == *high) refuse(fmt::format("the {} never changes, so it does not drive the axis", force_word()));
  if (measurement.is_excerpt()) {
    refuse("the log is too long to be simulated as a whole; give a part of at most 400000 samples");
  }
}

/// Sums of squares of the force's error over the rows of each run.
class ForceErrors {
 public:
  ForceErrors(const Measurement& measurement, const std::vector<FreeRunInterval>& runs)
      : measurement_(measurement), run_of_row_(measurement.row_samples().size(), -1) {
    for (std::size_t row = 0; row < run_of_row_.size(); ++row) {
      const std::size_t sample = measurement.row_samples()[row];
      const auto after =
          std::upper_bound(runs.begin(), runs.end(), sample,
                           [](std::size_t s, const FreeRunInterval& run) { return s < run.first; });
      if (after != runs.begin() && sample < (after - 1)->end) {
        run_of_row_[row] = static_cast<int>(after - runs.begin()) - 1;
      }
    }
  }

  bool is_in(Eigen::Index row, const std::vector<bool>& runs) const {
    const int run = run_of_row_[static_cast<std::size_t>(row)];
    return run >= 0 && runs[static_cast<std::size_t>(run)];
  }

  Eigen::VectorXd residual_N(const Terms& terms) const {
    return measurement_.force_N(measurement_dynamics_of(terms)) -
           measurement_.filtered(evaluate_force(measurement_, terms).force_N);
  }

  /// Adds the weighted squares and weights of the rows in these runs; the squares also to those of the
  /// blocks.
  void add(const Eigen::VectorXd& residual_N, const std::vector<bool>& runs, double& squares, double& weight,
           std::vector<double>* blocks = nullptr) const {
    for (Eigen::Index row = 0; row < residual_N.size(); ++row) {
      if (!is_in(row, runs)) continue;
      const double own = measurement_.row_weights()(row);
      squares += own * squared(residual_N(row));
      weight += own;
      if (blocks == nullptr) continue;
      const int block = measurement_.row_blocks()[static_cast<std::size_t>(row)];
      (*blocks)[static_cast<std::size_t>(block)] += own * squared(residual_N(row));
    }
  }

  /// The gains of a fit by inverse dynamics that has not seen the rows of these runs.
  Terms fitted_without(const std::vector<bool>& unseen, const Terms& terms) const {
    Measurement seen = measurement_;
    Eigen::VectorXd weights = measurement_.fit_weights();
    for (Eigen::Index row = 0; row < weights.size(); ++row) {
      if (is_in(row, unseen)) weights(row) = 0.0;
    }
    seen.set_fit_weights(weights);
    return fit_gains(seen, terms).terms;
  }

 private:
  const Measurement& measurement_;
  std::vector<int> run_of_row_;  ///< -1: in none
};

/// Which runs are unseen: a fifth of them each, dealt in turn, and at last the last third of each log.
std::vector<std::vector<bool>> unseen_runs(const Measurement& measurement,
                                           const std::vector<FreeRunInterval>& runs) {
  std::vector<std::vector<bool>> unseen(kFolds + 1, std::vector<bool>(runs.size(), false));
  for (std::size_t k = 0; k < runs.size(); ++k) {
    unseen[k % kFolds][k] = true;
    const LogPart& part = measurement.parts()[runs[k].part];
    unseen[kFolds][k] = 3 * (runs[k].first - part.first_sample) >= 2 * part.sample_count;
  }
  return unseen;
}

std::vector<FreeRunInterval> chosen(const std::vector<FreeRunInterval>& runs,
                                    const std::vector<bool>& which) {
  std::vector<FreeRunInterval> some;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    if (which[k]) some.push_back(runs[k]);
  }
  return some;
}

/// The errors of one criterion, from the models of its fits to a part of the data.
class Judge {
 public:
  Judge(const Measurement& measurement, const ForceErrors& force, const std::vector<FreeRunInterval>& runs,
        int steps_per_sample)
      : measurement_(measurement),
        force_(force),
        runs_(runs),
        unseen_(unseen_runs(measurement, runs)),
        steps_per_sample_(steps_per_sample) {}

  const std::vector<std::vector<bool>>& unseen() const { return unseen_; }

  /// `without`: one model for each of unseen(). `blocks`: squares of the held-out force error by block.
  CriterionErrors of(const Terms& all, const std::vector<Terms>& without, std::vector<double>& blocks) const {
    CriterionErrors errors;
    errors.force_N = measurement_.weighted_rms(force_.residual_N(all));
    errors.position_m = free_run_rmse_m(measurement_, all, joined_runs(runs_), steps_per_sample_);
    blocks.assign(static_cast<std::size_t>(measurement_.block_count()), 0.0);
    double squares = 0.0;
    double weight = 0.0;
    double squares_m2 = 0.0;
    double samples = 0.0;
    for (std::size_t fold = 0; fold < kFolds; ++fold) {
      force_.add(force_.residual_N(without[fold]), unseen_[fold], squares, weight, &blocks);
      const std::vector<FreeRunInterval> own = chosen(runs_, unseen_[fold]);
      double count = 0.0;
      for (const FreeRunInterval& run : own) count += static_cast<double>(run.size());
      squares_m2 += count * squared(free_run_rmse_m(measurement_, without[fold], own, steps_per_sample_));
      samples += count;
    }
    errors.held_out_force_N = std::sqrt(squares / std::max(weight, 1e-300));
    errors.held_out_position_m = std::sqrt(squares_m2 / samples);
    squares = weight = 0.0;
    force_.add(force_.residual_N(without.back()), unseen_.back(), squares, weight);
    errors.forward_force_N = std::sqrt(squares / std::max(weight, 1e-300));
    errors.forward_position_m = free_run_rmse_m(
        measurement_, without.back(), joined_runs(chosen(runs_, unseen_.back())), steps_per_sample_);
    return errors;
  }

 private:
  const Measurement& measurement_;
  const ForceErrors& force_;
  const std::vector<FreeRunInterval>& runs_;
  std::vector<std::vector<bool>> unseen_;
  int steps_per_sample_;
};

/// `like` with other gains; its errors in sample are computed, those on unseen data left.
FittedModel with_terms(const Measurement& measurement, FittedModel like, Terms terms) {
  like.terms = std::move(terms);
  like.linearisation = std::make_shared<Linearisation>(measurement, like.terms);
  like.solution.value = gains_of(like.terms);
  set_errors_in_sample(measurement, like);
  return like;
}

}  // namespace

SimulationFit fit_by_simulation(const std::string& logs, const Measurement& measurement,
                                const FittedModel& start, double horizon_s,
                                const std::function<void(double fraction)>& progress) {
  check_can_be_simulated(logs, measurement, start.terms);
  constexpr double kShareOfFit = 0.6;  // of the time; only for the display
  OutputErrorFit fit(measurement, start, run_intervals(logs, measurement, start.terms, horizon_s),
                     [&](double fraction) { progress(kShareOfFit * fraction); });
  SimulationFit result;
  result.converged = fit.run();
  const std::vector<FreeRunInterval>& runs = fit.runs();
  const ForceErrors force(measurement, runs);
  const Judge judge(measurement, force, runs, fit.steps_per_sample());
  std::vector<Terms> by_force;
  std::vector<Terms> by_position;
  for (std::size_t i = 0; i < judge.unseen().size(); ++i) {
    progress(kShareOfFit +
             (1.0 - kShareOfFit) * static_cast<double>(i) / static_cast<double>(judge.unseen().size()));
    by_force.push_back(force.fitted_without(judge.unseen()[i], start.terms));
    by_position.push_back(fit.fitted_without(judge.unseen()[i]));
  }
  std::vector<double> blocks;
  result.inverse_dynamics = judge.of(start.terms, by_force, blocks);
  result.simulation = judge.of(fit.terms(), by_position, blocks);
  if (!std::isfinite(result.simulation.position_m)) {
    throw InputError(fmt::format(
        "{}: --criterion simulation: the simulated axis runs away; the model does not fit this log",
        printable(logs)));
  }
  result.model = with_terms(measurement, start, fit.terms_with_standard_errors());
  result.model.block_squared_error = std::move(blocks);
  result.model.holdout_rmse_N = result.simulation.held_out_force_N;
  result.model.forward_rmse_N = result.simulation.forward_force_N;
  result.parameters = fit.parameters().size();
  result.runs = runs.size();
  for (const FreeRunInterval& run : runs) {
    result.run_s += static_cast<double>(run.size()) * measurement.tick_s() / static_cast<double>(runs.size());
  }
  return result;
}

FittedModel with_refined_gains(const Measurement& measurement, const FittedModel& before,
                               const FittedModel& refined, FittedModel reduced) {
  Terms terms = reduced.terms;
  for (Term& term : terms) {
    const Term* own = find_term(refined.terms, term.id());
    const Term* earlier = find_term(before.terms, term.id());
    if (own == nullptr || earlier == nullptr) continue;
    if (term.effect->has_role(Role::hysteresis)) {
      const double factor = hysteresis_level_N(*own) / std::max(hysteresis_level_N(*earlier), 1e-300);
      for (double& gain : term.gains) gain *= factor;
    } else {
      term.gains = own->gains;
      term.gain_standard_errors = own->gain_standard_errors;
    }
  }
  reduced = with_terms(measurement, std::move(reduced), std::move(terms));
  // The gains are those of the model before the reduction, which adds its error to that on unseen data.
  const double added_N2 = squared(reduced.train_rmse_N) - squared(refined.train_rmse_N);
  reduced.holdout_rmse_N = std::sqrt(std::max(0.0, squared(refined.holdout_rmse_N) + added_N2));
  return reduced;
}

}  // namespace slipstack::workbench
