// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/control/homing/coded_marks.h"
#include "firmware/friction/displacement.h"

namespace slipstack {

/// How the place of an encoder's zero is known, and how its marks are checked.
struct PositionReferenceParameters {
  bool absolute_encoder = false;      ///< counts keep their place when power is off: no homing
  std::int32_t absolute_origin = 0;   ///< counts of an absolute encoder at position zero
  std::uint32_t index_distance = 0;   ///< counts from one index mark to the next; 0: there is one only
  std::uint32_t index_tolerance = 0;  ///< counts by which a mark may be off its place; 0: not checked
  std::uint32_t bridged_ticks = 0;    ///< of an absolute encoder without a position (EncoderBridge)
  std::uint32_t coded_distance = 0;  ///< counts from one even mark to the next of a coded scale; 0: not coded
  std::int32_t coded_step = 0;       ///< of its code, counts

  MarkCode code() const { return {coded_distance, coded_step, index_tolerance > 1 ? index_tolerance : 1U}; }
};

/// Where position zero lies in the counts of the encoder, and whether that is known. Inside the controller
/// there are counts; what the world sees is a position, counts less origin(), modulo 2^32.
///
/// What depends on the place along the rail counts with weight(): zero without a reference, and in between
/// while it fades in or out, so that the force does not step. The origin changes while the weight is zero.
class PositionReference {
 public:
  std::int32_t origin() const { return origin_.load(std::memory_order_relaxed); }
  bool referenced() const { return referenced_.load(std::memory_order_relaxed); }
  float weight() const { return weight_.load(std::memory_order_relaxed); }
  std::int32_t position_of(std::int32_t counts) const { return difference(counts, origin()); }
  std::int32_t counts_of(std::int32_t position) const { return sum(position, origin()); }

  // ---- outside the tick ----

  /// Zero lies here from now on. False while what depends on the old one still fades: try again.
  bool set(std::int32_t origin_counts) {
    if (weight() > 0.0F && origin_counts != origin()) return false;
    origin_.store(origin_counts, std::memory_order_relaxed);
    referenced_.store(true, std::memory_order_release);
    return true;
  }
  void give_up() { referenced_.store(false, std::memory_order_relaxed); }

  /// In every pass of the main loop. `share`: of the time of fading that has passed since the last one; 1
  /// while the axis is not driven.
  void fade(float share) {
    const float step = referenced() ? share : -share;
    const float wanted = weight() + step;
    weight_.store(wanted < 0.0F ? 0.0F : (wanted > 1.0F ? 1.0F : wanted), std::memory_order_relaxed);
  }

  // ---- in the tick ----

  /// The counts have lost their place.
  void lose() {
    referenced_.store(false, std::memory_order_relaxed);
    marked_.store(false, std::memory_order_relaxed);
    scale_known_.store(false, std::memory_order_relaxed);
  }
  /// The first parameters.
  void start(const PositionReferenceParameters& parameters) {
    lose();
    weight_.store(0.0F, std::memory_order_relaxed);
    origin_.store(parameters.absolute_encoder ? parameters.absolute_origin : 0, std::memory_order_relaxed);
    if (!parameters.absolute_encoder) return;
    referenced_.store(true, std::memory_order_relaxed);
    weight_.store(1.0F, std::memory_order_relaxed);
  }
  /// An index mark passed at these counts.
  void index_passed(std::int32_t counts) {
    index_counts_ = counts;
    index_waits_.store(true, std::memory_order_release);
  }

  // ---- outside the tick ----

  /// The zero of a coded scale, by which its marks are checked from now on.
  void set_scale_zero(std::int32_t counts) {
    scale_zero_ = counts;
    scale_known_.store(true, std::memory_order_relaxed);
  }
  /// In every pass of the main loop. False if the last mark lies elsewhere than the first one says: counts
  /// were lost or added in between.
  bool check_index(const PositionReferenceParameters& parameters) {
    if (!index_waits_.exchange(false, std::memory_order_acquire)) return true;
    const std::int32_t counts = index_counts_;
    if (parameters.index_tolerance == 0) return true;
    if (parameters.coded_distance != 0) {
      return !scale_known_.load(std::memory_order_relaxed) ||
             CodedMarks::belongs(parameters.code(), scale_zero_, counts);
    }
    if (!marked_.exchange(true, std::memory_order_relaxed)) {
      mark_counts_ = counts;
      return true;
    }
    const std::int32_t apart = difference(counts, mark_counts_);
    std::uint32_t off =
        apart < 0 ? 0U - static_cast<std::uint32_t>(apart) : static_cast<std::uint32_t>(apart);
    if (parameters.index_distance != 0) {
      off %= parameters.index_distance;
      off = off < parameters.index_distance - off ? off : parameters.index_distance - off;
    }
    return off <= parameters.index_tolerance;
  }

 private:
  std::atomic<std::int32_t> origin_{0};
  std::atomic<float> weight_{0.0F};
  std::atomic<bool> referenced_{false};
  std::atomic<bool> marked_{false};
  std::int32_t mark_counts_ = 0;  // of the first mark
  std::atomic<bool> scale_known_{false};
  std::int32_t scale_zero_ = 0;  // of a coded scale
  std::atomic<bool> index_waits_{false};
  std::int32_t index_counts_ = 0;  // of the last one
};

}  // namespace slipstack
