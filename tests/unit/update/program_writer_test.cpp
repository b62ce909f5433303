// SPDX-License-Identifier: Apache-2.0
#include "firmware/update/program_writer.h"

#include <gtest/gtest.h>

#include "tests/unit/update/cut_memory.h"

namespace slipstack::update {
namespace {
using namespace test;  // NOLINT(google-build-using-namespace)

constexpr std::size_t kCapacity = 8 * 512 - 512;

struct Bench {
  CutMemory memory;
  Bytes old_one = random_bytes(700, 1);
  Bytes running;
  ProgramWriter writer{memory};

  Bench() {
    flash_new(memory, old_one);
    running = memory.slots[0].bytes;
  }
  ~Bench() { EXPECT_EQ(memory.slots[0].bytes, running) << "the running program was touched"; }
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  void clear() {
    ASSERT_EQ(writer.clear(), UpdateFault::kNone);
    while (writer.clearing()) ASSERT_EQ(writer.step(), UpdateFault::kNone);
  }
  /// Of the transfer as a whole: the first fault.
  UpdateFault transfer(const Bytes& file, unsigned seed = 1) {
    std::mt19937 random(seed);
    UpdateFault fault = writer.begin();
    for (std::size_t at = 0; at < file.size() && fault == UpdateFault::kNone;) {
      const std::size_t piece = std::min<std::size_t>(1 + random() % 200, file.size() - at);
      fault = writer.write(std::span(file).subspan(at, piece));
      at += piece;
    }
    return fault == UpdateFault::kNone ? writer.finish() : fault;
  }
  UpdateFault cleared_transfer(const Bytes& file) {
    clear();
    return transfer(file);
  }
  bool would_start_new() {
    CutMemory copy = memory;
    return decide(copy) == 1U;
  }
};

TEST(ProgramWriter, TakesTheImageForItsSlotInAnyOrderAndPieces) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    Bench bench;
    const Bytes mine = random_bytes(1 + random() % kCapacity, seed);
    const Bytes other = random_bytes(1 + random() % 5000, seed + 1);  // may be larger than what fits here
    Bytes file = image_for(1, mine);
    const Bytes second = image_for(0, other);
    if (random() % 3 == 0) {
      file = joined(second, file);
    } else if (random() % 2 == 0) {
      file = joined(file, second);
    }
    bench.clear();
    ASSERT_EQ(bench.transfer(file, seed), UpdateFault::kNone) << seed;
    EXPECT_EQ(program_in(bench.memory, 1, mine.size()), mine);
    EXPECT_FALSE(bench.would_start_new()) << "not before it was told to";
    ASSERT_EQ(bench.writer.install(), UpdateFault::kNone);
    EXPECT_TRUE(bench.would_start_new());
    EXPECT_EQ(look(bench.memory, 1).install, 2U);
  }
}

TEST(ProgramWriter, FitsToTheLastByteAndNoFurther) {
  Bench fits;
  EXPECT_EQ(fits.cleared_transfer(image_for(1, random_bytes(kCapacity, 1))), UpdateFault::kNone);
  Bench too_large;
  EXPECT_EQ(too_large.cleared_transfer(image_for(1, random_bytes(kCapacity + 1, 1))), UpdateFault::kTooLarge);
  EXPECT_EQ(too_large.writer.install(), UpdateFault::kNoProgram);
}

TEST(ProgramWriter, RefusesWhatIsForAnotherDevice) {
  const Bytes program = random_bytes(100, 1);
  const auto changed = [&](auto change) {
    HeaderWords header = header_for(1, program);
    change(header);
    Bench bench;
    const UpdateFault fault = bench.cleared_transfer(joined(header.bytes(), program));
    EXPECT_EQ(bench.writer.install(), fault == UpdateFault::kNone ? fault : UpdateFault::kNoProgram);
    return fault;
  };
  EXPECT_EQ(changed([](HeaderWords&) {}), UpdateFault::kNone);
  EXPECT_EQ(changed([](HeaderWords& h) { h.version = 0x12345678; }), UpdateFault::kNone) << "any version";
  EXPECT_EQ(changed([](HeaderWords& h) { h.vendor = 1; }), UpdateFault::kWrongDevice);
  EXPECT_EQ(changed([](HeaderWords& h) { h.product ^= 1; }), UpdateFault::kWrongDevice);
  EXPECT_EQ(changed([](HeaderWords& h) { h.board ^= 1; }), UpdateFault::kWrongDevice);
  EXPECT_EQ(changed([](HeaderWords& h) { h.magic ^= 1; }), UpdateFault::kFormat);
  EXPECT_EQ(changed([](HeaderWords& h) { h.layout = 2; }), UpdateFault::kFormat);
  EXPECT_EQ(changed([](HeaderWords& h) { h.crc ^= 1; }), UpdateFault::kChecksum);
  EXPECT_EQ(changed([](HeaderWords& h) { h.address = CutMemory::kAddresses[0]; }), UpdateFault::kNotForSlot);
  EXPECT_EQ(changed([](HeaderWords& h) { h.size += 1; }), UpdateFault::kCutShort);
}

TEST(ProgramWriter, EveryBitOfAnImageCounts) {
  const Bytes image = image_for(1, random_bytes(60, 1));
  for (std::size_t bit = 0; bit < 8 * image.size(); ++bit) {
    Bytes damaged = image;
    damaged[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
    Bench bench;
    ASSERT_NE(bench.cleared_transfer(damaged), UpdateFault::kNone) << bit;
    ASSERT_EQ(bench.writer.install(), UpdateFault::kNoProgram);
    ASSERT_FALSE(bench.would_start_new());
  }
}

TEST(ProgramWriter, WantsItsOrderOfCommands) {
  Bench bench;
  EXPECT_EQ(bench.writer.begin(), UpdateFault::kNotCleared);
  EXPECT_EQ(bench.writer.install(), UpdateFault::kNoProgram);
  bench.clear();
  EXPECT_EQ(bench.writer.install(), UpdateFault::kNoProgram);
  EXPECT_EQ(bench.transfer({}), UpdateFault::kNotForSlot);
  EXPECT_EQ(bench.transfer(Bytes(40)), UpdateFault::kCutShort);
  ASSERT_EQ(bench.transfer(image_for(1, random_bytes(90, 1))), UpdateFault::kNone);
  EXPECT_EQ(bench.writer.begin(), UpdateFault::kNotCleared) << "loaded: the flash is not blank any more";
  ASSERT_EQ(bench.writer.install(), UpdateFault::kNone);
  EXPECT_EQ(bench.writer.install(), UpdateFault::kNoProgram) << "once";
}

TEST(ProgramWriter, DoesNotEraseWhatAProgramOnTrialFallsBackTo) {
  CutMemory memory;
  flash_new(memory, random_bytes(70, 1), false);
  ProgramWriter writer(memory);
  EXPECT_EQ(writer.clear(), UpdateFault::kOnTrial);
  EXPECT_FALSE(writer.clearing());
  EXPECT_EQ(writer.begin(), UpdateFault::kNotCleared);
  const Bytes note = words({0x43000001, ~0x43000001U});
  std::copy(note.begin(), note.end(), memory.note_pages[0].bytes.begin());
  EXPECT_EQ(writer.clear(), UpdateFault::kNone);
}

TEST(ProgramWriter, ErasesTheHeaderFirstAndNoBlankPage) {
  Bench bench;
  constexpr std::size_t kOther = 1545;  // in page 3
  constexpr std::size_t kLast = 3584;   // page 7 begins here
  Bytes& slot = bench.memory.slots[1].bytes;
  slot[5] = slot[kOther] = slot[kLast] = std::byte{0};
  ASSERT_EQ(bench.writer.clear(), UpdateFault::kNone);
  ASSERT_EQ(bench.writer.step(), UpdateFault::kNone);
  EXPECT_EQ(slot[5], std::byte{0xFF});
  EXPECT_EQ(slot[kOther], std::byte{0});
  while (bench.writer.clearing()) ASSERT_EQ(bench.writer.step(), UpdateFault::kNone);
  EXPECT_EQ(bench.memory.slots[1].erasures, 3U);
  EXPECT_TRUE(std::all_of(slot.begin(), slot.end(), [](std::byte b) { return b == std::byte{0xFF}; }));
}

// A transfer that broke off goes on where it was: the header of the rest says of what, and from where.
TEST(ProgramWriter, GoesOnWhereATransferBrokeOff) {
  const Bytes program = random_bytes(2500, 1);
  const Bytes image = image_for(1, program);
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    Bench bench;
    bench.clear();
    ASSERT_EQ(bench.writer.begin(), UpdateFault::kNone);
    ASSERT_EQ(bench.writer.write(std::span(image).first(64 + random() % program.size())), UpdateFault::kNone);
    for (bool done = false; !done;) {
      HeaderWords rest = header_for(1, program);
      rest.magic = 0x43504C53;
      rest.offset = bench.writer.taken();
      ASSERT_EQ(bench.writer.crc(), crc_by_division(program));
      const std::size_t some = std::min<std::size_t>(random() % 900, program.size() - rest.offset);
      ASSERT_EQ(bench.writer.begin(), UpdateFault::kNone);
      ASSERT_EQ(bench.writer.write(rest.bytes()), UpdateFault::kNone);
      ASSERT_EQ(bench.writer.write(std::span(program).subspan(rest.offset, some)), UpdateFault::kNone);
      done = bench.writer.taken() == program.size();
    }
    ASSERT_EQ(bench.writer.finish(), UpdateFault::kNone);
    ASSERT_EQ(program_in(bench.memory, 1, program.size()), program);
  }
}

TEST(ProgramWriter, DoesNotGoOnWithAnotherProgramOrPlace) {
  const Bytes program = random_bytes(2500, 1);
  const Bytes image = image_for(1, program);
  const auto go_on = [&](auto change) {
    Bench bench;
    bench.clear();
    EXPECT_EQ(bench.writer.begin(), UpdateFault::kNone);
    EXPECT_EQ(bench.writer.write(std::span(image).first(64 + 1000)), UpdateFault::kNone);
    HeaderWords rest = header_for(1, program);
    rest.magic = 0x43504C53;
    rest.offset = 1000;
    change(rest);
    EXPECT_EQ(bench.writer.begin(), UpdateFault::kNone);
    return bench.writer.write(rest.bytes());
  };
  EXPECT_EQ(go_on([](HeaderWords&) {}), UpdateFault::kNone);
  EXPECT_EQ(go_on([](HeaderWords& h) { h.offset = 999; }), UpdateFault::kNotCleared);
  EXPECT_EQ(go_on([](HeaderWords& h) { h.offset = 1001; }), UpdateFault::kNotCleared);
  EXPECT_EQ(go_on([](HeaderWords& h) { h.crc ^= 1; }), UpdateFault::kNotCleared);
  EXPECT_EQ(go_on([](HeaderWords& h) { h.size -= 1; }), UpdateFault::kNotCleared);
  EXPECT_EQ(go_on([](HeaderWords& h) { h.address ^= 1; }), UpdateFault::kNotCleared);
  EXPECT_EQ(go_on([](HeaderWords& h) { h.magic = 0x49504C53; }), UpdateFault::kNotCleared)
      << "from the begin again";
}

TEST(ProgramWriter, ReportsTheFlash) {
  const Bytes image = image_for(1, random_bytes(2500, 1));
  for (std::size_t step = 0; step < 330; ++step) {
    Bench bench;
    bench.clear();
    bench.memory.supply.cut_at = step;
    bench.memory.supply.steps = 0;
    const UpdateFault fault = bench.transfer(image);
    const bool cut = bench.memory.supply.dead();
    ASSERT_EQ(fault, cut ? UpdateFault::kFlash : UpdateFault::kNone) << step;
  }
}

}  // namespace
}  // namespace slipstack::update
