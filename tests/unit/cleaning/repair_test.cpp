// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/repair.h"

#include <gtest/gtest.h>

#include "tests/unit/estimate/estimate_support.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/estimate/nonlinear/robust.h"
#include "workbench/estimate/uncertainty/row_weights.h"

// Faults of a recorder are inserted into a log of the simulated plant; the repaired log must give the answer
// of the log without them.
namespace slipstack::workbench {
namespace {

const std::vector<std::string> kEffects{"inertia", "presliding_hysteresis", "viscous"};

Log plant_log(std::uint64_t seed) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 1);
  bench.programme.seconds = 20.0;
  Log log = test::simulate(bench, seed);
  log.mass_kg.reset();
  // Five decimals, as in a file.
  for (double& force : log.force_N) force = 1e-5 * std::round(1e5 * force);
  return log;
}

/// Intervals of at least `shortest` samples in which the position stays within an encoder step.
std::vector<Interval> standstills_of(const Log& log, std::size_t shortest) {
  const std::vector<double>& x = log.position_m;
  std::vector<Interval> standstills;
  for (std::size_t i = 0; i < x.size();) {
    std::size_t end = i + 1;
    while (end < x.size() && std::abs(x[end] - x[i]) <= 1.5 * *log.encoder_resolution_m) ++end;
    if (end - i >= shortest) standstills.push_back({i, end});
    i = end;
  }
  return standstills;
}

struct Found {
  double mass_kg = 0.0;
  double level_N = 0.0;
  double error_N = 0.0;
  std::vector<std::string> repaired;
};

Found found_in(const Log& log) {
  Measurement measurement(log);
  weigh_rows(measurement);
  const RobustFit fit = fit_robustly(measurement, fit_effects(measurement, kEffects, {}));
  const Term& hysteresis = *find_term(fit.model.terms, "presliding_hysteresis");
  Found found;
  found.mass_kg = find_term(fit.model.terms, "inertia")->gains[0];
  for (std::size_t i = 0; i < hysteresis.gains.size(); ++i) {
    found.level_N += hysteresis.gains[i] * hysteresis.shapes[i];
  }
  found.error_N = fit.model.holdout_rmse_N;
  found.repaired = measurement.parts()[0].repaired;
  return found;
}

/// Expects the same estimates from the faulty log as from the clean one, and a note that contains `said`.
void expect_same(const Log& clean, const Log& faulty, const char* said, double share = 0.01) {
  const Found truth = found_in(clean);
  const Found found = found_in(faulty);
  ASSERT_EQ(truth.repaired.size(), 0u) << truth.repaired.front();
  EXPECT_NEAR(found.mass_kg, truth.mass_kg, share * truth.mass_kg);
  EXPECT_NEAR(found.level_N, truth.level_N, share * truth.level_N);
  EXPECT_LT(found.error_N, 1.3 * truth.error_N);
  ASSERT_FALSE(found.repaired.empty());
  EXPECT_NE(found.repaired.front().find(said), std::string::npos) << found.repaired.front();
}

TEST(Repair, DoesNotChangeCleanLogs) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Log log = plant_log(seed);
    Log copy = log;
    EXPECT_TRUE(repair(copy).notes.empty()) << seed;
    EXPECT_EQ(copy.force_N, log.force_N);
    EXPECT_EQ(copy.position_m, log.position_m);
  }
  const Log wandering = test::wandering_log(1, 1000.0, 20000);
  Log copy = wandering;
  EXPECT_TRUE(repair(copy).notes.empty());
}

TEST(Repair, OutliersOfForceAndPosition) {
  const Log clean = plant_log(11);
  test::Draw draw(5);
  Log faulty = clean;
  for (int i = 0; i < 40; ++i) {
    const auto at =
        static_cast<std::size_t>(draw.uniform(100.0, static_cast<double>(clean.force_N.size()) - 100.0));
    faulty.force_N[at] += draw.sign() * draw.log_uniform(20.0, 2000.0);
  }
  expect_same(clean, faulty, "outliers of the force");
  Log glitches = clean;
  for (int i = 0; i < 10; ++i) {
    const auto at =
        static_cast<std::size_t>(draw.uniform(100.0, static_cast<double>(clean.force_N.size()) - 100.0));
    glitches.position_m[at] += draw.sign() * 4096e-6;
  }
  expect_same(clean, glitches, "of the position");
}

// One sample in a hundred: many outliers are near another by chance, which must not count as a burst.
TEST(Repair, OutliersThatAreNearEachOtherByChance) {
  const Log clean = plant_log(11);
  test::Draw draw(15);
  Log faulty = clean;
  int left = 0;
  int outliers_found = 0;
  for (std::size_t i = 100; i + 100 < clean.force_N.size(); ++i) {
    if (draw.uniform(0.0, 1.0) < 0.01) faulty.force_N[i] += draw.sign() * draw.log_uniform(20.0, 200.0);
  }
  Log repaired = faulty;
  EXPECT_EQ(repair(repaired).notes.size(), 1U);
  for (std::size_t i = 0; i < clean.force_N.size(); ++i) {
    if (faulty.force_N[i] == clean.force_N[i]) continue;
    ++outliers_found;
    if (repaired.force_N[i] == faulty.force_N[i]) ++left;
  }
  EXPECT_GT(outliers_found, 100);
  EXPECT_LT(left, outliers_found / 40);
}

TEST(Repair, ABurstIsAnEventAndIsKept) {
  Log log = plant_log(12);
  test::Draw draw(6);
  for (std::size_t i = 20000; i < 20200; ++i) {
    if (draw.uniform(0.0, 1.0) < 0.5) log.force_N[i] += draw.sign() * draw.uniform(10.0, 100.0);
  }
  Log copy = log;
  EXPECT_TRUE(repair(copy).notes.empty());
  EXPECT_EQ(copy.force_N, log.force_N);
}

TEST(Repair, RepeatedSamples) {
  const Log clean = plant_log(13);
  test::Draw draw(7);
  Log repeats = clean;
  for (int i = 0; i < 300; ++i) {
    const auto at =
        static_cast<std::size_t>(draw.uniform(100.0, static_cast<double>(clean.force_N.size()) - 100.0));
    repeats.force_N[at] = repeats.force_N[at - 1];
    repeats.position_m[at] = repeats.position_m[at - 1];
  }
  expect_same(clean, repeats, "repeat the one before");
}

// A mass accelerates between two samples; a straight line would itself be an outlier.
TEST(Repair, PositionsAreInterpolatedByCubics) {
  const Log clean = plant_log(13);
  Log repeats = clean;
  std::vector<std::size_t> places;
  for (std::size_t i = 100; i + 100 < clean.force_N.size(); i += 83) {
    repeats.force_N[i] = repeats.force_N[i - 1];
    repeats.position_m[i] = repeats.position_m[i - 1];
    places.push_back(i);
  }
  ASSERT_GT(places.size(), 200U);
  EXPECT_EQ(repair(repeats).notes.size(), 1U);
  double worst_m = 0.0;
  for (const std::size_t i : places) {
    worst_m = std::max(worst_m, std::abs(repeats.position_m[i] - clean.position_m[i]));
  }
  EXPECT_LE(worst_m, 1.5 * *clean.encoder_resolution_m);
}

// The command of a controller changes slowly at standstill: in the digits of a file it is constant for some
// samples and then changes. That is no fault of the recorder.
TEST(Repair, ASlowlyChangingCommandAtStandstillIsKept) {
  Log log = plant_log(18);
  std::size_t equal = 0;
  for (const auto& [i, end] : standstills_of(log, 20)) {
    for (std::size_t k = i + 1; k < end; ++k) {
      log.position_m[k] = log.position_m[i];
      const std::size_t digits = (k - i) / (i % 2 == 0 ? 3 : 10);
      log.force_N[k] = log.force_N[i] + 1e-4 * static_cast<double>(digits);
      equal += log.force_N[k] == log.force_N[k - 1] ? 1 : 0;
    }
  }
  ASSERT_GT(equal, 500U);
  const Log before = log;
  const Repairs repairs = repair(log);
  EXPECT_TRUE(repairs.notes.empty()) << repairs.notes.front();
  EXPECT_TRUE(repairs.cut.empty());
  EXPECT_EQ(log.force_N, before.force_N);
  EXPECT_EQ(log.position_m, before.position_m);
}

TEST(Repair, ForceAtItsLimit) {
  const Log clean = plant_log(14);
  Log limited = clean;
  double largest = 0.0;
  for (const double force : clean.force_N) largest = std::max(largest, std::abs(force));
  for (double& force : limited.force_N) force = std::clamp(force, -0.6 * largest, 0.6 * largest);
  expect_same(clean, limited, "at its limit", 0.02);
}

// At the limit for most of the log, the median change of the force is zero; it has noise nevertheless, and
// the log is refused for its limit.
TEST(Repair, AForceThatIsMostlyAtItsLimitIsRefused) {
  Log limited = plant_log(1);
  std::vector<double> magnitudes;
  for (const double force : limited.force_N) magnitudes.push_back(std::abs(force));
  std::nth_element(magnitudes.begin(),
                   magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 4), magnitudes.end());
  const double limit_N = magnitudes[magnitudes.size() / 4];
  for (double& force : limited.force_N) force = std::clamp(force, -limit_N, limit_N);
  try {
    repair(limited, RepairScope::whole_log);
    FAIL() << "accepted";
  } catch (const InputError& refused) {
    EXPECT_NE(std::string(refused.what()).find("the force is at its limit"), std::string::npos)
        << refused.what();
  }
}

TEST(Repair, FrozenForce) {
  const Log clean = plant_log(15);
  Log off = clean;
  std::fill(off.force_N.begin() + 15000, off.force_N.begin() + 19000, 0.0);
  expect_same(clean, off, "frozen");
}

// A current commanded by a controller is constant at standstill: no fault, however often it occurs.
TEST(Repair, ForceWithoutNoiseAtStandstillIsKept) {
  Log log = plant_log(18);
  std::size_t still = 0;
  for (const Interval& one : standstills_of(log, 8)) {
    std::fill(log.force_N.begin() + static_cast<std::ptrdiff_t>(one.first),
              log.force_N.begin() + static_cast<std::ptrdiff_t>(one.end), log.force_N[one.first]);
    still += one.size();
  }
  ASSERT_GT(still, 500u);
  const Log before = log;
  const Repairs repairs = repair(log);
  EXPECT_TRUE(repairs.cut.empty());
  EXPECT_TRUE(repairs.notes.empty()) << repairs.notes.front();
  EXPECT_EQ(log.force_N, before.force_N);
}

TEST(Repair, StuckEncoder) {
  const Log clean = plant_log(16);
  Log stuck = clean;
  // During the first fast motion in the second half.
  std::size_t at = clean.position_m.size() / 2;
  while (std::abs(clean.position_m[at + 1] - clean.position_m[at]) < 20e-6) ++at;
  std::fill_n(stuck.position_m.begin() + static_cast<std::ptrdiff_t>(at), 200, clean.position_m[at]);
  ASSERT_GT(std::abs(clean.position_m[at + 200] - clean.position_m[at]), 1e-3);
  expect_same(clean, stuck, "encoder stuck", 0.02);
}

// Stuck several times, each time until the axis is at standstill. Such an interval must neither serve as a
// standstill with which forces are compared, nor count as lost counts.
TEST(Repair, EncoderStuckUntilTheNextStandstill) {
  Log clean = plant_log(16);
  clean.mass_kg = 10.0;
  Log stuck = clean;
  const auto step = [&](std::size_t i) { return std::abs(clean.position_m[i + 1] - clean.position_m[i]); };
  int times = 0;
  for (std::size_t at = clean.position_m.size() / 2; times < 3 && at + 3000 < clean.position_m.size(); ++at) {
    if (step(at) < 20e-6) continue;
    std::size_t standstill = at;
    while (standstill < at + 2500 && clean.position_m[standstill] != clean.position_m[standstill + 40])
      ++standstill;
    if (clean.position_m[standstill] != clean.position_m[standstill + 40]) continue;
    std::fill(stuck.position_m.begin() + static_cast<std::ptrdiff_t>(at),
              stuck.position_m.begin() + static_cast<std::ptrdiff_t>(standstill + 10), clean.position_m[at]);
    ++times;
    at = standstill + 500;
  }
  ASSERT_EQ(times, 3);
  const Repairs repairs = repair(stuck);
  EXPECT_TRUE(repairs.jumps.empty()) << repairs.notes.front();
  EXPECT_EQ(repairs.cut.size(), 3U);
}

/// From sample `at` on the encoder reads `jump_m` too much.
Log with_jump(Log log, std::size_t at, double jump_m) {
  for (std::size_t i = at; i < log.position_m.size(); ++i) log.position_m[i] += jump_m;
  return log;
}

// Jumps at speed, as when counts arrive too fast for the counter, and at standstill. Both are corrected.
TEST(Repair, JumpsOfTheEncoder) {
  Log clean = plant_log(16);
  clean.mass_kg = 10.0;
  const auto step = [&](std::size_t i) { return std::abs(clean.position_m[i + 1] - clean.position_m[i]); };
  std::size_t moves = clean.position_m.size() / 2;
  while (step(moves) < 20e-6) ++moves;
  std::size_t standstill = clean.position_m.size() / 4;
  while (clean.position_m[standstill - 40] != clean.position_m[standstill + 40]) ++standstill;
  for (const std::size_t at : {moves, standstill}) {
    for (const double jump_m : {-200e-6, 90e-6}) {
      Log log = with_jump(clean, at, jump_m);
      const Repairs repairs = repair(log);
      ASSERT_EQ(repairs.jumps.size(), 1U) << at;
      EXPECT_EQ(repairs.jumps[0].sample, at);
      EXPECT_NEAR(repairs.jumps[0].jump_m, jump_m, 2e-6);
      EXPECT_NEAR(log.position_m.back(), clean.position_m.back(), 2e-6);
      EXPECT_TRUE(repairs.cut.empty());
      // In a chunk it is reported only: a correction would shift this chunk against the others.
      Log chunk = with_jump(clean, at, jump_m);
      EXPECT_EQ(repair(chunk, RepairScope::chunk).jumps.size(), 1U);
      EXPECT_EQ(chunk.position_m.back(), clean.position_m.back() + jump_m);
    }
  }
  expect_same(plant_log(16), with_jump(plant_log(16), moves, 200e-6), "of the encoder corrected");
}

// Knocks, corners of moves and steep starts are motion.
TEST(Repair, NoMotionIsAJumpOfTheEncoder) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, seed);
    bench.programme.seconds = 20.0;
    const sim::MotionProgramme programme = sim::draw_programme(bench, seed);
    sim::add_outside(bench.axis, sim::OutsideKind::kBacklash, programme, bench.rate_Hz, 0.0, seed);
    const sim::SimulatedLog log = sim::simulate_log(bench.axis, programme, bench.rate_Hz, seed);
    EXPECT_TRUE(encoder_jumps(test::log_of(bench.axis, log)).empty()) << seed;
  }
}

// Pick and place at 200 samples a second: whole moves take only a few samples.
TEST(Repair, MovesOfAFewSamplesAreNoFault) {
  test::Draw draw(11);
  Log log;
  log.path = "test";
  log.sample_rate_Hz = 200.0;
  log.encoder_resolution_m = 1e-7;
  double from_m = 0.0;
  for (int move = 0; move < 40; ++move) {
    const double way_m = draw.sign() * draw.log_uniform(1e-4, 2e-2);
    const double samples = draw.uniform(3.0, 7.0);
    for (int i = 0; i < 60; ++i) {
      const double u = std::min(1.0, i / samples);
      const double x_m = from_m + way_m * u * u * u * (10.0 + u * (6.0 * u - 15.0));
      log.position_m.push_back(1e-7 * std::round(1e7 * x_m));
      log.force_N.push_back(1e-4 * std::round(1e4 * (5.0 * (1.0 - 2.0 * u) + 0.05 * draw.normal())));
    }
    from_m += way_m;
  }
  const Repairs repairs = repair(log);
  EXPECT_TRUE(repairs.cut.empty()) << repairs.notes.front();
  EXPECT_TRUE(repairs.jumps.empty()) << repairs.notes.front();
}

// Stuck in the middle of a move, or at a standstill before further moves.
TEST(Repair, EncoderStuckToTheEnd) {
  const Log clean = plant_log(16);
  const std::size_t count = clean.position_m.size();
  for (const bool at_standstill : {false, true}) {
    Log stuck = clean;
    std::size_t at = count * 3 / 4;
    const auto step = [&](std::size_t i) { return std::abs(clean.position_m[i + 1] - clean.position_m[i]); };
    while (at_standstill ? step(at) > 0.0 || step(at + 40) > 0.0 : step(at) < 20e-6) ++at;
    std::fill(stuck.position_m.begin() + static_cast<std::ptrdiff_t>(at), stuck.position_m.end(),
              clean.position_m[at]);
    expect_same(clean, stuck, "to the end of the log", 0.03);
  }
}

TEST(Repair, AStandstillAtTheEndIsNoFault) {
  Log log = plant_log(16);
  test::Draw draw(10);
  const double held_m = log.position_m.back();
  for (int i = 0; i < 3000; ++i) {
    log.position_m.push_back(held_m);
    log.force_N.push_back(1e-5 * std::round(1e5 * (0.05 * draw.normal())));
  }
  EXPECT_TRUE(repair(log).cut.empty());
}

TEST(Repair, MotionWithoutForce) {
  const Log clean = plant_log(17);
  Log idle = clean;
  test::Draw draw(8);
  std::size_t at = clean.position_m.size() / 3;
  while (std::abs(clean.position_m[at + 1] - clean.position_m[at]) < 20e-6) ++at;
  for (std::size_t i = at; i < at + 3000; ++i) idle.force_N[i] = 1e-5 * std::round(1e4 * draw.normal());
  expect_same(clean, idle, "without any force", 0.02);
}

// A joint with hardly any friction: between two accelerations its force is less than its noise, or than a
// step of its current.
TEST(Repair, AForceThatIsSmallAtConstantVelocityIsNoFault) {
  constexpr double kRate_Hz = 1000.0;
  constexpr double kStep_N = 0.05;
  Log fine;
  fine.sample_rate_Hz = kRate_Hz;
  fine.encoder_resolution_m = 1e-5;
  test::Draw draw(12);
  double x_m = 0.0;
  double v_mps = 0.0;
  for (int move = 0; move < 24; ++move) {
    const double way = move % 2 == 0 ? 1.0 : -1.0;
    // Of twelve moves, two have an interval at constant velocity.
    const double steady_s = move % 12 < 2 ? 0.6 : 0.0;
    const double a_mps2 = draw.uniform(1.0, 2.0);
    for (double t_s = 0.0; t_s < 1.0 + steady_s; t_s += 1.0 / kRate_Hz) {
      const double a = t_s < 0.5 ? way * a_mps2 : t_s < 0.5 + steady_s ? 0.0 : -way * a_mps2;
      v_mps += a / kRate_Hz;
      x_m += v_mps / kRate_Hz;
      fine.position_m.push_back(1e-5 * std::round(1e5 * x_m));
      fine.force_N.push_back(1e-5 * std::round(1e5 * (a + 0.02 * way + 0.02 * draw.normal())));
    }
  }
  Log coarse = fine;
  for (double& force_N : coarse.force_N) force_N = kStep_N * std::round(force_N / kStep_N);
  for (Log* one : {&fine, &coarse}) {
    for (const std::string& note : repair(*one).notes)
      EXPECT_EQ(note.find("without any force"), std::string::npos) << note;
  }
}

// Inertia and friction cancel for a while: the axis slows down by its friction alone.
TEST(Repair, AForceThatPassesZeroEvenlyIsNoDriveOff) {
  constexpr double kRate_Hz = 250.0;
  test::Draw draw(13);
  Log log;
  log.sample_rate_Hz = kRate_Hz;
  log.encoder_resolution_m = 1e-6;
  double x_m = 0.0;
  for (std::size_t i = 0; i < 15'000; ++i) {
    const double t_s = static_cast<double>(i) / kRate_Hz;
    const double v_mps = 0.4 * std::sin(0.9 * t_s) + 0.1 * std::sin(2.3 * t_s);
    const double a_mps2 = 0.36 * std::cos(0.9 * t_s) + 0.23 * std::cos(2.3 * t_s);
    x_m += v_mps / kRate_Hz;
    log.position_m.push_back(1e-6 * std::round(1e6 * x_m));
    log.force_N.push_back(1e-5 *
                          std::round(1e5 * (a_mps2 + 0.12 * std::tanh(v_mps / 1e-3) + 0.03 * draw.normal())));
  }
  for (const std::string& note : repair(log).notes)
    EXPECT_EQ(note.find("without any force"), std::string::npos) << note;
}

// A load whose weight is as large as the friction: down, the axis moves evenly without any force.
TEST(Repair, AConstantForceThatBalancesFrictionIsNoDriveOff) {
  constexpr double kRate_Hz = 1000.0;
  constexpr double kFriction_N = 5.0;
  test::Draw draw(14);
  Log log;
  log.sample_rate_Hz = kRate_Hz;
  log.encoder_resolution_m = 1e-6;
  double x_m = 0.0;
  double v_mps = 0.0;
  for (int move = 0; move < 20; ++move) {
    const double way = move % 2 == 0 ? 1.0 : -1.0;
    for (double t_s = 0.0; t_s < 2.0; t_s += 1.0 / kRate_Hz) {
      const double a_mps2 = t_s < 0.2 ? way : t_s < 1.2 ? 0.0 : t_s < 1.4 ? -way : 0.0;
      v_mps += a_mps2 / kRate_Hz;
      x_m += v_mps / kRate_Hz;
      const double dry_N = t_s < 1.4 ? kFriction_N * way : 0.0;
      log.position_m.push_back(1e-6 * std::round(1e6 * x_m));
      log.force_N.push_back(1e-5 *
                            std::round(1e5 * (8.0 * a_mps2 + dry_N + kFriction_N + 0.05 * draw.normal())));
    }
  }
  for (const std::string& note : repair(log).notes)
    EXPECT_EQ(note.find("without any force"), std::string::npos) << note;
}

TEST(Repair, TooMuchIsRefused) {
  Log log = plant_log(18);
  test::Draw draw(9);
  for (std::size_t i = 50; i + 50 < log.force_N.size(); i += 31) log.force_N[i] += 500.0 * draw.sign();
  try {
    repair(log);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("are outliers"), std::string::npos);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

TEST(Robust, AFewKnocksDoNotChangeTheEstimates) {
  const Log clean = plant_log(19);
  Log knocked = clean;
  test::Draw draw(10);
  for (int knock = 0; knock < 6; ++knock) {
    const auto at =
        static_cast<std::size_t>(draw.uniform(9000.0, static_cast<double>(clean.force_N.size()) - 200.0));
    for (std::size_t i = at; i < at + 40; ++i) knocked.force_N[i] += 60.0;
  }
  Measurement measurement(knocked);
  weigh_rows(measurement);
  const FittedModel plain = fit_effects(measurement, kEffects, {});
  const RobustFit robust = fit_robustly(measurement, plain);
  EXPECT_GT(robust.outliers, 5);
  const double truth = found_in(clean).mass_kg;
  const auto mass = [](const FittedModel& model) { return find_term(model.terms, "inertia")->gains[0]; };
  EXPECT_NEAR(mass(robust.model), truth, 0.005 * truth);
  EXPECT_LE(std::abs(mass(robust.model) - truth), std::abs(mass(plain) - truth) + 1e-3 * truth);
  EXPECT_LT(robust.model.holdout_rmse_N, 0.5 * plain.holdout_rmse_N);
}

TEST(Robust, GaussianResidualsKeepTheirWeight) {
  Measurement measurement(test::wandering_log(20, 500.0, 8000));
  const FittedModel plain = fit_effects(measurement, {"inertia", "viscous", "offset_force"}, {});
  const RobustFit robust = fit_robustly(measurement, plain);
  EXPECT_EQ(robust.outliers, 0);
  EXPECT_EQ(robust.model.terms[0].gains, plain.terms[0].gains);
}

}  // namespace
}  // namespace slipstack::workbench
