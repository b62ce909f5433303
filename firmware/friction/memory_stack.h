// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "firmware/friction/displacement.h"
#include "firmware/friction/virgin_curves.h"

namespace slipstack {

/// Hysteresis with non-local memory: a virgin curve y(x) and a stack of up to Depth reversal points.
///
///     Rule I   on the virgin curve:             F = y(x), odd in x, x from the place of the last reset.
///     Rule II  after a reversal at (x_m, F_m):  F = F_m +- 2 y(abs(x - x_m) / 2), + when moving towards +x.
///
/// Wiping: a branch ends where the branch that encloses it began; there the loop is closed, its two reversal
/// points are forgotten, and the older branch goes on as if the loop had never been. The first reversal is
/// closed by its mirror image, beyond which the virgin curve goes on.
///
/// One step closes all the loops it passes. When a reversal finds the stack full, the innermost loop (the
/// newest stored reversal and this one) gives way: neither is kept, and the force is taken anew from the
/// branch that encloses it. The force is then wrong by at most the height of that loop until the motion
/// leaves it; see overflow_count() and overflow_height_N().
///
/// Displacements are absolute (encoder counts or metres) and no differences are summed: nothing drifts.
/// Counts may wrap around; the travel away from the place of the reset must stay below 2^30 counts.
///
/// step() is bounded: at most (Depth + 1) / 2 loops close. Maxima and minima lie apart, each sorted since
/// loops are nested. One comparison with the outermost finds whether all close, and a binary search how many
/// of the others: log2(Depth) comparisons in all, however many that are.
///
/// Source: Symens, Al-Bender, Swevers, Van Brussel, Harmonic analysis of a mass subject to hysteretic
/// friction (Rules I and II, wiping-out).
template <VirginCurve Curve, std::size_t Depth, DisplacementType Displacement = typename Curve::Value>
class MemoryStack {
  static_assert(Depth >= 2, "giving up the innermost loop must leave the first reversal in place");

 public:
  using Real = typename Curve::Value;           ///< of the force
  static constexpr std::size_t kDepth = Depth;  ///< reversals that are held

  /// The curve's length unit is that of Displacement.
  constexpr explicit MemoryStack(const Curve& curve) : curve_(curve), branch_(curve.doubled()) {
    reset(Displacement{});
  }

  /// Forgets everything: the virgin state, unloaded, at x.
  constexpr void reset(Displacement x) {
    origin_ = x;
    travel_ = Displacement{};
    force_N_ = Real(0);
    forward_ = 1;  // either: a reversal here is forgotten at once
    memory_.maxima.at(0) = memory_.minima.at(0) = {travel_, force_N_};
    memory_.end_of_maxima = &memory_.maxima.at(0);
    memory_.end_of_minima = &memory_.minima.at(1);
  }

  /// Takes another curve for the same motion: what would be had it been there from the start. O(Depth),
  /// outside the tick.
  constexpr void set_curve(const Curve& curve) {
    curve_ = curve;
    branch_ = curve.doubled();
    for (Side* side : {&memory_.maxima, &memory_.minima}) {
      side->at(0).force_N = virgin_force_N(side->at(0).travel);
    }
    for (std::size_t i = 1; i < depth(); ++i) {
      const Reversal& from = reversal(i - 1);
      Reversal& to = reversal(i);
      const Real height_N = branch_.force(static_cast<Real>(distance(to.travel, from.travel)));
      to.force_N = to.travel > from.travel ? from.force_N + height_N : from.force_N - height_N;
    }
    force_N_ = forward_ != 0 ? force_on_branch<1>() : force_on_branch<-1>();
  }

  /// Moves to x and returns the friction force in N, positive after motion towards +x.
  constexpr Real step(Displacement x) {
    const Displacement travel = difference(x, origin_);
    if (travel == travel_) return force_N_;
    return travel > travel_ ? move<1>(travel) : move<-1>(travel);
  }

  constexpr Real force_N() const { return force_N_; }                        ///< of the last step
  constexpr Displacement position() const { return sum(origin_, travel_); }  ///< of the last step or reset

  /// Reversal points held at present; 0 on the virgin curve.
  constexpr std::size_t depth() const {
    const bool virgin = (forward_ != 0 ? memory_.number_of_maxima() : memory_.number_of_minima()) == 0;
    return virgin ? 0 : memory_.number_of_maxima() + memory_.number_of_minima() - 1;
  }

  /// Loops that gave way to a full stack since construction.
  constexpr std::uint32_t overflow_count() const { return overflow_count_; }

  /// Height in N of the highest loop that gave way since construction, on the present curve: bounds the error
  /// that overflow has caused.
  constexpr Real overflow_height_N() const { return branch_.force(static_cast<Real>(longest_overflow_)); }

 private:
  struct Reversal {
    Displacement travel;  // from the origin
    Real force_N;
  };

  static constexpr std::size_t kMostClosed = (Depth + 1) / 2;
  static constexpr std::size_t kLargestStride = std::bit_floor(kMostClosed - 1);  ///< the outermost apart

  /// The reversals of one kind, oldest first, each within the one before. Below the first lie places that no
  /// motion reaches. The first of one kind is the first reversal, that of the other its mirror image. On the
  /// virgin curve there are none in the direction of the motion, the first place is one that was passed, and
  /// behind is the mirror image of where it is now.
  struct Side {
    static constexpr std::size_t kBelow = kLargestStride > 0 ? kLargestStride - 1 : 0;

    constexpr explicit Side(Displacement unreached) {
      for (std::size_t i = 0; i < kBelow; ++i) all[i].travel = unreached;
    }
    constexpr Reversal& at(std::size_t i) { return all[kBelow + i]; }
    constexpr const Reversal& at(std::size_t i) const { return all[kBelow + i]; }

    std::array<Reversal, kBelow + kMostClosed + 2> all{};
  };

  /// Both sides, and the places behind the newest of each.
  struct Memory {
    constexpr Memory() = default;
    // The ends point into its own.
    constexpr Memory(const Memory& other) : maxima(other.maxima), minima(other.minima) { take_ends(other); }
    constexpr Memory& operator=(const Memory& other) {
      if (this == &other) return *this;
      maxima = other.maxima;
      minima = other.minima;
      take_ends(other);
      return *this;
    }
    constexpr ~Memory() = default;
    constexpr void take_ends(const Memory& other) {
      end_of_maxima = &maxima.at(other.number_of_maxima());
      end_of_minima = &minima.at(other.number_of_minima());
    }
    constexpr std::size_t number_of_maxima() const {
      return static_cast<std::size_t>(end_of_maxima - &maxima.at(0));
    }
    constexpr std::size_t number_of_minima() const {
      return static_cast<std::size_t>(end_of_minima - &minima.at(0));
    }

    Reversal* end_of_maxima = nullptr;
    Reversal* end_of_minima = nullptr;
    Side maxima{std::numeric_limits<Displacement>::max()};
    Side minima{std::numeric_limits<Displacement>::lowest()};
  };

  static constexpr Displacement distance(Displacement a, Displacement b) { return a > b ? a - b : b - a; }

  /// The reversal i of all, oldest first; i < depth().
  constexpr Reversal& reversal(std::size_t i) {
    const bool from_maximum = forward_ != 0 ? memory_.number_of_maxima() < memory_.number_of_minima()
                                            : memory_.number_of_maxima() == memory_.number_of_minima();
    const bool as_first = i % 2 == 0;
    Side& side = as_first == from_maximum ? memory_.maxima : memory_.minima;
    return side.at(as_first ? i / 2 : (i + 1) / 2);
  }

  /// Moves to `travel`, which lies in direction Sign. `ahead`: where branches in this direction end;
  /// `behind`: where they begin.
  template <int Sign>
  constexpr Real move(Displacement travel) {
    Side& ahead = Sign > 0 ? memory_.maxima : memory_.minima;
    Side& behind = Sign > 0 ? memory_.minima : memory_.maxima;
    Reversal*& end_ahead = Sign > 0 ? memory_.end_of_maxima : memory_.end_of_minima;
    Reversal*& end_behind = Sign > 0 ? memory_.end_of_minima : memory_.end_of_maxima;
    Reversal* end = end_ahead;
    Reversal* begin = end_behind;
    if (Sign > 0 ? forward_ == 0 : forward_ != 0) {
      // Even and odd depths fill up on different sides.
      const bool full = Depth % 2 == 0 ? end == &ahead.at(Depth / 2 + 1) : begin == &behind.at(kMostClosed);
      if (full) [[likely]] {  // It is rare, but the worst case counts: so the longest path has no jump.
        give_up<Sign>(*--end);
      } else {
        *begin++ = {travel_, force_N_};
      }
    }
    travel_ = travel;
    forward_ = Sign > 0 ? 1 : 0;
    if (reaches<Sign>(ahead.at(0))) {
      end_ahead = &ahead.at(0);
      behind.at(0).travel = -travel;
      end_behind = &behind.at(1);
      const Real force_N = curve_.force(static_cast<Real>(Sign > 0 ? travel : -travel));
      return force_N_ = Sign > 0 ? force_N : -force_N;
    }
#pragma GCC unroll 16
    for (std::size_t stride = kLargestStride; stride > 0; stride /= 2) {
      if (reaches<Sign>(*(end - stride))) {
        end -= stride;
        begin -= stride;
      }
    }
    end_ahead = end;
    end_behind = begin;
    return force_N_ = force_after<Sign>(*(begin - 1));
  }

  template <int Sign>
  constexpr bool reaches(const Reversal& place) const {
    return Sign > 0 ? travel_ >= place.travel : travel_ <= place.travel;
  }

  /// The innermost loop, from the newest reversal to here, the motion now in direction Sign.
  template <int Sign>
  constexpr void give_up(const Reversal& newest) {
    const Displacement length = Sign > 0 ? newest.travel - travel_ : travel_ - newest.travel;
    if (length > longest_overflow_) longest_overflow_ = length;
    ++overflow_count_;
  }

  template <int Sign>
  constexpr Real force_after(const Reversal& from) const {
    const Displacement moved = Sign > 0 ? travel_ - from.travel : from.travel - travel_;
    const Real height_N = branch_.force(static_cast<Real>(moved));
    return Sign > 0 ? from.force_N + height_N : from.force_N - height_N;
  }
  template <int Sign>
  constexpr Real force_on_branch() const {
    const bool virgin = (Sign > 0 ? memory_.number_of_maxima() : memory_.number_of_minima()) == 0;
    if (virgin) return virgin_force_N(travel_);
    return force_after<Sign>(*((Sign > 0 ? memory_.end_of_minima : memory_.end_of_maxima) - 1));
  }

  constexpr Real virgin_force_N(Displacement travel) const {
    const Real force_N = curve_.force(static_cast<Real>(distance(travel, Displacement{})));
    return travel < Displacement{} ? -force_N : force_N;
  }

  Curve curve_;
  Curve branch_;  ///< 2 y(x / 2), what a branch follows: the same to the bit, powers of two are exact
  Displacement origin_{};
  Displacement travel_{};     ///< position minus origin
  std::int32_t forward_ = 1;  ///< 1 after motion towards +x, 0 after motion towards -x
  Real force_N_ = Real(0);
  Memory memory_;
  Displacement longest_overflow_{};  ///< from reversal to reversal
  std::uint32_t overflow_count_ = 0;
};

}  // namespace slipstack
