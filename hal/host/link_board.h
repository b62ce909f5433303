// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/host/board.h"
#include "hal/plant_link/drivers.h"

namespace slipstack::host {

/// A link in this process: a base, because it must exist before the devices on it.
struct PlantLinkStorage {
  PlantLink own_link{};
};

/// A board in this process whose encoder and motor are those of a simulated plant at the other end of its
/// PlantLink, as on the emulated boards.
class LinkBoard : private PlantLinkStorage, public LinkDevices {
 public:
  LinkBoard() : LinkDevices(own_link) {}

  CanPort& can() { return can_; }
  Nonvolatile& nonvolatile() { return flash_; }
  Indicator& indicator() { return indicator_; }
  bool start() { return true; }
  bool wait() { return true; }

 private:
  HostCanPort can_;
  HostNonvolatile flash_{2, 2048, 8};
  HostIndicator indicator_;
};

}  // namespace slipstack::host
