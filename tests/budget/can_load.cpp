// SPDX-License-Identifier: Apache-2.0
// Image that runs the whole firmware (application, CANopen node, tick from the SysTick exception) while its
// CAN port is fed as fast as a bus of 1 Mbit/s carries frames, and counts the instructions of every tick. The
// axis is moved in the same way in every run, so that a tick that does not notice the bus has the same count
// in each. The command line says what comes in, and how many frames: "quiet 50000" runs as many ticks
// without.
//
// Prints the counts of the ticks, their checksum, what the node counted, and a checksum of its flash.
#include <array>
#include <cstdint>
#include <cstring>

#include "firmware/app/application.h"
#include "firmware/app/canopen_node.h"
#include "firmware/storage/crc32.h"
#include "hal/mps2/memory_flash.h"
#include "hal/mps2/semihosting.h"
#include "hal/mps2/systick.h"
#include "hal/mps2/uart.h"
#include "tests/budget/can_traffic.h"
#include "tests/budget/friction_model.h"
#include "tests/budget/memory_board.h"

namespace {

using namespace slipstack;
using namespace slipstack::budget;

// SysTick counts of a tick: 8000 instructions. A tick of 10 kHz has 17 000 cycles at 170 MHz (STM32G474); an
// instruction takes two of them or less.
constexpr std::uint32_t kPeriod = 204800;
constexpr std::uint32_t kClockPeriod = 100;  // us
constexpr std::uint32_t kPageBytes = mps2::MemoryFlash::kPages * mps2::MemoryFlash::kPageBytes;
constexpr std::uint8_t kNodeId = 5;

[[gnu::section(".psram")]] std::array<std::byte, 8 + kPageBytes> flash_memory;
[[gnu::section(".trace")]] std::array<canopen::TraceSample, 4096> trace;

// The bus is quiet before: in which of the first ticks the parameters come into force depends on how far the
// main loop is.
constexpr std::uint32_t kSettled = 16;

volatile std::uint32_t ticks = 0;
std::uint32_t wanted_ticks = 0;

/// Frames come at the rate of the bus, as the interrupt of a real port would put them into its ring.
class LoadPort final : public CanPort {
 public:
  static constexpr std::uint32_t kRing = 32;

  bool send(const CanFrame& frame) override {
    ++sent_;
    last_ = frame;
    return true;
  }
  bool receive(CanFrame& frame) override {
    if (question_pending_) {
      question_pending_ = false;
      frame = question_;
      return true;
    }
    if (ticks < kSettled) return false;
    // 111 bits and stuffing: 9 frames of 8 bytes in a millisecond at 1 Mbit/s.
    const std::uint32_t due = (ticks - kSettled) * 9 / 10;
    if (traffic == Traffic::kQuiet || due == taken_) return false;
    if (due - taken_ > kRing) {
      lost_ += due - taken_ - kRing;
      taken_ = due - kRing;
    }
    ++taken_;
    frame = next_frame(traffic, random_);
    return true;
  }
  CanBusStatus status() const override {
    CanBusStatus status;
    status.frames_lost = lost_;
    return status;
  }
  void recover() override {}

  /// An SDO upload by the way; the answer is the next frame with the server's identifier.
  void ask(std::uint16_t index, std::uint8_t sub) {
    question_.id = 0x600U + kNodeId;
    question_.length = 8;
    question_.data = {
        0x40, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8), sub, 0, 0, 0, 0};
    question_pending_ = true;
  }

  Traffic traffic = Traffic::kQuiet;
  std::uint32_t taken() const { return taken_; }
  std::uint32_t sent() const { return sent_; }
  const CanFrame& last() const { return last_; }

 private:
  Random random_{0x5EEDCA11};
  std::uint32_t taken_ = 0;
  std::uint32_t lost_ = 0;
  std::uint32_t sent_ = 0;
  bool question_pending_ = false;
  CanFrame question_;
  CanFrame last_;
};

class NoIndicator final : public Indicator {
 public:
  void show(Indication) override {}
};

struct LoadBoard {
  MemoryEncoder& encoder() { return memory_encoder; }
  MemoryMotor& motor_current() { return memory_motor; }
  MemoryClock& clock() { return memory_clock; }
  MemoryWatchdog& watchdog() { return memory_watchdog; }
  MemoryDigitalIo& digital_io() { return memory_io; }
  CanPort& can() { return port; }
  Nonvolatile& nonvolatile() { return flash; }
  Indicator& indicator() { return shown_nowhere; }
  std::uint32_t tick_period() const { return kClockPeriod; }
  bool start() {
    flash.start();
    return true;
  }
  // The node is polled all the time, and interrupted by ticks wherever it is.
  bool wait() { return ticks < wanted_ticks; }

  LoadPort port;
  mps2::MemoryFlash flash{flash_memory.data()};
  NoIndicator shown_nowhere;
};

LoadBoard board;
CanopenNode node{kNodeId, 1, trace};
Application application{board, node};

struct Counts {
  std::uint32_t least = 0xFFFFFFFF;
  std::uint32_t most = 0;
  std::uint64_t total = 0;
  std::uint32_t checksum = 2166136261U;
  std::uint32_t latest_entry = 0;

  void add(std::uint32_t instructions, std::uint32_t entry) {
    least = instructions < least ? instructions : least;
    most = instructions > most ? instructions : most;
    total += instructions;
    checksum = (checksum ^ instructions) * 16777619U;
    latest_entry = entry > latest_entry ? entry : latest_entry;
  }
};
Counts counts;
Random motion_random{0xBADCAB1E};

std::uint32_t instructions(std::uint32_t systick_counts) {
  return (systick_counts * 10 + 128) / 256;
}

// From inside the exception, so that it comes between the same two ticks in every run.
void move_the_axis() {
  Controller& controller = application.controller();
  memory_clock.count += kClockPeriod;
  memory_encoder.next.counts =
      controller.output().reference_counts + static_cast<std::int32_t>(motion_random.below(7)) - 3;
  memory_encoder.next.valid = true;
  const DriveState state = controller.state().state();
  if (state != DriveState::kOperationEnabled) {
    constexpr std::uint16_t kUp[] = {0x0080, 0x0006, 0x0007, 0x000F};
    controller.command(kUp[motion_random.below(4)]);
  } else if (controller.reference().idle()) {
    static_cast<void>(controller.move_to(static_cast<std::int32_t>(motion_random.below(300000))));
  }
}

void tell(const char* name, std::uint32_t value) {
  mps2::uart_write(" ");
  mps2::uart_write(name);
  mps2::uart_write(" ");
  mps2::uart_write_unsigned(value);
}

std::uint32_t read(std::uint16_t index, std::uint8_t sub) {
  board.port.ask(index, sub);
  const auto& data = board.port.last().data;
  const auto answered = [&] {
    return board.port.last().id == 0x580U + kNodeId && data[0] == 0x43 && (data[1] | data[2] << 8) == index &&
           data[3] == sub;
  };
  for (int i = 0; i < 100 && !answered(); ++i) application.serve();
  if (!answered()) return 0xFFFFFFFF;
  return data[4] | std::uint32_t{data[5]} << 8U | std::uint32_t{data[6]} << 16U |
         std::uint32_t{data[7]} << 24U;
}

}  // namespace

extern "C" void tick_handler();
extern "C" void tick_handler() {
  const std::uint32_t entry = mps2::kSystickMask & (kPeriod - mps2::systick_now());
  if (ticks == wanted_ticks) return;
  move_the_axis();
  const std::uint32_t begin = mps2::systick_now();
  application.tick();
  const std::uint32_t end = mps2::systick_now();
  counts.add(instructions(mps2::systick_elapsed(begin, end)), instructions(entry));
  ticks = ticks + 1;
}

int main() {
  char buffer[64];
  const char* words = mps2::command_line(buffer);
  const char* kind = std::strchr(words, ' ');
  const char* number = kind == nullptr ? nullptr : std::strchr(kind + 1, ' ');
  if (number == nullptr || !traffic_of(kind + 1, board.port.traffic)) {
    mps2::uart_write("usage: quiet|foreign|served|hostile FRAMES\n");
    return 1;
  }
  std::uint32_t frames = 0;
  for (++number; *number >= '0' && *number <= '9'; ++number)
    frames = frames * 10 + static_cast<std::uint32_t>(*number - '0');
  wanted_ticks = kSettled + (frames * 10 + 8) / 9;
  board.start();
  application.begin();
  static_cast<void>(application.controller().configure(everything_on(), all_effects()));
  application.serve();
  const std::uint32_t pages = crc32(flash_memory);
  mps2::systick_start_periodic(kPeriod);
  while (board.wait()) application.serve();
  mps2::systick_stop();
  const Traffic traffic = board.port.traffic;
  board.port.traffic = Traffic::kQuiet;
  mps2::uart_write("load");
  tell("ticks", ticks);
  tell("frames", traffic == Traffic::kQuiet ? 0 : board.port.taken());
  tell("least", counts.least);
  tell("most", counts.most);
  tell("mean_e3", static_cast<std::uint32_t>(counts.total * 1000 / ticks));
  tell("checksum", counts.checksum);
  tell("latest_entry", counts.latest_entry);
  tell("received", read(0x2211, 1));
  tell("lost", read(0x2211, 2));
  tell("malformed", read(0x2211, 3));
  tell("aborts", read(0x2211, 4));
  tell("sent", board.port.sent());
  tell("flash_same", crc32(flash_memory) == pages ? 1 : 0);
  tell("model_same", application.controller().parameters().hash == model_hash(all_effects()) ? 1 : 0);
  tell("faults", static_cast<std::uint32_t>(application.controller().state().faults().latched()));
  mps2::uart_write("\n");
  return 0;
}
