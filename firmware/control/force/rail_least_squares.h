// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// Least squares with forgetting for two unknowns that are the same everywhere, and for values along a line
/// of which each measurement sees the two that it lies between:
///
///   e = whole f_w + mass f_m + (1 - b) p_i f_p + b p_(i+1) f_p.
///
/// The information matrix of all of them, covariances included, is a tridiagonal one with two rows and
/// columns at its border: five numbers for each value along the line keep it exactly, and one sweep solves it
/// (elimination of the tridiagonal part, Schur complement of the border; Golub, Van Loan: Matrix
/// Computations, 4.3 and 3.2.11). A measurement here so corrects what was learned elsewhere together with the
/// mass.
///
/// Forgetting of unknown i scales its row and column: variances grow, correlations stay. That keeps the
/// matrix positive definite in exact arithmetic; `least` on its diagonal does in floats, and bounds what is
/// not seen.
template <std::size_t kCells>
class RailLeastSquares {
 public:
  /// Of one unknown, by the measurements that see it.
  struct Prior {
    float first = 1.0F;    ///< information before the first of them, of one measurement with factor 1
    float least = 1.0F;    ///< that stays when all of them are forgotten
    float forgets = 0.0F;  ///< share of the information, by a measurement with factor 1
  };
  struct Priors {
    Prior whole, part, mass;
  };
  /// Factors of the unknowns, zero for what is not learned, and the error that they explain.
  struct Measurement {
    float whole;
    float part;
    float mass;
    std::uint32_t cell;  ///< any: cells repeat
    float beyond;        ///< share of the next cell, 0 to 1
    float error;
  };
  /// What solve() adds to the unknowns.
  struct Change {
    float whole = 0.0F;
    float mass = 0.0F;
  };
  /// Within what it may.
  struct Limits {
    float whole_least, whole_most;
    float mass_least, mass_most;
  };

  void begin(const Priors& priors) {
    diagonal_.fill(priors.part.first);
    next_.fill(0.0F);
    whole_part_.fill(0.0F);
    mass_part_.fill(0.0F);
    error_part_.fill(0.0F);
    border_ = {priors.whole.first, 0.0F, priors.mass.first, 0.0F, 0.0F};
    kept_whole_ = kept_mass_ = 1.0F;
  }

  void add(const Priors& priors, const Measurement& seen) {
    const std::uint32_t near = seen.cell % kCells, far = (near + 1) % kCells;
    const float near_f = (1.0F - seen.beyond) * seen.part, far_f = seen.beyond * seen.part;
    forget(near, 1.0F / (1.0F + 0.5F * priors.part.forgets * near_f * near_f));
    forget(far, 1.0F / (1.0F + 0.5F * priors.part.forgets * far_f * far_f));
    kept_whole_ /= 1.0F + 0.5F * priors.whole.forgets * seen.whole * seen.whole;
    kept_mass_ /= 1.0F + 0.5F * priors.mass.forgets * seen.mass * seen.mass;
    const float both = near_f * far_f;
    // The last cell is not beside the first one: no more than is known.
    const float apart = far > 0 ? 0.0F : both;
    if (far > 0) next_[near] += both;
    diagonal_[near] += near_f * near_f + apart;
    diagonal_[far] += far_f * far_f + apart;
    whole_part_[near] += seen.whole * near_f;
    whole_part_[far] += seen.whole * far_f;
    mass_part_[near] += seen.mass * near_f;
    mass_part_[far] += seen.mass * far_f;
    error_part_[near] += near_f * seen.error;
    error_part_[far] += far_f * seen.error;
    border_.whole += seen.whole * seen.whole;
    border_.both += seen.whole * seen.mass;
    border_.mass += seen.mass * seen.mass;
    border_.whole_error += seen.whole * seen.error;
    border_.mass_error += seen.mass * seen.error;
  }

  /// Of the value at a place, in measurements with factor 1.
  float known(std::uint32_t cell, float beyond) const {
    return (1.0F - beyond) * diagonal_[cell % kCells] + beyond * diagonal_[(cell + 1) % kCells];
  }

  /// The mass may be another one: forgotten until its standard deviation is 1/kept times as large.
  void doubt_mass(float kept) { kept_mass_ *= kept; }

  /// What explains the errors since the last call best; `change_part(i, change)` gets that of each value
  /// along the line. The same work for any input.
  template <class ChangePart>
  Change solve(const Priors& priors, const Limits& limits, ChangePart&& change_part) {
    keep_whole_and_mass();
    float last_inverse = 0.0F, coupling = 0.0F;
    float last_error = 0.0F, last_whole = 0.0F, last_mass = 0.0F;
    float ww = border_.whole + priors.whole.least, wm = border_.both, mm = border_.mass + priors.mass.least;
    float we = border_.whole_error, me = border_.mass_error;
    for (std::size_t i = 0; i < kCells; ++i) {
      const float factor = coupling * last_inverse;
      const float pivot = diagonal_[i] + priors.part.least - factor * coupling;
      last_inverse = 1.0F / (pivot > priors.part.least ? pivot : priors.part.least);
      last_error = error_part_[i] - factor * last_error;
      last_whole = whole_part_[i] - factor * last_whole;
      last_mass = mass_part_[i] - factor * last_mass;
      ww -= last_whole * last_whole * last_inverse;
      wm -= last_whole * last_mass * last_inverse;
      mm -= last_mass * last_mass * last_inverse;
      we -= last_whole * last_error * last_inverse;
      me -= last_mass * last_error * last_inverse;
      inverse_[i] = last_inverse;
      error_part_[i] = last_error;
      reduced_whole_[i] = last_whole;
      reduced_mass_[i] = last_mass;
      coupling = next_[i];
    }
    border_.whole_error = border_.mass_error = 0.0F;
    // Whole and mass: what the parts leave of them.
    ww = ww > priors.whole.least ? ww : priors.whole.least;
    mm = mm > priors.mass.least ? mm : priors.mass.least;
    const float factor = wm / ww;
    float left = mm - factor * wm;
    left = left > priors.mass.least ? left : priors.mass.least;
    Change change;
    // One that is held at its limit is known: the others are what is best beside it.
    change.mass = approx::clamp((me - factor * we) / left, limits.mass_least, limits.mass_most);
    change.whole = approx::clamp((we - wm * change.mass) / ww, limits.whole_least, limits.whole_most);
    float beyond = 0.0F;
    for (std::size_t i = kCells; i-- > 0;) {
      const float right = error_part_[i] - reduced_whole_[i] * change.whole - reduced_mass_[i] * change.mass;
      beyond = (right - next_[i] * beyond) * inverse_[i];
      error_part_[i] = 0.0F;
      change_part(i, beyond);
    }
    return change;
  }

 private:
  using Cells = std::array<float, kCells>;
  struct Border {
    float whole, both, mass;
    float whole_error, mass_error;
  };

  void forget(std::uint32_t cell, float kept) {
    diagonal_[cell] *= kept * kept;
    next_[cell] *= kept;
    next_[(cell + kCells - 1) % kCells] *= kept;
    whole_part_[cell] *= kept;
    mass_part_[cell] *= kept;
    error_part_[cell] *= kept;
  }
  void keep_whole_and_mass() {
    border_.whole *= kept_whole_ * kept_whole_;
    border_.both *= kept_whole_ * kept_mass_;
    border_.mass *= kept_mass_ * kept_mass_;
    for (std::size_t i = 0; i < kCells; ++i) {
      whole_part_[i] *= kept_whole_;
      mass_part_[i] *= kept_mass_;
    }
    kept_whole_ = kept_mass_ = 1.0F;
  }

  Cells diagonal_{}, next_{};  // of the parts: each with itself, and with the one behind it
  Cells whole_part_{}, mass_part_{};
  Cells error_part_{};  // and what the elimination makes of them
  Border border_{};
  float kept_whole_ = 1.0F, kept_mass_ = 1.0F;          // since the last solve()
  Cells inverse_{}, reduced_whole_{}, reduced_mass_{};  // of a solution
};

}  // namespace slipstack
