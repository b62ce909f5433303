// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "workbench/simulate/free_parameters.h"
#include "workbench/simulate/free_run.h"

namespace slipstack::workbench {

/// Fit by the output error (Ljung 1999, sections 4.3 and 7.4; of machines Janot, Vandanjon, Gautier 2014):
/// the parameters for which the position that follows from the force alone is the measured one, in the sense
/// of least squares over the runs. Gauss-Newton with the damping of Marquardt (1963), derivatives by
/// difference quotients.
///
/// An axis integrates an error of the force twice, so that the initial state matters: every run has a
/// position and a velocity of its own at its start (multiple shooting without continuity; Bock and Plitt
/// 1984). They are fitted, held by initial_state_deviation() to the measured ones. A constant force is fitted
/// where the model has one.
///
/// The regression contains no derivative of a measured position, so noise of the position biases no
/// parameter.
class OutputErrorFit {
 public:
  /// Starts at `start`, a model fitted by inverse dynamics. Keeps a reference to the measurement.
  OutputErrorFit(const Measurement& measurement, const FittedModel& start, std::vector<FreeRunInterval> runs,
                 std::function<void(double fraction)> progress = {});

  /// Moves to the minimum over all runs. Returns whether that was reached. Cost: for each of up to 20 steps,
  /// as many simulations of the log as there are parameters, and three.
  bool run();

  const Terms& terms() const { return here_.solution.terms; }
  const std::vector<FreeParameter>& parameters() const { return parameters_; }
  const std::vector<FreeRunInterval>& runs() const { return runs_; }
  int steps_per_sample() const { return steps_per_sample_; }

  /// The model of a fit that has not seen these runs, from the solution of all with its derivatives, damped.
  /// After run(). Cost: some five simulations.
  Terms fitted_without(const std::vector<bool>& unseen) const;

  /// terms() with standard errors: the covariance of Gauss and Newton, with the scatter of the scores of the
  /// runs instead of white noise (Liang and Zeger 1986, clusters are runs), because the errors within a run
  /// are correlated. Shapes, which are held, have none. After run().
  Terms terms_with_standard_errors() const;

 private:
  struct Solution {
    Terms terms;
    std::vector<InitialState> states;  ///< of every run
  };
  /// A solution with its errors of position at the samples of every run in use, and its cost.
  struct State {
    Solution solution;
    std::vector<Eigen::VectorXd> errors_m;
    double cost_m2 = 0.0;
  };
  struct Step {
    Eigen::VectorXd parameters;
    std::vector<InitialState> states;
  };
  /// Derivatives of the errors of one run.
  struct Derivatives {
    Eigen::MatrixXd by_parameter;
    Eigen::MatrixXd by_state;
  };

  /// The normal equations of one run, its initial state eliminated.
  struct OfRun {
    Eigen::Matrix2d inverse;   ///< of the matrix of the state
    Eigen::MatrixXd coupling;  ///< 2 x parameters
    Eigen::Vector2d state_gradient;
    Eigen::MatrixXd matrix;
    Eigen::VectorXd gradient;
    Eigen::VectorXd diagonal;  ///< before the elimination
  };

  Eigen::VectorXd error_m(std::size_t run, const Terms& terms, const InitialState& state) const;
  State evaluated(Solution solution, const std::vector<bool>& use) const;
  double cost_m2(const State& at, const std::vector<bool>& use) const;
  std::vector<Derivatives> derivatives(const State& at) const;
  OfRun reduced(const State& at, std::size_t run, double damping) const;
  Step solve(const State& at, const std::vector<bool>& use, double damping) const;
  Solution moved(const Solution& from, const Step& step) const;
  bool attempt(State& here, const std::vector<bool>& use, double& damping) const;

  const Measurement& measurement_;
  Terms start_;
  std::vector<FreeRunInterval> runs_;
  std::function<void(double)> progress_;
  std::vector<FreeParameter> parameters_;
  int steps_per_sample_ = 1;
  std::size_t stride_ = 1;    ///< of the samples that are compared
  InitialState deviation_;    ///< standard deviations of the initial states
  double variance_m2_ = 0.0;  ///< of the errors at the start, which weighs the deviations above
  State here_;
  std::vector<Derivatives> derivatives_;
};

}  // namespace slipstack::workbench
