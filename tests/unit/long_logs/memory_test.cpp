// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <sched.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <new>
#include <random>

#include "tests/unit/temporary_directory.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/long_logs/shared_logs.h"
#include "workbench/long_logs/whole_logs.h"

// The memory for a log does not depend on its length. The test is a program of its own, because it replaces
// the global operators new and delete to count bytes.
#ifdef SLIPSTACK_SANITIZED

TEST(Memory, DoesNotGrowWithTheLog) {
  GTEST_SKIP() << "SKIP: the address sanitizer replaces operator new itself";
}

#else

namespace {

std::atomic<std::size_t> live_bytes{0};
std::atomic<std::size_t> peak_bytes{0};

}  // namespace

[[gnu::noinline]] void* operator new(std::size_t size) {
  void* const given = std::malloc(size);
  if (given == nullptr) throw std::bad_alloc();
  const std::size_t live = live_bytes += malloc_usable_size(given);
  std::size_t peak = peak_bytes;
  while (peak < live && !peak_bytes.compare_exchange_weak(peak, live)) {
  }
  return given;
}

[[gnu::noinline]] void operator delete(void* given) noexcept {
  live_bytes -= malloc_usable_size(given);
  std::free(given);
}

[[gnu::noinline]] void operator delete(void* given, std::size_t) noexcept {
  operator delete(given);
}

namespace slipstack::workbench {
namespace {

/// Bytes allocated in addition to those before some work: at most during it, and after it.
struct Cost {
  double peak_bytes = 0.0;
  double kept_bytes = 0.0;
};

template <class Work>
Cost cost_of(Work&& work) {
  const std::size_t before = live_bytes;
  peak_bytes = before;
  work();
  return {static_cast<double>(peak_bytes - before),
          static_cast<double>(live_bytes) - static_cast<double>(before)};
}

/// One thread, so that the memory does not depend on which chunks are processed at the same time.
void run_on_one_processor() {
  cpu_set_t all;
  ASSERT_EQ(sched_getaffinity(0, sizeof(all), &all), 0);
  int first = 0;
  while (!CPU_ISSET(first, &all)) ++first;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(first, &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof(one), &one), 0);
}

/// Traverses with dry and viscous friction.
std::filesystem::path traverses(std::size_t rows) {
  std::filesystem::path path = slipstack::test::directory_of_process() / fmt::format("traverses{}.csv", rows);
  std::ofstream file(path);
  file << "# mass_kg: 3\n# encoder_resolution_m: 1e-6\ntime_s,position_m,force_N\n";
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0.0, 0.05);
  for (std::size_t i = 0; i < rows; ++i) {
    const double phase = static_cast<double>(i) * 4e-3;
    const double x = std::round(5e4 * std::sin(phase)) * 1e-6;
    const double v = 0.2 * std::cos(phase);
    const double a = -0.8 * std::sin(phase);
    file << fmt::format("{:.3f},{:.6f},{:.4f}\n", static_cast<double>(i) * 1e-3, x,
                        3.0 * a + 12.0 * v + 5.0 * std::tanh(v / 2e-3) + noise(random));
  }
  return path;
}

struct Costs {
  std::size_t samples = 0;
  Cost opened;  ///< read once from end to end, the excerpt chosen
  Cost fitted;  ///< the gains of a model, by two passes through the log
};

Costs costs_of(std::size_t rows) {
  const std::filesystem::path path = traverses(rows);
  Costs costs;
  costs.samples = rows;
  SingleProcess alone;
  std::unique_ptr<SharedLogs> logs;
  std::vector<LogInterval> intervals;
  costs.opened = cost_of([&] {
    logs = std::make_unique<SharedLogs>(alone, std::vector<std::string>{path.string()}, 0);
    intervals = choose_intervals(logs->logs());
  });
  const Searched searched = logs->measure(intervals, {});
  FittedModel model = fit_effects(*searched.measurement, {"inertia", "coulomb", "viscous"}, {});
  WholeLogs whole(logs->logs(), *searched.measurement, searched.weighing, alone);
  costs.fitted = cost_of([&] { whole.fit({&model}, 3.0 * model.train_rmse_N); });
  EXPECT_NEAR(find_term(model.terms, "viscous")->gains[0], 12.0, 0.5);
  std::filesystem::remove(path);
  return costs;
}

TEST(Memory, DoesNotGrowWithTheLog) {
  run_on_one_processor();
  // Lengths whose blocks are read in chunks of the same size.
  const Costs some = costs_of(600'000);
  const Costs more = costs_of(1'800'000);
  const auto further = static_cast<double>(more.samples - some.samples);
  // A point of the envelope has 12 bytes for 128 samples; while there are few points, the reserved capacity
  // of the vector may be as large again.
  EXPECT_LT(more.opened.peak_bytes - some.opened.peak_bytes, 0.2 * further);
  EXPECT_LT(more.opened.kept_bytes, 0.2 * static_cast<double>(more.samples));
  EXPECT_LT(more.fitted.peak_bytes - some.fitted.peak_bytes, 0.1 * further);
  EXPECT_LT(more.fitted.kept_bytes - some.fitted.kept_bytes, 0.02 * further);
  // At most 16 vectors of a chunk of 196608 samples with its burn-in are held at once.
  EXPECT_LT(more.fitted.peak_bytes, 16.0 * 8.0 * 200'000);
}

}  // namespace
}  // namespace slipstack::workbench

#endif
