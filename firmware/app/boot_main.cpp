// SPDX-License-Identifier: Apache-2.0
// The one main of the boot loader: starts one of two programs (firmware/update/boot_choice.h). It has no bus
// and writes nothing but notes. SLIPSTACK_BOARD names the board's header, which has `BootBoard`.
#include "firmware/update/boot_choice.h"
#include SLIPSTACK_BOARD

int main() {
  slipstack::BootBoard board;
  board.start();
  const std::optional<std::size_t> slot = slipstack::update::decide(board.programs());
  if (slot) board.run(board.programs().address(*slot) + slipstack::update::kHeaderBlock);
  board.stay();
}
