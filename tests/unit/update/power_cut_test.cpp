// SPDX-License-Identifier: Apache-2.0
// Power fails at every step of a whole life: update, first start on trial, confirmation. After every one of
// them the boot loader starts the old program or the new one, whole.
#include <gtest/gtest.h>

#include "firmware/update/boot_choice.h"
#include "firmware/update/program_writer.h"
#include "firmware/update/trial_watch.h"
#include "tests/unit/update/cut_memory.h"

namespace slipstack::update {
namespace {
using namespace test;  // NOLINT(google-build-using-namespace)

// As the object 1F50h gives it: clear, transfer in pieces, end, start. False where the flash failed.
bool load(CutMemory& memory, const Bytes& file, std::size_t piece = 889) {
  ProgramWriter writer(memory);
  if (writer.clear() != UpdateFault::kNone) return false;
  while (writer.clearing()) {
    if (writer.step() != UpdateFault::kNone) return false;
  }
  if (writer.begin() != UpdateFault::kNone) return false;
  for (std::size_t at = 0; at < file.size(); at += piece) {
    const auto part = std::span(file).subspan(at, std::min(piece, file.size() - at));
    if (writer.write(part) != UpdateFault::kNone) return false;
  }
  return writer.finish() == UpdateFault::kNone && writer.install() == UpdateFault::kNone;
}

// The boot loader, then the program until it has reported in, or power fails.
std::optional<std::size_t> start(CutMemory& memory, bool reports = true) {
  const std::optional<std::size_t> slot = decide(memory);
  if (!slot || memory.supply.dead()) return slot;
  memory.runs = *slot;
  TrialWatch watch(memory);
  for (std::uint32_t now_us = 0; now_us < 6'000'000; now_us += 100'000) watch.step(now_us, reports, true);
  return slot;
}

struct Programs {
  Bytes old_one = random_bytes(1777, 1);
  std::array<Bytes, 2> next = {random_bytes(1901, 2), random_bytes(2003, 3)};
  std::array<Bytes, 2> third = {random_bytes(1601, 4), random_bytes(1401, 5)};
};

// What runs after power is back: the program of the slot that the boot loader starts, or nothing.
enum class Runs { kNothing, kOld, kNew, kBroken };
Runs what_runs(CutMemory& memory, const Bytes& old_one, const std::array<Bytes, 2>& next,
               std::size_t old_slot) {
  const std::optional<std::size_t> slot = decide(memory);
  if (!slot) return Runs::kNothing;
  memory.runs = *slot;
  if (*slot == old_slot && holds(memory, *slot, old_one)) return Runs::kOld;
  return holds(memory, *slot, next[*slot]) ? Runs::kNew : Runs::kBroken;
}

// One life with the supply failing at `step`; false when it did not come to that step.
bool life_cut_at(std::size_t step, const CutMemory& begin, const Bytes& old_one,
                 const std::array<Bytes, 2>& next, const Programs& programs, Tear tear, bool unreadable) {
  CutMemory memory = begin;
  const std::size_t old_slot = memory.runs;
  const Bytes running = memory.slots[old_slot].bytes;
  memory.supply.steps = 0;
  memory.supply.cut_at = step;
  memory.supply.tear = tear;
  memory.supply.torn_unreadable = unreadable;
  if (load(memory, file_of(next))) static_cast<void>(start(memory));
  const bool cut = memory.supply.dead();
  memory.supply.restore();
  EXPECT_EQ(memory.slots[old_slot].bytes, running) << "the running program was touched, step " << step;
  const Runs runs = what_runs(memory, old_one, next, old_slot);
  EXPECT_TRUE(runs == Runs::kOld || runs == Runs::kNew) << static_cast<int>(runs) << " at step " << step;
  if (!cut) {
    EXPECT_EQ(runs, Runs::kNew);
    return false;
  }
  // Whatever happened, a further update works, once what runs has reported in.
  EXPECT_TRUE(start(memory));
  EXPECT_TRUE(load(memory, file_of(programs.third))) << step;
  const std::optional<std::size_t> slot = start(memory);
  EXPECT_TRUE(slot && holds(memory, *slot, programs.third[*slot])) << step;
  EXPECT_EQ(look(memory, *slot).state, SlotState::kConfirmed) << step;
  return true;
}

std::size_t cut_every_step(const CutMemory& begin, const Bytes& old_one, const std::array<Bytes, 2>& next,
                           const Programs& programs, Tear tear, bool unreadable, std::size_t stride = 1) {
  std::size_t step = 0;
  while (life_cut_at(step, begin, old_one, next, programs, tear, unreadable)) {
    if (testing::Test::HasFailure()) break;
    step += stride;
  }
  return step;
}

TEST(UpdatePowerCut, AtEveryStepLeavesTheOldOrTheNewProgram) {
  const Programs programs;
  for (const Tear tear : {Tear::kNothing, Tear::kGarbage, Tear::kHalf, Tear::kAll}) {
    for (const bool unreadable : {false, true}) {
      CutMemory fresh;
      flash_new(fresh, programs.old_one);
      const std::size_t steps =
          cut_every_step(fresh, programs.old_one, programs.next, programs, tear, unreadable);
      // 2003 bytes are 251 units, made full to eight of them; header, install, start, report.
      EXPECT_GT(steps, 251U + 8U + 3U);
      ASSERT_FALSE(HasFailure()) << static_cast<int>(tear) << unreadable;
    }
  }
}

// The same from slot 1 to slot 0, over what lies there from before.
TEST(UpdatePowerCut, AlsoOnTheWayBackOverAnOlderProgram) {
  const Programs programs;
  const std::array<Bytes, 2> more = {random_bytes(2222, 8), random_bytes(2100, 9)};
  for (const Tear tear : {Tear::kGarbage, Tear::kHalf}) {
    CutMemory second;
    flash_new(second, programs.old_one);
    ASSERT_TRUE(load(second, file_of(programs.next)));
    ASSERT_EQ(start(second), 1U);
    const std::size_t steps = cut_every_step(second, programs.next[1], more, programs, tear, true);
    EXPECT_GT(steps, 4U + 278U + 8U) << "pages are erased as well";
    ASSERT_FALSE(HasFailure());
  }
}

TEST(UpdatePowerCut, TwiceInARow) {
  const Programs programs;
  CutMemory fresh;
  flash_new(fresh, programs.old_one);
  std::mt19937 random(11);
  for (int i = 0; i < 3000; ++i) {
    CutMemory memory = fresh;
    memory.supply.tear = static_cast<Tear>(random() % 4);
    memory.supply.torn_unreadable = random() % 2 == 0;
    for (int cut = 0; cut < 2; ++cut) {
      memory.supply.cut_at = memory.supply.steps + random() % (cut == 0 ? 300 : 30);
      if (random() % 3 == 0) {  // while the boot loader or the program on trial writes
        static_cast<void>(start(memory));
      } else if (load(memory, file_of(programs.next))) {
        static_cast<void>(start(memory));
      }
      memory.supply.restore();
      const Runs runs = what_runs(memory, programs.old_one, programs.next, 0);
      ASSERT_TRUE(runs == Runs::kOld || runs == Runs::kNew) << i << ' ' << cut;
    }
  }
}

// The size of the part, 112 pages of 2 KiB: cuts all over it, each 211th step.
TEST(UpdatePowerCut, InASlotOfTheRealSize) {
  Programs programs;
  programs.old_one = random_bytes(150'000, 1);
  programs.next = {random_bytes(168'424, 2), random_bytes(168'421, 3)};
  programs.third = {random_bytes(1000, 4), random_bytes(1000, 5)};
  CutMemory fresh(112, 2048);
  flash_new(fresh, programs.old_one);
  const std::size_t steps =
      cut_every_step(fresh, programs.old_one, programs.next, programs, Tear::kGarbage, true, 1999);
  EXPECT_GT(steps, 21'054U);
}

}  // namespace
}  // namespace slipstack::update
