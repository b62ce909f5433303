// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace slipstack::workbench {

/// Options of `slipstack node`; empty texts where an option was not given.
struct NodeRequest {
  std::string board = "host";
  std::string image;
  std::string can;  ///< --board host only
  int node = 5;
  std::int64_t seed = 1;
  std::string effects = "none";  ///< of the axis, beside mass and hysteresis
  double strength = 0.0;         ///< over the noise floor; 0: drawn
  std::string flash;             ///< file with the content of the flash
  double pace = 1.0;             ///< of the node's time, over the clock's
  std::string reversed;          ///< of the machine's wiring: encoder, motor or nothing; --board host only
};

/// Runs the firmware as a CANopen node around a simulated axis, in real time, until it is interrupted: in
/// this process on a CAN interface, or as the image of an emulated board whose UART speaks SLCAN on a
/// pseudo-terminal. Throws UsageError and InputError (status 2), RunError when the interface or the emulator
/// goes away.
void run_node(const NodeRequest& request);

}  // namespace slipstack::workbench
