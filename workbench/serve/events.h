// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace slipstack::workbench {

/// Tells the pages that something changed. There is no queue: a page that is slow or was away sees the latest
/// state and nothing piles up for it.
class Events {
 public:
  void tell() {
    {
      const std::lock_guard lock(lock_);
      ++number_;
    }
    changed_.notify_all();
  }
  std::uint64_t number() const {
    const std::lock_guard lock(lock_);
    return number_;
  }
  /// Waits until the number is another than `seen`, at most this long, or close(). Returns the number.
  std::uint64_t wait(std::uint64_t seen, std::chrono::milliseconds most) const {
    std::unique_lock lock(lock_);
    changed_.wait_for(lock, most, [&] { return number_ != seen || closed_; });
    return number_;
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
  mutable std::mutex lock_;
  mutable std::condition_variable changed_;
  std::uint64_t number_ = 1;
  bool closed_ = false;
};

}  // namespace slipstack::workbench
