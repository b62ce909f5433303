// SPDX-License-Identifier: Apache-2.0
// A bare Cortex-M4F that computes a friction force in every tick and prints it in mN: no system, no heap.
#include <charconv>
#include <cstdint>

#include "axis.h"

namespace {

std::uint32_t volatile& word_at(std::uint32_t address) {
  return *reinterpret_cast<std::uint32_t volatile*>(address);
}

// The UART of the board (CMSDK): data, state (bit 0: full), control (bit 0: transmit).
constexpr std::uint32_t kUart = 0x40004000U;

void write_line(std::int32_t number) {
  char text[12];
  char* const end = std::to_chars(text, text + 11, number).ptr;
  *end = '\n';
  for (const char* letter = text; letter <= end; ++letter) {
    while ((word_at(kUart + 4) & 1U) != 0) {
    }
    word_at(kUart) = static_cast<std::uint32_t>(*letter);
  }
}

}  // namespace

extern "C" {
extern std::uint32_t __stack_top[];

// In a drive the body of this loop is the timer interrupt: encoder in, force out.
[[noreturn]] void run() {
  word_at(kUart + 8) = 1U;
  slipstack::FrictionModel<float> model;
  model.prepare(example::parameters(), example::kScales);
  model.reset({});
  example::Motion motion;
  for (int tick = 0; tick < 200; ++tick) {
    const float force_N = model.step(motion.next()).total_N;
    write_line(static_cast<std::int32_t>(force_N * 1000.0F));
  }
  // Semihosting: ends the emulator (SYS_EXIT, ADP_Stopped_ApplicationExit).
  asm volatile("mov r0, #0x18\n ldr r1, =0x20026\n bkpt 0xAB" ::: "r0", "r1", "memory");
  for (;;) {
  }
}

// Switches the FPU on before anything uses it (CPACR, full access to CP10 and CP11).
[[gnu::naked]] void reset_handler() {
  asm volatile("ldr r0, =0xE000ED88\n ldr r1, [r0]\n orr r1, #0xF00000\n str r1, [r0]\n dsb\n isb\n b run");
}
}

// The first two words of the flash: stack, and where the processor starts.
[[gnu::section(".vectors"), gnu::used]] extern const struct {
  std::uint32_t* stack_top;
  void (*reset)();
} kVectors{__stack_top, reset_handler};
