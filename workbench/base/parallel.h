// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sched.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "workbench/base/cancel.h"

namespace slipstack::workbench {

/// Processors that this thread may run on. They are fewer than the machine has where taskset, a container or
/// mpirun restricts the thread; more threads than these would only cost memory.
inline std::size_t usable_processors() {
  cpu_set_t usable;
  if (sched_getaffinity(0, sizeof(usable), &usable) == 0) {
    return static_cast<std::size_t>(std::max(1, CPU_COUNT(&usable)));
  }
  return std::max(1u, std::thread::hardware_concurrency());
}

namespace detail {

/// Threads of this program that work in a parallel_for().
inline std::atomic<std::size_t> working{0};
inline thread_local bool is_working = false;

/// Counts one more thread, if a processor is free for it.
inline bool take_free_processor() {
  std::size_t now = working.load();
  while (now < usable_processors()) {
    if (working.compare_exchange_weak(now, now + 1)) return true;
  }
  return false;
}

/// Counts this thread as long as it works, once, however deep the loops are nested.
class Working {
 public:
  explicit Working(bool counted_already) : outermost_(!is_working) {
    if (outermost_ && !counted_already) ++working;
    is_working = true;
  }
  ~Working() {
    if (!outermost_) return;
    is_working = false;
    --working;
  }
  Working(const Working&) = delete;
  Working& operator=(const Working&) = delete;

 private:
  bool outermost_;
};

}  // namespace detail

/// Calls body(i) for i in [0, count) on `most_threads` threads (0: this one, and one for each usable
/// processor on which no other parallel_for() works: loops within loops do not multiply their threads); the
/// first exception is thrown again here. The results must not depend on the order of the calls. Throws
/// Cancelled between two calls where the work is no longer wanted (cancel.h).
template <class Body>
void parallel_for(std::size_t count, std::size_t most_threads, Body&& body) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_lock;
  const CancelToken* const token = cancel_token();
  const auto work = [&] {
    const CancelScope scope(token);
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        throw_if_cancelled();
        body(i);
      } catch (...) {
        const std::lock_guard lock(failure_lock);
        if (!failure) failure = std::current_exception();
      }
    }
  };
  {
    const detail::Working self(false);
    std::vector<std::jthread> threads;
    while (threads.size() + 1 < count) {
      if (most_threads > 0 ? threads.size() + 1 == most_threads : !detail::take_free_processor()) break;
      threads.emplace_back([&work, most_threads] {
        const detail::Working helper(most_threads == 0);
        work();
      });
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

/// The same on all usable processors.
template <class Body>
void parallel_for(std::size_t count, Body&& body) {
  parallel_for(count, 0, std::forward<Body>(body));
}

/// Calls each of `works` once, on all usable processors. None may need what another does.
template <class... Work>
void run_together(Work&&... works) {
  const std::array<std::function<void()>, sizeof...(works)> all{std::ref(works)...};
  parallel_for(all.size(), [&](std::size_t i) { all[i](); });
}

}  // namespace slipstack::workbench
