// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <signal.h>

#include <array>
#include <atomic>
#include <stdexcept>

namespace slipstack::workbench {

/// The user stopped the run; what() names the file of the intermediate result. Exit status 130, as a shell
/// counts Ctrl-C.
struct Stopped : std::runtime_error {
  using std::runtime_error::runtime_error;
};
inline constexpr int kStoppedStatus = 130;

/// During the life of this object the first Ctrl-C (or SIGTERM) asks to stop instead of ending the program;
/// the second ends it. At most one object at a time.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  static const std::atomic<bool>& flag();

 private:
  static constexpr std::array<int, 2> kSignals{SIGINT, SIGTERM};
  std::array<struct sigaction, kSignals.size()> before_{};
};

}  // namespace slipstack::workbench
