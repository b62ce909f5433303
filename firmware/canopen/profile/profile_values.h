// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/canopen/profile/profile_context.h"
#include "firmware/canopen/profile/profile_units.h"
#include "firmware/canopen/telemetry/telemetry.h"

namespace slipstack::canopen {

/// What an object of the drive profile shows of the axis, in the user's units; otherwise what is in `row`.
inline std::uint32_t profile_value(const ProfileContext& context, std::uint16_t index, std::size_t row) {
  const Controller& controller = context.controller;
  const ControlOutput& out = controller.output();
  const UserUnits& units = context.units;
  switch (index) {
    case 0x6061:
      return static_cast<std::uint32_t>(context.mode);
    case 0x6063:
      return static_cast<std::uint32_t>(context.place(controller.measured_counts()));
    case 0x6064:
      return context.position();
    case 0x606B:
      return rounded(units.velocity_in_user(context.demand_counts_per_s()), 2.1e9F);
    case 0x606C:
      return rounded(units.velocity_in_user(in_counts(context.axis(), out.velocity_mps)), 2.1e9F);
    case 0x6074:
      return rounded(in_thousandths(*context.dictionary, out.current_A), 32767.0F);
    case 0x6076:
      return rounded(rated_force_N(*context.dictionary, context.axis()) * 1e3F, 2.1e9F);
    case 0x6077:
      return rounded(in_thousandths(*context.dictionary, controller.measured_A()), 32767.0F);
    case 0x60F4:
      return rounded(units.distance_in_user(in_counts(context.axis(), out.position_error_m)), 2.1e9F);
    case 0x60FD:
      return controller.inputs().word(controller.parameters().io);
    default:
      return context.value(row);
  }
}

}  // namespace slipstack::canopen
