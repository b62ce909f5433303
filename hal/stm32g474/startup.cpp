// SPDX-License-Identifier: Apache-2.0
// Reset, vectors and faults of the STM32G474.
#include <cstddef>
#include <cstdint>

#include "hal/cortex_m/start.h"
#include "hal/stm32g474/board.h"
#include "hal/stm32g474/peripherals.h"
#include "hal/stm32g474/safe_outputs.h"

int main();

extern "C" {
// From the linker script: the table below, at the begin of a slot or of the flash.
extern std::uint32_t __vectors_begin[];  // NOLINT(bugprone-reserved-identifier)
void nmi_handler();
[[noreturn]] void fault_handler();
void indicator_handler();
void tick_handler();
void can_handler();
void encoder_handler();

// Outputs safe before the milliseconds that filling RAM takes; then the constructors and main. A main that
// returns is a fault.
__attribute__((used)) void start_program() {
  slipstack::stm32g474::force_safe_state();
  slipstack::cortex_m::fill_memory();
  // After a jump from a boot loader it still points to that one's table.
  slipstack::stm32g474::hardware_word(slipstack::stm32g474::kVectorTable) =
      reinterpret_cast<std::uint32_t>(__vectors_begin);
  slipstack::cortex_m::run_constructors();
  static_cast<void>(main());
  fault_handler();
}

// A fault, an unexpected interrupt, a failed assertion: power stage off at once; then the watchdog, if it
// runs, starts the controller anew within its time-out.
__attribute__((used)) void fault_handler() {
  asm volatile("cpsid i" ::: "memory");
  slipstack::stm32g474::force_safe_state();
  for (;;) asm volatile("");
}

// Either a word of the parameter pages that power left half written, which its reader deals with; or the
// crystal has stopped (clock security system), or the program's flash is bad.
__attribute__((used)) void nmi_handler() {
  using namespace slipstack::stm32g474;  // NOLINT(google-build-using-namespace)
  if (!on_flash_nmi(hardware<Flash>(kFLASH_BASE), careful_read)) fault_handler();
}

// Replaced by the application. An interrupt without a handler is a fault.
__attribute__((weak, used)) void indicator_handler() {
  fault_handler();
}
__attribute__((weak, used)) void tick_handler() {
  fault_handler();
}
__attribute__((weak, used)) void can_handler() {
  fault_handler();
}
__attribute__((weak, used)) void encoder_handler() {
  fault_handler();
}

using Vector = void (*)();
struct VectorTable {
  const std::uint32_t* stack_top;
  Vector system[15];       // reset, NMI ... SysTick: exceptions 1 ... 15
  Vector interrupts[102];  // RM0440, NVIC, vector table
};

constexpr VectorTable make_vector_table() {
  VectorTable table{__stack_top, {}, {}};
  for (Vector& vector : table.system) vector = fault_handler;
  for (Vector& vector : table.interrupts) vector = fault_handler;
  table.system[0] = reset_handler;
  table.system[1] = nmi_handler;
  table.system[14] = indicator_handler;
  table.interrupts[slipstack::stm32g474::kTIM6_DAC_IRQ] = tick_handler;
  table.interrupts[slipstack::stm32g474::kFDCAN1_IT0_IRQ] = can_handler;
  table.interrupts[slipstack::stm32g474::kDMA1_Channel1_IRQ] = encoder_handler;
  return table;
}
extern constinit const VectorTable kVectors;
__attribute__((section(".vectors"), used)) constinit const VectorTable kVectors = make_vector_table();

// The names below are the C library's and the C++ ABI's. NOLINTBEGIN(readability-identifier-naming)
// newlib's own __assert_func prints through stdio, which brings malloc in.
[[noreturn]] void __assert_func(const char* /*file*/, int /*line*/, const char* /*function*/,
                                const char* /*expression*/) {
  fault_handler();
}

// A pure virtual call and the end of the program go nowhere else.
[[noreturn]] void __cxa_pure_virtual() {
  fault_handler();
}

[[noreturn]] void abort() {
  fault_handler();
}
// NOLINTEND(readability-identifier-naming)
}  // extern "C"
