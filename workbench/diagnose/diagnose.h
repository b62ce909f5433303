// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "workbench/diagnose/alternatives/structure.h"
#include "workbench/diagnose/detectability/detectability.h"
#include "workbench/diagnose/detectability/separation.h"
#include "workbench/estimate/measurement/plausibility.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/nonlinear/trial.h"

namespace slipstack::workbench {

/// Why an effect that the log supports has no name.
enum class Refusal : std::uint8_t {
  none,
  at_floor,     ///< without it the error is already that of the noise floor, within its uncertainty
  implausible,  ///< as fitted it is no such effect (evidence/plausibility.h)
  too_small,    ///< no larger than kTooSmall
  superfluous,  ///< no step beside what was chosen, or not determined by the log
};
/// For the JSON; empty where there is none.
const char* name_of(Refusal refusal);

/// An effect tried on top of the baseline.
struct Candidate {
  Term term;    ///< with fitted shapes and gains
  Terms terms;  ///< the baseline and the effect
  double holdout_rmse_N = 0.0;
  std::vector<double> block_squared_error;
  double error_reduction = 0.0;       ///< 1 - held-out error / baseline's
  double error_reduction_se = 0.0;    ///< jackknife over blocks
  double criterion_difference = 0.0;  ///< against the baseline; negative: better (evidence/criterion.h)
  std::vector<std::string> confounded_with;  ///< its ties: the other effect of its pairs in cannot_separate
  std::string evidence;
  /// Of the candidate of lowest error among those that the log supports and that are no steps.
  Refusal refusal = Refusal::none;
};

struct Step {
  std::string effect;  ///< id of the effect that the step adds; "baseline" first
  double holdout_rmse_N = 0.0;
  double forward_rmse_N = 0.0;  ///< of the last third of each log, predicted by a fit to the first two
  std::vector<double> block_squared_error;
  double criterion_difference = 0.0;  ///< against the step before; negative: better (evidence/criterion.h)
  std::string evidence;  ///< evidence for the effect, with its values in the model of all effects
  Terms terms;           ///< the model with the effects up to this step
};

/// What a model leaves beyond the noise floor: the discrepancy of its form (Kennedy and O'Hagan 2001) [N].
/// Zero at the floor.
double discrepancy_N(const FittedModel& model, double noise_floor_N);

enum class Verdict { missing_effect, complete, unexplained };
const char* name_of(Verdict verdict);

/// What describes the force and is no effect of the catalogue (alternatives/causes.h).
struct OutsideCauses {
  std::vector<Structure> causes;  ///< the first tells all of them (tell_together())
  bool explain_most = false;      ///< they alone leave a smaller error than the effects alone
  bool replace_friction = false;  ///< one is dry friction of another form, in the place of the hysteresis
  /// Effects that were chosen beside the causes, and are no steps without them.
  std::vector<std::string> beside;
};

struct Diagnosis {
  Verdict verdict = Verdict::complete;
  double noise_floor_N = 0.0;  ///< of the log, whatever the model
  FittedModel baseline;
  std::vector<Candidate> candidates;  ///< best first
  std::vector<Step> steps;            ///< the explanation, one effect at a time
  FittedModel best;                   ///< baseline with the first candidate; the baseline itself without one
  FittedModel explained;              ///< baseline with every step
  std::optional<Structure> unexplained;
  std::vector<InputWarning> input_warnings;  ///< of what contradicts physics; the verdict is then unexplained
  OutsideCauses outside;  ///< that were chosen beside the steps; the models do not contain them
  /// The next step that was not made, because clocks and sensors may err that much: the effect and the error
  /// with it. Empty without one.
  std::optional<Step> withheld;
  /// Effects that this log would show only if they were a large part of the force: it does not rule them out.
  std::vector<Visibility> cannot_show;
  /// Pairs of effects that this log cannot tell apart (detectability/ties.h), the smallest angle first.
  std::vector<Separation> cannot_separate;
};

struct SelectionContext;

struct DiagnoseOptions {
  std::vector<std::string> baseline;
  std::vector<const EffectDescription*> user_effects =
      {};       ///< user-defined effects, tried beside the catalogue's
  Terms start;  ///< the baseline as a model file has it, whose shapes are kept; empty: shapes are searched
  std::function<void(const std::string& stage, double fraction)> progress;  ///< may be empty
  /// Called for every effect that was tried on the baseline alone, while others are still tried: from several
  /// threads, in any order, again where the search is repeated. May be empty. `baseline_N`: error without it.
  std::function<void(const Trial& trial, double baseline_N)> tried = {};
  /// Effects to try; all of the catalogue where empty. The result does not depend on their order.
  std::vector<std::string> candidates = {};
  /// Whether causes outside the catalogue are tried beside them.
  bool with_causes = true;

  /// Calls `progress`, where there is one.
  void report(const std::string& stage, double fraction) const;
};

/// A diagnosis in two steps, between which the errors of the excerpt may be replaced by those of the whole
/// logs.
class EffectSearch {
 public:
  EffectSearch(const EffectSearch&) = delete;
  EffectSearch& operator=(const EffectSearch&) = delete;
  ~EffectSearch();
  /// Fits the baseline and searches the effects that it lacks: candidates and steps. Both references must
  /// outlive this.
  EffectSearch(Measurement& measurement, const DiagnoseOptions& options);
  Diagnosis& diagnosis() { return diagnosis_; }
  /// Drops the steps that unseen data do not support (is_significant); the verdict, and what the log cannot
  /// show or separate.
  Diagnosis conclude();

 private:
  Measurement& measurement_;
  const DiagnoseOptions& options_;
  Diagnosis diagnosis_;
  std::unique_ptr<const SelectionContext> context_;  ///< by which the search compared; refers to the others
};

/// Finds the effects that the baseline lacks. Every effect of the catalogue is fitted jointly with the
/// baseline. Sets of effects are found by a beam search, because if two effects are missing, the best single
/// effect may be neither of them. One criterion decides between models (evidence/criterion.h); to be named,
/// an effect must also lower the held-out error by 3 %, and by more than a standard error of that.
Diagnosis diagnose(Measurement& measurement, const DiagnoseOptions& options);

}  // namespace slipstack::workbench
