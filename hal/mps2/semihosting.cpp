// SPDX-License-Identifier: Apache-2.0
#include "hal/mps2/semihosting.h"

#include <cstdint>

namespace slipstack::mps2 {

namespace {

// Operation numbers and arguments: "Semihosting for AArch32 and AArch64", Arm, version 2.0.
constexpr std::uint32_t kGetCommandLine = 0x15;
constexpr std::uint32_t kExitExtended = 0x20;
constexpr std::uint32_t kApplicationExit = 0x20026;

std::uint32_t call(std::uint32_t operation, void* arguments) {
  register std::uint32_t r0 asm("r0") = operation;
  register void* r1 asm("r1") = arguments;
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

}  // namespace

void exit_emulator(int status) {
  std::uint32_t arguments[2] = {kApplicationExit, static_cast<std::uint32_t>(status)};
  for (;;) call(kExitExtended, arguments);
}

const char* command_line(std::span<char> buffer) {
  struct {
    char* buffer;
    std::uint32_t size;
  } arguments = {buffer.data(), static_cast<std::uint32_t>(buffer.size())};
  if (buffer.empty()) return "";
  if (call(kGetCommandLine, &arguments) != 0) buffer[0] = '\0';
  return buffer.data();
}

}  // namespace slipstack::mps2
