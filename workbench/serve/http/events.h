// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>

namespace slipstack::workbench {

/// Tells the pages that something changed: the state of the session, or the signals of a live controller.
/// There is no queue: a page that is slow or was away sees the latest state and nothing piles up for it.
class Events {
 public:
  /// How often each was told.
  struct Numbers {
    std::uint64_t state = 1;
    std::uint64_t live = 1;
    std::uint64_t progress = 1;
    bool operator==(const Numbers&) const = default;
  };

  /// A page that follows: the number to wait with. When there are more than kMostFollowers, the oldest are
  /// told to end: a page that is there comes again, one that takes nothing holds no place for ever.
  static constexpr std::uint64_t kMostFollowers = 32;
  std::uint64_t follow() {
    std::uint64_t follower = 0;
    {
      const std::lock_guard lock(lock_);
      follower = ++followers_;
    }
    changed_.notify_all();
    return follower;
  }

  void tell() { count(&Numbers::state); }
  void tell_live() { count(&Numbers::live); }
  /// Tells how far a job is, which is part of the state, but can wait.
  void tell_progress() { count(&Numbers::progress); }
  using Clock = std::chrono::steady_clock;
  /// Waits until something was told since `seen`, at most this long; until `progress_from` for progress
  /// alone. Returns the numbers, or nothing where this follower is to end.
  std::optional<Numbers> wait(std::uint64_t follower, const Numbers& seen, std::chrono::milliseconds most,
                              Clock::time_point progress_from = {}) const {
    std::unique_lock lock(lock_);
    const auto ends = [&] { return closed_ || follower + kMostFollowers <= followers_; };
    const auto is_urgent = [&] {
      return numbers_.state != seen.state || numbers_.live != seen.live || ends();
    };
    changed_.wait_for(lock, most, [&] { return numbers_.progress != seen.progress || is_urgent(); });
    if (numbers_.progress != seen.progress) changed_.wait_until(lock, progress_from, is_urgent);
    if (ends()) return std::nullopt;
    return numbers_;
  }
  void close() {
    {
      const std::lock_guard lock(lock_);
      closed_ = true;
    }
    changed_.notify_all();
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
  std::uint64_t followers_ = 0;  ///< so far
  bool closed_ = false;
};

}  // namespace slipstack::workbench
