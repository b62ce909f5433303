// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/canopen/objects/dictionary.h"
#include "firmware/control/parameters/parameters.h"

// Units of the drive profile: position in encoder counts, force in thousandths of the rated force 6076h,
// which is the rated current 6075h times the motor constant.
namespace slipstack::canopen {

inline float rated_force_N(const Dictionary& dictionary, const AxisParameters& axis) {
  return static_cast<float>(dictionary.value(kRow<0x6075>)) * 1e-3F * axis.motor_constant_N_per_A;
}

/// A current as thousandths of the rated current, and so of the rated force.
inline float in_thousandths(const Dictionary& dictionary, float current_A) {
  return current_A / (static_cast<float>(dictionary.value(kRow<0x6075>)) * 1e-6F);
}

inline float in_counts(const AxisParameters& axis, float metres) {
  return metres / axis.encoder_resolution_m;
}

}  // namespace slipstack::canopen
