// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

#include "firmware/canopen/objects/object_table.h"
#include "firmware/control/controller.h"
#include "firmware/control/tick.h"

namespace slipstack::canopen {

/// A number as a rounded integer within [-largest, largest].
inline std::uint32_t rounded(float number, float largest) {
  const float limited = approx::clamp(number, -largest, largest);
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(limited + (limited < 0.0F ? -0.5F : 0.5F)));
}

/// What the controller publishes in objects: forces, memory of the hysteresis, timing, counters.
///
/// Values of several words that belong to one tick are read as a snapshot: taken again when a tick came in
/// between.
class Telemetry {
 public:
  Telemetry(const Controller& controller, const TickTiming& timing)
      : controller_(controller), timing_(timing) {}

  /// 2200h. `mean_command_A`: current about the instant at which the last counts were read.
  std::uint32_t read_observer(std::uint8_t sub, float mean_command_A) const {
    if (sub >= kMemorySub) return read_memory(sub);
    std::uint32_t result = 0;
    // A tick is far longer than a reading.
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t before = controller_.ticks();
      result = observer_value(sub, mean_command_A);
      if (controller_.ticks() == before) break;
    }
    return result;
  }
  std::uint32_t read_by_effect(std::uint8_t sub) const {
    return word(controller_.friction().by_effect_N[sub - 1U]);
  }
  /// 2202h; `stored` is what its parameter holds.
  std::uint32_t read_hunting(std::uint8_t sub, std::uint32_t stored) const {
    const HuntingWatch& hunting = controller_.hunting();
    switch (sub) {
      case 2:
        return static_cast<std::uint32_t>(hunting.state());
      case 3:
        return static_cast<std::uint32_t>(hunting.cause());
      case 4:
        return word(hunting_Hz());
      case 5:
        return word(hunting.oscillation().swing_counts * controller_.parameters().axis.encoder_resolution_m);
      case 6:
        return word(hunting.friction_share());
      case 7:
        return word(hunting.disturbance_share());
      case 8:
        return hunting.found();
      default:
        return sub == 1 ? stored : 0U;
    }
  }
  /// What the emergency message tells of hunting that is worth a warning: the cause, and behind it the
  /// frequency in whole Hz; 0 without one.
  std::uint32_t hunting_warning() const {
    const auto cause = static_cast<std::uint32_t>(controller_.hunting().warning());
    return cause == 0 ? 0U : cause | (rounded(hunting_Hz(), 32767.0F) << 16);
  }
  std::uint32_t read_timing(std::uint8_t sub) const {
    switch (sub) {
      case 1:
        return timing_.longest_period;
      case 2:
        return timing_.longest_duration;
      case 3:
        return timing_.overruns;
      case 4:
        return controller_.ticks();
      default:
        return controller_.ticks() & 0xFFFF;
    }
  }
  /// 2502h: the loads; `stored` is what its parameters hold.
  std::uint32_t read_load(std::uint8_t sub, std::uint32_t stored) const {
    if (sub == 5) return word(controller_.thermal().motor_load());
    return sub == 6 ? word(controller_.thermal().amplifier_load()) : stored;
  }
  std::uint32_t underruns() const {
    return controller_.reference().underruns() + controller_.cyclic_position().gaps();
  }
  std::uint32_t fault_count(std::uint8_t sub) const {
    return controller_.state().faults().count(static_cast<Fault>(sub));
  }

 private:
  static std::uint32_t word(float number) { return std::bit_cast<std::uint32_t>(number); }

  float hunting_Hz() const {
    const float period_s =
        controller_.hunting().oscillation().period_ticks * controller_.parameters().axis.tick_s;
    return period_s > 0.0F ? 1.0F / period_s : 0.0F;
  }

  std::uint32_t observer_value(std::uint8_t sub, float mean_command_A) const {
    const ControlOutput& out = controller_.output();
    switch (sub) {
      case 1:
        return word(out.feedforward_N);
      case 2:
        return word(out.feedback_N);
      case 3:
        return word(out.residual_N);
      case 4:
        return word(out.level);
      case 5:
        return word(controller_.friction().dry_friction_N);
      case 6:
        return word(controller_.friction().total_N);
      case 7:
        return word(out.position_error_m);
      case 8:
        return word(out.velocity_mps);
      case 9:
        return static_cast<std::uint32_t>(controller_.position().position_of(out.reference_counts));
      case 10:
        return out.limits;
      case 11:
        return rounded(mean_command_A / controller_.parameters().axis.current_limit_A * 32767.0F, 32767.0F);
      case 12:
        return word(out.current_A);
      default:
        return controller_.parameters().hash;
    }
  }

  // The main loop writes it, and reads it here.
  std::uint32_t read_memory(std::uint8_t sub) const {
    const HysteresisMemory& memory = controller_.memory();
    switch (sub) {
      case kMemorySub:
        return memory.depth();
      case kMemorySub + 1:
        return memory.overflow_count();
      case kMemorySub + 2:
        return word(memory.overflow_height_N());
      case kAddedMassSub:
        return word(controller_.added_kg());
      default:
        return memory.missed_ticks();
    }
  }

  const Controller& controller_;
  const TickTiming& timing_;
};

}  // namespace slipstack::canopen
