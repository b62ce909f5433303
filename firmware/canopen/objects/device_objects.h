// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "firmware/canopen/objects/object.h"
#include "firmware/control/supervision/faults.h"

// Objects of the manufacturer beside axis and friction model: what the observer finds, timing, counters,
// trace, access lock, node.
namespace slipstack::canopen {

inline constexpr std::uint16_t kObserverIndex = 0x2200;
inline constexpr std::uint8_t kMemorySub = 14;  ///< of 2200h: first of the memory stack
inline constexpr std::uint8_t kAddedMassSub = kMemorySub + 4;
inline constexpr std::uint16_t kTimingIndex = 0x2210;
inline constexpr std::uint16_t kCountersIndex = 0x2211;
inline constexpr std::uint16_t kFaultCountsIndex = 0x2212;
inline constexpr std::uint16_t kTraceIndex = 0x2300;
inline constexpr std::uint16_t kTraceDataIndex = 0x2310;
inline constexpr std::uint16_t kExcitationIndex = 0x2320;
inline constexpr std::uint16_t kLockIndex = 0x2400;
inline constexpr std::uint16_t kNodeIndex = 0x2402;
inline constexpr std::uint16_t kCommandTimeoutIndex = 0x2403;
inline constexpr std::uint16_t kDriftIndex = 0x2404;
inline constexpr std::uint16_t kBrakeIndex = 0x2408;

inline constexpr auto kObserverRows = std::to_array<Object>({
    head(kObserverIndex, ObjectCode::kRecord, "Observer", 18),
    reading(kObserverIndex, 1, Type::kReal32, "Feed-forward").in("N"),
    reading(kObserverIndex, 2, Type::kReal32, "Feedback").in("N"),
    reading(kObserverIndex, 3, Type::kReal32, "Residual").in("N"),
    reading(kObserverIndex, 4, Type::kReal32, "Level"),
    reading(kObserverIndex, 5, Type::kReal32, "Dry friction").in("N"),
    reading(kObserverIndex, 6, Type::kReal32, "Model force").in("N"),
    reading(kObserverIndex, 7, Type::kReal32, "Position error").in("m"),
    reading(kObserverIndex, 8, Type::kReal32, "Velocity").in("m/s"),
    reading(kObserverIndex, 9, Type::kI32, "Reference").in("count"),
    reading(kObserverIndex, 10, Type::kU16, "Limits"),
    reading(kObserverIndex, 11, Type::kI16, "Current about the reading over current limit")
        .in("", 1.0F / 32767.0F),
    reading(kObserverIndex, 12, Type::kReal32, "Current").in("A"),
    reading(kObserverIndex, 13, Type::kU32, "Model hash"),
    reading(kObserverIndex, kMemorySub, Type::kU8, "Depth of the memory stack"),
    reading(kObserverIndex, kMemorySub + 1, Type::kU32, "Loops given up by a full stack"),
    reading(kObserverIndex, kMemorySub + 2, Type::kReal32, "Highest loop given up").in("N"),
    reading(kObserverIndex, kMemorySub + 3, Type::kU32, "Ticks the memory stack missed"),
    reading(kObserverIndex, kAddedMassSub, Type::kReal32, "Mass added by the adaptation").in("kg"),
});

inline constexpr auto kTimingRows = std::to_array<Object>({
    head(kTimingIndex, ObjectCode::kRecord, "Tick", 5),
    reading(kTimingIndex, 1, Type::kU32, "Longest period").in("clock tick"),
    reading(kTimingIndex, 2, Type::kU32, "Longest duration").in("clock tick"),
    reading(kTimingIndex, 3, Type::kU32, "Overruns"),
    reading(kTimingIndex, 4, Type::kU32, "Ticks"),
    reading(kTimingIndex, 5, Type::kU16, "Ticks, low half"),
});

inline constexpr auto kCounterRows = std::to_array<Object>({
    head(kCountersIndex, ObjectCode::kRecord, "Counters", 11),
    reading(kCountersIndex, 1, Type::kU32, "Frames received"),
    reading(kCountersIndex, 2, Type::kU32, "Frames lost"),
    reading(kCountersIndex, 3, Type::kU32, "Frames malformed"),
    reading(kCountersIndex, 4, Type::kU32, "SDO aborts"),
    reading(kCountersIndex, 5, Type::kU32, "Frames not sent"),
    reading(kCountersIndex, 6, Type::kU32, "Bus-off"),
    reading(kCountersIndex, 7, Type::kU32, "PDO values refused"),
    reading(kCountersIndex, 8, Type::kU32, "Reference ran dry"),
    reading(kCountersIndex, 9, Type::kU32, "Sets stored"),
    reading(kCountersIndex, 10, Type::kU32, "Erasures of slot 1"),
    reading(kCountersIndex, 11, Type::kU32, "Erasures of slot 2"),
});

inline constexpr auto kFaultRows = [] {
  constexpr std::array<const char*, kFaultCount> kNames = {"",
                                                           "Encoder loss",
                                                           "Encoder jump",
                                                           "Stall",
                                                           "Following error",
                                                           "Over-current",
                                                           "Current sensor",
                                                           "Tick overrun",
                                                           "Watchdog",
                                                           "Parameter",
                                                           "Not finite",
                                                           "Stop time-out",
                                                           "Set-point refused",
                                                           "Amplifier fault",
                                                           "Amplifier not ready",
                                                           "Overspeed",
                                                           "Index off its place",
                                                           "Overload",
                                                           "Direction",
                                                           "Connection lost",
                                                           "Encoder stands",
                                                           "Over-temperature",
                                                           "Analogue sensor",
                                                           "Under-voltage",
                                                           "Over-voltage"};
  std::array<Object, kFaultCount> rows{};
  rows[0] = head(kFaultCountsIndex, ObjectCode::kRecord, "Faults since start", kFaultCount - 1);
  for (std::uint8_t i = 1; i < kFaultCount; ++i)
    rows[i] = reading(kFaultCountsIndex, i, Type::kU16, kNames[i]);
  return rows;
}();

/// 2300h. Command 1 arms; the trigger freezes the buffer after the samples that are to follow it.
inline constexpr auto kTraceRows = std::to_array<Object>({
    head(kTraceIndex, ObjectCode::kRecord, "Trace", 10),
    entry(kTraceIndex, 1, Type::kU8, "Command (0 stop, 1 arm)").within(0, 1).from_device(),
    reading(kTraceIndex, 2, Type::kU8, "State (0 idle, 1 armed, 2 triggered, 3 ready)"),
    entry(kTraceIndex, 3, Type::kU16, "Decimation").within(1, 10000).at_first(1U).in("tick"),
    entry(kTraceIndex, 4, Type::kU8, "Trigger (0 at once, 1 rising, 2 falling)").within(0, 2),
    entry(kTraceIndex, 5, Type::kU8, "Trigger channel (0 position, 1 reference, 2 current)").within(0, 2),
    entry(kTraceIndex, 6, Type::kReal32, "Trigger level (count or A)"),
    entry(kTraceIndex, 7, Type::kU16, "Samples before the trigger"),
    reading(kTraceIndex, 8, Type::kU32, "Samples"),
    reading(kTraceIndex, 9, Type::kU32, "Capacity"),
    entry(kTraceIndex, 10, Type::kU8, "Second channel (0 reference, 1 excitation)").within(0, 1),
    [] {
      Object object = entry(kTraceDataIndex, 0, Type::kDomain, "Trace data").read_only();
      object.object = object.name;
      return object;
    }(),
});

/// 2320h: what is injected into the loop to measure it (firmware/control/force/excitation.h).
inline constexpr auto kExcitationRows = std::to_array<Object>({
    head(kExcitationIndex, ObjectCode::kRecord, "Excitation", 12),
    entry(kExcitationIndex, 1, Type::kU8, "Command (0 stop, 1 start)").within(0, 1).from_device(),
    reading(kExcitationIndex, 2, Type::kU8,
            "State (0 idle, 1 running, 2 complete, 3 stopped, 4 ended by the axis, 5 too far)"),
    entry(kExcitationIndex, 3, Type::kU8, "Place (0 current, 1 position reference)").within(0, 1),
    entry(kExcitationIndex, 4, Type::kReal32, "Amplitude of the current").within(0.0F, 1.0e3F).in("A"),
    entry(kExcitationIndex, 5, Type::kReal32, "Amplitude of the position reference")
        .within(0.0F, 1.0F)
        .in("m"),
    entry(kExcitationIndex, 6, Type::kReal32, "Lowest frequency")
        .within(1.0e-3F, 2.0e4F)
        .at_first(20.0F)
        .in("Hz"),
    entry(kExcitationIndex, 7, Type::kReal32, "Highest frequency")
        .within(1.0e-3F, 2.0e4F)
        .at_first(1000.0F)
        .in("Hz"),
    entry(kExcitationIndex, 8, Type::kU32, "Period").within(64, 1000000).at_first(1024U).in("tick"),
    entry(kExcitationIndex, 9, Type::kU16, "Periods").within(1, 10000).at_first(16U),
    entry(kExcitationIndex, 10, Type::kReal32, "Largest deviation")
        .within(1.0e-7F, 1.0F)
        .at_first(1.0e-3F)
        .in("m"),
    reading(kExcitationIndex, 11, Type::kU32, "Periods so far"),
    reading(kExcitationIndex, 12, Type::kU16, "Limits met"),
});

/// 2400h: challenge and response (docs/can.md). The key can be written, never read.
inline constexpr auto kLockRows = [] {
  std::array<Object, 13> rows{};
  rows[0] = head(kLockIndex, ObjectCode::kRecord, "Access lock", 10);
  rows[1] = reading(kLockIndex, 1, Type::kU8, "State (0 off, 1 locked, 2 open)");
  rows[1].mapping = Mapping::kNone;
  rows[2] = entry(kLockIndex, 2, Type::kU32, "Challenge, low half").read_only().from_device();
  rows[3] = entry(kLockIndex, 3, Type::kU32, "Challenge, high half").read_only().from_device();
  rows[4] = entry(kLockIndex, 4, Type::kU32, "Response, low half").write_only();
  rows[5] = entry(kLockIndex, 5, Type::kU32, "Response, high half").write_only().from_device();
  for (std::uint8_t sub = 6; sub <= 9; ++sub) {
    rows[sub] = entry(kLockIndex, sub, Type::kU32, "Key word").write_only().stored(Storage::kSetting);
    rows[sub].number = sub - 5;
  }
  rows[10] = entry(kLockIndex, 10, Type::kBoolean, "Lock in use").from_device().stored(Storage::kSetting);
  rows[11] = head(kNodeIndex, ObjectCode::kRecord, "Node", 2);
  rows[12] = entry(kNodeIndex, 1, Type::kU8, "Node-ID").read_only().stored(Storage::kSetting).at_first(0xFFU);
  return rows;
}();
/// Default of the command time-out: twelve cycles of 4 ms, a cycle that open-source masters on a desktop
/// keep, and beyond the 14 ms by which such a desktop was seen to be late; 0.5 m/s coast 25 mm in it.
inline constexpr std::uint32_t kCommandTimeout_ms = 50;

inline constexpr std::uint32_t kNotKnown = 0xFFFFFFFF;

inline constexpr auto kNodeRows = std::to_array<Object>({
    entry(kNodeIndex, 2, Type::kU8, "Bit rate (CiA 305 index)")
        .read_only()
        .stored(Storage::kSetting)
        .at_first(3U),
    variable(kCommandTimeoutIndex, Type::kU16, "Command time-out in cyclic modes (0 off)")
        .at_first(kCommandTimeout_ms)
        .in("s", 1e-3F)
        .stored(Storage::kParameter),
    head(kDriftIndex, ObjectCode::kRecord, "Drift of the friction", 2),
    entry(kDriftIndex, 1, Type::kU32, "Time the axis had been running at the start (FFFFFFFFh: not known)")
        .at_first(kNotKnown)
        .in("s")
        .stored(Storage::kParameter),
    reading(kDriftIndex, 2, Type::kReal32, "Time that the drift goes by").in("s"),
    head(kBrakeIndex, ObjectCode::kRecord, "Brake", 2),
    entry(kBrakeIndex, 1, Type::kU16, "Time until it is open").in("s", 1e-3F).stored(Storage::kParameter),
    entry(kBrakeIndex, 2, Type::kU16, "Time until it is closed").in("s", 1e-3F).stored(Storage::kParameter),
});

}  // namespace slipstack::canopen
