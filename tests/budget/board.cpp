// SPDX-License-Identifier: Apache-2.0
// Image that shows what the other images rely on: memory set up, constructors run, FPU on and computing as
// the host does, in main and in an exception, and that an assertion and a fault end the emulator with
// statuses of their own. check_board.py runs it with each of its words.
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

// Whether the FPU rounds to nearest and keeps denormals: by its register, and by what it computes.
bool computes_as_the_host() {
  std::uint32_t mode = 0;
  asm volatile("vmrs %0, fpscr" : "=r"(mode));
  constexpr std::uint32_t kControl = 0x07C00000;  // AHP, DN, FZ, RMode
  volatile float smallest = 0x1p-126F;
  volatile float denormal = 0x1p-149F;
  volatile float one = 1.0F;
  volatile float less_than_half = 0x1.8p-25F;
  volatile float more_than_half = 0x1.8p-24F;
  return (mode & kControl) == 0 && smallest * 0.5F == 0x1p-127F && denormal * 2.0F == 0x1p-148F &&
         one + less_than_half == 1.0F && one + more_than_half == 1.0F + 0x1p-23F &&
         -one - less_than_half == -1.0F && -one - more_than_half == -1.0F - 0x1p-23F;
}

volatile std::uint32_t exceptions = 0;
volatile bool exception_computes_as_the_host = false;

// What is wrong, or nullptr.
const char* self_check() {
  if (from_flash != 0x12345678) return ".data was not copied";
  for (const volatile std::uint32_t& word : zeroed) {
    if (word != 0) return ".bss was not zeroed";
  }
  if (constructed.value != 0x12345679) return "constructors did not run";
  volatile float two = 2.0F;
  if (two * 1.5F != 3.0F) return "the FPU does not multiply";
  if (!computes_as_the_host()) return "main: rounding or denormals are not the host's";
  slipstack::mps2::systick_start_periodic(10000);
  while (exceptions == 0) asm volatile("");
  slipstack::mps2::systick_stop();
  if (!exception_computes_as_the_host) return "exception: rounding or denormals are not the host's";
  if (!computes_as_the_host()) return "main after an exception: rounding or denormals are not the host's";
  slipstack::mps2::systick_start_free();
  const std::uint32_t begin = slipstack::mps2::systick_now();
  if (slipstack::mps2::systick_elapsed(begin, slipstack::mps2::systick_now()) == 0)
    return "SysTick stands still";
  return nullptr;
}

}  // namespace

extern "C" void tick_handler();
extern "C" void tick_handler() {
  exception_computes_as_the_host = computes_as_the_host();
  exceptions = exceptions + 1;
}

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
