// SPDX-License-Identifier: Apache-2.0
// A program for a slot of the emulated board: what the firmware does of an update, without the rest. The host
// says in the shared memory what it shall do (check_boot.py). It ends the emulator once it has nothing to do.
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/update/program_writer.h"
#include "firmware/update/trial_watch.h"
#include "hal/mps2/program_memory.h"
#include "hal/mps2/semihosting.h"
#include "hal/mps2/uart.h"

namespace {
using namespace slipstack;          // NOLINT(google-build-using-namespace)
using namespace slipstack::update;  // NOLINT(google-build-using-namespace)

// Behind the flash and its supply; the update file follows at kFile.
struct Orders {
  volatile std::uint32_t file_bytes;  // not 0: an update is there; taken once
  volatile std::uint32_t silent;      // bit n: the program in slot n does not report in
  volatile std::uint32_t crashes;     // bit n: the program in slot n faults at once
};
constexpr std::uint32_t kOrders = mps2::kProgramSupply + 64;
constexpr std::uint32_t kFile = mps2::kProgramFlash + 0x100000;
constexpr std::size_t kPiece = 889;  // a block of an SDO block transfer
constexpr int kExitRefused = 77;

// As 1F50h and 1F51h give it.
UpdateFault load(ProgramMemory& memory, std::span<const std::byte> file) {
  ProgramWriter writer(memory);
  UpdateFault fault = writer.clear();
  while (fault == UpdateFault::kNone && writer.clearing()) fault = writer.step();
  if (fault == UpdateFault::kNone) fault = writer.begin();
  while (fault == UpdateFault::kNone && !file.empty()) {
    const auto part = file.first(std::min(kPiece, file.size()));
    fault = writer.write(part);
    file = file.subspan(part.size());
  }
  if (fault == UpdateFault::kNone) fault = writer.finish();
  return fault == UpdateFault::kNone ? writer.install() : fault;
}

void print(const char* text, std::uint32_t number) {
  mps2::uart_write(text);
  mps2::uart_write_unsigned(number);
  mps2::uart_write("\n");
}
}  // namespace

int main() {
  auto& orders = *reinterpret_cast<Orders*>(kOrders);
  const std::size_t slot =
      reinterpret_cast<std::uintptr_t>(&main) >= mps2::kProgramFlash + mps2::kProgramBankBytes ? 1 : 0;
  const std::uint32_t bit = 1U << slot;
  print("program in slot ", static_cast<std::uint32_t>(slot));
  if ((orders.crashes & bit) != 0) asm volatile("udf #0");

  mps2::EmulatedProgramMemory memory(slot);
  TrialWatch watch(memory);
  constexpr std::uint32_t kStep_us = 100'000;
  constexpr std::uint32_t kLongest_us = TrialWatch::kGiveUp_us + TrialWatch::kReport_us;
  for (std::uint32_t now_us = 0; now_us <= kLongest_us && watch.state() != SlotState::kConfirmed;
       now_us += kStep_us) {
    watch.step(now_us, (orders.silent & bit) == 0, true);
  }
  print("state ", static_cast<std::uint32_t>(watch.state()));
  if (orders.file_bytes == 0) return 0;
  const std::span file(reinterpret_cast<const std::byte*>(kFile), orders.file_bytes);
  orders.file_bytes = 0;
  const UpdateFault fault = load(memory, file);
  print("update ", static_cast<std::uint32_t>(fault));
  if (fault != UpdateFault::kNone) return kExitRefused;
  memory.restart();
}
