// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/tick.h"
#include "tests/budget/friction_model.h"
#include "tests/budget/memory_board.h"
#include "tests/budget/motion.h"

// The whole control tick with every effect of the catalogue on, both notches, disturbance compensation and
// adaptation, on a board that is a few words of memory. Driven by encoder counts that any motion may produce.
namespace slipstack::budget {

inline Tick tick_under_test(memory_encoder, memory_motor, memory_clock, memory_watchdog, memory_io);

// What the world does between two ticks: the axis follows its reference with an error, commands and moves
// come at random, position, cyclic position and torque mode take turns, parameters are changed in motion,
// sensors fail now and then; or `events` times as often as else, so that several of these meet in one tick.
class TickScenario {
 public:
  struct Kind {
    bool excited = false;
    std::uint32_t events = 1;
  };

  // The axis stays where it is, and new parameters come in motion: an encoder that jumps is a fault, and
  // parameters begin the wait anew that is to pass after it.
  void reset(const Kind& kind) {
    kind_ = kind;
    Controller& controller = tick_under_test.controller();
    if (controller.parameters().valid && !controller.output().driving) return;
    static_cast<void>(controller.configure(everything_on(), all_effects()));
  }

  void before() {
    Controller& controller = tick_under_test.controller();
    wait_out(controller);
    memory_clock.count += 100;
    ++ticks_;
    controller.poll();
    tick_under_test.main_loop_ran();
    // Now and then the master is silent for longer than it may be.
    if (random_.below(4) != 0) controller.commanded(5);
    const DriveState state = controller.state().state();
    if (once_in(2000)) {
      static_cast<void>(controller.configure(everything_on(), all_effects()));
    }
    if (once_in(500)) {
      options_ = (random_.below(3) == 0 ? kTorqueMode : 0U) | (random_.below(2) == 0 ? kReleaseOnFault : 0U) |
                 (random_.below(2) == 0 ? kLostStops : 0U) | (random_.below(2) == 0 ? kBrakeOnShutdown : 0U) |
                 (random_.below(2) == 0 ? kSlowQuickStop | kSlowFaultReaction : 0U);
      const auto target_N = static_cast<float>(random_.below(200)) - 100.0F;
      controller.set_torque(target_N, 0.1F * target_N);
    }
    if (kind_.excited) options_ &= ~kTorqueMode;  // no excitation in torque mode
    if (once_in(1000)) {
      UserBounds user;
      user.range = {-100000, 250000};
      user.velocity_mps = 0.3F;
      user.quick_stop_counts_per_s2 = 5.0e6F;
      controller.bound(random_.below(2) == 0 ? user : UserBounds{});
    }
    synchronise(controller);
    if (state != DriveState::kOperationEnabled) {
      constexpr std::uint32_t kUp[] = {0x0080, 0x0006, 0x0007, 0x000F};
      controller.command_all(options_ | kUp[random_.below(4)]);
    } else if (once_in(3000)) {
      controller.command_all(options_ | (random_.below(2) == 0 ? 0x000BU : 0x0000U));
    } else {
      controller.command_all(options_ | 0x000FU);
      if (!streaming_ && controller.reference().idle()) {
        static_cast<void>(controller.move_to(static_cast<std::int32_t>(random_.below(300000))));
      }
    }
    if (kind_.excited) excite(controller);
    const std::int32_t wobble = static_cast<std::int32_t>(random_.below(7)) - 3;
    memory_encoder.next.counts = controller.output().reference_counts + wobble;
    memory_encoder.index_passed = random_.below(20) == 0;
    if (streaming_) controller.latch().disarm();  // homing is no cyclic mode
    if (!streaming_ && !controller.latch().armed())
      controller.latch().arm(PositionLatch::Event::kIndexAfterActive, 1);
    memory_encoder.next.valid = !once_in(5000);
    if (once_in(5000)) memory_encoder.next.counts += 1000000;
    if (once_in(5000)) memory_clock.count += 80;
    if (once_in(5000)) memory_motor.measurement.current_A = 100.0F;
    // Limit switches and the home switch; rarely both at once.
    if (once_in(200)) switches_ = random_.below(4) == 0 ? random_.below(8) : 0U;
    memory_io.inputs = once_in(5000) ? 0U : kAmplifierWell | switches_;
  }

 private:
  // After some faults operation is enabled when the axis has stood for 200 ticks, undisturbed: those are not
  // measured, or hardly anything else would be.
  void wait_out(Controller& controller) {
    for (int i = 0; i < 300 && controller.state().state() == DriveState::kSwitchedOn; ++i) {
      memory_clock.count += 100;
      memory_encoder.index_passed = false;
      memory_io.inputs = kAmplifierWell;
      controller.poll();
      tick_under_test.main_loop_ran();
      controller.command_all(options_ | 0x000FU);
      tick_under_test.run();
    }
  }

  bool once_in(std::uint32_t ticks) { return random_.below(1 + (ticks - 1) / kind_.events) == 0; }

  // As often as the axis stands or moves at constant velocity.
  static void excite(Controller& controller) {
    if (controller.excitation().running() || !controller.may_excite()) return;
    controller.excitation().begin({.amplitude = 50.0F,
                                   .largest_deviation_m = 1.0F,
                                   .period_ticks = 100,
                                   .lowest = 1,
                                   .highest = 25,
                                   .periods = 3});
  }

  // SYNC every ten ticks, some late and some lost; a stream that begins somewhere, accelerates and ends.
  void synchronise(Controller& controller) {
    CyclicPosition& cyclic = controller.cyclic_position();
    const AxisParameters& axis = controller.parameters().axis;
    cyclic.set_period(10.0F, axis.tick_s);
    path_.set_limits(
        cyclic.path_limits(controller.stream_limits(), controller.range(), CyclicPosition::kRounding));
    if (once_in(1500)) {
      streaming_ = !streaming_;
      target_ = controller.reference().counts() + static_cast<std::int32_t>(random_.below(2000)) - 1000;
      velocity_ = 0;
      if (streaming_) cyclic.start();
      if (!streaming_) cyclic.stop();
    }
    if (ticks_ % 10 == 0) sync_at_ = ticks_ + random_.below(4) / 3;
    if (ticks_ != sync_at_ || random_.below(30) == 0) return;
    velocity_ += static_cast<std::int32_t>(random_.below(41)) - 20;
    target_ += velocity_;
    cyclic.sync(controller.ticks(), streaming_ && random_.below(30) != 0, target_, path_,
                [&controller](std::uint32_t lead) { return controller.ahead(lead); });
  }

  Random random_{0xBADCAB1E};
  Kind kind_;
  StreamPath path_;
  bool streaming_ = false;
  std::int32_t target_ = 0;
  std::int32_t velocity_ = 0;
  std::uint32_t sync_at_ = 0;
  std::uint32_t ticks_ = 0;
  std::uint32_t switches_ = 0;
  std::uint32_t options_ = 0;  // kTorqueMode, kReleaseOnFault, kLostStops
};

inline TickScenario tick_scenario;

// As an Observer: one step is one tick, its force the current that was commanded.
template <bool excited, std::uint32_t events>
void reset_tick(std::int32_t) {
  tick_scenario.reset({excited, events});
}
inline void prepare_tick(std::int32_t) {
  tick_scenario.before();
}
// A tick without current leaves out the control.
inline bool tick_drives() {
  return tick_under_test.controller().output().driving;
}
[[gnu::noinline]] inline float run_tick(std::int32_t) {
  tick_under_test.run();
  return memory_motor.set_point_A;
}

}  // namespace slipstack::budget
