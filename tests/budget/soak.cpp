// SPDX-License-Identifier: Apache-2.0
// Image that runs the control tick from the SysTick exception for as many ticks as its first word says, while
// the main loop changes parameters, commands, modes and moves at random, offers parameters that must be
// refused, and sensors fail. After every tick: nothing
// that is not a number, no current without permission or beyond its limit, counters that fit what was
// injected. Status 0 and a line of counts; 1 and the reason otherwise.
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "hal/mps2/semihosting.h"
#include "hal/mps2/systick.h"
#include "hal/mps2/uart.h"
#include "tests/budget/tick_under_test.h"

namespace {

using namespace slipstack;
using namespace slipstack::budget;
using mps2::uart_write;
using mps2::uart_write_unsigned;

// 25.6 counts an instruction: some 5500 for a tick, its checks, and what is left to the main loop, which the
// adaptation alone takes 1800 of, and the watch for hunting 200. With too little the main loop falls behind,
// its commands time out, and hardly a tick is driven.
constexpr std::uint32_t kPeriod = 140800;
constexpr std::uint32_t kClockPeriod = 100;

struct Injected {
  std::uint32_t losses = 0;
  std::uint32_t jumps = 0;
  std::uint32_t over_currents = 0;
  std::uint32_t late = 0;
  std::uint32_t refused = 0;
  std::uint32_t refused_driving = 0;  // of these: while the current was on
};

Random sensor_random{0xBADCAB1E};
Injected injected;
volatile std::uint32_t ticks = 0;
const char* volatile wrong = nullptr;
float last_A = 0.0F;
std::uint32_t last_faults = 0;

bool finite(float value) {
  return (std::bit_cast<std::uint32_t>(value) & 0x7F800000U) != 0x7F800000U;
}

// The axis follows its reference; without one, and under a given force, it comes to rest. Never by more than
// a quarter of the largest velocity from tick to tick: a reading that changes faster is a fault of the
// encoder.
std::int32_t place_of_axis() {
  static std::int32_t place = 0;
  static std::int32_t step = 0;
  const Controller& controller = tick_under_test.controller();
  const ControlSet& set = controller.parameters();
  const auto quickest =
      1 + static_cast<std::int32_t>(0.25F * set.axis.velocity_limit_mps * set.counts_per_mps);
  const bool follows = controller.output().driving && !controller.state().torque_mode();
  const std::int32_t wanted = follows ? difference(controller.output().reference_counts, place) : 0;
  const std::int32_t change = difference(wanted, step);
  step += change > quickest ? quickest : (change < -quickest ? -quickest : change);
  place = sum(place, step);
  return place;
}

void sense() {
  const std::int32_t wobble = static_cast<std::int32_t>(sensor_random.below(7)) - 3;
  memory_encoder.next.counts = place_of_axis() + wobble;
  memory_encoder.next.valid = true;
  memory_clock.count += kClockPeriod;
  const std::uint32_t event = sensor_random.below(20000);
  if (event == 0) {
    memory_encoder.next.valid = false;
    ++injected.losses;
  } else if (event == 1) {
    memory_encoder.next.counts += 1000000;
    ++injected.jumps;
  } else if (event == 2 && ticks > 0) {
    memory_clock.count += 80;
    ++injected.late;
  } else if (event == 3) {
    memory_motor.measurement.current_A = 100.0F;
    ++injected.over_currents;
  }
}

std::uint32_t fault_sum() {
  const FaultRecord& faults = tick_under_test.controller().state().faults();
  std::uint32_t sum = 0;
  for (std::size_t i = 1; i < kFaultCount; ++i) sum += faults.count(static_cast<Fault>(i));
  return sum;
}

void inspect() {
  const Controller& controller = tick_under_test.controller();
  const ControlOutput& out = controller.output();
  for (const float value : {out.current_A, out.position_error_m, out.velocity_mps, out.feedforward_N,
                            out.feedback_N, out.residual_N, out.level}) {
    if (!finite(value)) wrong = "a value is not finite";
  }
  for (const float force_N : controller.friction().by_effect_N) {
    if (!finite(force_N)) wrong = "the force of an effect is not finite";
  }
  const AxisParameters& axis = controller.parameters().axis;
  const float step_A = memory_motor.set_point_A - last_A;
  const float largest_A = axis.current_rate_A_per_s * axis.tick_s * 1.001F;
  last_A = memory_motor.set_point_A;
  if (approx::absolute(last_A) > axis.current_limit_A) wrong = "the current is beyond its limit";
  if (memory_motor.enabled && approx::absolute(step_A) > largest_A) wrong = "the current jumps";
  if (!controller.state().driving() && (memory_motor.enabled || last_A != 0.0F)) {
    wrong = "current without permission";
  }
  if (!(out.level >= axis.level_lowest && out.level <= axis.level_highest))
    wrong = "the level left its bounds";
  const std::uint32_t faults = fault_sum();
  if (faults < last_faults) wrong = "a fault counter went back";
  last_faults = faults;
  if (controller.ticks() != ticks || memory_watchdog.refreshed != ticks) wrong = "ticks were lost";
  if (tick_under_test.timing().overruns != injected.late) wrong = "overruns do not fit";
}

// Parameters that no tick may see, one of each kind.
void offer_bad_parameters(Random& random) {
  Controller& controller = tick_under_test.controller();
  if (controller.change_pending()) return;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  AxisParameters axis = everything_on();
  auto model = all_effects();
  auto& hysteresis = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(model);
  ParameterStatus expected = ParameterStatus::kAxisOutOfBounds;
  switch (random.below(5)) {
    case 0:
      axis.velocity_gain_N_s_per_m = 2.0e6F;
      break;
    case 1:
      axis.notch[1].frequency_Hz = kNan;
      break;
    case 2:
      hysteresis.gains[3] = -1.0F;
      expected = ParameterStatus::kGainOutOfBounds;
      break;
    case 3:
      hysteresis.gains[7] = kNan;
      expected = ParameterStatus::kGainOutOfBounds;
      break;
    default:
      hysteresis.shapes[0] = std::numeric_limits<float>::infinity();
      expected = ParameterStatus::kShapeOutOfBounds;
      break;
  }
  const std::uint32_t hash = controller.parameters().hash;
  const std::uint32_t number = controller.parameters().number;
  // No tick comes between the question and the refusal, so that both speak of the same state.
  asm volatile("cpsid i" ::: "memory");
  const bool driving = controller.state().driving();
  const ParameterStatus status = controller.configure(axis, model);
  if (status != expected) wrong = "bad parameters were not refused for what is wrong with them";
  if (controller.parameters().hash != hash || controller.parameters().number != number ||
      controller.change_pending()) {
    wrong = "refused parameters came into force";
  }
  ++injected.refused;
  if (driving) ++injected.refused_driving;
  asm volatile("cpsie i" ::: "memory");
}

void change_parameters(Random& random) {
  AxisParameters axis = everything_on();
  axis.velocity_gain_N_s_per_m = static_cast<float>(2000 + random.below(8000));
  axis.adapt_level = random.below(2) == 0;
  // Resolution and tick are fixed at the start: refused, but nothing is wrong with them.
  const bool fixed = random.below(50) == 0;
  if (fixed) axis.tick_s = 2.0e-4F;
  Controller& controller = tick_under_test.controller();
  if (controller.configure(axis, all_effects()) == ParameterStatus::kOk && fixed) {
    wrong = "the tick's period changed";
  }
}

// In the main loop, interrupted by ticks wherever it is.
void command(Random& random) {
  static std::uint32_t options = 0;
  Controller& controller = tick_under_test.controller();
  controller.poll();
  tick_under_test.main_loop_ran();
  // Now and then the master is silent for longer than it may be.
  if (random.below(4) != 0) controller.commanded(5);
  if (random.below(300) == 0) change_parameters(random);
  // At rest more often: that never lasts long. Of the driven ticks so many that a short run has some: none in
  // one run of 200 000 ticks of four, with a fifth of this, was chance and not a finding.
  if (random.below(controller.state().driving() ? 6000 : 100) == 0) offer_bad_parameters(random);
  if (random.below(20000) == 0) {
    options = (random.below(3) == 0 ? kTorqueMode : 0U) | (random.below(3) == 0 ? kLostStops : 0U);
    const auto target_N = static_cast<float>(random.below(200)) - 100.0F;
    controller.set_torque(target_N, 0.1F * target_N);
  }
  const DriveState state = controller.state().state();
  if (state != DriveState::kOperationEnabled) {
    constexpr std::uint32_t kUp[] = {0x0080, 0x0006, 0x0007, 0x000F};
    controller.command_all(options | kUp[random.below(4)]);
  } else if (random.below(5000) == 0) {
    controller.command_all(options | (random.below(2) == 0 ? 0x000BU : 0x0000U));
  } else {
    controller.command_all(options | 0x000FU);
    if (controller.reference().idle()) {
      static_cast<void>(controller.move_to(static_cast<std::int32_t>(random.below(300000))));
    }
  }
}

void tell(const char* name, std::uint32_t value) {
  uart_write(" ");
  uart_write(name);
  uart_write(" ");
  uart_write_unsigned(value);
}

std::uint32_t number(const char* text) {
  std::uint32_t value = 0;
  for (; *text >= '0' && *text <= '9'; ++text) value = value * 10 + static_cast<std::uint32_t>(*text - '0');
  return value;
}

}  // namespace

extern "C" void tick_handler();
extern "C" void tick_handler() {
  sense();
  run_tick(0);
  ticks = ticks + 1;
  inspect();
}

int main() {
  char buffer[64];
  const char* words = mps2::command_line(buffer);
  const char* space = std::strchr(words, ' ');
  const std::uint32_t wanted = space == nullptr ? 100000 : number(space + 1);
  tick_scenario.reset({});
  tick_under_test.set_period(kClockPeriod);
  Random random{0x50AC5EED};
  mps2::systick_start_periodic(kPeriod);
  while (ticks < wanted && wrong == nullptr) command(random);
  mps2::systick_stop();
  const FaultRecord& faults = tick_under_test.controller().state().faults();
  uart_write("soak");
  tell("ticks", ticks);
  tell("losses", injected.losses);
  tell("jumps", injected.jumps);
  tell("over_currents", injected.over_currents);
  tell("late", injected.late);
  tell("overruns", tick_under_test.timing().overruns);
  tell("refused", injected.refused);
  tell("refused_driving", injected.refused_driving);
  tell("counted_losses", faults.count(Fault::kEncoderLoss));
  tell("counted_jumps", faults.count(Fault::kEncoderJump));
  tell("counted_over_currents", faults.count(Fault::kOverCurrent));
  tell("counted_overruns", faults.count(Fault::kTickOverrun));
  tell("counted_parameters", faults.count(Fault::kParameter));
  uart_write("\n");
  if (wrong != nullptr) {
    uart_write("wrong: ");
    uart_write(wrong);
    uart_write("\n");
    return 1;
  }
  return 0;
}
