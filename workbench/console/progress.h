// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

namespace slipstack::workbench {

/// One line on the terminal (standard error) that shows the stage of the work and the elapsed time, after the
/// first half second. Shows nothing where standard error is not a terminal.
class Progress {
 public:
  using Listener = std::function<void(const std::string& stage, double fraction)>;

  Progress();
  /// Tells `listener` instead of the terminal, at every show().
  explicit Progress(Listener listener) : listener_(std::move(listener)) {}
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Sets the stage of the work and the `fraction` of it that is done, negative where it is not known. May be
  /// called from any thread. Throws Cancelled where the work is no longer wanted (base/cancel.h).
  void show(const std::string& stage, double fraction = -1.0);

  /// Removes the line for good; to be called before anything else is printed.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  void draw();
  void run();

  const Clock::time_point start_ = Clock::now();
  std::mutex lock_;
  std::condition_variable wake_;
  bool done_ = false;
  bool shown_ = false;
  std::string stage_;
  double fraction_ = -1.0;
  Listener listener_;
  std::thread painter_;  ///< runs only where standard error is a terminal
};

}  // namespace slipstack::workbench
