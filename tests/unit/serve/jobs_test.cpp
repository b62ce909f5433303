// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/session/jobs.h"

#include <gtest/gtest.h>

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
