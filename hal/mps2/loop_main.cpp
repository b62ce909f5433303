// SPDX-License-Identifier: Apache-2.0
// The firmware on the emulated board, in lock-step with a plant on the host: one tick for each turn of the
// link. The current that the amplifier would measure is the one it was told.
#include <cstring>

#include "firmware/control/tick.h"
#include "hal/include/plant_link.h"
#include "hal/mps2/systick.h"
#include "hal/mps2/uart.h"

namespace {

using namespace slipstack;

PlantLink& link() {
  return *reinterpret_cast<PlantLink*>(PlantLink::kGuestAddress);
}

struct LinkEncoder {
  EncoderReading read() const { return {link().counts, 0, link().encoder_valid != 0}; }
};
struct LinkMotor {
  float set_point_A = 0.0F;
  void set(float current_A) {
    set_point_A = current_A;
    link().current_A = current_A;
    link().driving = 1;
  }
  void disable() {
    set_point_A = 0.0F;
    link().current_A = 0.0F;
    link().driving = 0;
  }
  CurrentReading measured() const { return {set_point_A, true}; }
};
// Lock-step: a tick takes exactly its period.
struct LinkClock {
  std::uint32_t count = 0;
  std::uint32_t now() const { return count; }
  std::uint32_t ticks_per_second() const { return 1000000; }
};
struct LinkWatchdog {
  void refresh() {}
  bool caused_last_reset() const { return false; }
};

LinkEncoder encoder;
LinkMotor motor;
LinkClock board_clock;
LinkWatchdog watchdog;
Tick tick(encoder, motor, board_clock, watchdog);

struct ParameterBlock {
  AxisParameters axis;
  ModelParameters model;
};
static_assert(sizeof(ParameterBlock) <= sizeof(PlantLink::parameters));
ParameterBlock block;

void take_requests(std::uint32_t& moves, std::uint32_t& blocks) {
  Controller& controller = tick.controller();
  if (link().parameter_sequence != blocks) {
    blocks = link().parameter_sequence;
    if (link().parameter_bytes == sizeof block) {
      // A tuple of floats and flags: copied as the host laid it out.
      std::memcpy(static_cast<void*>(&block), link().parameters.data(), sizeof block);
      link().last_status = static_cast<std::uint32_t>(controller.configure(block.axis, block.model));
    } else {
      link().last_status = 255;
    }
  }
  if (link().move_sequence != moves) {
    moves = link().move_sequence;
    link().last_status = static_cast<std::uint32_t>(controller.move_to(link().move_counts));
  }
  controller.command(static_cast<std::uint16_t>(link().control_word));
}

void publish() {
  const Controller& controller = tick.controller();
  const ControlOutput& out = controller.output();
  link().state = static_cast<std::uint32_t>(controller.state().state());
  link().fault = static_cast<std::uint32_t>(controller.state().faults().latched());
  link().reference_counts = out.reference_counts;
  link().reference_idle = tick.controller().reference().idle() ? 1 : 0;
  link().feedforward_N = out.feedforward_N;
  link().residual_N = out.residual_N;
  link().model_hash = controller.parameters().hash;
}

}  // namespace

int main() {
  std::uint32_t sequence = 0;
  std::uint32_t moves = 0;
  std::uint32_t blocks = 0;
  link().magic = PlantLink::kMagic;
  for (;;) {
    const std::uint32_t now = link().host_sequence;
    if (now == sequence) continue;
    sequence = now;
    if (link().control_word == PlantLink::kQuit) return 0;
    take_requests(moves, blocks);
    board_clock.count += 100;
    tick.run();
    publish();
    asm volatile("dmb" ::: "memory");
    link().guest_sequence = sequence;
  }
}
