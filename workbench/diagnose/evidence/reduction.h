// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace slipstack::workbench {

/// An effect is named only if it lowers the held-out error by this share: on simulated logs that the baseline
/// describes completely no effect does (tests/bench/blind).
inline constexpr double kLeastReduction = 0.03;
/// Whether an error that falls from `before_N` to `after_N` falls by that share.
inline bool is_worth_a_name(double before_N, double after_N) {
  return after_N < (1.0 - kLeastReduction) * before_N;
}
/// The part of the mean square of an error `before_N` that a model with held-out error `after_N` explains
/// [N^2].
inline double explained_N2(double before_N, double after_N) {
  return before_N * before_N - after_N * after_N;
}
/// Most of a mean square: what explains less than this share of it is not its cause, and what leaves less
/// than this share of what another leaves is far better. The only share at which neither of two causes is
/// preferred.
inline constexpr double kMajority = 0.5;
/// Whether a model that lowers an error from `before_N` to `after_N` explains most of what one with the error
/// `least_N` does: of all that there is, where that is the noise floor.
inline bool explains_most(double before_N, double after_N, double least_N) {
  return explained_N2(before_N, after_N) > kMajority * explained_N2(before_N, least_N);
}
/// A discrepancy of the form above this share of the force (rms) is large: models of machines that are called
/// good in the literature of identification leave less (EMPS 3 to 4 %; Janot, Gautier, Brunot 2019). What a
/// log would not show though it were larger, it does not rule out.
inline constexpr double kLargeShareOfForce = 0.05;
/// Smaller reductions are not shown, nor fitted in full, nor called seen. Chosen.
inline constexpr double kLeastShownReduction = 0.005;
/// Whether an error that falls from `before_N` to `after_N` falls by that share.
inline bool is_shown(double before_N, double after_N) {
  return after_N < (1.0 - kLeastShownReduction) * before_N;
}

/// The share by which a model lowers a held-out error.
struct Reduction {
  double value = 0.0;
  double standard_error = 0.0;
};

/// 1 - rms(after)/rms(before) from the squared errors of each block, with its jackknife standard error (Efron
/// and Stein 1981).
Reduction reduction(const std::vector<double>& before, const std::vector<double>& after);

/// Whether a reduction is larger than its standard error (the one-standard-error rule: of models whose errors
/// differ by less the simplest; Breiman, Friedman, Olshen, Stone 1984, section 3.4.3).
inline bool is_above_chance(const Reduction& reduction) {
  return reduction.value > reduction.standard_error;
}

/// Whether a reduction is worth a name and larger than its standard error.
inline bool is_significant(const Reduction& reduction) {
  return reduction.value > kLeastReduction && is_above_chance(reduction);
}

/// The reduction of an rms if some rows had no more energy than expected: they hold the share `energy` of the
/// sum of squares, and `expected` of it would be normal for them.
double reduction_beyond(double energy, double expected);

}  // namespace slipstack::workbench
