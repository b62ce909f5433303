// SPDX-License-Identifier: Apache-2.0
// Reset, vectors and faults of the emulated board MPS2 (AN386).
#include <cstddef>
#include <cstdint>

#include "hal/cortex_m/start.h"
#include "hal/mps2/semihosting.h"
#include "hal/mps2/uart.h"

int main();

extern "C" {
[[noreturn]] void fault_handler();
void sys_tick_handler();
void tick_handler();

using Vector = void (*)();
struct VectorTable {
  const std::uint32_t* stack_top;
  Vector reset;
  Vector system[14];      // NMI ... SysTick, exceptions 2 ... 15
  Vector interrupts[32];  // AN386 table 3-4
};
extern const VectorTable kVectorTable;

// Fills RAM, runs the constructors, runs main and ends with its status. After a jump from a boot loader VTOR
// (Armv7-M Architecture Reference Manual, B3.2.5) still points to that one's table.
__attribute__((used)) void start_program() {
  slipstack::cortex_m::fill_memory();
  *reinterpret_cast<volatile std::uint32_t*>(0xE000ED08U) = reinterpret_cast<std::uint32_t>(&kVectorTable);
  slipstack::cortex_m::run_constructors();
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

// The names below are the C library's and the C++ ABI's. NOLINTBEGIN(readability-identifier-naming)
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
// NOLINTEND(readability-identifier-naming)
}  // extern "C"
