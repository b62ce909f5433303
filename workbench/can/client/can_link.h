// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "hal/include/can_port.h"

namespace slipstack::workbench {

/// A bus, used by a master: a CAN interface of this machine, or a node in this process (tests).
class CanLink {
 public:
  virtual ~CanLink() = default;
  /// Throws UsageError when the bus does not accept the frame.
  virtual void send(const CanFrame& frame) = 0;
  /// The next frame within this time, else false.
  virtual bool receive(CanFrame& frame, int timeout_ms) = 0;
  /// Only frames with these 11-bit identifiers are received from now on, so that a busy bus costs little
  /// time.
  virtual void listen_to(std::span<const std::uint32_t>) {}
  /// Time stamp of the frame received last, seconds since an arbitrary fixed time; 0: not known.
  virtual double stamp_s() const { return 0.0; }
  virtual std::string name() const = 0;
};

}  // namespace slipstack::workbench
