// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/whole_logs.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <barrier>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <numeric>
#include <thread>

#include "tests/unit/identify/simulated_axis.h"

// Long logs: what is found on an excerpt and judged by the whole is what a search of the whole would say.
namespace slipstack::workbench {
namespace {

const std::vector<std::string> kBaseline{"inertia", "presliding_hysteresis"};

/// A log of a simulated axis with viscous friction that no model knows of, in a file.
std::filesystem::path viscous_file(const std::string& name, std::uint64_t seed, double seconds) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, seed);
  bench.programme.seconds = seconds;
  bench.rate_Hz = 1000.0;
  Log log = test::simulate(bench, seed + 20);
  const Measurement motion(log);
  std::filesystem::path path = std::filesystem::path(testing::TempDir()) / name;
  std::ofstream file(path);
  file << "# mass_kg: " << *log.mass_kg << "\n# encoder_resolution_m: " << *log.encoder_resolution_m << "\n";
  file << "time_s,position_m,force_N\n";
  for (std::size_t i = 0; i < log.force_N.size(); ++i) {
    file << fmt::format("{:.3f},{:.9f},{:.6f}\n", static_cast<double>(i) * 1e-3, log.position_m[i],
                        log.force_N[i] + 15.0 * motion.velocity_mps()[i]);
  }
  return path;
}

struct Found {
  Diagnosis diagnosis;
  std::unique_ptr<Measurement> measurement;
  RowWeighing weighing;
  std::vector<LogStretch> surprises;
};

Found diagnosed(const std::vector<LongLog>& logs, const std::vector<LogStretch>& stretches, Team& team) {
  Found found;
  found.measurement = std::make_unique<Measurement>(pieces_of(logs, stretches));
  found.weighing = weigh_rows(*found.measurement);
  WholeLogs whole(logs, *found.measurement, found.weighing, team);
  if (!team.is_first()) {
    whole.serve();
    return found;
  }
  DiagnoseOptions options;
  options.baseline = kBaseline;
  options.candidates = {"viscous",      "quadratic_drag", "coulomb",
                        "offset_force", "time_delay",     "position_dependent_preload"};
  if (found.measurement->is_excerpt()) {
    options.judge_on_whole = [&](Diagnosis& diagnosis) { whole.judge(diagnosis, {}); };
  }
  found.diagnosis = diagnose(*found.measurement, options);
  found.surprises = whole.surprises(stretches);
  whole.done();
  return found;
}

std::vector<LogStretch> everything(const std::vector<LongLog>& logs) {
  std::vector<LogStretch> all;
  for (std::size_t log = 0; log < logs.size(); ++log) all.push_back({log, 0, logs[log].sample_count()});
  return all;
}

/// Threads that pose as processes.
class Posing final : public Team {
 public:
  struct Shared {
    explicit Shared(int members) : size(members), barrier(members), said(static_cast<std::size_t>(members)) {}
    int size;
    std::barrier<> barrier;
    std::vector<std::string> said;
  };
  Posing(Shared& shared, int rank) : shared_(shared), rank_(rank) {}
  int rank() const override { return rank_; }
  int size() const override { return shared_.size; }
  std::string broadcast(std::string said, int from) override {
    if (rank_ == from) shared_.said[0] = std::move(said);
    shared_.barrier.arrive_and_wait();
    std::string heard = shared_.said[0];
    shared_.barrier.arrive_and_wait();
    return heard;
  }
  std::vector<std::string> gather(std::string said) override {
    shared_.said[static_cast<std::size_t>(rank_)] = std::move(said);
    shared_.barrier.arrive_and_wait();
    std::vector<std::string> heard;
    if (rank_ == 0) heard = shared_.said;
    shared_.barrier.arrive_and_wait();
    return heard;
  }

 private:
  Shared& shared_;
  int rank_;
};

void expect_equal(const Diagnosis& a, const Diagnosis& b) {
  EXPECT_EQ(a.verdict, b.verdict);
  EXPECT_EQ(a.baseline.holdout_rmse_N, b.baseline.holdout_rmse_N);
  ASSERT_EQ(a.candidates.size(), b.candidates.size());
  for (std::size_t i = 0; i < a.candidates.size(); ++i) {
    EXPECT_EQ(a.candidates[i].term.id(), b.candidates[i].term.id());
    EXPECT_EQ(a.candidates[i].holdout_rmse_N, b.candidates[i].holdout_rmse_N) << a.candidates[i].term.id();
    EXPECT_EQ(a.candidates[i].error_reduction_se, b.candidates[i].error_reduction_se);
  }
}

TEST(WholeLogs, AnExcerptJudgedByTheWholeSaysWhatTheWholeSays) {
  const std::filesystem::path path = viscous_file("viscous.csv", 5, 260.0);
  std::vector<LongLog> logs{LongLog::open(path, 0)};
  Alone alone;
  const std::vector<LogStretch> stretches = choose_stretches(logs);
  const std::size_t chosen =
      std::accumulate(stretches.begin(), stretches.end(), std::size_t{0},
                      [](std::size_t sum, const auto& one) { return sum + one.count; });
  ASSERT_LT(chosen, logs[0].sample_count() * 3 / 4);
  const Found excerpt = diagnosed(logs, stretches, alone);
  const Found whole = diagnosed(logs, everything(logs), alone);
  ASSERT_TRUE(excerpt.measurement->is_excerpt());
  EXPECT_EQ(excerpt.diagnosis.verdict, whole.diagnosis.verdict);
  ASSERT_EQ(excerpt.diagnosis.candidates.front().term.id(), "viscous");
  EXPECT_NEAR(excerpt.diagnosis.baseline.holdout_rmse_N / whole.diagnosis.baseline.holdout_rmse_N, 1.0, 0.05);
  EXPECT_NEAR(
      excerpt.diagnosis.candidates.front().holdout_rmse_N / whole.diagnosis.candidates.front().holdout_rmse_N,
      1.0, 0.10);
  EXPECT_NEAR(excerpt.diagnosis.candidates.front().term.gains[0], 15.0, 1.0);
  EXPECT_TRUE(excerpt.surprises.empty());
}

TEST(WholeLogs, TheAnswerIsTheSameForAnyNumberOfProcesses) {
  std::vector<LongLog> logs{LongLog::open(viscous_file("one.csv", 6, 180.0), 0),
                            LongLog::open(viscous_file("two.csv", 6, 120.0), 0)};
  const std::vector<LogStretch> stretches = choose_stretches(logs);
  Alone alone;
  const Found one = diagnosed(logs, stretches, alone);
  ASSERT_TRUE(one.measurement->is_excerpt());
  Posing::Shared shared(3);
  std::vector<Found> found(3);
  {
    std::vector<std::jthread> threads;
    threads.reserve(3);
    for (int rank = 0; rank < 3; ++rank) {
      threads.emplace_back([&, rank] {
        Posing team(shared, rank);
        found[static_cast<std::size_t>(rank)] = diagnosed(logs, stretches, team);
      });
    }
  }
  expect_equal(one.diagnosis, found[0].diagnosis);
}

TEST(WholeLogs, AnEventOutsideTheExcerptIsASurprise) {
  const std::filesystem::path path = viscous_file("event.csv", 7, 260.0);
  std::vector<LongLog> logs{LongLog::open(path)};
  const std::vector<LogStretch> stretches = choose_stretches(logs);
  // A place that the excerpt leaves out.
  std::size_t event = 0;
  for (std::size_t i = 0; i + 1 < stretches.size(); ++i) {
    const std::size_t end = stretches[i].first + stretches[i].count;
    if (stretches[i + 1].first > end + 40'000) event = (end + stretches[i + 1].first) / 2;
  }
  ASSERT_GT(event, 0u);
  Log log = logs[0].take();
  const std::filesystem::path disturbed = std::filesystem::path(testing::TempDir()) / "disturbed.csv";
  {
    std::ofstream file(disturbed);
    file << "# mass_kg: " << *log.mass_kg << "\n# encoder_resolution_m: " << *log.encoder_resolution_m
         << "\n";
    file << "time_s,position_m,force_N\n";
    for (std::size_t i = 0; i < log.force_N.size(); ++i) {
      const double away = (static_cast<double>(i) - static_cast<double>(event)) / 3000.0;
      file << fmt::format("{:.3f},{:.9f},{:.6f}\n", static_cast<double>(i) * 1e-3, log.position_m[i],
                          log.force_N[i] + 40.0 * std::exp(-away * away));
    }
  }
  logs = {LongLog::open(disturbed)};
  Alone alone;
  const Found found = diagnosed(logs, choose_stretches(logs), alone);
  ASSERT_FALSE(found.surprises.empty());
  EXPECT_LE(found.surprises[0].first, event);
  EXPECT_GE(found.surprises[0].first + found.surprises[0].count + 16'384, event);
}

TEST(ChooseStretches, CoversSlowPartsAndFastOnesAndEveryLog) {
  // Fast strokes nearly all the time; one per cent of it creeps.
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "creep.csv";
  constexpr std::size_t kRows = 400'000;
  const auto creeps = [](std::size_t i) { return i >= 300'000 && i < 304'000; };
  {
    std::ofstream file(path);
    file << "time_s,position_m,force_N\n";
    double x = 0.0;
    for (std::size_t i = 0; i < kRows; ++i) {
      const double v = creeps(i) ? 1e-4 : 0.5 * std::cos(static_cast<double>(i) * 0.004);
      x += v * 1e-3;
      file << fmt::format("{:.3f},{:.7f},{}\n", static_cast<double>(i) * 1e-3, x, i % 11);
    }
  }
  const std::vector<LongLog> logs{LongLog::open(path, 0),
                                  LongLog::open(viscous_file("other.csv", 8, 20.0), 0)};
  const std::vector<LogStretch> stretches = choose_stretches(logs);
  bool slow = false;
  bool other = false;
  std::size_t samples = 0;
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    const LogStretch& one = stretches[i];
    samples += one.count;
    other = other || one.log == 1;
    slow = slow || (one.log == 0 && one.first < 303'000 && one.first + one.count > 301'000);
    if (i > 0 && stretches[i - 1].log == one.log) {
      EXPECT_GT(one.first, stretches[i - 1].first + stretches[i - 1].count);
    }
  }
  EXPECT_TRUE(slow);
  EXPECT_TRUE(other);
  EXPECT_LT(samples, 2 * kExcerptSamples);
}

}  // namespace
}  // namespace slipstack::workbench
