// SPDX-License-Identifier: Apache-2.0
// The host's end of the lock-step loop with an emulated board.
#pragma once

#include <sys/types.h>
#include <cstdint>
#include <string>

#include "hal/include/plant_link.h"

namespace slipstack::sim {

/// An emulator that runs an image and shares the guest's PSRAM. The emulator ends with this object, and with
/// this process however that ends.
class EmulatedBoard {
 public:
  /// Starts `qemu-system-arm -M <machine>`. Throws std::runtime_error in one line when the image or the
  /// emulator is missing, or the image does not answer within `start_timeout_s`.
  EmulatedBoard(const std::string& machine, const std::string& image, double start_timeout_s = 10.0);
  ~EmulatedBoard();
  EmulatedBoard(const EmulatedBoard&) = delete;
  EmulatedBoard& operator=(const EmulatedBoard&) = delete;

  PlantLink& link() { return *link_; }
  /// Lets the guest run one tick with the words written before. Throws when the emulator ended or does not
  /// answer within `timeout_s`.
  void tick(double timeout_s = 2.0);
  /// Process of the emulator.
  pid_t process() const { return process_; }

 private:
  bool ended();
  void release();

  std::string memory_path_;
  PlantLink* link_ = nullptr;
  pid_t process_ = -1;
};

}  // namespace slipstack::sim
