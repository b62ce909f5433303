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

  /// A fault found there; the next tick sees it.
  void inject(Fault fault) { events_.store(static_cast<std::uint32_t>(fault), std::memory_order_release); }
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
  static constexpr std::uint32_t kRefused = 0x100;  // beside the number of a fault

  // What the amplifier reports explains what else is seen of it.
  static Fault with_amplifier(const IoMasks& io, const DigitalInputs& digital, Fault fault, bool driving) {
    if (digital.amplifier_fault(io)) return Fault::kAmplifierFault;
    return driving ? Fault::kAmplifierNotReady : fault;
  }

  Fault with_event(Fault fault, bool driving) {
    const std::uint32_t event = events_.exchange(0, std::memory_order_acquire);
    const auto injected = static_cast<Fault>(event & 0xFFU);
    if (injected != Fault::kNone) return injected;
    return driving && fault == Fault::kNone ? Fault::kParameter : fault;
  }

  FaultMonitor monitor_;
  std::atomic<std::uint32_t> events_{0};  // a fault, and kRefused
};

}  // namespace slipstack
