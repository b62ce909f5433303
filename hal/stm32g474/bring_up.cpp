// SPDX-License-Identifier: Apache-2.0
// Shows that a board is alive, with the motor off: blinks, ticks, counts the encoder, measures the current,
// sends a CANopen heartbeat, and reports once a second on the ST-LINK's serial port (115200 baud).
#include <cstdint>
#include <string_view>

#include "hal/stm32g474/board.h"
#include "hal/stm32g474/peripherals.h"

namespace {
using namespace slipstack;             // NOLINT(google-build-using-namespace)
using namespace slipstack::stm32g474;  // NOLINT(google-build-using-namespace)

#ifdef SLIPSTACK_BRING_UP_PWM
constexpr DriveKind kDrive = DriveKind::kPwm;
#else
constexpr DriveKind kDrive = DriveKind::kDac;
#endif

constexpr BoardSetup kSetup{};
Board<kDrive, Part> board{kSetup};

// Written in the tick, read in the main loop.
volatile std::int32_t encoder_counts = 0;
volatile float current_A = 0.0F;
volatile bool current_valid = false;

void write_unsigned(std::uint32_t value) {
  char digits[10];
  std::size_t at = sizeof digits;
  do {
    digits[--at] = static_cast<char>('0' + value % 10);
    value /= 10;
  } while (value > 0);
  board.uart().write({digits + at, sizeof digits - at});
}

void write_field(std::string_view name, std::int32_t value) {
  board.uart().write(name);
  if (value < 0) board.uart().write("-");
  write_unsigned(value < 0 ? 0U - static_cast<std::uint32_t>(value) : static_cast<std::uint32_t>(value));
}

void tell_state() {
  const TickPunctuality timing = board.tick_timer().timing();
  const CanBusStatus bus = board.can().status();
  write_field("ticks ", static_cast<std::int32_t>(timing.ticks));
  write_field(" overruns ", static_cast<std::int32_t>(timing.overruns));
  write_field(" latency ", static_cast<std::int32_t>(timing.latency_min));
  write_field("..", static_cast<std::int32_t>(timing.latency_max));
  write_field(" longest ", static_cast<std::int32_t>(timing.duration_max));
  write_field(" cycles, encoder ", encoder_counts);
  write_field(" errors ", static_cast<std::int32_t>(board.incremental_encoder().transition_errors()));
  write_field(", current_mA ", static_cast<std::int32_t>(1000.0F * current_A));
  board.uart().write(current_valid ? "" : " (not valid)");
  write_field(", CAN state ", static_cast<std::int32_t>(bus.state));
  write_field(" tx ", bus.transmit_errors);
  write_field(" rx ", bus.receive_errors);
  write_field(" lost ", static_cast<std::int32_t>(bus.frames_lost));
  board.uart().write(board.runs_on_crystal() ? "\r\n" : ", no crystal\r\n");
}

void send_heartbeat() {
  CanFrame frame;
  frame.id = 0x77F;  // CiA 301: heartbeat of node 127, pre-operational
  frame.length = 1;
  frame.data[0] = 0x7F;
  if (board.can().status().state == CanBusState::kOff) board.can().recover();
  static_cast<void>(board.can().send(frame));
}
}  // namespace

extern "C" void tick_handler() {
  board.tick_timer().begin();
  const EncoderReading position = board.encoder().read();
  const CurrentReading current = board.motor_current().measured();
  encoder_counts = position.counts;
  current_A = current.current_A;
  current_valid = current.valid;
  board.watchdog().refresh();
  board.tick_timer().end();
}

extern "C" void encoder_handler() {
  board.biss().on_interrupt();
}

extern "C" void can_handler() {
  board.can().on_interrupt();
}

extern "C" void indicator_handler() {
  board.indicator().step();
}

int main() {
  const BoardFault fault = board.start({});
  if (fault != BoardFault::kNone) {
    write_field("fault ", static_cast<std::int32_t>(fault));
    board.uart().write("\r\n");
    return 1;
  }
  board.motor_current().disable();
  board.uart().write(board.watchdog().caused_last_reset() ? "slipstack: reset by the watchdog\r\n"
                                                          : "slipstack\r\n");
  board.indicator().show(Indication::kReady);
  std::uint32_t reported = 0;
  for (;;) {
    CanFrame received;
    while (board.can().receive(received)) static_cast<void>(board.can().send(received));
    if (board.tick_timer().timing().ticks - reported >= kSetup.tick_rate_Hz) {
      reported += kSetup.tick_rate_Hz;
      send_heartbeat();
      tell_state();
    }
  }
}
