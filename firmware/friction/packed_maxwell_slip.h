// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/friction/displacement.h"
#include "firmware/friction/packed_arithmetic.h"
#include "firmware/friction/virgin_curves.h"

namespace slipstack {

namespace detail {

/// State and parameters of 2 W stop operators, one word for two.
template <std::size_t W>
struct PackedRows {
  std::array<std::uint32_t, W> lanes{};
  std::array<std::uint32_t, W> turn{};       ///< 2 Delta + 1
  std::array<std::uint32_t, W> stiffness{};  ///< k in units of the common scale
};

/// Changes the direction of all lanes by `turn` (+1, 0, -1), moves them by `both`, limits them, and returns
/// total + sum of stiffness times lane, modulo 2^32.
template <std::size_t W>
std::uint32_t advance(PackedRows<W>& rows, std::uint32_t turn, std::uint32_t both, std::uint32_t total) {
#pragma GCC unroll 16
  for (std::size_t j = 0; j < W; ++j) {
    rows.lanes[j] = add_saturating(rows.lanes[j] + turn * rows.turn[j], both);
    total = multiply_add(rows.lanes[j], rows.stiffness[j], total);
  }
  return total;
}

#if defined(__ARM_FEATURE_SIMD32) && defined(__thumb2__) && defined(__OPTIMIZE__)
/// The same for the ten elements of the controller, with loads of several words at once, which the compiler
/// does not make: without them the observer exceeds its budget. Bit for bit the portable form (tests/budget
/// compares the two).
template <>
inline std::uint32_t advance<5>(PackedRows<5>& rows, std::uint32_t turn, std::uint32_t both,
                                std::uint32_t total) {
  static_assert(sizeof(PackedRows<5>) == 60);
  // The pointer is an input only: it comes back to where it was. r7 is left alone, a frame pointer may be in
  // it.
  asm("ldm    %[row]!, {r3, r4, r5, r6, r8} \n"
      "ldm    %[row]!, {r9, r10, r12}       \n"
      "mla    r3, r9, %[turn], r3           \n"
      "mla    r4, r10, %[turn], r4          \n"
      "mla    r5, r12, %[turn], r5          \n"
      "ldm    %[row]!, {r9, r10}            \n"
      "mla    r6, r9, %[turn], r6           \n"
      "mla    r8, r10, %[turn], r8          \n"
      "qadd16 r3, r3, %[both]               \n"
      "qadd16 r4, r4, %[both]               \n"
      "qadd16 r5, r5, %[both]               \n"
      "qadd16 r6, r6, %[both]               \n"
      "qadd16 r8, r8, %[both]               \n"
      "ldm    %[row]!, {r9, r10, r12}       \n"
      "smlad  %[total], r3, r9, %[total]    \n"
      "smlad  %[total], r4, r10, %[total]   \n"
      "smlad  %[total], r5, r12, %[total]   \n"
      "ldm    %[row]!, {r9, r10}            \n"
      "smlad  %[total], r6, r9, %[total]    \n"
      "smlad  %[total], r8, r10, %[total]   \n"
      "sub    %[row], #60                   \n"
      "stm    %[row], {r3, r4, r5, r6, r8}  \n"
      : [total] "+r"(total), "+m"(rows)
      : [row] "r"(&rows), [turn] "r"(turn), [both] "r"(both)
      : "r3", "r4", "r5", "r6", "r8", "r9", "r10", "r12");
  return total;
}
#endif

}  // namespace detail

/// MaxwellSlip on encoder counts for a processor with 16-bit lanes: three instructions for two elements.
///
/// A lane holds v = z + 32767 - Delta while the motion is towards +x, so that the slip limit ahead, z =
/// Delta, lies on the upper rail of the saturating addition; the limit behind cannot be reached in this
/// direction. Towards -x it holds v = z - 32768 + Delta, with z = -Delta on the lower rail. A change of
/// direction therefore adds or subtracts 2 Delta + 1, without a branch: with Delta <= 16383 no carry leaves a
/// lane, so that one 32-bit multiplication by +1, 0 or -1 and addition does it for both. Then QADD16 moves
/// and clamps both, SMLAD sums stiffness times lane, and the sum's offset (known for each direction) is taken
/// out at the start.
///
/// Every z_i is exact. Stiffnesses are rounded to 16 bits of a common scale: the force is that of MaxwellSlip
/// with the stiffnesses stiffness(i), exactly, but for one rounding to float at the end. The same bits on
/// every platform, and the same work for every input. A step of more than 32767 counts is cut there: all
/// elements slip fully either way.
///
/// N elements, N even; cost in tests/budget/budget.csv.
template <std::size_t N>
class PackedMaxwellSlip {
  static_assert(N >= 2 && N % 2 == 0, "two elements share a word");

 public:
  static constexpr std::size_t kCapacity = N;                  ///< elements
  static constexpr std::int32_t kLargestSlipDistance = 16383;  ///< counts

  PackedMaxwellSlip() { clear(); }

  /// Takes up to N elements: slip distances in counts, 0 <= Delta <= 16383, stiffnesses in N per count,
  /// finite and not negative. The elements restart unloaded at the present position. Outside the tick.
  [[nodiscard]] SetupStatus set_elements(std::span<const std::int32_t> slip_distance,
                                         std::span<const float> stiffness) {
    if (slip_distance.size() != stiffness.size()) return SetupStatus::kSizeMismatch;
    if (slip_distance.size() > N) return SetupStatus::kTooMany;
    for (std::size_t i = 0; i < slip_distance.size(); ++i) {
      if (slip_distance[i] < 0 || slip_distance[i] > kLargestSlipDistance) return SetupStatus::kOutOfRange;
      if (!is_finite(stiffness[i]) || stiffness[i] < 0.0F) return SetupStatus::kOutOfRange;
    }
    const float scale = common_scale(slip_distance, stiffness);
    if (!is_finite(scale)) return SetupStatus::kOutOfRange;
    clear();
    scale_N_ = scale;
    for (std::size_t i = 0; i < slip_distance.size(); ++i) {
      const std::int32_t k = scale > 0.0F ? static_cast<std::int32_t>(stiffness[i] / scale + 0.5F) : 0;
      set_element(i, slip_distance[i], portable::saturate16(k));
    }
    reset(position_);
    return SetupStatus::kOk;
  }

  /// Unloads every element at position x.
  void reset(std::int32_t x) {
    position_ = x;
    backward_ = 0;
    for (std::size_t j = 0; j < kWords; ++j) {
      const std::int32_t low = 32767 - slip_distance(2 * j);
      const std::int32_t high = 32767 - slip_distance(2 * j + 1);
      rows_.lanes[j] = portable::pack(low, high);
    }
  }

  /// Moves to position x in counts and returns the friction force in N. The difference to the last position
  /// must be below 2^31 counts; the counter may wrap.
  float step(std::int32_t x) {
    const std::int32_t travel = saturate16(difference(x, position_));
    const std::int32_t backward = travel >> 31;  // 0 towards +x or at rest, -1 towards -x
    const auto turn = static_cast<std::uint32_t>(backward_ - backward);
    const std::uint32_t both = both_lanes(travel);
    position_ = x;
    backward_ = backward;
    const std::uint32_t offset = offset_forward_ + static_cast<std::uint32_t>(backward) * offset_change_;
    const std::uint32_t total = detail::advance(rows_, turn, both, offset);
    return static_cast<float>(static_cast<std::int32_t>(total)) * scale_N_;
  }

  /// Continues the motion of `from`, which has other parameters for the same axis: its position and
  /// direction, and its displacements as far as the slip distances of this one allow.
  void carry_over(const PackedMaxwellSlip& from) {
    position_ = from.position_;
    backward_ = from.backward_;
    for (std::size_t j = 0; j < kWords; ++j) {
      const std::int32_t low = slip_distance(2 * j), high = slip_distance(2 * j + 1);
      const std::int32_t z_low = limited(from.z(2 * j), low), z_high = limited(from.z(2 * j + 1), high);
      rows_.lanes[j] = backward_ != 0 ? portable::pack(z_low - 32768 + low, z_high - 32768 + high)
                                      : portable::pack(z_low + 32767 - low, z_high + 32767 - high);
    }
  }

  /// Displacement of element i in counts, exact.
  std::int32_t z(std::size_t i) const {
    const std::int32_t v = lane(rows_.lanes[i / 2], i);
    return backward_ != 0 ? v + 32768 - slip_distance(i) : v - 32767 + slip_distance(i);
  }

  /// Writes the displacements of the first min(N, out.size()) elements, in counts.
  void elements(std::span<float> out) const {
    for (std::size_t i = 0; i < N && i < out.size(); ++i) out[i] = static_cast<float>(z(i));
  }

  /// Energy held by the elements, sum k z^2 / 2, in N counts.
  float stored_energy() const {
    float energy = 0.0F;
    for (std::size_t i = 0; i < N; ++i) {
      const auto stretch = static_cast<float>(z(i));
      energy += 0.5F * stiffness(i) * stretch * stretch;
    }
    return energy;
  }

  /// Stiffness of element i as held, in N per count: a whole multiple of stiffness_step().
  float stiffness(std::size_t i) const {
    return static_cast<float>(lane(rows_.stiffness[i / 2], i)) * scale_N_;
  }

  /// The unit of the stiffnesses, in N per count.
  float stiffness_step() const { return scale_N_; }

  /// Of element i, in counts.
  std::int32_t slip_distance(std::size_t i) const {
    return static_cast<std::int32_t>((rows_.turn[i / 2] >> (i % 2 == 0 ? 0U : 16U)) & 0xFFFFU) / 2;
  }

  std::int32_t position() const { return position_; }  ///< of the last step or reset, in counts

 private:
  static constexpr std::size_t kWords = N / 2;

  static std::int32_t lane(std::uint32_t word, std::size_t i) {
    return i % 2 == 0 ? portable::low_lane(word) : portable::high_lane(word);
  }

  static std::int32_t limited(std::int32_t z, std::int32_t limit) {
    const std::int32_t below = z > limit ? limit : z;
    return below < -limit ? -limit : below;
  }

  /// Smallest unit for which every stiffness fits in 15 bits and the greatest sum of k z in 31.
  static float common_scale(std::span<const std::int32_t> slip_distance, std::span<const float> stiffness) {
    float largest = 0.0F;
    float sum_N = 0.0F;
    float rounding = 0.0F;  // what rounding each k up by half a unit can add to the sum
    for (std::size_t i = 0; i < stiffness.size(); ++i) {
      largest = stiffness[i] > largest ? stiffness[i] : largest;
      sum_N += stiffness[i] * static_cast<float>(slip_distance[i]);
      rounding += static_cast<float>(slip_distance[i]);
    }
    const float by_lane = largest / 32767.0F;
    const float by_sum = sum_N / (2147480000.0F - rounding);
    return by_lane > by_sum ? by_lane : by_sum;
  }

  void clear() {
    rows_.stiffness.fill(0);
    rows_.turn.fill(0x00010001U);  // 2 Delta + 1 with Delta = 0
    offset_forward_ = 0;
    offset_change_ = 0;
    scale_N_ = 0.0F;
    reset(position_);
  }

  void set_element(std::size_t i, std::int32_t slip_distance, std::int32_t stiffness) {
    const unsigned shift = i % 2 == 0 ? 0U : 16U;
    rows_.turn[i / 2] = (rows_.turn[i / 2] & ~(0xFFFFU << shift)) |
                        (static_cast<std::uint32_t>(2 * slip_distance + 1) << shift);
    rows_.stiffness[i / 2] |= static_cast<std::uint32_t>(stiffness) << shift;
    // Forward the sum carries + k (32767 - Delta), backward - k (32768 - Delta): 65535 - 2 Delta apart.
    offset_forward_ -= static_cast<std::uint32_t>(stiffness * (32767 - slip_distance));
    offset_change_ -=
        static_cast<std::uint32_t>(stiffness) * static_cast<std::uint32_t>(65535 - 2 * slip_distance);
  }

  detail::PackedRows<kWords> rows_;
  std::int32_t position_ = 0;
  std::int32_t backward_ = 0;  ///< 0: the lanes are held for motion towards +x, -1: towards -x
  std::uint32_t offset_forward_ = 0;
  std::uint32_t offset_change_ = 0;
  float scale_N_ = 0.0F;
};

}  // namespace slipstack
