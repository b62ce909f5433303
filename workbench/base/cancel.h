// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <exception>

namespace slipstack::workbench {

/// Thrown by work that somebody no longer wants. Not an error: nothing is to be reported but that it ended.
struct Cancelled : std::exception {
  const char* what() const noexcept override { return "cancelled"; }
};

/// Asks the work that is done under it (CancelScope) to end. May be set from any thread.
class CancelToken {
 public:
  void cancel() { cancelled_.store(true); }
  bool is_cancelled() const { return cancelled_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> cancelled_{false};
};

namespace detail {
inline thread_local const CancelToken* current_token = nullptr;
}  // namespace detail

/// The token of the work that this thread does; nullptr where nobody can cancel it.
inline const CancelToken* cancel_token() {
  return detail::current_token;
}

/// During its life the work of this thread, and of the threads that parallel_for() starts for it, ends when
/// the token asks for it.
class CancelScope {
 public:
  explicit CancelScope(const CancelToken* token) : before_(detail::current_token) {
    detail::current_token = token;
  }
  ~CancelScope() { detail::current_token = before_; }
  CancelScope(const CancelScope&) = delete;
  CancelScope& operator=(const CancelScope&) = delete;

 private:
  const CancelToken* before_;
};

/// Throws Cancelled where the work of this thread is no longer wanted. Called by parallel_for() and by
/// Progress::show(), through which all long work passes. Cost: one load.
inline void throw_if_cancelled() {
  if (detail::current_token != nullptr && detail::current_token->is_cancelled()) throw Cancelled();
}

}  // namespace slipstack::workbench
