// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "hal/host/board.h"
#include "sim_host/log/draw.h"
#include "workbench/can/client/can_link.h"
#include "workbench/can/client/sdo_client.h"
#include "workbench/can/commands/master.h"
#include "workbench/can/host_node/simulated_drive.h"

// The commands' master and a drive around a simulated axis, in one process on one cable.
namespace slipstack::workbench {

/// The master's end of a cable; while it waits the drive's time passes. `meddle` sees the frames to the
/// master and may hold them back, `twist` may change them.
class CableLink final : public CanLink {
 public:
  CableLink(host::HostCanPort& port, SimulatedDrive& drive) : port_(port), drive_(drive) {}
  void send(const CanFrame& frame) override {
    if (!cut) port_.send(frame);
  }
  bool receive(CanFrame& frame, int timeout_ms) override {
    for (int tick = 0; tick <= 10 * timeout_ms; ++tick) {
      while (port_.receive(frame)) {
        if (cut || (meddle && meddle(frame))) continue;
        if (twist) twist(frame);
        return true;
      }
      if (timeout_ms > 0) {
        if (each_tick) each_tick(ticks_);
        drive_.step();
        ++ticks_;
      }
    }
    return false;
  }
  double stamp_s() const override {
    return stamped ? 1.0 + 1e-4 * static_cast<double>(ticks_) + late_s : 0.0;
  }
  std::string name() const override { return "cable"; }
  bool cut = false;
  bool stamped = false;
  double late_s = 0.0;
  std::function<bool(const CanFrame&)> meddle;
  std::function<void(CanFrame&)> twist;
  std::function<void(std::uint64_t)> each_tick;

 private:
  host::HostCanPort& port_;
  SimulatedDrive& drive_;
  std::uint64_t ticks_ = 0;
};

/// A master and a drive around a simulated axis.
struct Desk {
  sim::Bench bench;
  host::HostNonvolatile flash{2, 2048, 8};
  host::HostCanPort device{4096};
  host::HostCanPort port{4096};
  std::unique_ptr<SimulatedDrive> drive;
  std::unique_ptr<CableLink> link;
  std::unique_ptr<SdoClient> client;
  std::uint64_t seed;
  Wiring wiring;
  explicit Desk(std::uint64_t axis_seed = 4)
      : Desk(sim::draw_bench(sim::Setup::kPickAndPlace, axis_seed), axis_seed) {}
  Desk(sim::Bench with, std::uint64_t axis_seed) : bench(std::move(with)), seed(axis_seed) {
    port.connect(device);
    power_on();
  }
  void power_on() {
    drive = std::make_unique<SimulatedDrive>(bench.axis, device, flash, 5, seed, wiring);
    link = std::make_unique<CableLink>(port, *drive);
    client = std::make_unique<SdoClient>(*link, 5);
    for (int i = 0; i < 20; ++i) drive->step();
  }
  /// Profile position mode, operation enabled.
  void enable() {
    client->write(0x6060, 0, 1, 1);
    for (const std::uint32_t word : {6U, 7U, 15U}) {
      client->write(0x6040, 0, word, 2);
      for (int i = 0; i < 20; ++i) drive->step();
    }
  }
};

inline const Show kNoiseless = [](const std::string&, double) {};

}  // namespace slipstack::workbench
