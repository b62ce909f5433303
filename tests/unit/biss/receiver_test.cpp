// SPDX-License-Identifier: Apache-2.0
#include "hal/biss/receiver.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "sim_host/sensors/biss_encoder.h"

namespace slipstack::biss {
namespace {

// A master with its encoder: one frame a tick.
struct Line {
  explicit Line(const EncoderInterface& interface, bool reversed = false)
      : encoder({.bits = interface.position_bits}) {
    receiver.use(interface, reversed);
  }
  EncoderReading tick(std::uint64_t position, const sim::BissEncoder::Fault& fault = {}) {
    receiver.received(encoder.cycle(position, fault, 16), ++time);
    return receiver.read();
  }

  sim::BissEncoder encoder;
  Receiver receiver;
  std::uint32_t time = 0;
};

constexpr EncoderInterface bits(std::uint8_t position, std::uint8_t dropped = 0) {
  return {EncoderInterface::Kind::kBissC, position, dropped};
}

TEST(BissReceiver, CountsArePositionsModulo2To32) {
  Line line(bits(36));
  for (const std::uint64_t position : {0x0FFFFFFF0ULL, 0x0FFFFFFFFULL, 0x100000000ULL, 0x100000005ULL,
                                       0xABCDEF012ULL, 0x07FFFFFFFULL, 0x080000000ULL}) {
    const EncoderReading reading = line.tick(position);
    EXPECT_TRUE(reading.valid);
    EXPECT_EQ(static_cast<std::uint32_t>(reading.counts), static_cast<std::uint32_t>(position));
    EXPECT_EQ(reading.latched, line.time);
  }
}

TEST(BissReceiver, DroppedBitsMakeCountsCoarser) {
  Line line(bits(40, 4));
  EXPECT_EQ(line.tick(0x12345678F).counts, 0x12345678);
}

// A shaft: the counts go on where the position begins anew, both ways, at any speed below half a turn a tick.
TEST(BissReceiver, CountsGoOnWhereThePositionWraps) {
  std::mt19937 random(5);
  for (const std::uint8_t wide : {std::uint8_t{8}, std::uint8_t{18}, std::uint8_t{24}, std::uint8_t{31}}) {
    Line line(bits(wide));
    const std::int64_t turn = std::int64_t{1} << wide;
    std::int64_t truth = turn / 3;
    const std::int64_t begin = line.tick(static_cast<std::uint64_t>(truth)).counts;
    ASSERT_EQ(begin, truth);
    std::uniform_int_distribution<std::int64_t> step(-turn / 2 + 1, turn / 2 - 1);
    for (int i = 0; i < 2000; ++i) {
      truth += step(random);
      const std::int64_t within = ((truth % turn) + turn) % turn;
      const EncoderReading reading = line.tick(static_cast<std::uint64_t>(within));
      ASSERT_EQ(static_cast<std::uint32_t>(reading.counts), static_cast<std::uint32_t>(truth));
    }
  }
}

TEST(BissReceiver, AReversedScaleCountsDown) {
  Line line(bits(32), true);
  EXPECT_EQ(line.tick(5).counts, -5);
  EXPECT_EQ(line.tick(0).counts, 0);
  EXPECT_EQ(line.tick(0x80000000ULL).counts, std::numeric_limits<std::int32_t>::min());
}

TEST(BissReceiver, NothingIsValidWithoutANewFrame) {
  Line line(bits(32));
  EXPECT_FALSE(line.receiver.read().valid) << "before the first frame";
  EXPECT_TRUE(line.tick(7).valid);
  const EncoderReading old = line.receiver.read();
  EXPECT_FALSE(old.valid);
  EXPECT_EQ(old.counts, 7) << "the last one that was good";
}

TEST(BissReceiver, EachKindOfFailureIsCounted) {
  Line line(bits(32));
  EXPECT_TRUE(line.tick(100).valid);
  EXPECT_FALSE(line.tick(101, {.unplugged = true}).valid);
  EXPECT_FALSE(line.tick(102, {.flipped = 20}).valid);
  EXPECT_FALSE(line.tick(103, {.flipped = 21}).valid);
  EXPECT_FALSE(line.tick(104, {.error = true}).valid);
  EXPECT_TRUE(line.tick(105, {.warning = true}).valid);
  line.receiver.late();
  FrameCounters counters = line.receiver.counters();
  EXPECT_EQ(counters.silent, 2U);
  EXPECT_EQ(counters.bad_crc, 2U);
  EXPECT_EQ(counters.errors, 1U);
  EXPECT_EQ(counters.warnings, 1U);
  EXPECT_TRUE(counters.warning);
  EXPECT_EQ(line.tick(106).counts, 106);
  EXPECT_FALSE(line.receiver.counters().warning);
}

// A carriage that is pushed over more than half of its scale while the encoder is off is found where it is.
TEST(BissReceiver, BehindALongGapThePositionIsTakenAsItIs) {
  const std::uint64_t far = 0xF00000;
  Line line(bits(24));
  static_cast<void>(line.tick(0x100000));
  for (std::uint32_t i = 0; i < Receiver::kGap; ++i) static_cast<void>(line.tick(0, {.unplugged = true}));
  EXPECT_EQ(line.tick(far).counts, 0xF00000);
  // After a short one it goes on, the shorter way round.
  Line other(bits(24));
  static_cast<void>(other.tick(0x100000));
  for (std::uint32_t i = 0; i + 1 < Receiver::kGap; ++i)
    static_cast<void>(other.tick(0, {.unplugged = true}));
  EXPECT_EQ(other.tick(far).counts, 0xF00000 - 0x1000000);
  // Frames that never ended are missing too.
  Line late(bits(24));
  static_cast<void>(late.tick(0x100000));
  for (std::uint32_t i = 0; i < Receiver::kGap; ++i) late.receiver.late();
  EXPECT_EQ(late.tick(far).counts, 0xF00000);
}

}  // namespace
}  // namespace slipstack::biss
