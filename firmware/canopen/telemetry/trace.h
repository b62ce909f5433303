// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstdint>
#include <span>

#include "firmware/canopen/objects/dictionary.h"

namespace slipstack::canopen {

/// One recorded tick.
struct TraceSample {
  std::int32_t counts = 0;     ///< as the encoder read
  std::int32_t reference = 0;  ///< counts; or the excitation, the bits of a float in N or m (2300h:0A)
  float current_A = 0.0F;      ///< commanded, about the instant of the counts
};

enum class TraceState : std::uint8_t { kIdle, kArmed, kTriggered, kReady };
enum class TraceTrigger : std::uint8_t { kAtOnce, kRising, kFalling };

struct TraceSettings {
  std::uint32_t decimation = 1;
  TraceTrigger trigger = TraceTrigger::kAtOnce;
  std::uint8_t channel = 0;  ///< 0 counts, 1 reference, 2 current
  float level = 0.0F;        ///< counts or A
  std::uint32_t before = 0;  ///< samples kept from before the trigger
};

/// A ring of samples that a trigger freezes. sample() is called from the tick's interrupt, behind the tick;
/// everything else from the main loop.
class TraceBuffer {
 public:
  explicit TraceBuffer(std::span<TraceSample> memory) : memory_(memory) {}

  std::uint32_t capacity() const { return static_cast<std::uint32_t>(memory_.size()); }
  TraceState state() const { return state_.load(std::memory_order_acquire); }
  std::uint32_t samples() const { return count_; }
  std::uint32_t decimation() const { return settings_.decimation; }
  /// Place of the first sample at or after the trigger.
  std::uint32_t trigger_place() const { return count_ - (after_ < count_ ? after_ : count_); }
  std::uint32_t last_tick() const { return last_tick_; }

  void stop() { state_.store(TraceState::kIdle, std::memory_order_release); }
  void arm(const TraceSettings& settings) {
    stop();
    settings_ = settings;
    if (settings_.before >= capacity()) settings_.before = capacity() - 1;
    next_ = count_ = after_ = 0;
    skip_ = 0;
    have_last_ = false;
    state_.store(TraceState::kArmed, std::memory_order_release);
  }

  /// In the tick.
  void sample(const TraceSample& now, std::uint32_t tick) {
    const TraceState state = state_.load(std::memory_order_relaxed);
    if (state != TraceState::kArmed && state != TraceState::kTriggered) return;
    bool fires = false;
    if (state == TraceState::kArmed) fires = triggers(now);
    const bool skipped = skip_ != 0 && !fires;
    skip_ = skipped ? skip_ - 1 : settings_.decimation - 1;
    if (skipped) return;
    memory_[next_] = now;
    next_ = next_ + 1 == capacity() ? 0 : next_ + 1;
    if (count_ < capacity()) ++count_;
    last_tick_ = tick;
    if (!fires && state == TraceState::kArmed) {
      if (count_ > settings_.before) count_ = settings_.before;  // only so many are kept
      return;
    }
    ++after_;
    const bool full = after_ >= capacity() - settings_.before;
    state_.store(full ? TraceState::kReady : TraceState::kTriggered, std::memory_order_release);
  }

  /// Samples in the order of time; only when ready or stopped.
  const TraceSample& operator[](std::uint32_t i) const {
    const std::uint32_t first = next_ >= count_ ? next_ - count_ : next_ + capacity() - count_;
    const std::uint32_t at = first + i;
    return memory_[at >= capacity() ? at - capacity() : at];
  }

 private:
  bool triggers(const TraceSample& now) {
    if (settings_.trigger == TraceTrigger::kAtOnce) return true;
    const float value = settings_.channel == 0   ? static_cast<float>(now.counts)
                        : settings_.channel == 1 ? static_cast<float>(now.reference)
                                                 : now.current_A;
    const bool above = value >= settings_.level;
    const bool fires =
        have_last_ && above != last_above_ && above == (settings_.trigger == TraceTrigger::kRising);
    last_above_ = above;
    have_last_ = true;
    return fires;
  }

  std::span<TraceSample> memory_;
  TraceSettings settings_;
  std::atomic<TraceState> state_{TraceState::kIdle};
  std::uint32_t next_ = 0;
  std::uint32_t count_ = 0;
  std::uint32_t after_ = 0;
  std::uint32_t skip_ = 0;
  std::uint32_t last_tick_ = 0;
  bool have_last_ = false;
  bool last_above_ = false;
};

/// The head of the domain 2310h, little-endian; the samples follow.
struct TraceHead {
  static constexpr std::uint32_t kMagic = 0x52544C53;  ///< "SLTR"
  std::uint32_t magic = kMagic;
  std::uint16_t version = 1;
  std::uint16_t head_bytes = 48;
  std::uint32_t samples = 0;
  std::uint32_t decimation = 1;
  float tick_s = 0.0F;
  float encoder_resolution_m = 0.0F;
  float motor_constant_N_per_A = 0.0F;
  float mass_kg = 0.0F;
  std::uint32_t model_hash = 0;
  std::uint32_t trigger_place = 0;
  std::uint32_t last_tick = 0;
  std::uint32_t second_channel = 0;  ///< 0 reference, 1 excitation
};
static_assert(sizeof(TraceHead) == 48 && sizeof(TraceSample) == 12 &&
              std::endian::native == std::endian::little);

}  // namespace slipstack::canopen
