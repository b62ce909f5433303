// SPDX-License-Identifier: Apache-2.0
// A new program reports in, or does not: then the one before comes back, whatever the way.
#include "firmware/update/trial_watch.h"

#include <gtest/gtest.h>

#include <functional>

#include "firmware/update/program_writer.h"
#include "tests/unit/update/cut_memory.h"

namespace slipstack::update {
namespace {
using namespace test;  // NOLINT(google-build-using-namespace)

constexpr std::uint32_t kMillisecond = 1000;

struct Trial {
  CutMemory memory;
  Trial() {
    flash_new(memory, random_bytes(100, 1));
    const Bytes program = random_bytes(90, 2);
    const auto put = [&](std::size_t at, const Bytes& bytes) {
      std::copy(bytes.begin(), bytes.end(), memory.slots[1].bytes.begin() + static_cast<std::ptrdiff_t>(at));
    };
    put(0, header_for(1, program).bytes());
    put(64, words({2, ~2U}));
    put(512, program);
  }
  std::size_t boot() {
    const std::optional<std::size_t> slot = decide(memory);
    EXPECT_TRUE(slot.has_value());
    memory.runs = slot.value_or(0);
    return memory.runs;
  }
  /// Runs for so long; `reports` and `idle` by the millisecond.
  SlotState run(
      std::uint32_t from_us, int milliseconds, const std::function<bool(int)>& reports,
      const std::function<bool(int)>& idle = [](int) { return true; }) {
    TrialWatch watch(memory);
    for (int i = 0; i <= milliseconds && memory.restarts == 0; ++i) {
      watch.step(from_us + static_cast<std::uint32_t>(i) * kMillisecond, reports(i), idle(i));
    }
    return watch.state();
  }
};
const auto kAlways = [](int) { return true; };
const auto kNever = [](int) { return false; };

TEST(TrialWatch, ConfirmsAfterFiveSecondsOnTheBus) {
  for (const std::uint32_t from_us : {0U, 0xFFFFFFFFU - 2'000'000U}) {  // the clock may wrap
    Trial shorter;
    EXPECT_EQ(shorter.boot(), 1U);
    EXPECT_EQ(shorter.run(from_us, 4999, kAlways), SlotState::kTrial);
    Trial enough;
    EXPECT_EQ(enough.boot(), 1U);
    EXPECT_EQ(enough.run(from_us, 5000, kAlways), SlotState::kConfirmed);
    for (int i = 0; i < 10; ++i) EXPECT_EQ(enough.boot(), 1U) << "for good";
    EXPECT_EQ(look(enough.memory, 1).state, SlotState::kConfirmed);
  }
}

TEST(TrialWatch, AGapBeginsTheFiveSecondsAnew) {
  Trial trial;
  EXPECT_EQ(trial.boot(), 1U);
  const auto gap = [](int ms) { return ms != 4000; };
  EXPECT_EQ(trial.run(0, 8999, gap), SlotState::kTrial);
  EXPECT_EQ(trial.run(0, 9000, gap), SlotState::kConfirmed);
}

TEST(TrialWatch, NeitherWritesNorRestartsWhileTheAxisIsDriven) {
  Trial trial;
  EXPECT_EQ(trial.boot(), 1U);
  const std::size_t steps = trial.memory.supply.steps;
  EXPECT_EQ(trial.run(0, 100'000, kAlways, kNever), SlotState::kTrial);
  EXPECT_EQ(trial.run(0, 100'000, kNever, kNever), SlotState::kTrial);
  EXPECT_EQ(trial.memory.restarts, 0);
  EXPECT_EQ(trial.memory.supply.steps, steps);
  EXPECT_EQ(trial.run(0, 30'000, kAlways, [](int ms) { return ms > 20'000; }), SlotState::kConfirmed);
}

TEST(TrialWatch, RestartsAfterAMinuteOfSilence) {
  Trial shorter;
  EXPECT_EQ(shorter.boot(), 1U);
  EXPECT_EQ(shorter.run(0, 59'999, kNever), SlotState::kTrial);
  EXPECT_EQ(shorter.memory.restarts, 0);
  Trial longer;
  EXPECT_EQ(longer.boot(), 1U);
  EXPECT_EQ(longer.run(0, 60'000, kNever), SlotState::kTrial);
  EXPECT_EQ(longer.memory.restarts, 1);
}

TEST(TrialWatch, ThreeStartsInVainBringTheOldProgramBack) {
  Trial silent;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(silent.boot(), 1U);
    silent.run(0, 60'000, kNever);
    EXPECT_EQ(silent.memory.restarts, 1);
    silent.memory.restarts = 0;
  }
  for (int i = 0; i < 5; ++i) EXPECT_EQ(silent.boot(), 0U);
  EXPECT_EQ(look(silent.memory, 1).state, SlotState::kGivenUp);
  EXPECT_EQ(look(silent.memory, 0).state, SlotState::kConfirmed);

  Trial crashing;  // before its main loop: a hard fault, a watchdog
  for (int i = 0; i < 3; ++i) EXPECT_EQ(crashing.boot(), 1U);
  EXPECT_EQ(crashing.boot(), 0U);

  Trial late;  // the third start is as good as the first
  for (int i = 0; i < 3; ++i) EXPECT_EQ(late.boot(), 1U);
  EXPECT_EQ(late.run(0, 5000, kAlways), SlotState::kConfirmed);
  EXPECT_EQ(late.boot(), 1U);
}

// The only program there is: it is never restarted, and may still report in.
TEST(TrialWatch, ALastResortRunsAndMayProveItself) {
  Trial trial;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(trial.boot(), 1U);
  trial.memory.slots[0].bytes[520] ^= std::byte{1};
  EXPECT_EQ(trial.boot(), 1U);
  EXPECT_EQ(trial.run(0, 200'000, kNever), SlotState::kGivenUp);
  EXPECT_EQ(trial.memory.restarts, 0);
  EXPECT_EQ(trial.run(0, 5000, kAlways), SlotState::kConfirmed);
}

// Until it has reported in, the program before is not erased: on none of the three starts.
TEST(TrialWatch, NoUpdateBeforeTheTrialEnds) {
  Trial trial;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(trial.boot(), 1U);
    EXPECT_EQ(ProgramWriter(trial.memory).clear(), UpdateFault::kOnTrial) << i;
  }
  EXPECT_EQ(trial.boot(), 0U);
  EXPECT_EQ(ProgramWriter(trial.memory).clear(), UpdateFault::kNone);
}

TEST(TrialWatch, AConfirmationThatFlashDoesNotTakeIsTriedAgain) {
  Trial trial;
  EXPECT_EQ(trial.boot(), 1U);
  TrialWatch watch(trial.memory);
  trial.memory.supply.cut_at = trial.memory.supply.steps;
  trial.memory.supply.tear = Tear::kGarbage;
  std::uint32_t now_us = 0;
  for (; now_us < 8'000'000; now_us += kMillisecond) watch.step(now_us, true, true);
  EXPECT_EQ(watch.state(), SlotState::kTrial);
  trial.memory.supply.restore();
  for (; now_us < 13'000'000; now_us += kMillisecond) watch.step(now_us, true, true);
  EXPECT_EQ(watch.state(), SlotState::kConfirmed);
  EXPECT_EQ(look(trial.memory, 1).state, SlotState::kConfirmed);
}

TEST(TrialWatch, AProgramThatWasNotInstalledIsLeftAlone) {
  CutMemory memory;  // as a debugger leaves it
  TrialWatch watch(memory);
  for (std::uint32_t now_us = 0; now_us < 200'000'000; now_us += 100 * kMillisecond)
    watch.step(now_us, false, true);
  EXPECT_EQ(watch.state(), SlotState::kEmpty);
  EXPECT_EQ(memory.restarts, 0);
  EXPECT_EQ(memory.supply.steps, 0U);
}

}  // namespace
}  // namespace slipstack::update
