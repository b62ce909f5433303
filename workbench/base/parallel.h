// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
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

/// Calls body(i) for i in [0, count) on `most_threads` threads (0: one for each usable processor); the first
/// exception is thrown again here. The results must not depend on the order of the calls. Throws Cancelled
/// between two calls where the work is no longer wanted (cancel.h).
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
  std::vector<std::jthread> threads;
  const std::size_t wanted = most_threads > 0 ? most_threads : usable_processors();
  for (std::size_t i = 1; i < std::min(wanted, count); ++i) threads.emplace_back(work);
  work();
  threads.clear();
  if (failure) std::rethrow_exception(failure);
}

/// The same on all usable processors.
template <class Body>
void parallel_for(std::size_t count, Body&& body) {
  parallel_for(count, 0, std::forward<Body>(body));
}

}  // namespace slipstack::workbench
