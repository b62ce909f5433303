// SPDX-License-Identifier: Apache-2.0
// Work in independent pieces: on all processors, with progress, stoppable, the same result in any order.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace slipstack::sim {

/// How somebody watches and stops a long piece of work. All members may be left as they are.
struct Watch {
  std::function<void(double)> progress;     // share done, 0 … 1; from any thread, one at a time
  const std::atomic<bool>* stop = nullptr;  // set: end at the next point, with what there is
  std::size_t threads = 0;                  // 0: one per processor

  bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
};

/// Counts points over several threads and tells the watcher.
class PointCounter {
 public:
  PointCounter(const Watch& watch, std::size_t total) : watch_(watch), total_(total) {}
  void add(std::size_t points = 1) {
    const std::lock_guard lock(lock_);
    done_ += points;
    if (watch_.progress) watch_.progress(static_cast<double>(done_) / static_cast<double>(total_));
  }

 private:
  const Watch& watch_;
  std::size_t total_;
  std::size_t done_ = 0;
  std::mutex lock_;
};

/// Calls body(i) for i in [0, count), each once, on the watch's threads. Every body must depend on i alone.
/// The first exception is thrown again here.
template <class Body>
void for_each_piece(std::size_t count, const Watch& watch, Body&& body) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_lock;
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard lock(failure_lock);
        if (!failure) failure = std::current_exception();
      }
    }
  };
  const std::size_t processors =
      watch.threads > 0 ? watch.threads : std::max(1U, std::thread::hardware_concurrency());
  std::vector<std::jthread> threads;
  for (std::size_t i = 1; i < std::min(processors, count); ++i) threads.emplace_back(work);
  work();
  threads.clear();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace slipstack::sim
