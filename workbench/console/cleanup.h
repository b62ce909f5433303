// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <signal.h>

#include <array>
#include <string>
#include <vector>

namespace slipstack::workbench {

/// Removes files at the end of its life, and when a signal ends the program during it. One at a time.
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

/// Signals that would end the program wait while this lives.
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
