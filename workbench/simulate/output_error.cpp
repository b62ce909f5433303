// SPDX-License-Identifier: Apache-2.0
#include "workbench/simulate/output_error.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "workbench/base/linear_systems.h"
#include "workbench/base/parallel.h"
#include "workbench/base/statistics.h"
#include "workbench/simulate/run_intervals.h"

namespace slipstack::workbench {
namespace {

constexpr int kMostSteps = 20;
/// Steps of a fit to a part of the runs, which starts at the solution of all.
constexpr int kStepsOfPart = 4;
/// Relative decrease of the squared error that ends the steps.
constexpr double kConverged = 1e-4;
/// Damping relative to the diagonal (Marquardt 1963): at first, its change after a step that helped and after
/// one that did not, and its limits.
constexpr double kFirstDamping = 1e-3;
constexpr double kAfterSuccess = 0.2;
constexpr double kAfterFailure = 5.0;
constexpr double kLeastDamping = 1e-9;
constexpr double kMostDamping = 1e6;
/// The position is smooth: of all runs together about so many samples enter the regression. Chosen.
constexpr std::size_t kComparedSamples = 50'000;
/// Coarser than a simulation that is shown, for speed; the scheme is stable below 2.
constexpr double kStepTimesRate = 0.5;

/// Column of difference quotients; zero where the moved model runs away.
Eigen::VectorXd quotient(const Eigen::VectorXd& moved, const Eigen::VectorXd& here, double step) {
  const Eigen::VectorXd change = moved - here;
  if (step == 0.0 || !change.allFinite()) return Eigen::VectorXd::Zero(here.size());
  return change / step;
}

}  // namespace

OutputErrorFit::OutputErrorFit(const Measurement& measurement, const FittedModel& start,
                               std::vector<FreeRunInterval> runs,
                               std::function<void(double fraction)> progress)
    : measurement_(measurement),
      start_(start.terms),
      runs_(std::move(runs)),
      progress_(std::move(progress)),
      parameters_(free_parameters(start)),
      steps_per_sample_(free_run_steps(measurement, start_, kStepTimesRate)),
      deviation_(initial_state_deviation(measurement)) {
  std::size_t samples = 0;
  for (const FreeRunInterval& run : runs_) samples += run.size();
  stride_ = std::max<std::size_t>(1, samples / kComparedSamples);
}

Eigen::VectorXd OutputErrorFit::error_m(std::size_t run, const Terms& terms,
                                        const InitialState& state) const {
  const FreeRunInterval& interval = runs_[run];
  const Terms own = terms_of_log(terms, measurement_.parts()[interval.part].log);
  const std::vector<double> position_m = free_run(measurement_, own, interval, steps_per_sample_, state);
  const std::vector<double>& measured_m = measurement_.log().position_m;
  Eigen::VectorXd error_m(static_cast<Eigen::Index>((interval.size() + stride_ - 1) / stride_));
  for (Eigen::Index i = 0; i < error_m.size(); ++i) {
    const std::size_t sample = static_cast<std::size_t>(i) * stride_;
    error_m(i) = position_m[sample] - measured_m[interval.first + sample];
  }
  return error_m;
}

OutputErrorFit::State OutputErrorFit::evaluated(Solution solution, const std::vector<bool>& use) const {
  State state{std::move(solution), std::vector<Eigen::VectorXd>(runs_.size()), 0.0};
  parallel_for(runs_.size(), [&](std::size_t k) {
    if (use[k]) state.errors_m[k] = error_m(k, state.solution.terms, state.solution.states[k]);
  });
  state.cost_m2 = cost_m2(state, use);
  return state;
}

double OutputErrorFit::cost_m2(const State& at, const std::vector<bool>& use) const {
  double cost = 0.0;
  for (std::size_t k = 0; k < runs_.size(); ++k) {
    if (!use[k]) continue;
    const InitialState& start = at.solution.states[k];
    cost +=
        at.errors_m[k].squaredNorm() + variance_m2_ * (squared(start.position_m / deviation_.position_m) +
                                                       squared(start.velocity_mps / deviation_.velocity_mps));
  }
  return std::isfinite(cost) ? cost : std::numeric_limits<double>::infinity();
}

std::vector<OutputErrorFit::Derivatives> OutputErrorFit::derivatives(const State& at) const {
  const std::size_t count = parameters_.size();
  const Solution& here = at.solution;
  std::vector<Terms> moved(count, here.terms);
  std::vector<double> by(count);
  for (std::size_t p = 0; p < count; ++p) {
    const FreeParameter& parameter = parameters_[p];
    const double value = value_of(parameter, here.terms, start_);
    const bool up = value + parameter.step <= parameter.upper;
    set_value(parameter, value + (up ? parameter.step : -parameter.step), start_, moved[p]);
    by[p] = value_of(parameter, moved[p], start_) - value;
  }
  std::vector<Derivatives> all(runs_.size());
  for (std::size_t k = 0; k < runs_.size(); ++k) {
    all[k].by_parameter.resize(at.errors_m[k].size(), static_cast<Eigen::Index>(count));
    all[k].by_state.resize(at.errors_m[k].size(), 2);
  }
  parallel_for(runs_.size() * (count + 2), [&](std::size_t i) {
    const std::size_t k = i % runs_.size();
    const std::size_t p = i / runs_.size();
    const Eigen::VectorXd& errors_m = at.errors_m[k];
    InitialState state = here.states[k];
    if (p < count) {
      all[k].by_parameter.col(static_cast<Eigen::Index>(p)) =
          quotient(error_m(k, moved[p], state), errors_m, by[p]);
    } else if (p == count) {
      state.position_m += deviation_.position_m;
      all[k].by_state.col(0) = quotient(error_m(k, here.terms, state), errors_m, deviation_.position_m);
    } else {
      state.velocity_mps += deviation_.velocity_mps;
      all[k].by_state.col(1) = quotient(error_m(k, here.terms, state), errors_m, deviation_.velocity_mps);
    }
  });
  return all;
}

OutputErrorFit::OfRun OutputErrorFit::reduced(const State& at, std::size_t run, double damping) const {
  const Derivatives& by = derivatives_[run];
  const Eigen::VectorXd& errors_m = at.errors_m[run];
  const InitialState& start = at.solution.states[run];
  const Eigen::Vector2d precision(variance_m2_ / squared(deviation_.position_m),
                                  variance_m2_ / squared(deviation_.velocity_mps));
  OfRun one;
  Eigen::Matrix2d own = by.by_state.transpose() * by.by_state;
  own.diagonal() = (1.0 + damping) * (own.diagonal() + precision);
  one.inverse = own.inverse();
  one.coupling = by.by_state.transpose() * by.by_parameter;
  one.state_gradient = by.by_state.transpose() * errors_m +
                       precision.cwiseProduct(Eigen::Vector2d(start.position_m, start.velocity_mps));
  const Eigen::MatrixXd plain = by.by_parameter.transpose() * by.by_parameter;
  const Eigen::MatrixXd eliminated = one.coupling.transpose() * one.inverse;
  one.diagonal = plain.diagonal();
  one.matrix = plain - eliminated * one.coupling;
  one.gradient = by.by_parameter.transpose() * errors_m - eliminated * one.state_gradient;
  return one;
}

/// The step to the minimum of the linearised problem. The initial state of a run occurs in no other, so the
/// states are eliminated one by one.
OutputErrorFit::Step OutputErrorFit::solve(const State& at, const std::vector<bool>& use,
                                           double damping) const {
  const auto count = static_cast<Eigen::Index>(parameters_.size());
  std::vector<OfRun> of_run(runs_.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(count);
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(count);
  for (std::size_t k = 0; k < runs_.size(); ++k) {
    if (!use[k]) continue;
    of_run[k] = reduced(at, k, damping);
    matrix += of_run[k].matrix;
    gradient += of_run[k].gradient;
    diagonal += of_run[k].diagonal;
  }
  for (Eigen::Index p = 0; p < count; ++p) {
    matrix(p, p) += diagonal(p) > 0.0 ? damping * diagonal(p) : 1.0;
  }
  Step step{-solve_symmetric(matrix, gradient), std::vector<InitialState>(runs_.size())};
  for (std::size_t k = 0; k < runs_.size(); ++k) {
    if (!use[k]) continue;
    const OfRun& one = of_run[k];
    const Eigen::Vector2d change = -one.inverse * (one.state_gradient + one.coupling * step.parameters);
    step.states[k] = {change(0), change(1)};
  }
  return step;
}

Terms OutputErrorFit::terms_with_standard_errors() const {
  const auto count = static_cast<Eigen::Index>(parameters_.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, count);
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(count, count);
  for (std::size_t k = 0; k < runs_.size(); ++k) {
    const OfRun one = reduced(here_, k, 0.0);
    matrix += one.matrix;
    scatter += one.gradient * one.gradient.transpose();
  }
  const auto runs = static_cast<double>(runs_.size());
  scatter *= runs / std::max(1.0, runs - static_cast<double>(count));
  const Eigen::MatrixXd inverse = pseudo_inverse(matrix);
  const Eigen::MatrixXd covariance = inverse * scatter * inverse;
  Terms terms = here_.solution.terms;
  for (Term& term : terms) {
    term.gain_standard_errors.assign(term.gains.size(), 0.0);
    term.shape_standard_errors.assign(term.shapes.size(), 0.0);
    term.total_standard_errors.assign(term.gain_sets(), 0.0);
  }
  for (Eigen::Index p = 0; p < count; ++p) {
    const FreeParameter& parameter = parameters_[static_cast<std::size_t>(p)];
    const double error = std::sqrt(std::max(0.0, covariance(p, p)));
    for (std::size_t g = parameter.first; g < parameter.first + parameter.count; ++g) {
      const double unit = parameter.is_factor() ? std::abs(start_[parameter.term].gains[g]) : 1.0;
      terms[parameter.term].gain_standard_errors[g] = unit * error;
    }
    if (!terms[parameter.term].effect->has_role(Role::hysteresis)) continue;
    const Term& start = start_[parameter.term];
    for (std::size_t set = 0; set < start.gain_sets(); ++set)
      terms[parameter.term].total_standard_errors[set] = hysteresis_level_N(start, set) * error;
  }
  return terms;
}

OutputErrorFit::Solution OutputErrorFit::moved(const Solution& from, const Step& step) const {
  Solution to = from;
  for (std::size_t p = 0; p < parameters_.size(); ++p) {
    const double value = value_of(parameters_[p], from.terms, start_);
    set_value(parameters_[p], value + step.parameters(static_cast<Eigen::Index>(p)), start_, to.terms);
  }
  keep_parts_within(to.terms);
  for (std::size_t k = 0; k < to.states.size(); ++k) {
    to.states[k].position_m += step.states[k].position_m;
    to.states[k].velocity_mps += step.states[k].velocity_mps;
  }
  return to;
}

/// One step, damped as far as it needs to lower the cost. Returns whether another is worth while.
bool OutputErrorFit::attempt(State& here, const std::vector<bool>& use, double& damping) const {
  for (; damping <= kMostDamping; damping *= kAfterFailure) {
    State there = evaluated(moved(here.solution, solve(here, use, damping)), use);
    if (there.cost_m2 >= here.cost_m2) continue;
    // A short step that helps little does not say that a longer one would not.
    const bool goes_on = there.cost_m2 < (1.0 - kConverged) * here.cost_m2 || damping > kFirstDamping;
    here = std::move(there);
    damping = std::max(kAfterSuccess * damping, kLeastDamping);
    return goes_on;
  }
  return false;
}

bool OutputErrorFit::run() {
  const std::vector<bool> all(runs_.size(), true);
  here_ = evaluated({start_, std::vector<InitialState>(runs_.size())}, all);
  double samples = 0.0;
  for (const Eigen::VectorXd& errors_m : here_.errors_m) samples += static_cast<double>(errors_m.size());
  variance_m2_ = here_.cost_m2 / samples;
  double damping = kFirstDamping;
  if (!std::isfinite(here_.cost_m2)) return false;
  bool goes_on = true;
  for (int step = 0; step < kMostSteps && goes_on; ++step) {
    if (progress_) progress_(static_cast<double>(step) / kMostSteps);
    derivatives_ = derivatives(here_);
    goes_on = attempt(here_, all, damping);
  }
  return !goes_on;
}

Terms OutputErrorFit::fitted_without(const std::vector<bool>& unseen) const {
  std::vector<bool> use(unseen);
  use.flip();
  State here = here_;
  here.cost_m2 = cost_m2(here, use);
  double damping = kFirstDamping;
  for (int step = 0; step < kStepsOfPart && attempt(here, use, damping); ++step) {
  }
  return here.solution.terms;
}

}  // namespace slipstack::workbench
