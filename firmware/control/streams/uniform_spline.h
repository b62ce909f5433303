// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace slipstack {

/// A segment of the uniform cubic B-spline (de Boor, A Practical Guide to Splines, chapter 9) of four control
/// points, over u from 0 to 1:
///
///   (sixfold + 3 twice_slope u + 3 bend u^2 + twist u^3) / 6
///
/// Position, velocity and acceleration are continuous from one segment to the next. Integers, so that nothing
/// is lost before the caller divides.
template <class Integer>
struct SplineSegment {
  Integer sixfold = 0;      ///< where it begins, times 6
  Integer twice_slope = 0;  ///< there, per segment, times 2
  Integer bend = 0;         ///< second derivative there
  Integer twist = 0;        ///< third derivative

  /// Oldest first; the segment lies between b and c.
  static SplineSegment of(Integer a, Integer b, Integer c, Integer d) {
    const Integer bend = (c - b) - (b - a);
    return {6 * b + bend, c - a, bend, (d - c) - (c - b) - bend};
  }
};

}  // namespace slipstack
