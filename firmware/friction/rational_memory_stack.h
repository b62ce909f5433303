// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "firmware/friction/displacement.h"
#include "firmware/friction/virgin_curves.h"

namespace slipstack {

// MemoryStack with the rational curve on encoder counts, in a form whose worst case is short.
//
// Everything is held as seen along the motion: displacement and force are multiplied by the direction, so
// that a branch always leads from a reversal at `start` upwards to larger displacement and force, and one
// comparison finds the end of whichever branch is followed:
//
//   F = base - g / (d + D)^2,   d = displacement - start,
//   virgin curve:           start = 0,      base = h0,          g = h0 delta^2,    D = delta,
//   after a reversal at F_m: start = -x_m,  base = 2 h0 + F_m,  g = 8 h0 delta^2,  D = 2 delta,
//
// which is Rule II written out. Branch t is enclosed, in its own direction, by branch t - 2, and ends at the
// start of branch t - 1; branches 0 and 1 are both the virgin curve, one for each direction. The starts of
// the branches alternate between two ordered rows, so that all loops that a step closes are found by
// bisection.
//
// Forces differ from those of MemoryStack by rounding only (of the size of 2^-24 h0 for each reversal held).
// Overflow is treated alike. Depth even; cost in tests/budget/budget.csv.
template <std::size_t Depth>
class RationalMemoryStack {
  static_assert(Depth >= 2 && Depth % 2 == 0);

 public:
  static constexpr std::size_t kDepth = Depth;

  // The curve's length is in counts.
  explicit RationalMemoryStack(const RationalCurve<float>& curve) : span_N_(2.0F * curve.height_N) {
    Branch* const first = &branches_[kPad];
    for (std::size_t t = 0; t < kBranches; ++t) {
      const bool virgin = t <= kVirgin;
      Branch& branch = first[t];
      branch.length = virgin ? curve.length : 2.0F * curve.length;
      branch.gain = (virgin ? 1.0F : 2.0F) * curve.height_N * (branch.length * branch.length);
      branch.base_N = curve.height_N;
      branch.next = virgin ? &first[kVirgin + 1] : (t + 1 < kBranches ? &first[t + 1] : nullptr);
      branch.mirror = virgin ? &first[kVirgin] : branch.next;
    }
    reset(0);
  }

  // The branches point at each other.
  RationalMemoryStack(const RationalMemoryStack&) = delete;
  RationalMemoryStack& operator=(const RationalMemoryStack&) = delete;
  RationalMemoryStack(RationalMemoryStack&&) = delete;
  RationalMemoryStack& operator=(RationalMemoryStack&&) = delete;
  ~RationalMemoryStack() = default;

  // Forgets everything: the virgin state, unloaded, at x.
  void reset(std::int32_t x) {
    origin_ = x;
    direction_ = 1;
    behind_ = 0;
    force_N_ = 0.0F;
    branch_ = virgin();
  }

  // Moves to position x in counts and returns the friction force in N, positive after motion towards +x. The
  // travel from the place of the reset must stay below 2^30 counts. Bounded: one bisection, no loop.
  float step(std::int32_t x) {
    std::int32_t direction = direction_;
    std::int32_t behind = difference(origin_, x) * direction;
    Branch* branch = branch_;
    if (behind > behind_) [[likely]] {
      behind = -behind;
      direction = -direction;
      branch = reverse(branch);
    }
    if (branch[-1].bound >= behind) {
      branch -= 2;
#pragma GCC unroll 8
      for (std::ptrdiff_t loops = kFirstStride; loops > 0; loops /= 2) {
        if (branch[1 - 2 * loops].bound >= behind) branch -= 2 * loops;
      }
    }
    direction_ = direction;
    behind_ = behind;
    branch_ = branch;
    const float moved = branch->length - static_cast<float>(behind + branch->start);
    force_N_ = branch->base_N - branch->gain / (moved * moved);
    return direction < 0 ? -force_N_ : force_N_;
  }

  float force_N() const {
    return direction_ < 0 ? -force_N_ : force_N_;
  }
  std::int32_t position() const {
    return difference(origin_, behind_ * direction_);
  }
  std::size_t depth() const {
    return branch_ <= virgin() ? 0 : static_cast<std::size_t>(branch_ - virgin());
  }
  std::uint32_t overflow_count() const {
    return overflow_count_;
  }

 private:
  static constexpr std::size_t kVirgin = 1;
  static constexpr std::size_t kBranches = Depth + 2;
  static constexpr std::ptrdiff_t kFirstStride = std::bit_ceil(Depth / 2) / 2;
  static constexpr std::size_t kPad = 2 * static_cast<std::size_t>(kFirstStride) + 1;
  static constexpr std::int32_t kNever = std::numeric_limits<std::int32_t>::min();

  struct Branch {
    std::int32_t bound = kNever;  // the branch after this one ends when the displacement passes -bound
    std::int32_t start = 0;
    float base_N = 0.0F;
    float gain = 0.0F;
    float length = 1.0F;
    Branch* next = nullptr;  // entered by a reversal; none when the stack is full
    Branch* mirror =
        nullptr;  // whose bound a reversal sets as well: leaving the virgin curve, the mirror image
  };

  Branch* virgin() {
    return &branches_[kPad + kVirgin];
  }
  const Branch* virgin() const {
    return &branches_[kPad + kVirgin];
  }

  // Leaves a branch in the opposite direction, at behind_ and force_N_; returns the branch that begins.
  Branch* reverse(Branch* branch) {
    Branch* const next = branch->next;
    if (next == nullptr) {
      ++overflow_count_;
      return branch - 1;
    }
    branch->mirror->bound = behind_;
    next->bound = behind_;
    next->start = behind_;
    next->base_N = span_N_ - force_N_;
    return next;
  }

  std::int32_t origin_ = 0;
  std::int32_t direction_ = 1;  // of the last motion
  std::int32_t behind_ = 0;     // origin minus position, times direction
  Branch* branch_ = nullptr;
  float force_N_ = 0.0F;  // times direction
  float span_N_ = 0.0F;
  std::uint32_t overflow_count_ = 0;
  std::array<Branch, kPad + kBranches> branches_{};
};

}  // namespace slipstack
