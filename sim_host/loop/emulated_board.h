// SPDX-License-Identifier: Apache-2.0
// The host's end of the lock-step loop with an emulated board.
#pragma once

#include <sched.h>
#include <sys/types.h>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "hal/plant_link/plant_link.h"
#include "sim_host/loop/lockstep_board.h"

namespace slipstack::sim {

/// An emulator that runs an image and shares the guest's PSRAM. The emulator ends with this object, and with
/// this process however that ends; nothing remains in the file system. During its life the thread that
/// constructed it is bound to one processor and the emulator to the others.
class EmulatedBoard final : public LockstepBoard {
 public:
  struct Options {
    double start_timeout_s = 10.0;
    double tick_timeout_s = 2.0;
    /// What the board's CAN, SLCAN on its UART1, is connected to: a character device of the emulator, as
    /// "unix:PATH,server=on,wait=off" or "pty" (can_terminal() gives its name); "null": nothing.
    std::string can = "null";
    /// Content of its flash at the start: the pages, one behind the other. Empty: erased.
    std::span<const std::byte> pages{};
    /// Program to start; tests give the name of a program that does not exist.
    std::string emulator = "qemu-system-arm";
  };

  /// Starts the emulator of `machine`, mps2-an386 or mps2-an500, with an image. Throws LoopError in one line
  /// when the image or the emulator is missing, or the image does not answer in time.
  EmulatedBoard(const std::string& machine, const std::string& image, const Options& options);
  EmulatedBoard(const std::string& machine, const std::string& image)
      : EmulatedBoard(machine, image, Options{}) {}
  ~EmulatedBoard() override;
  EmulatedBoard(const EmulatedBoard&) = delete;
  EmulatedBoard& operator=(const EmulatedBoard&) = delete;

  PlantLink& link() override { return *link_; }
  void tick() override;
  /// The board's flash: its marker, then its pages.
  std::span<std::byte> flash() {
    return {reinterpret_cast<std::byte*>(link_) + PlantMemory::kFlashOffset,
            PlantMemory::kBytes - PlantMemory::kFlashOffset};
  }
  /// The pseudo-terminal on which the board speaks SLCAN, if it was started with "pty".
  const std::string& can_terminal() const { return can_terminal_; }
  /// Process of the emulator.
  pid_t process() const { return process_; }

 private:
  bool ended();
  void release();
  void fill_flash();
  void find_terminal();
  [[noreturn]] void refuse(const std::string& machine, const std::string& image);

  Options options_;
  int memory_ = -1;
  int output_ = -1;  ///< read end of the emulator's output
  std::string can_terminal_;
  PlantLink* link_ = nullptr;
  pid_t process_ = -1;
  cpu_set_t processors_{};  // that the thread could use before
  int status_ = 0;          // of the process, once it has ended
};

}  // namespace slipstack::sim
