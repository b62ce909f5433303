// SPDX-License-Identifier: Apache-2.0
// What `record` writes of a moving axis is a log of which `diagnose` says the right thing.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <deque>
#include <vector>

#include "tests/can/master/desk.h"
#include "tests/unit/temporary_directory.h"
#include "workbench/cleaning/repair.h"
#include "workbench/diagnose/diagnose.h"
#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {
namespace {

struct Move {
  std::int32_t to_counts;
  std::uint32_t counts_per_s;
};

// Small moves at several places, slow traverses, fast ones: what docs/can-sessions.md does by cansend.
constexpr std::array<Move, 19> kMoves = {{{200060, 2000},
                                          {200000, 1000},
                                          {200150, 3000},
                                          {230000, 100000},
                                          {230080, 1000},
                                          {230000, 1000},
                                          {228000, 5000},
                                          {180000, 200000},
                                          {179900, 500},
                                          {180000, 1000},
                                          {182000, 10000},
                                          {150000, 50000},
                                          {150050, 300},
                                          {150000, 300},
                                          {250000, 250000},
                                          {249000, 2000},
                                          {250500, 4000},
                                          {190000, 150000},
                                          {200000, 20000}}};

/// A master that gives the set-points of kMoves, over and over, as profile velocity by SDO and target by
/// RPDO 2, while another one records.
class Mover {
 public:
  explicit Mover(Desk& desk) : desk_(desk) {
    desk.enable();
    desk.link->each_tick = [this](std::uint64_t tick) { give(tick); };
  }

 private:
  void give(std::uint64_t tick) {
    if (desk_.drive->node().state() != canopen::NmtState::kOperational) return;
    if (tick >= next_) {
      const Move& move = kMoves[number_++ % kMoves.size()];
      const auto velocity = move.counts_per_s;
      const auto target = static_cast<std::uint32_t>(move.to_counts);
      waiting_.push_back(frame(
          0x605,
          {0x23, 0x81, 0x60, 0, byte(velocity, 0), byte(velocity, 1), byte(velocity, 2), byte(velocity, 3)},
          8));
      for (const std::uint8_t word : {std::uint8_t{0x0F}, std::uint8_t{0x1F}}) {
        waiting_.push_back(frame(
            0x305, {word, 0, byte(target, 0), byte(target, 1), byte(target, 2), byte(target, 3), 0, 0}, 6));
      }
      const double way_s = std::fabs(move.to_counts - at_counts_) / velocity + velocity / 1e6;
      next_ = tick + 2000 + static_cast<std::uint64_t>(1e4 * way_s);
      at_counts_ = move.to_counts;
    }
    if (tick % 50 == 0 && !waiting_.empty()) {
      desk_.port.send(waiting_.front());
      waiting_.pop_front();
    }
  }
  static std::uint8_t byte(std::uint32_t word, int at) { return static_cast<std::uint8_t>(word >> (8 * at)); }
  static CanFrame frame(std::uint32_t id, const std::array<std::uint8_t, 8>& data, std::uint8_t length) {
    CanFrame made;
    made.id = id;
    made.length = length;
    made.data = data;
    return made;
  }

  Desk& desk_;
  std::deque<CanFrame> waiting_;
  std::uint64_t next_ = 0;
  std::size_t number_ = 0;
  std::int32_t at_counts_ = 200000;
};

Log read_text(const std::string& text, const char* name) {
  const slipstack::test::TemporaryDirectory directory;
  return read_log(directory.write(std::string(name) + ".csv", text));
}

Diagnosis diagnosis_of(const std::string& text, const char* name) {
  const Log log = read_text(text, name);
  DiagnoseOptions options;
  options.baseline = {"inertia", "presliding_hysteresis"};
  Measurement measurement(log);
  weigh_rows(measurement);
  return diagnose(measurement, options);
}

// The recorded force is a commanded current: constant while the axis moves by as many counts in each sample,
// and no fault of a sensor.
TEST(RecordAndDiagnose, NothingOfARecordingIsCut) {
  for (const std::uint64_t seed : {1U, 4U, 6U}) {
    for (const double rate_Hz : {500.0, 1000.0}) {
      Desk desk(seed);
      const Mover mover(desk);
      const Recording recording = record_stream(*desk.client, 18.0, rate_Hz, kNoiseless);
      Log log = read_text(recording.log, "constant");
      const Repairs repairs = repair(log);
      EXPECT_TRUE(repairs.cut.empty()) << seed << ' ' << rate_Hz << ": " << repairs.notes.front();
    }
  }
}

TEST(RecordAndDiagnose, ACleanAxisIsComplete) {
  for (const std::uint64_t seed : {1U, 2U}) {
    Desk desk(seed);
    const Mover mover(desk);
    const Recording recording = record_stream(*desk.client, 18.0, 1000.0, kNoiseless);
    const Diagnosis diagnosis = diagnosis_of(recording.log, "clean");
    EXPECT_EQ(diagnosis.verdict, Verdict::complete)
        << seed << ' ' << diagnosis.explained.holdout_rmse_N / diagnosis.noise_floor_N << " floors; "
        << (diagnosis.unexplained ? diagnosis.unexplained->description : "");
    EXPECT_LT(diagnosis.baseline.holdout_rmse_N, 2.5 * diagnosis.noise_floor_N);
  }
}

TEST(RecordAndDiagnose, ACleanAxisAtAFewSamplesIsNotGivenAName) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    Desk desk(seed);
    const Mover mover(desk);
    const Recording recording = record_stream(*desk.client, 18.0, 500.0, kNoiseless);
    const Diagnosis diagnosis = diagnosis_of(recording.log, "coarse");
    EXPECT_NE(diagnosis.verdict, Verdict::missing_effect)
        << seed << ' ' << diagnosis.candidates[0].term.effect->text.id;
  }
}

TEST(RecordAndDiagnose, AHiddenEffectIsNamed) {
  for (const sim::EffectId hidden : {sim::EffectId::kViscous, sim::EffectId::kDirectionAsymmetry}) {
    sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 1);
    sim::add_effects(bench.axis, {hidden}, sim::draw_programme(bench, 1), bench.rate_Hz, 6.0, 1);
    Desk desk(bench, 1);
    const Mover mover(desk);
    const Recording recording = record_stream(*desk.client, 18.0, 1000.0, kNoiseless);
    const Diagnosis diagnosis = diagnosis_of(recording.log, "hidden");
    EXPECT_EQ(diagnosis.verdict, Verdict::missing_effect);
    ASSERT_FALSE(diagnosis.candidates.empty());
    EXPECT_EQ(diagnosis.candidates[0].term.effect->text.id, sim::name(hidden));
  }
}

}  // namespace
}  // namespace slipstack::workbench
