// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>
#include <utility>

#include "firmware/canopen/object.h"
#include "firmware/control/faults.h"
#include "firmware/control/parameters.h"

// Objects of the manufacturer, 2000h to 5FFFh: the axis, one record for each effect of the catalogue, what
// the observer says, trace, access lock.
namespace slipstack::canopen {

/// A parameter of the axis as sub-index of 2000h.
struct AxisObject {
  float AxisParameters::*member;
  const char* name;
  const char* unit;
};

inline constexpr auto kAxisObjects = std::to_array<AxisObject>({
    {&AxisParameters::encoder_resolution_m, "Encoder resolution", "m"},
    {&AxisParameters::tick_s, "Tick period", "s"},
    {&AxisParameters::motor_constant_N_per_A, "Motor constant", "N/A"},
    {&AxisParameters::observer_bandwidth_rad_per_s, "Observer bandwidth", "rad/s"},
    {&AxisParameters::position_gain_per_s, "Position gain", "1/s"},
    {&AxisParameters::velocity_gain_N_s_per_m, "Velocity gain", "N s/m"},
    {&AxisParameters::integral_per_s, "Integral", "1/s"},
    {&AxisParameters::disturbance_share, "Disturbance share", ""},
    {&AxisParameters::current_limit_A, "Current limit", "A"},
    {&AxisParameters::current_rate_A_per_s, "Current rate", "A/s"},
    {&AxisParameters::velocity_limit_mps, "Velocity limit", "m/s"},
    {&AxisParameters::acceleration_limit_mps2, "Acceleration limit", "m/s2"},
    {&AxisParameters::jerk_limit_mps3, "Jerk limit", "m/s3"},
    {&AxisParameters::quick_stop_mps2, "Quick stop deceleration", "m/s2"},
    {&AxisParameters::following_error_m, "Following error", "m"},
    {&AxisParameters::over_current_A, "Over-current", "A"},
    {&AxisParameters::current_mismatch_A, "Current mismatch", "A"},
    {&AxisParameters::current_mismatch_s, "Current mismatch time", "s"},
    {&AxisParameters::stall_current_A, "Stall current", "A"},
    {&AxisParameters::stall_s, "Stall time", "s"},
    {&AxisParameters::stop_timeout_s, "Stop time-out", "s"},
    {&AxisParameters::swap_time_s, "Swap time", "s"},
    {&AxisParameters::level_lowest, "Lowest level", ""},
    {&AxisParameters::level_highest, "Highest level", ""},
    {&AxisParameters::level_memory_s, "Level memory", "s"},
    {&AxisParameters::adaptation_speed_mps, "Adaptation speed", "m/s"},
});
inline constexpr std::uint8_t kAxisFloats = kAxisObjects.size();
inline constexpr std::uint8_t kNotchFirst = kAxisFloats + 1;
inline constexpr std::uint8_t kCompensateSub = kNotchFirst + 6;
inline constexpr std::uint8_t kAdaptLevelSub = kCompensateSub + 1;

inline constexpr std::uint16_t kAxisIndex = 0x2000;
inline constexpr std::uint16_t kEffectIndex = 0x2100;  ///< + place in the catalogue
inline constexpr std::uint16_t kModelIndex = 0x2140;
inline constexpr std::uint16_t kModelImageIndex = 0x2141;
inline constexpr std::uint16_t kObserverIndex = 0x2200;
inline constexpr std::uint8_t kMemorySub = 14;  ///< of 2200h: first of the memory stack
inline constexpr std::uint16_t kByEffectIndex = 0x2201;
inline constexpr std::uint16_t kTimingIndex = 0x2210;
inline constexpr std::uint16_t kCountersIndex = 0x2211;
inline constexpr std::uint16_t kFaultCountsIndex = 0x2212;
inline constexpr std::uint16_t kTraceIndex = 0x2300;
inline constexpr std::uint16_t kTraceDataIndex = 0x2310;
inline constexpr std::uint16_t kLockIndex = 0x2400;
inline constexpr std::uint16_t kNodeIndex = 0x2402;

inline constexpr auto kAxisRows = [] {
  std::array<Object, std::size_t{kAdaptLevelSub} + 1> rows{};
  const AxisParameters defaults;
  rows[0] = head(kAxisIndex, ObjectCode::kRecord, "Axis parameters", kAdaptLevelSub);
  std::uint8_t sub = 1;
  for (const AxisObject& own : kAxisObjects) {
    Object row = entry(kAxisIndex, sub, Type::kReal32, own.name).at_first(defaults.*own.member).in(own.unit);
    for (const slipstack::detail::Bound& bound : slipstack::detail::kAxisBounds) {
      if (bound.member == own.member) row = row.within(bound.lower, bound.upper);
    }
    rows[sub++] = row.stored(Storage::kParameter);
  }
  for (int notch = 1; notch <= 2; ++notch) {
    rows[sub] = entry(kAxisIndex, sub, Type::kReal32, "Notch frequency").within(0.0F, 22500.0F).in("Hz");
    rows[sub + 1] = entry(kAxisIndex, static_cast<std::uint8_t>(sub + 1), Type::kReal32, "Notch damping")
                        .within(1e-3F, 10.0F)
                        .at_first(0.1F);
    rows[sub + 2] = entry(kAxisIndex, static_cast<std::uint8_t>(sub + 2), Type::kReal32, "Notch depth")
                        .within(0.0F, 1.0F)
                        .at_first(0.1F);
    for (int i = 0; i < 3; ++i) {
      rows[sub].number = notch;
      rows[sub++].storage = Storage::kParameter;
    }
  }
  rows[sub] = entry(kAxisIndex, kCompensateSub, Type::kBoolean, "Compensate friction")
                  .at_first(1U)
                  .stored(Storage::kParameter);
  rows[sub + 1] =
      entry(kAxisIndex, kAdaptLevelSub, Type::kBoolean, "Adapt level").stored(Storage::kParameter);
  return rows;
}();

template <class E>
inline constexpr std::size_t kRowsOfEffect = 2U + E::gain_count + E::shape_count;

namespace detail {

template <class... Effects>
constexpr std::size_t effect_row_count(const std::tuple<Effects...>*) {
  return (kRowsOfEffect<Effects> + ...);
}

template <class E, std::size_t N>
constexpr void describe_effect(std::array<Object, N>& rows, std::size_t& at, std::uint16_t index) {
  rows[at++] =
      head(index, ObjectCode::kRecord, E::text.title, static_cast<std::uint8_t>(kRowsOfEffect<E> - 1));
  rows[at++] = entry(index, 1, Type::kBoolean, "Enabled").stored(Storage::kParameter);
  std::uint8_t sub = 2;
  for (const GainGroup& group : E::gains) {
    for (int i = 0; i < group.count; ++i) {
      rows[at] = entry(index, sub++, Type::kReal32, group.name)
                     .within(group.lower, group.upper)
                     .in(group.unit)
                     .stored(Storage::kParameter);
      rows[at++].number = group.count > 1 ? i + 1 : 0;
    }
  }
  if constexpr (E::shape_count > 0) {
    for (int i = 0; i < E::shape_count; ++i) {
      const ShapeSpec& shape = E::shapes[static_cast<std::size_t>(i)];
      rows[at] = entry(index, sub++, Type::kReal32, shape.name)
                     .within(shape.lower, shape.upper)
                     .at_first(shape.lower)
                     .in(shape.unit)
                     .stored(Storage::kParameter);
      bool repeated = false;
      for (const ShapeSpec& other : E::shapes) {
        repeated |= &other != &shape && std::string_view(other.name) == shape.name;
      }
      rows[at++].number = repeated ? i + 1 : 0;
    }
  }
}

template <std::size_t N, class... Effects>
constexpr std::array<Object, N> effect_rows(const std::tuple<Effects...>*) {
  std::array<Object, N> rows{};
  std::size_t at = 0;
  std::uint16_t index = kEffectIndex;
  (describe_effect<Effects>(rows, at, index++), ...);
  return rows;
}

inline constexpr const Catalogue<float>* kCatalogue = nullptr;

template <std::size_t N, class... Effects>
constexpr std::array<Object, N> by_effect_rows(const std::tuple<Effects...>*) {
  std::array<Object, N> rows{};
  rows[0] = head(kByEffectIndex, ObjectCode::kRecord, "Force by effect", static_cast<std::uint8_t>(N - 1));
  std::uint8_t sub = 1;
  ((rows[sub] = entry(kByEffectIndex, sub, Type::kReal32, Effects::text.title)
                    .read_only()
                    .from_device()
                    .mapped(Mapping::kTransmit)
                    .in("N"),
    ++sub),
   ...);
  return rows;
}

}  // namespace detail

inline constexpr std::size_t kEffectCount = FrictionModel<float>::effect_count;
inline constexpr auto kEffectRows =
    detail::effect_rows<detail::effect_row_count(detail::kCatalogue)>(detail::kCatalogue);
inline constexpr auto kByEffectRows = detail::by_effect_rows<kEffectCount + 1>(detail::kCatalogue);

/// Words of the model image 2141h: every effect's "enabled", gains and shapes.
inline constexpr std::size_t kModelWords = kEffectRows.size() - kEffectCount;

constexpr Object reading(std::uint16_t index, std::uint8_t sub, Type type, const char* name) {
  return entry(index, sub, type, name).read_only().from_device().mapped(Mapping::kTransmit);
}

inline constexpr auto kModelRows = std::to_array<Object>({
    head(kModelIndex, ObjectCode::kRecord, "Model", 6),
    reading(kModelIndex, 1, Type::kU32, "Hash of the staged model"),
    reading(kModelIndex, 2, Type::kU32, "Hash of the active model"),
    entry(kModelIndex, 3, Type::kU32, "Apply: write the staged hash").write_only().from_device(),
    reading(kModelIndex, 4, Type::kU8, "Result of the last apply"),
    reading(kModelIndex, 5, Type::kBoolean, "Change pending"),
    reading(kModelIndex, 6, Type::kU32, "Changes refused"),
    [] {
      Object object = entry(kModelImageIndex, 0, Type::kDomain, "Model image");
      object.object = object.name;
      object.storage = Storage::kVolatile;
      return object;
    }(),
});

inline constexpr auto kObserverRows = std::to_array<Object>({
    head(kObserverIndex, ObjectCode::kRecord, "Observer", 17),
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
                                                           "Set-point refused"};
  std::array<Object, kFaultCount> rows{};
  rows[0] = head(kFaultCountsIndex, ObjectCode::kRecord, "Faults since start", kFaultCount - 1);
  for (std::uint8_t i = 1; i < kFaultCount; ++i)
    rows[i] = reading(kFaultCountsIndex, i, Type::kU16, kNames[i]);
  return rows;
}();

/// 2300h. Command 1 arms; the trigger freezes the buffer after the samples that are to follow it.
inline constexpr auto kTraceRows = std::to_array<Object>({
    head(kTraceIndex, ObjectCode::kRecord, "Trace", 9),
    entry(kTraceIndex, 1, Type::kU8, "Command (0 stop, 1 arm)").within(0, 1).from_device(),
    reading(kTraceIndex, 2, Type::kU8, "State (0 idle, 1 armed, 2 triggered, 3 ready)"),
    entry(kTraceIndex, 3, Type::kU16, "Decimation").within(1, 10000).at_first(1U).in("tick"),
    entry(kTraceIndex, 4, Type::kU8, "Trigger (0 at once, 1 rising, 2 falling)").within(0, 2),
    entry(kTraceIndex, 5, Type::kU8, "Trigger channel (0 position, 1 reference, 2 current)").within(0, 2),
    entry(kTraceIndex, 6, Type::kReal32, "Trigger level (count or A)"),
    entry(kTraceIndex, 7, Type::kU16, "Samples before the trigger"),
    reading(kTraceIndex, 8, Type::kU32, "Samples"),
    reading(kTraceIndex, 9, Type::kU32, "Capacity"),
    [] {
      Object object = entry(kTraceDataIndex, 0, Type::kDomain, "Trace data").read_only();
      object.object = object.name;
      return object;
    }(),
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
inline constexpr auto kNodeRows = std::to_array<Object>({
    entry(kNodeIndex, 2, Type::kU8, "Bit rate (CiA 305 index)")
        .read_only()
        .stored(Storage::kSetting)
        .at_first(3U),
});

}  // namespace slipstack::canopen
