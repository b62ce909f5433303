// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/tick.h"

// A board that is a few words of memory, and an axis with everything on.
namespace slipstack::budget {

struct MemoryEncoder {
  EncoderReading next;
  bool index_passed = false;
  EncoderReading read() const { return next; }
  bool take_index(std::int32_t& counts) {
    counts = next.counts;
    return index_passed;
  }
};
struct MemoryMotor {
  float set_point_A = 0.0F;
  bool enabled = false;
  CurrentReading measurement;
  void set(float current_A) {
    set_point_A = current_A;
    enabled = true;
    measurement.current_A = current_A;
  }
  void disable() {
    set_point_A = 0.0F;
    enabled = false;
    measurement.current_A = 0.0F;
  }
  CurrentReading measured() const { return measurement; }
};
struct MemoryClock {
  std::uint32_t count = 0;
  std::uint32_t now() const { return count; }
  std::uint32_t ticks_per_second() const { return 1000000; }
};
struct MemoryWatchdog {
  std::uint32_t refreshed = 0;
  void refresh() { ++refreshed; }
  bool caused_last_reset() const { return false; }
};

/// Terminal 4 is high while the amplifier is ready, terminal 5 low while it has a fault.
inline constexpr std::uint32_t kAmplifierWell = 0x18;
struct MemoryDigitalIo {
  std::uint32_t inputs = kAmplifierWell;
  std::uint32_t outputs = 0;
  std::uint32_t read() const { return inputs; }
  void write(std::uint32_t levels) { outputs = levels; }
};

inline MemoryEncoder memory_encoder;
inline MemoryMotor memory_motor;
inline MemoryClock memory_clock;
inline MemoryWatchdog memory_watchdog;
inline MemoryDigitalIo memory_io;

inline AxisParameters everything_on() {
  AxisParameters axis;
  axis.adapt_level = true;
  axis.adapt_mass = true;
  axis.disturbance_share = 0.5F;
  axis.torque_friction_share = 0.5F;
  axis.notch[0] = {180.0F, 0.2F, 0.1F};
  axis.notch[1] = {410.0F, 0.1F, 0.2F};
  axis.following_error_m = 1.0e-2F;
  axis.velocity_limit_mps = 0.5F;
  axis.stall_s = 1.0F;
  axis.io = {1, 2, 3, 4, 5, 1, 0x0010, 0x0000};
  axis.reference = {.absolute_encoder = true, .index_distance = 1, .index_tolerance = 1};
  return axis;
}

}  // namespace slipstack::budget
