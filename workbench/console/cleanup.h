// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <signal.h>

#include <array>
#include <string>
#include <vector>

namespace slipstack::workbench {

/// Removes files when it is destroyed, and when a signal ends the program before that. Only one may exist at
/// a time.
class Cleanup {
 public:
  static constexpr std::size_t kMostFiles = 64;

  explicit Cleanup(std::vector<std::string> files);
  ~Cleanup();
  Cleanup(const Cleanup&) = delete;
  Cleanup& operator=(const Cleanup&) = delete;

 private:
  static constexpr std::array<int, 4> kSignals{SIGINT, SIGTERM, SIGHUP, SIGPIPE};

  std::vector<std::string> files_;
  std::array<struct sigaction, kSignals.size()> before_{};
};

/// Defers all signals as long as it exists.
class SignalsHeld {
 public:
  SignalsHeld();
  ~SignalsHeld();
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace slipstack::workbench
