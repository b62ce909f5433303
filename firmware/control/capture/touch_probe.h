// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack {

/// A touch probe: keeps the position at the edges of an input, or at an index mark (IEC 61800-7-201, touch
/// probe). In the main loop, which follows the ticks one by one.
class TouchProbe {
 public:
  /// Bits of the probe's half of 60B8h.
  static constexpr std::uint32_t kEnable = 1U << 0;
  static constexpr std::uint32_t kContinuous = 1U << 1;
  static constexpr std::uint32_t kIndex = 1U << 2;  ///< the encoder's index mark in place of the input
  static constexpr std::uint32_t kSamplePositive = 1U << 4;
  static constexpr std::uint32_t kSampleNegative = 1U << 5;

  /// The position at an edge, in the unit that see() was given.
  struct Edge {
    bool stored = false;  ///< since the probe was armed
    std::int32_t position = 0;
    std::uint16_t number = 0;  ///< positions kept since the start
  };

  /// Another function. Enabling, and another source or repetition, arm both edges; a bit of an edge arms that
  /// one when it is set. Positions stay until the next edge. `active`: the input as it is now.
  void command(std::uint32_t function, bool active) {
    const std::uint32_t changed = function ^ function_;
    const bool anew = (changed & ~(kSamplePositive | kSampleNegative)) != 0;
    function_ = function;
    if (anew) was_active_ = active;
    if (anew || (changed & kSamplePositive) != 0) positive_.stored = false;
    if (anew || (changed & kSampleNegative) != 0) negative_.stored = false;
  }
  bool enabled() const { return (function_ & kEnable) != 0; }

  /// The input in the next tick. `position()` is asked at an edge.
  template <class Position>
  void see(bool active, Position&& position) {
    const bool edge = active != was_active_;
    was_active_ = active;
    if (edge) see_edge(active, position);
  }
  /// After ticks that were not seen: an edge among them is lost, for its place is not known.
  void resume(bool active) { was_active_ = active; }
  /// An edge of the input that hardware has caught, to active or not. In place of see().
  template <class Position>
  void see_edge(bool to_active, Position&& position) {
    if ((function_ & (kEnable | kIndex)) != kEnable) return;
    take(to_active ? positive_ : negative_, to_active ? kSamplePositive : kSampleNegative, position);
  }
  /// An index mark; it counts as a positive edge.
  template <class Position>
  void see_index(Position&& position) {
    if ((function_ & (kEnable | kIndex)) == (kEnable | kIndex)) take(positive_, kSamplePositive, position);
  }

  const Edge& positive() const { return positive_; }
  const Edge& negative() const { return negative_; }

  /// The probe's half of 60B9h: enabled, edges stored; bits 6 and 7 change with each position that is kept,
  /// so that a master in continuous mode sees it.
  std::uint32_t status() const {
    if (!enabled()) return 0;
    return 1U | (positive_.stored ? 2U : 0U) | (negative_.stored ? 4U : 0U) |
           ((positive_.number & 1U) << 6U) | ((negative_.number & 1U) << 7U);
  }

 private:
  template <class Position>
  void take(Edge& edge, std::uint32_t sampled, Position& position) {
    if ((function_ & sampled) == 0 || (edge.stored && (function_ & kContinuous) == 0)) return;
    edge = {true, position(), static_cast<std::uint16_t>(edge.number + 1U)};
  }

  std::uint32_t function_ = 0;
  bool was_active_ = false;
  Edge positive_;
  Edge negative_;
};

}  // namespace slipstack
