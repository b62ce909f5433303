// SPDX-License-Identifier: Apache-2.0
// The one main of the firmware. SLIPSTACK_BOARD names the board's header, which has `BoardOfImage`; a line in
// the board's CMakeLists.txt sets it.
#include <array>

#include "firmware/app/canopen_node.h"
#include "firmware/app/lockstep/linked_application.h"
#include SLIPSTACK_BOARD

namespace {
using namespace slipstack;  // NOLINT(google-build-using-namespace)

constexpr std::uint8_t kNodeId = 127;  // until LSS gives another

BoardOfImage board;
// Kept out of the working memory: the linker script has a place for it.
[[gnu::section(".trace")]] std::array<canopen::TraceSample, 4096> trace;
CanopenNode node{kNodeId, BoardOfImage::serial_number(), trace};
lockstep::ApplicationFor<BoardOfImage, CanopenNode> application{board, node};
}  // namespace

extern "C" {
void tick_handler();
void tick_handler() {
  board.begin_tick();
  application.tick();
  board.end_tick();
}

// Of lower priority than the tick; boards without these interrupts do nothing in them.
void can_handler();
void can_handler() {
  board.on_can_interrupt();
}
void encoder_handler();
void encoder_handler() {
  board.on_encoder_interrupt();
}
void indicator_handler();
void indicator_handler() {
  board.on_indicator_interrupt();
}
}

int main() {
  return application.run();
}
