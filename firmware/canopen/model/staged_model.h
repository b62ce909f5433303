// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

#include "firmware/canopen/model/machine_scales.h"
#include "firmware/canopen/objects/dictionary.h"
#include "firmware/control/parameters/parameters.h"

// Axis and friction model as they stand in the dictionary: staged, until they are applied.
namespace slipstack::canopen {

/// The terminals of 2010h.
inline IoParameters staged_io(const Dictionary& dictionary) {
  const auto terminal = [&](std::size_t sub) {
    return static_cast<std::uint8_t>(dictionary.value(kRow<kIoIndex> + sub));
  };
  const auto inverted = [&](std::size_t sub) {
    return static_cast<std::uint16_t>(dictionary.value(kRow<kIoIndex> + sub));
  };
  return {terminal(1), terminal(2), terminal(3), terminal(4),
          terminal(5), terminal(6), inverted(7), inverted(8)};
}

/// The encoder of 2012h.
inline PositionReferenceParameters staged_reference(const Dictionary& dictionary) {
  constexpr std::size_t kHead = kRow<kReferenceIndex>;
  return {dictionary.value(kHead + 1) != 0,
          static_cast<std::int32_t>(dictionary.value(kHead + 2)),
          dictionary.value(kHead + 3),
          dictionary.value(kHead + 4),
          dictionary.value(kHead + 6),
          dictionary.value(kHead + 7),
          static_cast<std::int32_t>(dictionary.value(kHead + 8))};
}

/// The axis of 2000h, 2010h, 2012h, 2404h, 2501h to 2504h and 6075h.
inline AxisParameters staged_axis(const Dictionary& dictionary) {
  constexpr std::size_t kFirst = kRow<kAxisIndex>;
  AxisParameters axis;
  for (std::size_t i = 0; i < kAxisObjects.size(); ++i) {
    axis.*kAxisObjects[i].member = dictionary.real(kFirst + 1 + i);
  }
  for (std::size_t i = 0; i < axis.notch.size(); ++i) {
    const std::size_t row = kFirst + kNotchFirst + 3 * i;
    axis.notch[i] = {dictionary.real(row), dictionary.real(row + 1), dictionary.real(row + 2)};
  }
  axis.compensate = dictionary.value(kFirst + kCompensateSub) != 0;
  axis.adapt_level = dictionary.value(kFirst + kAdaptLevelSub) != 0;
  axis.observe_friction = dictionary.value(kFirst + kObserverSub) != 0;
  axis.friction_band_counts = dictionary.real(kFirst + kObserverSub + 1);
  axis.torque_friction_share = dictionary.real(kFirst + kTorqueShareSub);
  axis.hunting_swing_m = dictionary.real(kRow<kHuntingIndex, 1>);
  axis.adapt_mass = dictionary.value(kFirst + kLastAxisSub) != 0;
  axis.io = staged_io(dictionary);
  axis.reference = staged_reference(dictionary);
  axis.motor_rated_A = static_cast<float>(dictionary.value(kRow<0x6075>)) * 1e-3F;
  axis.motor_thermal_s = dictionary.real(kRow<kThermalIndex, 1>);
  axis.amplifier_rated_A = dictionary.real(kRow<kThermalIndex, 2>);
  axis.amplifier_thermal_s = dictionary.real(kRow<kThermalIndex, 3>);
  axis.overload_is_fault = dictionary.value(kRow<kThermalIndex, 4>) != 0;
  const std::uint32_t run_before_s = dictionary.value(kRow<kDriftIndex, 1>);
  axis.run_before_s = run_before_s == kNotKnown ? -1.0F : static_cast<float>(run_before_s);
  // Passed is passed until a scale changes.
  axis.check_direction = dictionary.value(kRow<kDirectionIndex, 1>) != 0 &&
                         dictionary.value(kRow<kDirectionIndex, 5>) != scales_hash(dictionary);
  axis.check_distance_m = dictionary.real(kRow<kDirectionIndex, 2>);
  axis.check_current_A = dictionary.real(kRow<kDirectionIndex, 3>);
  axis.check_rate_A_per_s = dictionary.real(kRow<kDirectionIndex, 4>);
  axis.temperature_C_per_V = dictionary.real(kRow<kAnalogueIndex, 1>);
  axis.temperature_at_zero_C = dictionary.real(kRow<kAnalogueIndex, 2>);
  axis.temperature_warning_C = dictionary.real(kRow<kAnalogueIndex, 3>);
  axis.temperature_fault_C = dictionary.real(kRow<kAnalogueIndex, 4>);
  axis.bus_V_per_V = dictionary.real(kRow<kAnalogueIndex, 6>);
  axis.bus_lowest_V = dictionary.real(kRow<kAnalogueIndex, 7>);
  axis.bus_highest_V = dictionary.real(kRow<kAnalogueIndex, 8>);
  axis.unseen_motion_m = dictionary.real(kRow<kEncoderIndex, 9>);
  return axis;
}

namespace detail {

/// Visits the rows and the parameters of the model together: first "enabled", then each gain and shape.
template <class Model, class Enabled, class Real>
void visit_model(Model& model, Enabled&& enabled, Real&& real) {
  std::size_t row = kRow<kEffectIndex>;
  std::apply(
      [&](auto&... own) {
        const auto visit = [&](auto& one) {
          ++row;  // the head
          enabled(row++, one.enabled);
          for (auto& gain : one.gains) real(row++, gain);
          for (auto& shape : one.shapes) real(row++, shape);
        };
        (visit(own), ...);
      },
      model);
}

}  // namespace detail

/// The model of 2100h and up.
inline ModelParameters staged_model(const Dictionary& dictionary) {
  ModelParameters model{};
  detail::visit_model(
      model, [&](std::size_t row, bool& enabled) { enabled = dictionary.value(row) != 0; },
      [&](std::size_t row, float& value) { value = dictionary.real(row); });
  return model;
}

/// Calls `take(row, word)` for every word of a model, in the order of the image 2141h. What belongs to an
/// effect that is off is the table's default: it has no meaning, and lies within its bounds.
template <class Take>
void model_words(const ModelParameters& model, Take&& take) {
  bool on = false;
  detail::visit_model(
      model,
      [&](std::size_t row, const bool& enabled) {
        on = enabled;
        take(row, enabled ? 1U : 0U);
      },
      [&](std::size_t row, const float& value) {
        take(row, on ? std::bit_cast<std::uint32_t>(value) : kObjects[row].initial);
      });
}

/// The row of each word of the image.
inline constexpr auto kModelImageRows = [] {
  std::array<std::size_t, kModelWords> rows{};
  std::size_t at = 0;
  for (std::size_t row = kRow<kEffectIndex>; kObjects[row].index < kModelIndex; ++row) {
    if (kObjects[row].sub != 0) rows[at++] = row;
  }
  return rows;
}();

}  // namespace slipstack::canopen
