// SPDX-License-Identifier: Apache-2.0
// A bare Cortex-M4F that computes a friction force in every tick and prints it in mN. No operating system, no
// heap.
#include <cstdint>
#include <new>

#include "axis.h"

namespace {

std::uint32_t volatile& word_at(std::uint32_t address) {
  return *reinterpret_cast<std::uint32_t volatile*>(address);
}

// The UART of the board (CMSDK): data, state (bit 0: full), control (bit 0: transmit).
constexpr std::uint32_t kUart = 0x40004000U;

void write(char letter) {
  while ((word_at(kUart + 4) & 1U) != 0) {
  }
  word_at(kUart) = static_cast<std::uint32_t>(letter);
}

void write(std::int32_t number) {
  if (number < 0) write('-');
  auto rest = static_cast<std::uint32_t>(number < 0 ? -number : number);
  char digits[10];
  int count = 0;
  do {
    digits[count++] = static_cast<char>('0' + rest % 10U);
    rest /= 10U;
  } while (rest > 0);
  while (count > 0) write(digits[--count]);
  write('\n');
}

// Constructed by run(): nothing here runs constructors before.
using Model = slipstack::FrictionModel<float>;
alignas(Model) unsigned char model_place[sizeof(Model)];

}  // namespace

extern "C" {
extern std::uint32_t __stack_top[];

// In a drive the body of this loop is the timer interrupt: encoder in, force out.
[[noreturn]] void run() {
  Model& model = *new (model_place) Model;
  word_at(kUart + 8) = 1U;
  model.prepare(example::parameters(), example::kScales);
  model.reset({});
  example::Motion motion;
  for (int tick = 0; tick < 200; ++tick) {
    const float force_N = model.step(motion.next()).total_N;
    write(static_cast<std::int32_t>(force_N * 1000.0F));
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

struct Vectors {
  std::uint32_t* stack_top;
  void (*reset)();
};
[[gnu::section(".vectors"), gnu::used]] extern const Vectors kVectors{__stack_top, reset_handler};
