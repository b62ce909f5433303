// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace slipstack::workbench {

/// Tells the pages that something changed: the state of the session, or the signals of a live controller.
/// There is no queue: a page that is slow or was away sees the latest state and nothing piles up for it.
class Events {
 public:
  /// How often each was told.
  struct Numbers {
    std::uint64_t state = 1;
    std::uint64_t live = 1;
    bool operator==(const Numbers&) const = default;
  };

  void tell() { count(&Numbers::state); }
  void tell_live() { count(&Numbers::live); }
  /// Waits until something was told since `seen`, at most this long, or close(). Returns the numbers.
  Numbers wait(const Numbers& seen, std::chrono::milliseconds most) const {
    std::unique_lock lock(lock_);
    changed_.wait_for(lock, most, [&] { return numbers_ != seen || closed_; });
    return numbers_;
  }
  void close() {
    {
      const std::lock_guard lock(lock_);
      closed_ = true;
    }
    changed_.notify_all();
  }
  bool closed() const {
    const std::lock_guard lock(lock_);
    return closed_;
  }

 private:
  void count(std::uint64_t Numbers::*which) {
    {
      const std::lock_guard lock(lock_);
      ++(numbers_.*which);
    }
    changed_.notify_all();
  }

  mutable std::mutex lock_;
  mutable std::condition_variable changed_;
  Numbers numbers_;
  bool closed_ = false;
};

}  // namespace slipstack::workbench
