// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// Encoder motion for measurements and traces, from integers only: the same on host and target.
namespace slipstack::budget {

// Marsaglia's xorshift32 (Journal of Statistical Software 8(14), 2003).
class Random {
 public:
  explicit Random(std::uint32_t seed) : state_(seed) {}

  std::uint32_t next() {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 17;
    state_ ^= state_ << 5;
    return state_;
  }

  // Uniform in [0, bound), bound > 0. The bias of the remainder does not matter here.
  std::uint32_t below(std::uint32_t bound) { return next() % bound; }

 private:
  std::uint32_t state_;
};

// Random motion that visits what an observer can meet: rest, single counts, slow runs, nested loops that
// spiral in and are closed all at once, overflow of a stack of depth 16, travel far into sliding, a
// wrapped-around counter. Positions in counts.
class RandomMotion {
 public:
  explicit RandomMotion(std::uint32_t seed, std::int32_t start = 0)
      : random_(seed), home_(start), x_(start) {}

  std::int32_t next() {
    if (left_ == 0) begin_phase();
    --left_;
    switch (phase_) {
      case Phase::kCreep:
        add(static_cast<std::int32_t>(random_.below(3)) - 1);
        break;
      case Phase::kRun:
        add(velocity_);
        break;
      case Phase::kSpiral:
        x_ = offset(home_, side_ * static_cast<std::int32_t>(amplitude_));
        side_ = -side_;
        amplitude_ -= amplitude_ > shrink_ ? shrink_ : amplitude_;
        break;
      case Phase::kScatter:
        x_ = offset(home_, static_cast<std::int32_t>(random_.below(2 * amplitude_ + 1)) -
                               static_cast<std::int32_t>(amplitude_));
        break;
    }
    return x_;
  }

 private:
  enum class Phase : std::uint8_t { kCreep, kRun, kSpiral, kScatter };

  static std::int32_t offset(std::int32_t x, std::int32_t by) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(x) + static_cast<std::uint32_t>(by));
  }

  void add(std::int32_t by) { x_ = offset(x_, by); }

  void begin_phase() {
    phase_ = static_cast<Phase>(random_.below(4));
    left_ = 1 + random_.below(60);
    velocity_ = static_cast<std::int32_t>(random_.below(81)) - 40;
    amplitude_ = 2 + random_.below(1U << (2 + random_.below(9)));
    shrink_ = 1 + amplitude_ / (1 + random_.below(40));
    side_ = random_.below(2) == 0 ? 1 : -1;
  }

  Random random_;
  std::int32_t home_;
  std::int32_t x_;
  Phase phase_ = Phase::kCreep;
  std::uint32_t left_ = 0;
  std::int32_t velocity_ = 0;
  std::uint32_t amplitude_ = 0;
  std::uint32_t shrink_ = 1;
  std::int32_t side_ = 1;
};

}  // namespace slipstack::budget
