// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/host/board.h"
#include "hal/plant_link/drivers.h"

namespace slipstack::host {

/// A board in this process whose encoder and motor are those of a simulated plant at the other end of its
/// PlantLink, as on the emulated boards.
class LinkBoard {
 public:
  PlantLink& link() { return link_; }
  LinkEncoder& encoder() { return encoder_; }
  LinkMotor& motor_current() { return motor_; }
  LinkClock& clock() { return clock_; }
  LinkWatchdog& watchdog() { return watchdog_; }
  CanPort& can() { return can_; }
  Nonvolatile& nonvolatile() { return flash_; }
  Indicator& indicator() { return indicator_; }
  std::uint32_t tick_period() const { return 0; }
  bool start() { return true; }
  bool wait() { return true; }

 private:
  PlantLink link_{};
  LinkEncoder encoder_{link_};
  LinkMotor motor_{link_};
  LinkClock clock_{link_};
  LinkWatchdog watchdog_{link_};
  HostCanPort can_;
  HostNonvolatile flash_{2, 2048, 8};
  HostIndicator indicator_;
};

}  // namespace slipstack::host
