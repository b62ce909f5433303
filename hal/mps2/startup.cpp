// SPDX-License-Identifier: Apache-2.0
// Reset, vectors and faults of the emulated board MPS2 (AN386).
#include <cstddef>
#include <cstdint>

#include "hal/mps2/semihosting.h"
#include "hal/mps2/uart.h"

int main();

extern "C" {
// From the linker script toolchain/ld/mps2-an386.ld.
extern std::uint32_t __data_load[], __data_begin[], __data_end[];  // NOLINT(bugprone-reserved-identifier)
extern std::uint32_t __bss_begin[], __bss_end[];                   // NOLINT(bugprone-reserved-identifier)
extern std::uint32_t __stack_top[];                                // NOLINT(bugprone-reserved-identifier)
using Constructor = void (*)();
extern Constructor __init_array_begin[], __init_array_end[];  // NOLINT(bugprone-reserved-identifier)

[[noreturn]] void start_program();
[[noreturn]] void fault_handler();
void reset_handler();
void sys_tick_handler();
void tick_handler();

// The FPU is off after reset, and a prologue that saves its registers would fault: no prologue here.
// CPACR, CP10 and CP11 full access: Armv7-M Architecture Reference Manual, B3.2.20.
__attribute__((naked, noreturn, used)) void reset_handler() {
  asm volatile(
      "ldr r0, =0xE000ED88 \n"
      "ldr r1, [r0]        \n"
      "orr r1, #0xF00000   \n"
      "str r1, [r0]        \n"
      "dsb                 \n"
      "isb                 \n"
      "b start_program     \n");
}

// Fills RAM, runs the constructors, runs main and ends with its status. Word loops of our own: memcpy may be
// compiled to use what is not ready yet.
__attribute__((used, optimize("no-tree-loop-distribute-patterns"))) void start_program() {
  const std::uint32_t* from = __data_load;
  for (std::uint32_t* to = __data_begin; to < __data_end; ++to, ++from) *to = *from;
  for (std::uint32_t* to = __bss_begin; to < __bss_end; ++to) *to = 0;
  for (const Constructor* constructor = __init_array_begin; constructor < __init_array_end; ++constructor) {
    (*constructor)();
  }
  slipstack::mps2::exit_emulator(main());
}

// Any fault or unexpected exception ends the run with a status of its own; which one is in the line printed.
__attribute__((used)) void fault_handler() {
  std::uint32_t exception = 0;
  asm volatile("mrs %0, ipsr" : "=r"(exception));
  slipstack::mps2::uart_write("fault: exception ");
  slipstack::mps2::uart_write_unsigned(exception);
  slipstack::mps2::uart_write("\n");
  slipstack::mps2::exit_emulator(slipstack::mps2::kExitFault);
}

// Replaced by the application that uses the tick.
__attribute__((weak, used)) void tick_handler() {}
__attribute__((used)) void sys_tick_handler() {
  tick_handler();
}

using Vector = void (*)();
struct VectorTable {
  const std::uint32_t* stack_top;
  Vector reset;
  Vector system[14];      // NMI ... SysTick, exceptions 2 ... 15
  Vector interrupts[32];  // AN386 table 3-4
};

__attribute__((section(".vectors"), used)) const VectorTable kVectorTable = {
    __stack_top,
    reset_handler,
    {fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler,
     fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler,
     sys_tick_handler},
    {fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler,
     fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler,
     fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler,
     fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler,
     fault_handler, fault_handler, fault_handler, fault_handler},
};

// newlib's own __assert_func prints through stdio, which brings malloc in.
[[noreturn]] void __assert_func(const char* file, int line, const char* function, const char* expression) {
  using slipstack::mps2::uart_write;
  uart_write(file);
  uart_write(":");
  slipstack::mps2::uart_write_unsigned(static_cast<std::uint32_t>(line));
  uart_write(": ");
  uart_write(function == nullptr ? "" : function);
  uart_write(": assertion failed: ");
  uart_write(expression);
  uart_write("\n");
  slipstack::mps2::exit_emulator(slipstack::mps2::kExitAssertion);
}

// A pure virtual call and the end of the program go nowhere else.
[[noreturn]] void __cxa_pure_virtual() {
  slipstack::mps2::uart_write("pure virtual call\n");
  slipstack::mps2::exit_emulator(slipstack::mps2::kExitFault);
}

[[noreturn]] void abort() {
  slipstack::mps2::uart_write("abort\n");
  slipstack::mps2::exit_emulator(slipstack::mps2::kExitAssertion);
}
}  // extern "C"
