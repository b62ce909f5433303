// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "firmware/app/application.h"
#include "hal/host/board.h"
#include "hal/lockstep/drivers.h"
#include "hal/lockstep/link_service.h"

namespace slipstack::host {

/// The firmware's application in this process, in lock-step through a PlantLink as on the emulated board: the
/// same tick, the same service of the link, no emulator.
template <Node N>
class LinkedApplication {
 public:
  explicit LinkedApplication(N& node) : application_(board_, node) { application_.begin(); }

  PlantLink& link() { return board_.link; }
  /// One turn: what is asked, the tick, what is told.
  void tick() {
    application_.serve();
    board_.service.take(application_.controller());
    board_.link_clock.turn();
    application_.tick();
    board_.service.publish(application_.controller(), application_.timing());
    board_.link.guest_sequence = board_.link.host_sequence;
  }
  Controller& controller() { return application_.controller(); }

 private:
  struct LinkBoard {
    lockstep::LinkEncoder& encoder() { return link_encoder; }
    lockstep::LinkMotor& motor_current() { return link_motor; }
    lockstep::LinkClock& clock() { return link_clock; }
    lockstep::LinkWatchdog& watchdog() { return link_watchdog; }
    CanPort& can() { return can_port; }
    Nonvolatile& nonvolatile() { return flash; }
    Indicator& indicator() { return lamp; }
    std::uint32_t tick_period() const { return 0; }
    bool start() { return true; }
    bool wait(Controller&, const TickTiming&) { return true; }

    PlantLink link{};
    lockstep::LinkEncoder link_encoder{link};
    lockstep::LinkMotor link_motor{link};
    lockstep::LinkClock link_clock{link};
    lockstep::LinkWatchdog link_watchdog{link};
    lockstep::LinkService service{link};
    HostCanPort can_port;
    HostNonvolatile flash{2, 2048, 8};
    HostIndicator lamp;
  };

  LinkBoard board_;
  Application<LinkBoard, N> application_;
};

}  // namespace slipstack::host
