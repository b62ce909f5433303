// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>

#include "firmware/canopen/objects/dictionary.h"

namespace slipstack::canopen {

/// The user's unit of position against the encoder's count (IEC 61800-7-201, factor group):
///
///   count = user x encoder resolution (608Fh) x gear ratio (6091h) / feed constant (6092h)
///
/// and the signs of 607Eh. The ratio of the six numbers is reduced once, N / D; a position is then one
/// product of 64 bits and one division, rounded to the nearest, halves away from zero: exact, also over 2 m
/// in nanometres. Where counts are not coarser than the user's unit, a position survives the way to counts
/// and back.
class UserUnits {
 public:
  /// N and D: a product with any number of 32 bits stays within 63.
  static constexpr std::uint64_t kLargest = 1U << 30U;

  /// In this order: 608Fh:01, :02, 6091h:01, :02, 6092h:01, :02. Nothing where N or D would be too large.
  static constexpr std::optional<UserUnits> of(const std::array<std::uint32_t, 6>& factors,
                                               std::uint32_t polarity) {
    std::array<std::uint32_t, 3> up = {factors[0], factors[2], factors[5]};
    std::array<std::uint32_t, 3> down = {factors[1], factors[3], factors[4]};
    for (std::uint32_t& a : up) {
      for (std::uint32_t& b : down) {
        if (a == 0 || b == 0) return std::nullopt;
        const std::uint32_t common = std::gcd(a, b);
        a /= common;
        b /= common;
      }
    }
    UserUnits made;
    const auto product = [](const std::array<std::uint32_t, 3>& of, std::int64_t& result) {
      std::uint64_t value = of[0];
      for (std::size_t i = 1; i < of.size(); ++i) {
        if (of[i] > kLargest || value > kLargest / of[i]) return false;
        value *= of[i];
      }
      result = static_cast<std::int64_t>(value);
      return value <= kLargest;
    };
    if (!product(up, made.counts_) || !product(down, made.users_)) return std::nullopt;
    made.turned_ = (polarity & kPosition) != 0;
    made.velocity_turned_ = (polarity & kVelocity) != 0;
    made.counts_per_user_ = static_cast<float>(made.counts_) / static_cast<float>(made.users_);
    return made;
  }

  /// Of the dictionary; `row` stands for another value than the one it holds.
  static std::optional<UserUnits> of(const Dictionary& dictionary, std::size_t row = kNoRow,
                                     std::uint32_t value = 0) {
    const auto at = [&](std::size_t wanted) { return wanted == row ? value : dictionary.value(wanted); };
    return of({at(kRow<0x608F, 1>), at(kRow<0x608F, 2>), at(kRow<0x6091, 1>), at(kRow<0x6091, 2>),
               at(kRow<0x6092, 1>), at(kRow<0x6092, 2>)},
              at(kRow<0x607E>));
  }

  /// A position or a distance in counts; nothing where it does not fit 32 bits.
  constexpr std::optional<std::int32_t> to_counts(std::int32_t user) const {
    const std::int64_t counts = scaled(turned_ ? -std::int64_t{user} : user, counts_, users_);
    if (counts != static_cast<std::int32_t>(counts)) return std::nullopt;
    return static_cast<std::int32_t>(counts);
  }
  /// The same in the user's unit; at the end of 32 bits where it would not fit.
  constexpr std::int32_t to_user(std::int32_t counts) const {
    const std::int64_t user = scaled(turned_ ? -std::int64_t{counts} : counts, users_, counts_);
    if (user > INT32_MAX) return INT32_MAX;
    return user < INT32_MIN ? INT32_MIN : static_cast<std::int32_t>(user);
  }
  /// A width: without sign; up to 2^62.
  constexpr std::uint64_t width_in_counts(std::uint32_t user) const {
    return static_cast<std::uint64_t>(scaled(user, counts_, users_));
  }

  /// Higher positions are lower counts.
  constexpr bool turned() const { return turned_; }

  /// Of rates without sign (6081h, 6083h, 6084h, 60A4h).
  constexpr float counts_per_user() const { return counts_per_user_; }
  /// Of a velocity, with the sign of its own.
  constexpr float velocity_in_user(float counts_per_s) const {
    const float user = counts_per_s / counts_per_user_;
    return velocity_turned_ ? -user : user;
  }
  constexpr float velocity_in_counts(float user_per_s) const {
    const float counts = user_per_s * counts_per_user_;
    return velocity_turned_ ? -counts : counts;
  }
  /// Of a difference of positions in counts that need not be whole.
  constexpr float distance_in_user(float counts) const {
    const float user = counts / counts_per_user_;
    return turned_ ? -user : user;
  }

  static constexpr std::uint32_t kPosition = 1U << 7U;  ///< bits of 607Eh
  static constexpr std::uint32_t kVelocity = 1U << 6U;

 private:
  static constexpr std::int64_t scaled(std::int64_t value, std::int64_t by, std::int64_t over) {
    if (over == 1) return value * by;
    const std::int64_t product = value * by;
    const std::int64_t half = over / 2;
    return (product < 0 ? product - half : product + half) / over;
  }

  std::int64_t counts_ = 1;
  std::int64_t users_ = 1;
  float counts_per_user_ = 1.0F;
  bool turned_ = false;
  bool velocity_turned_ = false;
};

}  // namespace slipstack::canopen
