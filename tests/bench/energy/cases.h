// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tests/bench/energy/machine.h"

namespace slipstack::energy {

enum class Drive402 : std::uint8_t {
  kProfilePosition,
  kProfileVelocity,
  kCyclicPosition,
  kCyclicVelocity,
  kCyclicTorque
};

struct Case {
  std::string name;
  Drive402 mode = Drive402::kProfilePosition;
  Failure failure{};
  /// What the master still sends after the fault.
  bool master_silent = false;
  bool sync_lost = false;
  bool has_limit = true;  ///< 607Dh
  bool has_switch = false;
  double force = 0.0;    ///< in torque mode, per thousand of the rated force
  double ahead_m = 0.0;  ///< in cyclic position, of the set-points from the first one on
  /// Largest energy at the end stop that is accepted, with brake and without; J.
  double most_J = 0.0;
  double most_without_J = 0.0;
};

std::vector<Case> cases();

/// The carriage runs at 2 m/s towards the end; the fault comes where a stop must begin, not to pass the
/// software limit.
Outcome run(const Case& one, bool has_brake);

/// All of them as a table, aligned.
std::string table();

}  // namespace slipstack::energy
