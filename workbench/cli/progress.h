// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <mutex>
#include <string>

namespace slipstack::workbench {

/// One line on a terminal's standard error that says what is going on, from the first half second of work;
/// silent when nobody watches.
class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `fraction` of the stage that is done; may be called from any thread.
  void show(const std::string& stage, double fraction);

 private:
  using Clock = std::chrono::steady_clock;
  bool watched_;
  bool shown_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;
  std::mutex lock_;
};

}  // namespace slipstack::workbench
