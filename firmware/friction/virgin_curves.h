// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <limits>
#include <span>

#include "firmware/friction/displacement.h"

// The virgin curve y(x): friction force against the distance moved since the unloaded state, x >= 0. Odd
// continuation, reversals and memory are the business of MemoryStack. The length unit is the caller's: metres
// in the workbench, encoder counts on the controller; slopes are then N/m or N/count.
//
// A curve that is concave, with y(0) = 0 and slope >= 0, is passive: it is a sum of Maxwell-slip elements
// with positive stiffness. Both curves here are concave for parameters within their bounds.
namespace slipstack {

/// What MemoryStack asks of a curve: its force and slope at x >= 0, and the curve 2 y(x / 2).
template <class C>
concept VirginCurve = requires(const C curve, typename C::Value x) {
  { curve.force(x) } -> std::same_as<typename C::Value>;
  { curve.stiffness(x) } -> std::same_as<typename C::Value>;
  { curve.doubled() } -> std::same_as<C>;
};

/// True for a number that is neither infinite nor NaN.
template <std::floating_point Real>
constexpr bool is_finite(Real value) {
  return value >= -std::numeric_limits<Real>::max() && value <= std::numeric_limits<Real>::max();
}

/// y(x) = h0 (1 - (delta / (x + delta))^2): force h0 [N] far away, initial stiffness 2 h0 / delta.
/// Source: Al-Bender and Symens, Wear 258 (2005), the curve fitted to ball-bearing guideways.
template <std::floating_point Real>
struct RationalCurve {
  using Value = Real;       ///< of length and force
  Real height_N = Real(0);  ///< h0 >= 0
  Real length = Real(1);    ///< delta > 0, in the length unit of x

  /// Within these bounds.
  constexpr bool valid() const {
    return is_finite(height_N) && is_finite(length) && height_N >= Real(0) && length > Real(0);
  }

  /// Force in N at x >= 0. Written h0 x (x + 2 delta) / (x + delta)^2, which keeps its digits near x = 0.
  constexpr Real force(Real x) const {
    const Real moved = x + length;
    return height_N * ((x / moved) * ((moved + length) / moved));
  }

  /// The curve 2 y(x / 2).
  constexpr RationalCurve doubled() const { return {Real(2) * height_N, Real(2) * length}; }

  /// Tangent stiffness dy/dx at x >= 0, in N per length unit: 2 h0 delta^2 / (x + delta)^3.
  constexpr Real stiffness(Real x) const {
    const Real moved = x + length;
    const Real ratio = length / moved;
    return Real(2) * height_N * ratio * ratio / moved;
  }
};

/// Straight lines through the origin and up to N knots (x_j, y_j), level after the last knot. Equal, with all
/// its memory, to Maxwell-slip with slip distances x_j and stiffnesses slope_j - slope_(j+1) (knots from a
/// calibration: the force-transducer work of EMRP SIB63, there k_i).
template <std::size_t N, std::floating_point Real>
class PiecewiseLinearCurve {
 public:
  using Value = Real;  ///< of length and force

  /// Takes the knots, abscissae ascending and > 0, in the length unit of x and in N. O(N), outside the tick.
  [[nodiscard]] constexpr SetupStatus set_knots(std::span<const Real> x, std::span<const Real> force_N) {
    if (const SetupStatus status = begin_pieces(x, force_N); status != SetupStatus::kOk) return status;
    for (std::size_t j = 0; j < size_; ++j) {
      slope_[j] = (force_N[j] - start_force_N_[j]) / (x[j] - start_[j]);
      start_force_N_[j + 1] = force_N[j];
    }
    return SetupStatus::kOk;
  }

  /// Takes the slopes of the pieces that end at the knots x (ascending, > 0): the form without a division.
  [[nodiscard]] constexpr SetupStatus set_slopes(std::span<const Real> x, std::span<const Real> slope) {
    if (const SetupStatus status = begin_pieces(x, slope); status != SetupStatus::kOk) return status;
    for (std::size_t j = 0; j < size_; ++j) {
      slope_[j] = slope[j];
      start_force_N_[j + 1] = start_force_N_[j] + slope[j] * (x[j] - start_[j]);
    }
    return SetupStatus::kOk;
  }

  /// The curve 2 y(x / 2): the same slopes.
  constexpr PiecewiseLinearCurve doubled() const {
    PiecewiseLinearCurve made = *this;
    for (Real& x : made.start_) x *= Real(2);
    for (Real& force_N : made.start_force_N_) force_N *= Real(2);
    return made;
  }

  /// Writes the equal Maxwell-slip elements: slip distances and stiffnesses (N per length unit), one per
  /// knot. Both spans must hold at least size() values. A stiffness comes out negative where the curve is not
  /// concave.
  constexpr void elements(std::span<Real> slip_distance, std::span<Real> stiffness) const {
    for (std::size_t j = 0; j < size_; ++j) {
      slip_distance[j] = start_[j + 1];
      stiffness[j] = slope_[j] - slope_[j + 1];
    }
  }

  constexpr std::size_t size() const { return size_; }  ///< knots

  /// Force in N at x >= 0. Work grows with the number of knots, not with x.
  constexpr Real force(Real x) const {
    const std::size_t j = piece(x);
    return start_force_N_[j] + slope_[j] * (x - start_[j]);
  }

  /// Slope of the piece that holds x (the piece to the right at a knot), in N per length unit.
  constexpr Real stiffness(Real x) const { return slope_[piece(x)]; }

 private:
  /// Where the pieces begin, if there is a finite value for each of them.
  constexpr SetupStatus begin_pieces(std::span<const Real> x, std::span<const Real> value) {
    if (x.size() != value.size()) return SetupStatus::kSizeMismatch;
    if (x.size() > N) return SetupStatus::kTooMany;
    Real before = Real(0);
    for (std::size_t j = 0; j < x.size(); ++j) {
      if (!is_finite(x[j]) || !is_finite(value[j])) return SetupStatus::kOutOfRange;
      if (!(x[j] > before)) return SetupStatus::kNotAscending;
      before = x[j];
    }
    size_ = x.size();
    start_ = {};
    start_force_N_ = {};
    slope_ = {};
    for (std::size_t j = 0; j < size_; ++j) start_[j + 1] = x[j];
    return SetupStatus::kOk;
  }

  constexpr std::size_t piece(Real x) const {
    std::size_t j = 0;
    for (std::size_t i = 1; i <= size_; ++i) j += x >= start_[i] ? 1U : 0U;
    return j;
  }

  std::size_t size_ = 0;
  std::array<Real, N + 1> start_{};  ///< piece j begins here; the last one is level
  std::array<Real, N + 1> start_force_N_{};
  std::array<Real, N + 1> slope_{};
};

}  // namespace slipstack
