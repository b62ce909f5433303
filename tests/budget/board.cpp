// SPDX-License-Identifier: Apache-2.0
// Image that shows what the other images rely on: memory set up, constructors run, FPU on, and that an
// assertion and a fault end the emulator with statuses of their own. check_board.py runs it with each of its
// words.
#undef NDEBUG
#include <cassert>
#include <cstdint>
#include <cstring>

#include "hal/mps2/semihosting.h"
#include "hal/mps2/systick.h"
#include "hal/mps2/uart.h"

namespace {

volatile std::uint32_t from_flash = 0x12345678;  // .data
volatile std::uint32_t zeroed[64];               // .bss

struct Constructed {
  Constructed() : value(from_flash + 1) {}
  volatile std::uint32_t value;
};
Constructed constructed;

// What is wrong, or nullptr.
const char* self_check() {
  if (from_flash != 0x12345678) return ".data was not copied";
  for (const volatile std::uint32_t& word : zeroed) {
    if (word != 0) return ".bss was not zeroed";
  }
  if (constructed.value != 0x12345679) return "constructors did not run";
  volatile float two = 2.0F;
  if (two * 1.5F != 3.0F) return "the FPU does not multiply";
  volatile float smallest = 0x1p-126F;
  if (smallest * 0.5F != 0x1p-127F) return "denormals are flushed";
  slipstack::mps2::systick_start_free();
  const std::uint32_t begin = slipstack::mps2::systick_now();
  if (slipstack::mps2::systick_elapsed(begin, slipstack::mps2::systick_now()) == 0)
    return "SysTick stands still";
  return nullptr;
}

}  // namespace

int main() {
  using namespace slipstack::mps2;
  char buffer[64];
  const char* words = command_line(buffer);
  const char* word = std::strchr(words, ' ');
  word = word == nullptr ? "" : word + 1;
  if (std::strcmp(word, "assert") == 0) assert(from_flash == 0);
  if (std::strcmp(word, "fault") == 0) asm volatile("udf #0");
  if (std::strcmp(word, "status") == 0) return 42;
  const char* wrong = self_check();
  uart_write(wrong == nullptr ? "board: as it should be" : wrong);
  uart_write("\n");
  return wrong == nullptr ? 0 : 1;
}
