// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>

namespace slipstack::test {

// Seeded random motion on integer positions within [-range, range] that is hard on hysteresis with memory:
// creeping by single counts with rests, jumps anywhere, spirals that nest as many loops as fit and are then
// left in one step, and exact returns to earlier turning points.
class NestedMotion {
 public:
  NestedMotion(std::uint64_t seed, std::int32_t range) : random_(seed), range_(range) {}

  std::int32_t next() {
    if (left_ == 0) begin_phase();
    --left_;
    const std::int32_t before = x_;
    switch (phase_) {
      case 0:
        x_ += between(-1, 1);
        break;
      case 1:
        x_ += between(0, 1) * velocity_;
        break;
      case 2:
        x_ = center_ + side_ * amplitude_;
        side_ = -side_;
        amplitude_ = std::max(0, amplitude_ - between(0, shrink_));
        break;
      case 3:
        x_ = between(-range_, range_);
        break;
      default:  // back to exactly where the motion has been
        x_ = remembered_[static_cast<std::size_t>(between(0, kRemembered - 1))];
        break;
    }
    x_ = std::clamp(x_, -range_, range_);
    remembered_[static_cast<std::size_t>(between(0, kRemembered - 1))] = before;
    return x_;
  }

  std::int32_t between(std::int32_t low, std::int32_t high) {
    return low + static_cast<std::int32_t>(random_() % static_cast<std::uint64_t>(high - low + 1));
  }

 private:
  static constexpr std::int32_t kRemembered = 8;

  void begin_phase() {
    phase_ = between(0, 4);
    left_ = between(1, phase_ == 2 ? 3 * range_ : 40);
    velocity_ = between(-std::max(1, range_ / 8), std::max(1, range_ / 8));
    amplitude_ = between(1, range_);
    center_ = between(-(range_ - amplitude_), range_ - amplitude_);
    shrink_ = between(1, 3);
    side_ = between(0, 1) == 0 ? 1 : -1;
  }

  std::mt19937_64 random_;
  std::int32_t range_;
  std::int32_t x_ = 0;
  std::int32_t phase_ = 0;
  std::int32_t left_ = 0;
  std::int32_t velocity_ = 0;
  std::int32_t amplitude_ = 0;
  std::int32_t center_ = 0;
  std::int32_t shrink_ = 1;
  std::int32_t side_ = 1;
  std::int32_t remembered_[kRemembered] = {};
};

}  // namespace slipstack::test
