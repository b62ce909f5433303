// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/control/parameters/control_set.h"
#include "firmware/control/supervision/digital_io.h"
#include "firmware/control/supervision/fault_monitor.h"

namespace slipstack {

/// Where faults come from: the sensors, the amplifier's terminals, and code outside the tick. What follows
/// from a fault is the state machine's.
class FaultSources {
 public:
  // ---- outside the tick ----

  /// A fault found there; the next tick sees it. Of several before that tick, the first.
  void inject(Fault fault) {
    change([fault](std::uint32_t events) {
      return (events & kEvent) != 0 ? events : events | static_cast<std::uint32_t>(fault);
    });
  }
  /// A fault that every tick sees until another one, or kNone, is written.
  void hold(Fault fault) {
    const std::uint32_t held = static_cast<std::uint32_t>(fault) << kHeldShift;
    if ((events_.load(std::memory_order_relaxed) & kHeld) == held) return;
    change([held](std::uint32_t events) { return (events & ~kHeld) | held; });
  }
  /// Parameters were refused: a fault if the axis is enabled.
  void parameters_refused() { events_.fetch_or(kRefused, std::memory_order_release); }

  // ---- in the tick ----

  /// The first fault of this tick. `set_point_A` and `reference_counts` are those of the tick before, when
  /// the power stage was on if `driving`.
  Fault check(const ControlSet& set, const TickInputs& in, const DigitalInputs& digital,
              std::int32_t reference_counts, float set_point_A, bool driving) {
    Fault fault = Fault::kNone;
    if (set.valid) {
      fault = monitor_.check(set.monitor, in, reference_counts, set_point_A, driving);
    } else {
      monitor_.reset(in.encoder.counts);
    }
    if (!digital.amplifier_well(set.io)) [[unlikely]]
      fault = with_amplifier(set.io, digital, fault, driving);
    if (events_.load(std::memory_order_relaxed) != 0) fault = with_event(fault, driving);
    return fault;
  }
  void reset(std::int32_t counts) { monitor_.reset(counts); }

  /// The readings of the sensors in the last tick.
  const FaultMonitor& monitor() const { return monitor_; }

 private:
  static constexpr std::uint32_t kEvent = 0xFF;     // the number of a fault
  static constexpr std::uint32_t kRefused = 0x100;  // beside it
  static constexpr unsigned kHeldShift = 16;
  static constexpr std::uint32_t kHeld = 0xFF0000;  // the number of a fault that stays

  // The tick may come in between.
  template <class Change>
  void change(Change&& changed) {
    std::uint32_t events = events_.load(std::memory_order_relaxed);
    while (!events_.compare_exchange_weak(events, changed(events), std::memory_order_release,
                                          std::memory_order_relaxed)) {
    }
  }

  // What the amplifier reports explains what else is seen of it.
  static Fault with_amplifier(const IoMasks& io, const DigitalInputs& digital, Fault fault, bool driving) {
    if (digital.amplifier_fault(io)) return Fault::kAmplifierFault;
    return driving ? Fault::kAmplifierNotReady : fault;
  }

  Fault with_event(Fault fault, bool driving) {
    const std::uint32_t event = events_.fetch_and(kHeld, std::memory_order_acquire);
    const auto injected = static_cast<Fault>(event & kEvent);
    if (injected != Fault::kNone) return injected;
    if (fault != Fault::kNone) return fault;
    if (driving && (event & kRefused) != 0) return Fault::kParameter;
    return static_cast<Fault>(event >> kHeldShift);
  }

  FaultMonitor monitor_;
  std::atomic<std::uint32_t> events_{0};  // a fault, kRefused, a fault that stays
};

}  // namespace slipstack
