// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tests/bench/observer/observed_axis.h"

namespace slipstack::observer {

/// How the friction is compensated in position mode.
struct Drive {
  const char* name;
  bool compensate = true;
  bool observe = true;
  float disturbance_share = 0.0F;

  void set(AxisParameters& parameters) const;
};
/// Mass alone, model on the reference alone, with the observer; each without and with the disturbance
/// observer.
std::vector<Drive> drives();

/// Moves to and fro, each followed by a pause, and pushes at rest; errors in um over two axes.
struct Visits {
  std::array<Spread, 3> moving;    ///< ways of 10, 1 and 0.1 mm
  std::array<Spread, 3> standing;  ///< the pause behind them
  Spread pushed;                   ///< 5, -10, 20 N for 0.2 s
  Spread left;                     ///< 0.25 to 0.3 s after the push
};
Visits visit(const Drive& drive, double level_error);

/// Moves of 1 mm to and fro with this pause; the error in um in the 50 ms after each reversal.
Spread moves_with_pause(const Drive& drive, double level_error, double pause_s);

/// Torque mode with target 0: a hand leads the axis over 20 mm, half a cycle per second, then lets go.
struct Led {
  Spread hand_N;
  double coast_mps = 0.0;  ///< speed a second after it was let go
};
Led lead(float share, double level_error);

/// What docs/friction-observer.md shows.
std::string table();

}  // namespace slipstack::observer
