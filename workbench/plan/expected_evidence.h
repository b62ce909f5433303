// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "workbench/plan/information.h"

namespace slipstack::workbench {

/// The expected evidence for one effect against another, or against the baseline where `other` is empty.
struct ExpectedEvidence {
  std::string effect;
  std::string other;
  double angle_deg = 0.0;
  double chi_squared = 0.0;
  /// How much the criterion of the model with the effect is expected to be below that of the model without
  /// it, or with the other in its place (diagnose/evidence/criterion.h), if the axis has the effect.
  /// Without what speaks for it because the other has more parameters.
  double evidence = 0.0;
};

/// What the rows are expected to scatter about a model of all that acts, beside the noise that a measurement
/// has anyway.
struct ExpectedScatter {
  double discrepancy_N = 0.0;
  double inflation = 1.0;  ///< how many rows are worth one independent row
};

/// The scatter of a log about the baseline with these effects, as fitted to it.
ExpectedScatter scatter_of(const Measurement& measurement, const FittedModel& base, const Terms& effects);

/// The evidence about the effects that is expected of a measurement with this baseline; of an excerpt, that
/// of the whole logs, assuming that they are alike.
std::vector<ExpectedEvidence> expected_evidence(const Measurement& measurement, const FittedModel& base,
                                                const Terms& effects, const ExpectedScatter& scatter);

/// The scatter of the rows of a measurement: its noise floor and what is expected beside it.
ResidualScale at_rows_of(const Measurement& measurement, const ExpectedScatter& scatter);

/// Evidence above this is decisive: odds of 150 to 1 (Kass and Raftery 1995, difference of BIC above 10).
inline constexpr double kDecisive = 10.0;

/// The least evidence among the questions that either experiment answers, of each. An effect that contains
/// another can always imitate it; such questions are answered by none and do not count.
struct LeastEvidence {
  double log = 0.0;
  double plan = 0.0;
};
std::optional<LeastEvidence> least_evidence(const std::vector<ExpectedEvidence>& log,
                                            const std::vector<ExpectedEvidence>& plan);

/// The effects, each with shapes at which it may be mistaken for another.
std::vector<Information::Expected> expected_effects(const Measurement& measurement, const Terms& effects);

}  // namespace slipstack::workbench
