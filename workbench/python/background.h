// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "workbench/base/cancel.h"
#include "workbench/console/progress.h"

namespace slipstack::workbench {

/// A command in a thread of its own, so that the thread that waits for it can look at signals meanwhile. In
/// one program one command works at a time, since the units of the axis are those of the program
/// (base/axis_units.h); the others wait. Each begins without an axis.
class Background {
 public:
  /// A stage of the work, and the fraction of it that is done; negative where it is not known.
  struct Stage {
    std::string name;
    double fraction = -1.0;
  };

  explicit Background(std::function<void(Progress&)> work);
  /// Cancels the work and waits for its end.
  ~Background();
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  /// Waits for news, for a twentieth of a second at most; replaces `stages` by what the work has shown since.
  /// True when the work has ended and all of its stages were given.
  bool wait(std::vector<Stage>& stages);

  /// Asks the work to end and waits until it has (base/cancel.h).
  void cancel();

  /// Throws what the work has thrown. After its end.
  void rethrow() const;

 private:
  void run(const std::function<void(Progress&)>& work);
  void show(const std::string& stage, double fraction);

  CancelToken token_;
  std::mutex lock_;
  std::condition_variable news_;
  std::vector<Stage> stages_;
  bool ended_ = false;
  std::exception_ptr fault_;
  std::thread thread_;
};

}  // namespace slipstack::workbench
