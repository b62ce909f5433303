// SPDX-License-Identifier: Apache-2.0
// The boot loader's decision on random headers, marks and notes, against a second reading of
// docs/firmware-update.md.
#include <gtest/gtest.h>

#include <map>

#include "firmware/update/boot_choice.h"
#include "tests/unit/update/cut_memory.h"

namespace slipstack::update {
namespace {
using namespace test;  // NOLINT(google-build-using-namespace)

std::uint32_t word_at(const Bytes& bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word |= std::to_integer<std::uint32_t>(bytes[at + i]) << (8 * i);
  return word;
}
bool readable(const CutPages& pages, std::size_t begin, std::size_t size) {
  for (std::size_t unit = begin / 8; unit < (begin + size + 7) / 8; ++unit) {
    if (pages.unreadable.contains(unit)) return false;
  }
  return true;
}

// What the document says of one slot, read from the raw bytes.
struct Expected {
  bool present = false;
  bool whole = false;
  bool confirmed = false;
  std::uint32_t starts = 0;
  std::uint32_t install = 0;
};

Expected expected_of(const CutMemory& memory, std::size_t slot) {
  Expected expected;
  const CutPages& pages = memory.slots[slot];
  const Bytes& bytes = pages.bytes;
  if (!readable(pages, 0, 64)) return expected;
  const std::vector<std::uint32_t> fixed = {0x49504C53, 1, 0, 0x534C4B31, CutMemory::kBoard};
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    if (word_at(bytes, 4 * i) != fixed[i]) return expected;
  }
  const std::uint32_t size = word_at(bytes, 28);
  if (word_at(bytes, 60) != crc_by_division(std::span(bytes).first(60))) return expected;
  if (word_at(bytes, 24) != CutMemory::kAddresses[slot] || size == 0 || size > bytes.size() - 512)
    return expected;
  if (!readable(pages, 64, 8) || word_at(bytes, 64) != ~word_at(bytes, 68)) return expected;
  expected.install = word_at(bytes, 64);
  expected.present = expected.install > 0 && expected.install <= 0xFFFFFF;
  expected.whole = readable(pages, 512, size) &&
                   word_at(bytes, 32) == crc_by_division(std::span(bytes).subspan(512, size));
  const CutPages& notes = memory.note_pages[slot];
  for (std::size_t at = 0; at < notes.bytes.size(); at += 8) {
    if (!readable(notes, at, 8) || word_at(notes.bytes, at) != ~word_at(notes.bytes, at + 4)) continue;
    if (word_at(notes.bytes, at) == (0x53000000 | expected.install)) ++expected.starts;
    if (word_at(notes.bytes, at) == (0x43000000 | expected.install)) expected.confirmed = true;
  }
  return expected;
}

// The latest install that is whole and was not started three times in vain; else the latest that is whole.
std::optional<std::size_t> expected_choice(const std::array<Expected, 2>& slots) {
  std::optional<std::size_t> best;
  for (const bool given_up : {false, true}) {
    for (const std::size_t slot : {0U, 1U}) {
      const Expected& one = slots[slot];
      if (!one.present || !one.whole || (!one.confirmed && one.starts >= 3) != given_up) continue;
      if (!best || one.install > slots[*best].install) best = slot;
    }
    if (best) return best;
  }
  return best;
}

void put(Bytes& into, std::size_t at, const Bytes& bytes) {
  std::copy(bytes.begin(), bytes.end(), into.begin() + static_cast<std::ptrdiff_t>(at));
}

class RandomMemory {
 public:
  explicit RandomMemory(unsigned seed) : random_(seed) {}

  void fill(CutMemory& memory) {
    for (const std::size_t slot : {0U, 1U}) {
      if (one_in(12)) continue;  // blank
      const std::uint32_t install = one_in(10) ? draw() : 1 + draw() % 4;
      fill_slot(memory, slot, install);
      fill_notes(memory, slot, install);
      for (auto* pages : {&memory.slots[slot], &memory.note_pages[slot]}) {
        // Not so far back that the page of notes counts as full.
        if (one_in(8)) pages->unreadable.insert(draw() % (pages->bytes.size() / 16));
        if (one_in(8)) pages->bytes[random_() % 80] ^= std::byte{0x04};
      }
    }
  }

 private:
  std::uint32_t draw() { return static_cast<std::uint32_t>(random_()); }
  bool one_in(unsigned n) { return draw() % n == 0; }

  void fill_slot(CutMemory& memory, std::size_t slot, std::uint32_t install) {
    const Bytes program = random_bytes(1 + draw() % 3000, draw());
    HeaderWords header = header_for(slot, program);
    const std::array<std::uint32_t*, 9> fields = {&header.magic,   &header.layout, &header.vendor,
                                                  &header.product, &header.board,  &header.address,
                                                  &header.size,    &header.crc,    &header.version};
    if (one_in(6)) *fields[draw() % fields.size()] ^= 1U << draw() % 32;
    if (one_in(20)) header.size = draw();
    Bytes bytes = header.bytes();
    if (one_in(10)) bytes[random_() % bytes.size()] ^= std::byte{0x20};
    put(memory.slots[slot].bytes, 0, bytes);
    put(memory.slots[slot].bytes, 512, program);
    if (one_in(10)) return;
    put(memory.slots[slot].bytes, 64, words({install, one_in(10) ? draw() : ~install}));
  }
  void fill_notes(CutMemory& memory, std::size_t slot, std::uint32_t install) {
    const std::size_t count = random_() % 7;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t kind = one_in(4) ? 0x43000000 : one_in(8) ? draw() & 0xFF000000 : 0x53000000;
      const std::uint32_t word = kind | (one_in(5) ? draw() % 4 : install & 0xFFFFFF);
      put(memory.note_pages[slot].bytes, 8 * i, words({word, one_in(8) ? 0U : ~word}));
    }
  }

  std::mt19937 random_;
};

TEST(UpdateDecision, IsThatOfTheDocumentOnRandomMemory) {
  std::map<int, int> seen;  // neither, first, second
  int on_trial = 0;
  int last_resort = 0;
  for (unsigned seed = 0; seed < 20'000; ++seed) {
    CutMemory memory;
    RandomMemory(seed).fill(memory);
    const std::array<Expected, 2> slots = {expected_of(memory, 0), expected_of(memory, 1)};
    const std::optional<std::size_t> wanted = expected_choice(slots);
    const std::size_t before = memory.supply.steps;
    const std::optional<std::size_t> chosen = decide(memory);
    ASSERT_EQ(chosen, wanted) << seed;
    ++seen[chosen ? static_cast<int>(*chosen) : -1];
    if (!chosen) continue;
    // The start of an image on trial is noted, once, and nothing else is written.
    const Expected& was = slots[*chosen];
    const Expected is = expected_of(memory, *chosen);
    const bool trial = !was.confirmed && was.starts <= 3;  // the fourth: for want of another
    ASSERT_EQ(is.starts, was.starts + (trial ? 1 : 0)) << seed;
    ASSERT_EQ(memory.supply.steps, before + (trial ? 1 : 0)) << seed;
    on_trial += trial ? 1 : 0;
    last_resort += !was.confirmed && was.starts >= 3 ? 1 : 0;
  }
  // Every kind of case was there often enough to mean something.
  EXPECT_GT(seen[-1], 500);
  EXPECT_GT(seen[0], 3000);
  EXPECT_GT(seen[1], 3000);
  EXPECT_GT(on_trial, 1000);
  EXPECT_GT(last_resort, 300);
}

TEST(UpdateDecision, CrcIsThatOfTheStandard) {
  for (unsigned size = 0; size < 300; ++size) {
    const Bytes bytes = random_bytes(size, size);
    ASSERT_EQ(crc32(bytes), crc_by_division(bytes));
    const std::size_t cut = size / 3;
    ASSERT_EQ(crc32(std::span(bytes).subspan(cut), crc32(std::span(bytes).first(cut))),
              crc_by_division(bytes));
  }
}

// A start that cannot be noted could repeat for ever: the other program is started instead, if there is one.
TEST(UpdateDecision, WithoutNotesTheOtherProgramIsStarted) {
  CutMemory memory;
  flash_new(memory, random_bytes(100, 1));
  const Bytes program = random_bytes(90, 2);
  put(memory.slots[1].bytes, 0, header_for(1, program).bytes());
  put(memory.slots[1].bytes, 64, words({2, ~2U}));
  put(memory.slots[1].bytes, 512, program);
  {
    CutMemory works = memory;
    EXPECT_EQ(decide(works), 1U);
  }
  memory.supply.cut_at = 0;
  ++memory.supply.steps;  // the flash takes nothing any more
  EXPECT_EQ(decide(memory), 0U);
  memory.slots[0].bytes[600] ^= std::byte{1};
  EXPECT_EQ(decide(memory), 1U) << "better than none";
}

// The page of notes is erased when it is full, before the first start of an install and never later.
TEST(UpdateDecision, AFullPageOfNotesIsErasedForANewInstall) {
  CutMemory memory;
  flash_new(memory, random_bytes(100, 1));
  const Bytes program = random_bytes(90, 2);
  put(memory.slots[1].bytes, 0, header_for(1, program).bytes());
  put(memory.slots[1].bytes, 64, words({9, ~9U}));
  put(memory.slots[1].bytes, 512, program);
  for (std::size_t i = 0; i < 64; ++i)
    put(memory.note_pages[1].bytes, 8 * i, words({0x53000008, ~0x53000008U}));
  EXPECT_EQ(decide(memory), 1U);
  EXPECT_EQ(memory.note_pages[1].erasures, 1U);
  EXPECT_EQ(decide(memory), 1U);
  EXPECT_EQ(decide(memory), 1U);
  EXPECT_EQ(decide(memory), 0U) << "three starts in vain";
  EXPECT_EQ(decide(memory), 0U);
  EXPECT_EQ(memory.note_pages[1].erasures, 1U);
  EXPECT_EQ(memory.note_pages[0].erasures, 0U);
}

}  // namespace
}  // namespace slipstack::update
