// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>
#include <utility>

#include "firmware/canopen/objects/object.h"
#include "firmware/control/parameters/parameters.h"

// Objects of the manufacturer: the axis, one record for each effect of the catalogue, the model as a whole.
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

inline constexpr std::uint8_t kObserverSub = kAdaptLevelSub + 1;  ///< and two that follow
inline constexpr std::uint8_t kTorqueShareSub = kObserverSub + 2;
inline constexpr std::uint8_t kLastAxisSub = kTorqueShareSub + 1;

inline constexpr std::uint16_t kAxisIndex = 0x2000;
inline constexpr std::uint16_t kIoIndex = 0x2010;
inline constexpr std::uint16_t kHomingIndex = 0x2011;
inline constexpr std::uint16_t kReferenceIndex = 0x2012;
inline constexpr std::uint16_t kTouchProbeIndex = 0x2013;
inline constexpr std::uint16_t kEffectIndex = 0x2100;  ///< + place in the catalogue
inline constexpr std::uint16_t kModelIndex = 0x2140;
inline constexpr std::uint16_t kModelImageIndex = 0x2141;
inline constexpr std::uint16_t kByEffectIndex = 0x2201;
inline constexpr std::uint16_t kHuntingIndex = 0x2202;

inline constexpr auto kAxisRows = [] {
  std::array<Object, std::size_t{kLastAxisSub} + 1> rows{};
  const auto bounded = [](Object row, float AxisParameters::*member) {
    for (const slipstack::detail::Bound& bound : slipstack::detail::kAxisBounds) {
      if (bound.member == member) row = row.within(bound.lower, bound.upper);
    }
    return row.at_first(AxisParameters{}.*member).stored(Storage::kParameter);
  };
  rows[0] = head(kAxisIndex, ObjectCode::kRecord, "Axis parameters", kLastAxisSub);
  std::uint8_t sub = 1;
  for (const AxisObject& own : kAxisObjects) {
    rows[sub] = bounded(entry(kAxisIndex, sub, Type::kReal32, own.name).in(own.unit), own.member);
    ++sub;
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
  rows[sub + 2] = entry(kAxisIndex, kObserverSub, Type::kBoolean, "Observe friction at rest")
                      .at_first(1U)
                      .stored(Storage::kParameter);
  rows[sub + 3] = bounded(
      entry(kAxisIndex, kObserverSub + 1, Type::kReal32, "Dead band of the friction observer").in("count"),
      &AxisParameters::friction_band_counts);
  rows[sub + 4] =
      bounded(entry(kAxisIndex, kTorqueShareSub, Type::kReal32, "Share of the friction in torque mode"),
              &AxisParameters::torque_friction_share);
  rows[sub + 5] = entry(kAxisIndex, kLastAxisSub, Type::kBoolean, "Adapt mass").stored(Storage::kParameter);
  return rows;
}();

/// Which terminal does what; staged and applied with 2000h.
inline constexpr auto kIoRows = [] {
  constexpr std::uint8_t kMost = 8;
  const auto terminal = [](std::uint8_t sub, const char* name) {
    return entry(kIoIndex, sub, Type::kU8, name).within(0, int{kTerminals}).stored(Storage::kParameter);
  };
  const auto inverted = [](std::uint8_t sub, const char* name) {
    return entry(kIoIndex, sub, Type::kU16, name).stored(Storage::kParameter);
  };
  return std::to_array<Object>({
      head(kIoIndex, ObjectCode::kRecord, "Terminals of digital inputs and outputs", kMost),
      terminal(1, "Input of the negative limit switch (0 none)"),
      terminal(2, "Input of the positive limit switch (0 none)"),
      terminal(3, "Input of the home switch (0 none)"),
      terminal(4, "Input amplifier ready (0 none)"),
      terminal(5, "Input amplifier fault (0 none)"),
      terminal(6, "Output that releases the brake (0 none)"),
      inverted(7, "Inputs active while low (bit 0: terminal 1)"),
      inverted(kMost, "Outputs active while low (bit 0: terminal 1)"),
  });
}();

/// What homing needs beside the objects of the drive profile. An axis of 2 m at 50 mm/s there and back takes
/// 80 s.
inline constexpr auto kHomingRows = std::to_array<Object>({
    head(kHomingIndex, ObjectCode::kRecord, "Homing", 3),
    entry(kHomingIndex, 1, Type::kReal32, "Homing time-out")
        .within(0.1F, 3600.0F)
        .at_first(120.0F)
        .in("s")
        .stored(Storage::kSetting),
    entry(kHomingIndex, 2, Type::kReal32, "Current against an end stop")
        .within(0.0F, 1.0e3F)
        .at_first(2.0F)
        .in("A")
        .stored(Storage::kSetting),
    entry(kHomingIndex, 3, Type::kReal32, "Time against an end stop")
        .within(1.0e-3F, 10.0F)
        .at_first(0.01F)
        .in("s")
        .stored(Storage::kSetting),
});

/// What the encoder is; staged and applied with 2000h.
inline constexpr auto kReferenceRows = std::to_array<Object>({
    head(kReferenceIndex, ObjectCode::kRecord, "Position reference", 8),
    entry(kReferenceIndex, 1, Type::kBoolean, "Absolute encoder").stored(Storage::kParameter),
    entry(kReferenceIndex, 2, Type::kI32, "Counts of an absolute encoder at position zero")
        .in("count")
        .stored(Storage::kParameter),
    entry(kReferenceIndex, 3, Type::kU32, "Distance of index marks (0: there is one)")
        .in("count")
        .stored(Storage::kParameter),
    entry(kReferenceIndex, 4, Type::kU32, "Tolerance of index marks (0: not checked)")
        .within(0, 1000000)
        .in("count")
        .stored(Storage::kParameter),
    reading(kReferenceIndex, 5, Type::kBoolean, "Referenced"),
    entry(kReferenceIndex, 6, Type::kU8, "Ticks of an absolute encoder that are bridged")
        .within(0, 16)
        .at_first(3U)
        .in("tick")
        .stored(Storage::kParameter),
    entry(kReferenceIndex, 7, Type::kU32, "Distance of the even marks of a coded scale (0: not coded)")
        .within(0, 0x10000000)
        .in("count")
        .stored(Storage::kParameter),
    entry(kReferenceIndex, 8, Type::kI32, "Step of a coded scale (negative: against the encoder)")
        .within(-0x4000000, 0x4000000)
        .in("count")
        .stored(Storage::kParameter),
});

inline constexpr auto kTouchProbeRows = std::to_array<Object>({
    head(kTouchProbeIndex, ObjectCode::kArray, "Touch probe terminals (0: none)", 2),
    entry(kTouchProbeIndex, 1, Type::kU8, "Terminal of touch probe 1")
        .within(0, kTerminals)
        .stored(Storage::kParameter),
    entry(kTouchProbeIndex, 2, Type::kU8, "Terminal of touch probe 2")
        .within(0, kTerminals)
        .stored(Storage::kParameter),
});

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

/// Hunting (firmware/control/hunting/hunting_watch.h).
inline constexpr auto kHuntingRows = std::to_array<Object>({
    head(kHuntingIndex, ObjectCode::kRecord, "Hunting", 9),
    entry(kHuntingIndex, 1, Type::kReal32, "Smallest swing of hunting (0: not watched)")
        .within(0.0F, 1.0F)
        .at_first(AxisParameters{}.hunting_swing_m)
        .in("m")
        .stored(Storage::kParameter),
    reading(kHuntingIndex, 2, Type::kU8, "State (0 watching, 1 trying, 2 lowered, 3 goes on)"),
    reading(kHuntingIndex, 3, Type::kU8,
            "Cause (0 none, 1 friction, 2 disturbance observer, 3 elsewhere, 4 ended)"),
    reading(kHuntingIndex, 4, Type::kReal32, "Frequency found last").in("Hz"),
    reading(kHuntingIndex, 5, Type::kReal32, "Swing found last").in("m"),
    reading(kHuntingIndex, 6, Type::kReal32, "Share of the friction compensation in force"),
    reading(kHuntingIndex, 7, Type::kReal32, "Share of the disturbance observer in force"),
    reading(kHuntingIndex, 8, Type::kU16, "Found since the start"),
    entry(kHuntingIndex, 9, Type::kU8, "Command (1: full compensation again)").within(0, 1).from_device(),
});

/// Words of the model image 2141h: every effect's "enabled", gains and shapes.
inline constexpr std::size_t kModelWords = kEffectRows.size() - kEffectCount;

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

}  // namespace slipstack::canopen
