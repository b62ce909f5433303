// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/friction/displacement.h"

namespace slipstack {

/// How the index marks of a scale are coded. Mark k of the even ones lies at k D from the scale's zero,
/// between it and the next one lies an odd one at k D + D/2 + k s: neighbours are D/2 + k s or D/2 - k s
/// apart, so that the distance of two, and which of both it is, say where they are. 1 <= k < D/2s.
struct MarkCode {
  std::uint32_t distance = 0;   ///< D, counts; 0: the marks are not coded
  std::int32_t step = 0;        ///< s, counts; negative: the scale counts against the encoder
  std::uint32_t tolerance = 1;  ///< by which a mark may be off its place, counts
};

/// Two steps must not be taken for one another, and no distance may be that of marks of which one was missed.
constexpr bool valid(const MarkCode& code) {
  if (code.distance == 0) return code.step == 0;
  const std::uint32_t step =
      code.step < 0 ? 0U - static_cast<std::uint32_t>(code.step) : static_cast<std::uint32_t>(code.step);
  return code.distance <= 0x1000'0000U && step > 4 * code.tolerance && step < code.distance / 4 &&
         code.tolerance >= 1;
}

/// Finds the scale's zero by marks that pass one after the other in one direction. Two would do; the third
/// must lie where these say, so that a mark that was missed, and one that is none, is refused: a missed one
/// makes a distance of D or D + s, which no neighbours have, and a false one two distances whose sum is
/// neither. After a refusal the search goes on with the marks that follow. O(1) a mark.
class CodedMarks {
 public:
  void restart() { seen_ = 0; }

  /// A mark passed at these counts. True when the marks agree: zero() is known.
  bool passed(const MarkCode& code, std::int32_t counts) {
    const std::int32_t along = code.step < 0 ? difference(std::int32_t{0}, counts) : counts;
    if (seen_ == marks_.size()) {
      marks_ = {marks_[1], marks_[2], along};
    } else {
      marks_[seen_++] = along;
    }
    if (seen_ < marks_.size()) return false;
    const bool up = difference(marks_[1], marks_[0]) > 0;
    const std::int32_t low = up ? marks_[0] : marks_[2];
    const std::int32_t high = up ? marks_[2] : marks_[0];
    const Mark first = lower_of(code, difference(marks_[1], low));
    const Mark second = lower_of(code, difference(high, marks_[1]));
    if (!follows(first, second)) return false;
    const std::int32_t zero = difference(marks_[1], place_of(code, second));
    zero_ = code.step < 0 ? difference(std::int32_t{0}, zero) : zero;
    return true;
  }
  /// Counts of the scale's zero.
  std::int32_t zero() const { return zero_; }

  /// Whether a mark may pass at these counts, if the scale's zero lies there: the check in service.
  static bool belongs(const MarkCode& code, std::int32_t zero, std::int32_t counts) {
    const std::int32_t along = code.step < 0 ? difference(zero, counts) : difference(counts, zero);
    const auto distance = static_cast<std::int32_t>(code.distance);
    const auto tolerance = static_cast<std::int32_t>(code.tolerance);
    // The even mark that is nearest, then the odd one before and behind it.
    const std::int32_t nearest = along / distance + (along % distance > distance / 2 ? 1 : 0);
    for (std::int32_t number = nearest - 1; number <= nearest; ++number) {
      if (number < 0) continue;
      for (const bool odd : {false, true}) {
        const std::int32_t off = difference(along, place_of(code, {number, odd}));
        if (off <= tolerance && off >= -tolerance) return true;
      }
    }
    return false;
  }

 private:
  struct Mark {
    std::int32_t number = 0;  // k; 0: no neighbours are so far apart
    bool odd = false;
  };

  static std::int32_t size_of(const MarkCode& code) { return code.step < 0 ? -code.step : code.step; }

  static std::int32_t place_of(const MarkCode& code, const Mark& mark) {
    const auto distance = static_cast<std::int32_t>(code.distance);
    const std::int32_t even =
        static_cast<std::int32_t>(static_cast<std::uint32_t>(mark.number) * code.distance);
    return mark.odd ? sum(even, distance / 2 + mark.number * size_of(code)) : even;
  }

  // Of two neighbours this far apart. Behind an even one the distance is the longer one.
  static Mark lower_of(const MarkCode& code, std::int32_t apart) {
    const auto distance = static_cast<std::int32_t>(code.distance);
    if (apart <= 0 || apart >= distance) return {};
    const std::int32_t longer = apart - distance / 2;
    const std::int32_t size = longer < 0 ? -longer : longer;
    const std::int32_t number = (size + size_of(code) / 2) / size_of(code);
    const std::int32_t off = size - number * size_of(code);
    // Both marks may be off their places.
    const auto tolerance = 2 * static_cast<std::int32_t>(code.tolerance);
    if (off > tolerance || off < -tolerance || number * size_of(code) > distance / 2 - size_of(code))
      return {};
    return {number, longer < 0};
  }

  static bool follows(const Mark& first, const Mark& second) {
    if (first.number == 0 || second.number == 0 || first.odd == second.odd) return false;
    return second.number == (first.odd ? first.number + 1 : first.number);
  }

  std::array<std::int32_t, 3> marks_{};
  std::size_t seen_ = 0;
  std::int32_t zero_ = 0;
};

}  // namespace slipstack
