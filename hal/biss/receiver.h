// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include "hal/biss/frame.h"
#include "hal/include/absolute_encoder.h"
#include "hal/include/encoder.h"

namespace slipstack::biss {

/// The counts of an axis from the positions of its encoder. The counts of the firmware are 32 bits, modulo
/// 2^32; a position of more bits loses its highest ones, which is right on every axis shorter than 2^32
/// counts. With fewer bits the counts go on where the position wraps, as on a shaft.
class AbsoluteCounts {
 public:
  /// Behind a gap the position is taken as it is: what happened meanwhile nobody saw.
  std::int32_t take(std::uint64_t position, unsigned bits, bool behind_a_gap) {
    const auto now = static_cast<std::uint32_t>(position);
    if (bits >= 32 || behind_a_gap) {
      counts_ = now;
    } else {
      const std::uint32_t step = (now - last_) << (32 - bits);  // its sign is that of the shorter way
      counts_ += static_cast<std::uint32_t>(static_cast<std::int32_t>(step) >> (32 - bits));
    }
    last_ = now;
    return static_cast<std::int32_t>(counts_);
  }

 private:
  std::uint32_t counts_ = 0;
  std::uint32_t last_ = 0;
};

/// Between the frames, which an interrupt below the tick receives, and the tick, which reads the last one.
class Receiver {
 public:
  /// Frames without a position after which the next one is taken as it is: far more than the controller
  /// bridges, so that such a step meets an axis that is at fault.
  static constexpr std::uint32_t kGap = 64;

  // ---- outside the tick, while no frame is under way ----

  void use(const EncoderInterface& interface, bool reversed) {
    interface_ = interface;
    reversed_ = reversed;
    missing_ = kGap;
    published_.store(nullptr, std::memory_order_relaxed);
  }
  FrameCounters counters() const {
    FrameCounters all = counters_;
    all.silent += late_.load(std::memory_order_relaxed);
    return all;
  }

  // ---- in the interrupt at the end of a frame ----

  /// What was sampled, and when the encoder took its position. O(bits): 351 instructions for 36 of them
  /// (tests/budget, encoder_frame).
  void received(std::span<const std::uint8_t> sampled, std::uint32_t latched) {
    const Frame frame = decode(sampled, interface_.position_bits);
    note(frame);
    const std::uint32_t late = late_.load(std::memory_order_relaxed);
    missing_ = missing_ + (late - seen_late_) < kGap ? missing_ + (late - seen_late_) : kGap;
    seen_late_ = late;
    const bool good = frame.reception == Reception::kGood;
    if (good) {
      const unsigned bits = interface_.position_bits - interface_.dropped_bits;
      last_ = counts_.take(frame.position >> interface_.dropped_bits, bits, missing_ >= kGap);
    }
    missing_ = good ? 0 : missing_ + (missing_ < kGap ? 1U : 0U);
    EncoderReading& next = readings_[next_];
    // The complement and one, modulo 2^32: the lowest count has no opposite.
    const auto counts = static_cast<std::uint32_t>(last_);
    next = {static_cast<std::int32_t>(reversed_ ? 0U - counts : counts), latched, good};
    published_.store(&next, std::memory_order_release);
    next_ = 1 - next_;
  }

  // ---- in the tick ----

  /// The position that came since the last call; not valid without one. 25 instructions.
  EncoderReading read() {
    if (const EncoderReading* const now = published_.load(std::memory_order_acquire)) {
      published_.store(nullptr, std::memory_order_relaxed);
      reading_ = *now;
    } else {
      reading_.valid = false;
    }
    return reading_;
  }
  /// The frame before has not ended in time.
  void late() { late_.store(late_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed); }

 private:
  static void count(std::uint32_t& counter) {
    if (counter != 0xFFFFFFFF) ++counter;
  }
  void note(const Frame& frame) {
    switch (frame.reception) {
      case Reception::kSilent:
        return count(counters_.silent);
      case Reception::kBadCrc:
        return count(counters_.bad_crc);
      case Reception::kError:
        return count(counters_.errors);
      case Reception::kGood:
        counters_.warning = frame.warning;
        if (frame.warning) count(counters_.warnings);
    }
  }

  EncoderInterface interface_;
  bool reversed_ = false;
  AbsoluteCounts counts_;
  std::int32_t last_ = 0;
  std::uint32_t missing_ = kGap;
  std::uint32_t seen_late_ = 0;
  std::atomic<std::uint32_t> late_{0};
  FrameCounters counters_;
  std::array<EncoderReading, 2> readings_{};
  unsigned next_ = 0;
  std::atomic<const EncoderReading*> published_{nullptr};
  EncoderReading reading_;  // the tick's
};

}  // namespace slipstack::biss
