// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace slipstack::workbench {

/// One line on a terminal's standard error that says what is going on and for how long, from the first half
/// second of work; silent when nobody watches.
class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// What is being done; `fraction` of it that is done, negative where nobody can say. From any thread.
  void show(const std::string& stage, double fraction = -1.0);

  /// Removes the line, for good: before anything else is printed.
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
  std::thread painter_;  ///< only when somebody watches
};

}  // namespace slipstack::workbench
