// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/canopen/profile/profile_context.h"
#include "firmware/control/capture/touch_probe.h"
#include "hal/include/edge_capture.h"

namespace slipstack::canopen {

/// The two touch probes: 60B8h to 60BDh and 60D5h to 60D8h (IEC 61800-7-201), their terminals 2013h. An index
/// mark is seen to the count, and so are the edges of a terminal that the board captures; those of others to
/// the tick.
class TouchProbeProfile {
 public:
  explicit TouchProbeProfile(const ProfileContext& context, EdgeCapture* edges = nullptr)
      : context_(context), edges_(edges) {}

  /// Values of 60B8h: sources are the input (0) and the index mark (1); a probe without a terminal cannot be
  /// enabled on its input.
  static Abort check(const Dictionary& dictionary, std::uint32_t function) {
    for (std::uint8_t i = 0; i < kProbes; ++i) {
      const std::uint32_t half = half_of(function, i);
      if ((half & ~kFunctionBits) != 0) return Abort::kBadValue;
      const bool on_input = (half & (TouchProbe::kEnable | TouchProbe::kIndex)) == TouchProbe::kEnable;
      if (on_input && terminal(dictionary, i) == 0) return Abort::kBadValue;
    }
    return Abort::kNone;
  }

  void reset() { probes_ = {}; }

  /// 60B8h was written.
  void command(std::uint32_t function) {
    step();
    const std::uint32_t active = this->active(context_.controller.history().reading(seen_));
    for (std::uint8_t i = 0; i < kProbes; ++i) {
      masks_[i] = IoMasks::bit(terminal(*context_.dictionary, i));
      probes_[i].command(half_of(function, i), (active & masks_[i]) != 0);
    }
  }

  /// Once in every poll: what the ticks have read since the last one. At most TickHistory::kLatest ticks.
  void step() {
    const Controller& controller = context_.controller;
    const TickHistory& history = controller.history();
    const std::uint32_t last = controller.ticks();
    const std::uint32_t index_number = history.index_number();
    const bool enabled = probes_[0].enabled() || probes_[1].enabled();
    if (enabled && index_number != index_seen_) {
      for (TouchProbe& probe : probes_) probe.see_index([&] { return position(history.index_counts()); });
    }
    index_seen_ = index_number;
    take_edges();
    if (!enabled) {
      seen_ = last;
      return;
    }
    history.follow(
        seen_, last, [&controller] { return controller.ticks(); },
        [this](const TickHistory::Entry& entry, std::uint32_t missed) { see(entry.reading, missed > 0); });
  }

  /// Whether an object is read here.
  static bool has(std::uint16_t index) {
    return (index >= 0x60B9 && index <= 0x60BD) || (index >= 0x60D5 && index <= 0x60D8);
  }
  std::uint32_t read(std::uint16_t index) const {
    if (index == 0x60B9) return probes_[0].status() | (probes_[1].status() << 8U);
    const bool counter = index >= 0x60D5;
    const unsigned edge = index - (counter ? 0x60D5U : 0x60BAU);  // positive, negative; of both probes
    const TouchProbe& probe = probes_[edge / 2];
    const TouchProbe::Edge& kept = edge % 2 == 0 ? probe.positive() : probe.negative();
    return counter ? kept.number : static_cast<std::uint32_t>(kept.position);
  }

 private:
  static constexpr std::uint8_t kProbes = 2;
  static constexpr std::uint32_t kFunctionBits = TouchProbe::kEnable | TouchProbe::kContinuous |
                                                 TouchProbe::kIndex | TouchProbe::kSamplePositive |
                                                 TouchProbe::kSampleNegative;

  static std::uint32_t half_of(std::uint32_t function, std::uint8_t probe) {
    return (function >> (8U * probe)) & 0xFFU;
  }
  static std::uint8_t terminal(const Dictionary& dictionary, std::uint8_t probe) {
    return static_cast<std::uint8_t>(dictionary.value(kRow<kTouchProbeIndex, 1> + probe));
  }

  // Those that the board has captured since the last poll, whether a probe waits for them or not.
  void take_edges() {
    if (edges_ == nullptr) return;
    captured_ = IoMasks::bit(edges_->terminal());
    std::array<CapturedEdge, EdgeCapture::kKept> edges;
    const std::size_t count = edges_->take(edges);
    for (std::size_t n = 0; n < count; ++n) {
      const std::uint32_t active = this->active({.levels = edges[n].high ? captured_ : 0U}) & captured_;
      for (std::uint8_t i = 0; i < kProbes; ++i) {
        if ((masks_[i] & captured_) == 0) continue;
        probes_[i].see_edge(active != 0, [&] { return position(edges[n].counts); });
      }
    }
  }

  // One tick; `gap`: those before it were not seen.
  void see(const TickHistory::Reading& reading, bool gap) {
    const std::uint32_t active = this->active(reading);
    for (std::uint8_t i = 0; i < kProbes; ++i) {
      const bool on = (active & masks_[i]) != 0;
      if (gap || (masks_[i] & captured_) != 0) probes_[i].resume(on);
      probes_[i].see(on, [&] { return position(reading.counts); });
    }
  }
  std::uint32_t active(const TickHistory::Reading& reading) const {
    return DigitalInputs(reading.levels).active(context_.controller.parameters().io);
  }
  // As 6064h.
  std::int32_t position(std::int32_t counts) const { return context_.units.to_user(context_.place(counts)); }

  const ProfileContext& context_;
  EdgeCapture* edges_;
  std::uint32_t captured_ = 0;  // bit of the terminal whose edges are captured
  std::array<TouchProbe, kProbes> probes_{};
  std::array<std::uint32_t, kProbes> masks_{};
  std::uint32_t seen_ = 0;  // the last tick
  std::uint32_t index_seen_ = 0;
};

}  // namespace slipstack::canopen
