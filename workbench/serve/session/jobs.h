// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "workbench/base/cancel.h"
#include "workbench/console/progress.h"
#include "workbench/serve/http/events.h"

namespace slipstack::workbench {

/// The long work of the session: one job at a time, in a thread of its own, with progress, cancellation and a
/// last message for the page. A job that fails or is cancelled changes nothing.
class Jobs {
 public:
  using Work = std::function<void(Progress&)>;

  explicit Jobs(Events& events) : events_(events) {}
  ~Jobs();
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;

  /// Starts a job. Throws UsageError while another one runs.
  void start(const std::string& what, Work work);
  /// Asks the running job to end; it ends at its next check (base/cancel.h).
  void cancel();
  bool running() const;
  /// Called within a job: from here on its thread, and those that it starts, give way to the answers that the
  /// pages wait for. What a page waits for itself should be done before.
  static void give_way();
  /// {running, what, stage, fraction, elapsed_s, error, outcome}: outcome is done, failed or cancelled.
  nlohmann::json to_json() const;

 private:
  void run(const Work& work);
  void show(const std::string& stage, double fraction);

  Events& events_;
  mutable std::mutex lock_;
  std::thread thread_;
  std::shared_ptr<CancelToken> token_;
  bool running_ = false;
  std::string what_;
  std::string stage_;
  double fraction_ = -1.0;
  std::string error_;
  std::string outcome_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace slipstack::workbench
