// SPDX-License-Identifier: Apache-2.0
#include "hal/mps2/memory_flash.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace slipstack::mps2 {
namespace {

using Status = NonvolatileStatus;

struct Memory {
  std::vector<std::byte> bytes = std::vector<std::byte>(8 + MemoryFlash::kPages * MemoryFlash::kPageBytes);
  MemoryFlash flash{bytes.data()};
};

TEST(MemoryFlash, IsErasedOnceAndThenKeepsWhatItHolds) {
  Memory memory;
  memory.flash.start();
  std::array<std::byte, 16> read{};
  ASSERT_EQ(memory.flash.read(1, 2032, read), Status::kOk);
  for (const std::byte byte : read) EXPECT_EQ(byte, std::byte{0xFF});
  const std::array<std::byte, 8> data = {std::byte{1}, std::byte{2}, std::byte{3}};
  ASSERT_EQ(memory.flash.write(1, 2040, data), Status::kOk);
  // The next run of the firmware.
  MemoryFlash again(memory.bytes.data());
  again.start();
  std::array<std::byte, 8> kept{};
  ASSERT_EQ(again.read(1, 2040, kept), Status::kOk);
  EXPECT_EQ(kept, data);
  ASSERT_EQ(again.erase(1), Status::kOk);
  ASSERT_EQ(again.read(1, 2040, kept), Status::kOk);
  EXPECT_EQ(kept[0], std::byte{0xFF});
}

TEST(MemoryFlash, KeepsTheRulesOfFlash) {
  Memory memory;
  memory.flash.start();
  const std::array<std::byte, 8> data{};
  std::array<std::byte, 9> odd{};
  EXPECT_EQ(memory.flash.write(0, 0, data), Status::kOk);
  EXPECT_EQ(memory.flash.write(0, 0, data), Status::kNotErased);
  EXPECT_EQ(memory.flash.write(0, 4, data), Status::kMisaligned);
  EXPECT_EQ(memory.flash.write(0, 8, odd), Status::kMisaligned);
  EXPECT_EQ(memory.flash.write(0, 2048, data), Status::kOutOfRange);
  EXPECT_EQ(memory.flash.write(2, 0, data), Status::kOutOfRange);
  EXPECT_EQ(memory.flash.write(0, static_cast<std::size_t>(-8), data), Status::kOutOfRange);
  EXPECT_EQ(memory.flash.read(0, 2040, odd), Status::kOutOfRange);
  EXPECT_EQ(memory.flash.erase(2), Status::kOutOfRange);
  std::array<std::byte, 8> other{};
  ASSERT_EQ(memory.flash.read(0, 8, other), Status::kOk);
  EXPECT_EQ(other[0], std::byte{0xFF});
}

}  // namespace
}  // namespace slipstack::mps2
