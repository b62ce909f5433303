// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/session/jobs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "workbench/base/errors.h"
#include "workbench/base/parallel.h"

namespace slipstack::workbench {
namespace {

using namespace std::chrono_literals;

void wait(const Jobs& jobs) {
  for (int i = 0; i < 2000 && jobs.running(); ++i) std::this_thread::sleep_for(5ms);
  ASSERT_FALSE(jobs.running());
}

TEST(Jobs, RunOneAtATimeAndTellHowTheyEnded) {
  Events events;
  Jobs jobs(events);
  std::atomic<bool> go{false};
  jobs.start("wait", [&](Progress&) {
    while (!go.load()) std::this_thread::sleep_for(1ms);
  });
  EXPECT_THROW(jobs.start("another", [](Progress&) {}), UsageError);
  go = true;
  wait(jobs);
  EXPECT_EQ(jobs.to_json()["outcome"], "done");
  jobs.start("fail", [](Progress&) { throw InputError("log.csv: gone"); });
  wait(jobs);
  EXPECT_EQ(jobs.to_json()["outcome"], "failed");
  EXPECT_EQ(jobs.to_json()["error"], "log.csv: gone");
}

// Threads are those of the processors, however deep loops lie within each other, and all of them are there
// again for the next loop.
TEST(Parallel, LoopsWithinLoopsShareTheProcessors) {
  for (int round = 0; round < 3; ++round) {
    std::atomic<std::size_t> at_once{0};
    std::atomic<std::size_t> most{0};
    std::atomic<std::size_t> calls{0};
    parallel_for(6, [&](std::size_t) {
      parallel_for(6, [&](std::size_t) {
        const std::size_t now = ++at_once;
        for (std::size_t known = most.load(); known < now && !most.compare_exchange_weak(known, now);) {
        }
        ++calls;
        std::this_thread::sleep_for(2ms);
        --at_once;
      });
    });
    EXPECT_EQ(calls.load(), 36U);
    EXPECT_EQ(most.load(), std::min<std::size_t>(36, usable_processors()));
  }
}

// Work that would never end by itself, in the calls of parallel_for and on its threads.
TEST(Jobs, CancellationStopsParallelWork) {
  Events events;
  Jobs jobs(events);
  std::atomic<std::size_t> calls{0};
  jobs.start("endless", [&](Progress&) {
    for (;;) {
      parallel_for(64, 4, [&](std::size_t) {
        ++calls;
        std::this_thread::sleep_for(1ms);
      });
    }
  });
  while (calls.load() < 10) std::this_thread::sleep_for(1ms);
  jobs.cancel();
  wait(jobs);
  EXPECT_EQ(jobs.to_json()["outcome"], "cancelled");
  EXPECT_EQ(jobs.to_json()["error"], "");
  jobs.start("next", [](Progress& progress) { progress.show("still works", 0.5); });
  wait(jobs);
  EXPECT_EQ(jobs.to_json()["outcome"], "done");
}

}  // namespace
}  // namespace slipstack::workbench
