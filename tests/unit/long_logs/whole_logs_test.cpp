// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/whole_logs.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <barrier>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <numbers>
#include <numeric>
#include <thread>

#include "tests/unit/draw.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "tests/unit/temporary_directory.h"
#include "workbench/base/errors.h"
#include "workbench/long_logs/log_search.h"
#include "workbench/long_logs/processes/requests.h"
#include "workbench/long_logs/shared_logs.h"

// Long logs: a search of an excerpt, judged by the whole logs, gives the result of a search of the whole
// logs.
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
  std::filesystem::path path = slipstack::test::directory_of_process() / name;
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
  std::vector<LogInterval> poorly_predicted;
};

Found diagnosed(const SharedLogs& logs, const std::vector<LogInterval>& intervals) {
  Found found;
  Searched searched = logs.measure(intervals, {});
  found.measurement = std::move(searched.measurement);
  WholeLogs whole(logs.logs(), *found.measurement, searched.weighing, logs.group());
  DiagnoseOptions options;
  options.baseline = kBaseline;
  options.candidates = {"viscous",      "quadratic_drag", "coulomb",
                        "offset_force", "time_delay",     "position_dependent_preload"};
  EffectSearch search(*found.measurement, options);
  if (found.measurement->is_excerpt()) whole.judge(search.diagnosis());
  found.diagnosis = search.conclude();
  found.poorly_predicted = whole.poorly_predicted(intervals);
  return found;
}

std::vector<LogInterval> everything(const std::vector<LongLog>& logs) {
  std::vector<LogInterval> all;
  for (std::size_t log = 0; log < logs.size(); ++log) all.push_back({log, 0, logs[log].sample_count()});
  return all;
}

/// A process group whose processes are threads.
class ThreadsAsProcesses final : public ProcessGroup {
 public:
  struct Shared {
    explicit Shared(int members)
        : size(members), barrier(members), messages(static_cast<std::size_t>(members)) {}
    int size;
    std::barrier<> barrier;
    std::vector<std::string> messages;
  };
  ThreadsAsProcesses(Shared& shared, int rank) : shared_(shared), rank_(rank) {}
  int rank() const override { return rank_; }
  int size() const override { return shared_.size; }
  std::string broadcast(std::string message, int from) override {
    if (rank_ == from) shared_.messages[0] = std::move(message);
    shared_.barrier.arrive_and_wait();
    std::string received = shared_.messages[0];
    shared_.barrier.arrive_and_wait();
    return received;
  }
  std::vector<std::string> gather(std::string message) override {
    shared_.messages[static_cast<std::size_t>(rank_)] = std::move(message);
    shared_.barrier.arrive_and_wait();
    std::vector<std::string> received;
    if (rank_ == 0) received = shared_.messages;
    shared_.barrier.arrive_and_wait();
    return received;
  }

 private:
  Shared& shared_;
  int rank_;
};

void expect_equal(const Diagnosis& a, const Diagnosis& b) {
  EXPECT_EQ(a.verdict, b.verdict);
  EXPECT_EQ(a.baseline.holdout_rmse_N, b.baseline.holdout_rmse_N);
  ASSERT_EQ(a.explained.log_errors.size(), b.explained.log_errors.size());
  for (std::size_t log = 0; log < a.explained.log_errors.size(); ++log) {
    EXPECT_EQ(a.explained.log_errors[log].rmse_N, b.explained.log_errors[log].rmse_N);
    EXPECT_EQ(a.explained.log_errors[log].holdout_rmse_N, b.explained.log_errors[log].holdout_rmse_N);
  }
  ASSERT_EQ(a.candidates.size(), b.candidates.size());
  for (std::size_t i = 0; i < a.candidates.size(); ++i) {
    EXPECT_EQ(a.candidates[i].term.id(), b.candidates[i].term.id());
    EXPECT_EQ(a.candidates[i].holdout_rmse_N, b.candidates[i].holdout_rmse_N) << a.candidates[i].term.id();
    EXPECT_EQ(a.candidates[i].error_reduction_se, b.candidates[i].error_reduction_se);
  }
}

// A job of the workbench begins with the logs as they are open, whatever jobs before it have done to theirs.
TEST(LogSearch, ASecondSearchIsThatOfTheLogsAsTheyWereOpened) {
  const std::filesystem::path path = viscous_file("opened.csv", 5, 20.0);
  SingleProcess alone;
  Progress progress;
  LogSearch opened({&alone, {path.string()}, {}}, progress);
  DiagnoseOptions options;
  options.baseline = kBaseline;
  options.candidates = {"viscous", "coulomb"};
  {
    LogSearch changed(opened, progress);
    Measurement& own = changed.measurement();
    own.set_row_weights(0.5 * own.row_weights());
    own.set_slip_distances({});
  }
  std::filesystem::remove(path);  // nothing is read again
  LogSearch second(opened, progress);
  EXPECT_EQ(second.paths(), opened.paths());
  EXPECT_EQ(second.measurement().row_weights(), opened.measurement().row_weights());
  expect_equal(second.diagnose(options), opened.diagnose(options));
}

/// A mass of 2 kg with 5 N of friction that goes from place to place, recorded at 200 Hz; `arm_kg` more swing
/// at 15.7 Hz with 2 % damping.
Log log_with_arm(double arm_kg) {
  constexpr int kSubsteps = 10;
  constexpr double kTick_s = 5e-3 / kSubsteps;
  constexpr double kTurn_per_s = 2.0 * std::numbers::pi * 15.7;
  const auto quintic = [](double u) {
    const double within = std::clamp(u, 0.0, 1.0);
    return within * within * within * (10.0 - 15.0 * within + 6.0 * within * within);
  };
  slipstack::test::Draw draw(11);
  std::vector<double> position_m;
  double at_m = 0.0;
  while (position_m.size() < std::size_t{40} * 200 * kSubsteps) {
    const double goal_m = draw.uniform(0.0, 1.0);
    const double take_s = draw.uniform(0.4, 1.2);
    for (double t = 0.0; t < take_s + 0.3; t += kTick_s)
      position_m.push_back(at_m + (goal_m - at_m) * quintic(t / take_s));
    at_m = goal_m;
  }
  Log log;
  log.path = "arm";
  log.sample_rate_Hz = 200.0;
  log.mass_kg = 2.0;
  double bristle = 0.0;
  double swing_m = 0.0;
  double swing_mps = 0.0;
  for (std::size_t i = 1; i + 1 < position_m.size(); ++i) {
    const double acceleration_mps2 =
        (position_m[i - 1] - 2.0 * position_m[i] + position_m[i + 1]) / (kTick_s * kTick_s);
    const double spring_mps2 = kTurn_per_s * kTurn_per_s * swing_m + 0.04 * kTurn_per_s * swing_mps;
    swing_mps += (-acceleration_mps2 - spring_mps2) * kTick_s;
    swing_m += swing_mps * kTick_s;
    const double step_m = position_m[i] - position_m[i - 1];
    if (step_m != 0.0) {
      const double side = std::copysign(1.0, step_m);
      bristle = side + (bristle - side) * std::exp(-std::abs(step_m) / 0.5e-3);
    }
    if (i % kSubsteps != 0) continue;
    log.position_m.push_back(position_m[i]);
    log.force_N.push_back(2.0 * acceleration_mps2 + 5.0 * bristle - arm_kg * spring_mps2 +
                          0.02 * draw.normal());
  }
  return log;
}

// A twentieth of the rate is 10 Hz. Every command measures the logs as this does.
TEST(LogSearch, TheBandwidthHoldsAModeThatRingsAboveIt) {
  SingleProcess alone;
  Progress progress;
  LogSearch without({&alone, {"arm"}, {}, {{"arm", log_with_arm(0.0)}}}, progress);
  EXPECT_LE(without.measurement().bandwidth_Hz(), 10.0);
  LogSearch logs({&alone, {"arm"}, {}, {{"arm", log_with_arm(0.6)}}}, progress);
  EXPECT_NEAR(logs.measurement().bandwidth_Hz(), 1.5 * 15.7, 1.0);
  DiagnoseOptions options;
  options.baseline = kBaseline;
  const Diagnosis diagnosis = logs.diagnose(options);
  ASSERT_GE(diagnosis.steps.size(), 2u);
  ASSERT_EQ(diagnosis.steps[1].effect, "structural_resonance");
  EXPECT_NEAR(find_role(diagnosis.steps[1].terms, Role::resonance)->shapes[0], 15.7, 0.1);
}

TEST(WholeLogs, AnExcerptJudgedByTheWholeGivesTheDiagnosisOfTheWhole) {
  const std::filesystem::path path = viscous_file("viscous.csv", 5, 260.0);
  SingleProcess alone;
  const SharedLogs shared_logs(alone, {path.string()}, 0);
  const std::vector<LongLog>& logs = shared_logs.logs();
  const std::vector<LogInterval> intervals = choose_intervals(logs);
  const std::size_t chosen =
      std::accumulate(intervals.begin(), intervals.end(), std::size_t{0},
                      [](std::size_t sum, const auto& one) { return sum + one.count; });
  ASSERT_LT(chosen, logs[0].sample_count() * 3 / 4);
  const Found excerpt = diagnosed(shared_logs, intervals);
  const Found whole = diagnosed(shared_logs, everything(logs));
  ASSERT_TRUE(excerpt.measurement->is_excerpt());
  EXPECT_EQ(excerpt.diagnosis.verdict, whole.diagnosis.verdict);
  ASSERT_EQ(excerpt.diagnosis.candidates.front().term.id(), "viscous");
  EXPECT_NEAR(excerpt.diagnosis.baseline.holdout_rmse_N / whole.diagnosis.baseline.holdout_rmse_N, 1.0, 0.05);
  EXPECT_NEAR(
      excerpt.diagnosis.candidates.front().holdout_rmse_N / whole.diagnosis.candidates.front().holdout_rmse_N,
      1.0, 0.10);
  EXPECT_NEAR(excerpt.diagnosis.candidates.front().term.gains[0], 15.0, 1.0);
  EXPECT_TRUE(excerpt.poorly_predicted.empty());
}

/// Runs `work` on the first process of a group while the others serve it.
template <class Work>
void as_group(int members, Work&& work) {
  ThreadsAsProcesses::Shared shared(members);
  std::vector<std::jthread> threads;
  threads.reserve(static_cast<std::size_t>(members));
  for (int rank = 1; rank < members; ++rank) {
    threads.emplace_back([&shared, rank] {
      ThreadsAsProcesses group(shared, rank);
      serve_logs(group);
    });
  }
  ThreadsAsProcesses first(shared, 0);
  const Dismissal dismissal(first);
  work(first);
}

TEST(WholeLogs, TheAnswerIsTheSameForAnyNumberOfProcesses) {
  const std::vector<std::string> paths{viscous_file("one.csv", 6, 180.0).string(),
                                       viscous_file("two.csv", 6, 120.0).string()};
  SingleProcess alone;
  const SharedLogs logs(alone, paths, 0);
  const std::vector<LogInterval> intervals = choose_intervals(logs.logs());
  const Found one = diagnosed(logs, intervals);
  ASSERT_TRUE(one.measurement->is_excerpt());
  as_group(3, [&](ProcessGroup& group) {
    const SharedLogs shared(group, paths, 0);
    expect_equal(one.diagnosis, diagnosed(shared, intervals).diagnosis);
  });
}

TEST(WholeLogs, GainsAreThoseOfTheWholeAndOutliersHaveLessWeight) {
  const std::filesystem::path path = viscous_file("gains.csv", 5, 260.0);
  SingleProcess alone;
  const SharedLogs logs(alone, {path.string()}, 0);
  const std::vector<std::string> effects{"inertia", "presliding_hysteresis", "viscous"};
  const auto viscous = [](const FittedModel& model) { return find_term(model.terms, "viscous")->gains[0]; };
  const Searched all = logs.measure(everything(logs.logs()), {});
  const FittedModel by_all = fit_effects(*all.measurement, effects, {});
  const Searched part = logs.measure(choose_intervals(logs.logs()), {});
  ASSERT_TRUE(part.measurement->is_excerpt());
  const FittedModel by_part = fit_effects(*part.measurement, effects, {});
  WholeLogs whole(logs.logs(), *part.measurement, part.weighing, alone);
  const auto judged = [&](double limit_N) {
    FittedModel model = by_part;
    whole.fit({&model}, limit_N);
    return model;
  };
  const FittedModel plain = judged(0.0);
  EXPECT_LT(std::abs(viscous(plain) - viscous(by_all)), 0.5 * std::abs(viscous(by_part) - viscous(by_all)));
  EXPECT_NEAR(plain.holdout_rmse_N / by_all.holdout_rmse_N, 1.0, 0.05);
  // The residual of the fit is the residual of its model.
  const WholeLogs::Residual left = whole.residuals_of({plain.terms}).front();
  EXPECT_NEAR(left.rmse_N / plain.train_rmse_N, 1.0, 0.01);
  EXPECT_EQ(left.relative_error, plain.relative_error);
  // A limit that no residual reaches changes nothing; a low one shifts the gains towards the median.
  EXPECT_EQ(viscous(judged(1e6)), viscous(plain));
  EXPECT_NE(viscous(judged(plain.train_rmse_N)), viscous(plain));
  // Its error is that of all rows, outliers included: no fit is below the least squares.
  const FittedModel robust = judged(plain.train_rmse_N);
  EXPECT_GT(robust.train_rmse_N, plain.train_rmse_N);
  EXPECT_EQ(robust.train_rmse_N, whole.residuals_of({robust.terms}).front().rmse_N);
}

/// Weighted rms of the residual of a model in one log, and its share of the force, at the rows.
LogErrors errors_of(const Measurement& measurement, const Terms& terms, std::size_t log) {
  const auto [first, count] = measurement.rows_of_log(log);
  const Eigen::VectorXd measured_N = measurement.force_N().segment(first, count);
  const Eigen::VectorXd left_N =
      measured_N - measurement.filtered(evaluate_force(measurement, terms).force_N).segment(first, count);
  const Eigen::VectorXd weights = measurement.row_weights().segment(first, count);
  return {std::sqrt(weights.dot(left_N.cwiseAbs2()) / weights.sum()), 0.0, left_N.norm() / measured_N.norm()};
}

TEST(WholeLogs, ErrorsOfEachLogAreThoseOfItsWhole) {
  const std::vector<std::string> paths{viscous_file("first.csv", 5, 260.0).string(),
                                       viscous_file("second.csv", 5, 130.0).string()};
  SingleProcess alone;
  const SharedLogs logs(alone, paths, 0);
  const Searched all = logs.measure(everything(logs.logs()), {});
  const Searched part = logs.measure(choose_intervals(logs.logs()), {});
  ASSERT_TRUE(part.measurement->is_excerpt());
  FittedModel model = fit_effects(*part.measurement, kBaseline, {});
  EXPECT_TRUE(model.log_errors.empty());
  WholeLogs whole(logs.logs(), *part.measurement, part.weighing, alone);
  whole.fit({&model}, 0.0);
  MotionExtremes reached;
  reached.take(*all.measurement, 0, all.measurement->sample_count());
  EXPECT_EQ(whole.reached().low_m, reached.low_m);
  EXPECT_EQ(whole.reached().high_m, reached.high_m);
  EXPECT_NEAR(whole.reached().velocity_mps / reached.velocity_mps, 1.0, 1e-3);
  EXPECT_NEAR(whole.reached().acceleration_mps2 / reached.acceleration_mps2, 1.0, 1e-3);
  const FittedModel by_all = fit_effects(*all.measurement, kBaseline, {});
  ASSERT_EQ(model.log_errors.size(), 2u);
  const std::vector<LogErrors> left = whole.residuals_of({model.terms}).front().logs;
  double excerpt_off = 0.0;
  for (std::size_t log = 0; log < 2; ++log) {
    const LogErrors& found = model.log_errors[log];
    const LogErrors expected = errors_of(*all.measurement, model.terms, log);
    EXPECT_NEAR(found.rmse_N / expected.rmse_N, 1.0, 0.01);
    const LogErrors excerpt = errors_of(*part.measurement, model.terms, log);
    excerpt_off = std::max(excerpt_off, std::abs(excerpt.rmse_N / expected.rmse_N - 1.0));
    EXPECT_NEAR(found.relative_error / expected.relative_error, 1.0, 0.01);
    EXPECT_EQ(found.rmse_N, left[log].rmse_N);
    EXPECT_EQ(found.relative_error, left[log].relative_error);
    EXPECT_EQ(left[log].holdout_rmse_N, 0.0);
    const LogPart& own = all.measurement->parts()[log];
    double held_out = 0.0;
    double weight = 0.0;
    for (int b = own.first_block; b < own.first_block + own.block_count; ++b) {
      held_out += by_all.block_squared_error[static_cast<std::size_t>(b)];
      weight += by_all.block_weight[static_cast<std::size_t>(b)];
    }
    EXPECT_NEAR(found.holdout_rmse_N / std::sqrt(held_out / weight), 1.0, 0.02);
  }
  // They differ from those of the excerpt, which contains more of the rare kinds of motion.
  EXPECT_GT(excerpt_off, 0.03);
}

TEST(SharedLogs, AFaultInAnyProcessGivesTheMessageOfASingleProcess) {
  const std::filesystem::path good = viscous_file("good.csv", 9, 40.0);
  std::vector<std::string> paths{good.string()};
  for (const char* name : {"bad1.csv", "bad2.csv", "bad3.csv"}) {
    const std::filesystem::path bad = slipstack::test::directory_of_process() / name;
    std::filesystem::copy_file(good, bad, std::filesystem::copy_options::overwrite_existing);
    std::ofstream(bad, std::ios::app) << "40.000,zero,0\n";
    paths.push_back(bad.string());
  }
  const auto refusal = [&](ProcessGroup& group) -> std::string {
    try {
      const SharedLogs logs(group, paths, 0);
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing";
  };
  SingleProcess alone;
  const std::string expected = refusal(alone);
  EXPECT_NE(expected.find("bad1.csv:"), std::string::npos) << expected;
  for (const int members : {2, 3}) {
    as_group(members, [&](ProcessGroup& group) { EXPECT_EQ(refusal(group), expected) << members; });
  }
}

TEST(SharedLogs, AFileThatShrinksMeanwhileIsRefusedByAllProcesses) {
  const std::filesystem::path path = viscous_file("shrinks.csv", 6, 260.0);
  as_group(3, [&](ProcessGroup& group) {
    const SharedLogs logs(group, {path.string()}, 0);
    const std::vector<LogInterval> intervals = choose_intervals(logs.logs());
    std::filesystem::resize_file(path, std::filesystem::file_size(path) / 50);
    EXPECT_THROW(logs.measure(intervals, {}), InputError);
  });
}

TEST(WholeLogs, AnEventOutsideTheExcerptIsPoorlyPredicted) {
  const std::filesystem::path path = viscous_file("event.csv", 7, 400.0);
  const std::vector<LongLog> logs{LongLog::open(path)};
  const std::vector<LogInterval> intervals = choose_intervals(logs);
  // A time that the excerpt does not contain.
  std::size_t event = 0;
  for (std::size_t i = 0; i + 1 < intervals.size(); ++i) {
    const std::size_t end = intervals[i].first + intervals[i].count;
    if (intervals[i + 1].first > end + 40'000) event = (end + intervals[i + 1].first) / 2;
  }
  ASSERT_GT(event, 0u);
  const Log log = logs[0].chunk(0, logs[0].sample_count());
  const std::filesystem::path disturbed = slipstack::test::directory_of_process() / "disturbed.csv";
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
  SingleProcess alone;
  const SharedLogs shared_logs(alone, {disturbed.string()});
  const Found found = diagnosed(shared_logs, choose_intervals(shared_logs.logs()));
  ASSERT_FALSE(found.poorly_predicted.empty());
  EXPECT_LE(found.poorly_predicted[0].first, event);
  EXPECT_GE(found.poorly_predicted[0].first + found.poorly_predicted[0].count + 16'384, event);
}

TEST(ChooseIntervals, WorksWithACoarserEnvelope) {
  const std::filesystem::path path = viscous_file("coarse.csv", 5, 400.0);
  const LongLog fine = LongLog::open(path, 0);
  Survey survey = *fine.survey();
  survey.envelope = Envelope(512);
  const Log all = fine.chunk(0, fine.sample_count());
  survey.envelope.take(all.position_m);
  ASSERT_EQ(survey.envelope.samples(), 8 * kEnvelopeSamples);
  const std::vector<LongLog> logs{LongLog::open(path, std::move(survey))};
  std::size_t samples = 0;
  for (const LogInterval& one : choose_intervals(logs)) {
    samples += one.count;
    EXPECT_LE(one.first + one.count, all.position_m.size());
  }
  EXPECT_GE(samples, kExcerptSamples);
  EXPECT_LT(samples, 2 * kExcerptSamples);
  for (std::size_t sample = 100'000; sample < 400'000; sample += 30'011) {
    const std::size_t first = burn_in_start(logs[0], sample, 90'000);
    ASSERT_LE(first, sample);
    if (first + 90'000 <= sample) continue;  // the limit was reached
    const auto begin = all.position_m.begin();
    const auto [low, high] = std::minmax_element(begin + static_cast<std::ptrdiff_t>(first),
                                                 begin + static_cast<std::ptrdiff_t>(sample) + 1);
    EXPECT_GT(*high - *low, 0.99 * burn_in_travel_m(fine.travel_m()));
  }
}

TEST(ChooseIntervals, CoversSlowPartsAndFastOnesAndEveryLog) {
  // Fast traverses nearly all the time; one per cent of the log creeps.
  const std::filesystem::path path = slipstack::test::directory_of_process() / "creep.csv";
  constexpr std::size_t kCreepRows = 400'000;
  const auto creeps = [](std::size_t i) { return i >= 300'000 && i < 304'000; };
  {
    std::ofstream file(path);
    file << "time_s,position_m,force_N\n";
    double x = 0.0;
    for (std::size_t i = 0; i < kCreepRows; ++i) {
      const double v = creeps(i) ? 1e-4 : 0.5 * std::cos(static_cast<double>(i) * 0.004);
      x += v * 1e-3;
      file << fmt::format("{:.3f},{:.7f},{}\n", static_cast<double>(i) * 1e-3, x, i % 11);
    }
  }
  const std::vector<LongLog> logs{LongLog::open(path, 0),
                                  LongLog::open(viscous_file("other.csv", 8, 20.0), 0)};
  const std::vector<LogInterval> intervals = choose_intervals(logs);
  bool slow = false;
  bool other = false;
  std::size_t samples = 0;
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const LogInterval& one = intervals[i];
    samples += one.count;
    other = other || one.log == 1;
    slow = slow || (one.log == 0 && one.first < 303'000 && one.first + one.count > 301'000);
    if (i > 0 && intervals[i - 1].log == one.log) {
      EXPECT_GT(one.first, intervals[i - 1].first + intervals[i - 1].count);
    }
  }
  EXPECT_TRUE(slow);
  EXPECT_TRUE(other);
  EXPECT_LT(samples, 2 * kExcerptSamples);
}

}  // namespace
}  // namespace slipstack::workbench
