// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "workbench/diagnose/diagnose.h"
#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// A model on the way to an explanation.
struct Explanation {
  FittedModel model;
  std::vector<std::string> added;
};

/// An explanation with one more effect, to first order.
struct Attempt {
  const Explanation* from;
  const EffectDescription* effect;
  Trial trial;
};

/// Tries every effect that is asked for on top of every explanation of `beam`; by error, the best first.
/// `alone`: the trials on the baseline, whose shapes are where a further search starts; null on the first
/// level, which searches them. Points into `beam`.
std::vector<Attempt> try_effects(const Measurement& measurement, const DiagnoseOptions& options,
                                 const std::vector<Explanation>& beam, const std::vector<Trial>* alone);

/// Fits in full the best `most` of the attempts that promise anything, each set of effects once.
std::vector<Explanation> fit_best(const Measurement& measurement, std::vector<Attempt> attempts,
                                  std::size_t most);

/// The trial of an effect, or null.
const Trial* find_trial(const std::vector<Trial>& trials, std::string_view id);

}  // namespace slipstack::workbench
