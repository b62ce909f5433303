// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <type_traits>

// Which mutant runs. rewrite.py puts this header before the copies that it makes of the firmware's.
namespace slipstack::mutation {

inline constexpr std::uint32_t kMost = 4096;

/// The mutant that this process runs; 0: none, the code as it is.
inline const std::uint32_t chosen = [] {
  const char* text = std::getenv("SLIPSTACK_MUTANT");
  return text == nullptr ? 0U : static_cast<std::uint32_t>(std::strtoul(text, nullptr, 10));
}();

/// Which mutants the process came past: a byte for each, in the file SLIPSTACK_MUTANTS_PASSED where it is
/// set. The process may end in any way.
inline std::uint8_t* const passed = [] {
  static std::uint8_t own[kMost];
  const char* path = std::getenv("SLIPSTACK_MUTANTS_PASSED");
  if (path == nullptr) return own;
  const int file = ::open(path, O_RDWR | O_CREAT, 0600);
  if (file < 0 || ::ftruncate(file, kMost) != 0) std::abort();
  void* const memory = ::mmap(nullptr, kMost, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (memory == MAP_FAILED) std::abort();
  return static_cast<std::uint8_t*>(memory);
}();

inline bool ask(std::uint32_t mutant) {
  if (passed != nullptr) passed[mutant] = 1;
  return mutant == chosen;
}

/// Whether this mutant runs. Never where the compiler computes: a mutant is the same program.
constexpr bool active(std::uint32_t mutant) {
  if (std::is_constant_evaluated()) return false;
  return ask(mutant);
}

}  // namespace slipstack::mutation
