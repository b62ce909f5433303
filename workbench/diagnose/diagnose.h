// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "workbench/diagnose/alternatives/structure.h"
#include "workbench/diagnose/detectability/detectability.h"
#include "workbench/diagnose/detectability/separation.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/uncertainty/noise_floor.h"

namespace slipstack::workbench {

/// An effect tried on top of the baseline.
struct Candidate {
  Term term;    ///< with fitted shapes and gains
  Terms terms;  ///< the baseline and the effect
  double holdout_rmse_N = 0.0;
  std::vector<double> block_squared_error;
  double error_reduction = 0.0;              ///< 1 - held-out error / baseline's
  double error_reduction_se = 0.0;           ///< jackknife over blocks
  std::vector<std::string> confounded_with;  ///< effects that this log cannot tell from it
  std::string evidence;
};

struct Step {
  std::string effect;  ///< id of the effect that the step adds; "baseline" first
  double holdout_rmse_N = 0.0;
  std::string evidence;  ///< the physical reading of what was added, in the company of the others
  Terms terms;           ///< the model so far
};

enum class Verdict { missing_effect, complete, unexplained };
const char* name_of(Verdict verdict);

struct Diagnosis {
  Verdict verdict = Verdict::complete;
  double noise_floor_N = 0.0;  ///< of the final explanation
  FittedModel baseline;
  std::vector<Candidate> candidates;  ///< best first
  std::vector<Step> steps;            ///< the explanation, one effect at a time
  FittedModel best;                   ///< baseline with the first candidate; the baseline itself without one
  FittedModel explained;              ///< baseline with every step
  std::optional<Structure> unexplained;
  /// Effects that this log could show only if they were a large part of the force: not ruled out by it.
  std::vector<Visibility> cannot_show;
  /// Pairs of promising effects that this log cannot separate, the nearest first: their forces, without what
  /// the baseline imitates, point the same way or explain the same.
  std::vector<Separation> cannot_separate;
};

struct DiagnoseOptions {
  std::vector<std::string> baseline;
  std::vector<const EffectDescription*> user_effects =
      {};       ///< user-defined effects, tried beside the catalogue's
  Terms start;  ///< the baseline as a model file has it; its shapes are kept; empty: searched
  std::function<void(const std::string& stage, double fraction)> progress;  ///< may be empty
  /// Effects to try, all of the catalogue where empty. The answer does not depend on their order.
  std::vector<std::string> candidates = {};

  /// Tells `progress`, where there is one.
  void report(const std::string& stage, double fraction) const;
};

/// A diagnosis in two steps, between which the errors of the whole logs may take the place of the excerpt's.
class EffectSearch {
 public:
  /// Fits the baseline and searches what it lacks: candidates and steps. Both references must outlive this.
  EffectSearch(const Measurement& measurement, const DiagnoseOptions& options);
  Diagnosis& diagnosis() { return diagnosis_; }
  /// After the errors in diagnosis() were replaced: drops the steps that these do not support.
  void drop_what_whole_logs_do_not_support();
  /// The verdict, and what the log cannot show or separate.
  Diagnosis conclude();

 private:
  const Measurement& measurement_;
  const DiagnoseOptions& options_;
  NoiseFloor floor_;
  Diagnosis diagnosis_;
};

/// What the axis does that the baseline does not: every effect of the catalogue that the baseline lacks is
/// fitted jointly with it and judged on held-out blocks; sets of effects are grown by a beam search, because
/// of a pair the best single effect may be neither; whatever an effect of fewer parameters explains as well
/// is given to it. An effect must lower the held-out error by 3 % and by three standard errors to be named.
Diagnosis diagnose(const Measurement& measurement, const DiagnoseOptions& options);

}  // namespace slipstack::workbench
