// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>

#include "firmware/canopen/objects/dictionary.h"
#include "firmware/control/controller.h"

namespace slipstack::canopen {

/// The excitation (2320h): what is injected into the loop, and how far it has come.
class ExcitationObjects {
 public:
  explicit ExcitationObjects(Controller& controller) : controller_(controller) {}

  /// Once in every poll: another mode of operation (6061h), halt (bit 8 of the control word) and every stop
  /// end it.
  void step(const Dictionary& dictionary, std::uint32_t mode) {
    const bool halt = (dictionary.value(kRow<0x6040>) & kHalt) != 0;
    const bool ends = !may_be_excited(mode) || halt || !controller_.may_excite();
    if (ends && controller_.excitation().running()) controller_.excitation().stop();
  }
  /// From the tick's interrupt, behind the tick.
  void after_tick() { controller_.excitation().note(controller_.output().limits); }

  std::uint32_t read(const Dictionary& dictionary, std::uint8_t sub) const {
    const Excitation& excitation = controller_.excitation();
    switch (sub) {
      case 2:
        return static_cast<std::uint32_t>(state());
      case 11:
        return excitation.periods();
      case 12:
        return excitation.limits();
      default:
        return dictionary.value(kRow<kExcitationIndex, 1>);
    }
  }

  /// While it runs its settings stay. It begins in a profile mode only (`mode`: 6061h), on an axis that
  /// stands or moves at constant velocity; and with settings that a tick can follow.
  Abort check(const Dictionary& dictionary, std::uint8_t sub, std::uint32_t value, std::uint32_t mode) const {
    if (sub != 1) return running() ? Abort::kDeviceState : Abort::kNone;
    if (value == 0) return Abort::kNone;
    if (running() || !may_be_excited(mode) || !controller_.may_excite()) return Abort::kDeviceState;
    return possible(settings(dictionary)) ? Abort::kNone : Abort::kBadValue;
  }

  /// 2320h:01.
  void command(const Dictionary& dictionary, std::uint32_t value) {
    if (value == 0) return controller_.excitation().stop();
    if (controller_.may_excite()) controller_.excitation().begin(settings(dictionary));
  }

 private:
  // Profile position and profile velocity.
  static bool may_be_excited(std::uint32_t mode) { return mode == 1 || mode == 3; }

  // An axis that was switched off, or is in another mode, has ended it, also before the next tick says so.
  ExcitationState state() const {
    const ExcitationState state = controller_.excitation().state();
    const bool over = state == ExcitationState::kRunning && !controller_.may_excite();
    return over ? ExcitationState::kEnded : state;
  }
  bool running() const { return state() == ExcitationState::kRunning; }

  // The current that is left for the feedback is at least as much.
  bool possible(const ExcitationSettings& settings) const {
    const AxisParameters& axis = controller_.parameters().axis;
    const bool current = settings.place == ExcitationPlace::kCurrent;
    const float largest =
        current ? 0.5F * axis.current_limit_A * axis.motor_constant_N_per_A : axis.following_error_m;
    return settings.possible() && settings.amplitude <= largest;
  }

  ExcitationSettings settings(const Dictionary& dictionary) const {
    const AxisParameters& axis = controller_.parameters().axis;
    ExcitationSettings made;
    const bool current = dictionary.value(kRow<kExcitationIndex, 3>) == 0;
    made.place = current ? ExcitationPlace::kCurrent : ExcitationPlace::kPosition;
    made.amplitude = current ? dictionary.real(kRow<kExcitationIndex, 4>) * axis.motor_constant_N_per_A
                             : dictionary.real(kRow<kExcitationIndex, 5>);
    made.period_ticks = dictionary.value(kRow<kExcitationIndex, 8>);
    made.periods = dictionary.value(kRow<kExcitationIndex, 9>);
    made.largest_deviation_m = dictionary.real(kRow<kExcitationIndex, 10>);
    made.set_band(dictionary.real(kRow<kExcitationIndex, 6>), dictionary.real(kRow<kExcitationIndex, 7>),
                  axis.tick_s);
    return made;
  }

  Controller& controller_;
};

}  // namespace slipstack::canopen
