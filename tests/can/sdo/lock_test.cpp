// SPDX-License-Identifier: Apache-2.0
// The access lock.
#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

TEST(SipHash, VectorOfTheAuthors) {
  // Aumasson, Bernstein, reference implementation: key 00..0f, message 00..07.
  EXPECT_EQ(canopen::siphash(0x0706050403020100U, 0x0F0E0D0C0B0A0908U, 0x0706050403020100U),
            0x93F5F5799A932462U);
}

class LockTest : public ::testing::Test {
 protected:
  void SetUp() override {
    for (std::uint8_t i = 0; i < 4; ++i) {
      ASSERT_EQ(bench.write(0x2400, static_cast<std::uint8_t>(6 + i), 0x11111111U * (i + 1U), 4), 0U);
    }
    ASSERT_EQ(bench.write(0x2400, 10, 1, 1), 0U);
  }
  std::uint64_t challenge() {
    const std::uint64_t low = bench.read(0x2400, 2);
    return low | (static_cast<std::uint64_t>(bench.read(0x2400, 3)) << 32);
  }
  std::uint32_t respond(std::uint64_t response) {
    bench.write(0x2400, 4, static_cast<std::uint32_t>(response), 4);
    return bench.write(0x2400, 5, static_cast<std::uint32_t>(response >> 32), 4);
  }
  static std::uint64_t answer(std::uint64_t question) {
    return canopen::siphash(0x2222222211111111U, 0x4444444433333333U, question);
  }
  Bench bench;  // NOLINT(readability-identifier-naming): used as a local one is elsewhere
};

TEST_F(LockTest, WritingNeedsTheKey) {
  EXPECT_EQ(bench.read(0x2400, 1), 1U);
  const std::uint32_t before = bench.read(0x2000, 5);
  EXPECT_EQ(bench.write_real(0x2000, 5, 50.0F), 0x08000021U);
  EXPECT_EQ(bench.write(0x1010, 1, 0x65766173, 4), 0x08000021U);
  EXPECT_EQ(bench.write(0x1011, 1, 0x64616F6C, 4), 0x08000021U);
  EXPECT_EQ(bench.write(0x2400, 6, 0, 4), 0x08000021U) << "the key itself";
  EXPECT_EQ(bench.write(0x2400, 10, 0, 1), 0x08000021U) << "and the lock";
  EXPECT_EQ(Bench::number(bench.sdo(Bench::address(0xC4, 0x2141, 0)), 4), 0x08000021U);
  EXPECT_EQ(bench.read(0x2000, 5), before);
  EXPECT_EQ(bench.sdo(Bench::address(0x40, 0x2400, 6)).at(0), 0x80) << "the key is never read";
  EXPECT_EQ(respond(answer(challenge())), 0U);
  EXPECT_EQ(bench.read(0x2400, 1), 2U);
  EXPECT_EQ(bench.write_real(0x2000, 5, 50.0F), 0U);
  bench.nmt(0x82);
  EXPECT_EQ(bench.write_real(0x2000, 5, 60.0F), 0x08000021U) << "closed again after a reset";
}

TEST_F(LockTest, EachChallengeIsGoodForOneTry) {
  const std::uint64_t first = challenge();
  EXPECT_NE(challenge(), first);
  EXPECT_EQ(respond(answer(first)), 0x08000021U);
  bench.run_ms(1100);
  const std::uint64_t good = answer(challenge());
  EXPECT_EQ(respond(good), 0U);
  bench.nmt(0x82);
  EXPECT_EQ(respond(good), 0x08000021U) << "a recorded response";
}

// Two drives from the same reset, with the same key and the same frames: who repeats the frames of a morning
// finds another challenge, as they come at another time.
TEST_F(LockTest, TheTimeOfAFrameIsInTheChallenge) {
  const auto challenge_after = [](int wait_ms) {
    Bench other;
    for (std::uint8_t sub = 6; sub < 10; ++sub) EXPECT_EQ(other.write(0x2400, sub, 0x11111111U, 4), 0U);
    EXPECT_EQ(other.write(0x2400, 10, 1, 1), 0U);
    other.run_ms(wait_ms);
    const std::uint64_t low = other.read(0x2400, 2);
    return low | (static_cast<std::uint64_t>(other.read(0x2400, 3)) << 32);
  };
  EXPECT_EQ(challenge_after(3), challenge_after(3)) << "all else is the same";
  EXPECT_NE(challenge_after(3), challenge_after(4));
}

TEST_F(LockTest, WrongTriesAreSlowedDown) {
  int tries = 0;
  for (int ms = 0; ms < 16000; ms += 50) {
    // The right answer opens only when the wait is over: until then it is not even looked at.
    const std::uint32_t wait = bench.node->lock().wait_us();
    respond(1);
    tries += bench.node->lock().wait_us() != wait ? 1 : 0;
    bench.run_ms(50);
  }
  EXPECT_EQ(tries, 5) << "at about 0, 1, 3, 7, 15 s";
  EXPECT_EQ(respond(answer(challenge())), 0x08000021U) << "still waiting";
  bench.run_ms(16000);
  EXPECT_EQ(respond(answer(challenge())), 0U);
}

}  // namespace
}  // namespace slipstack::can
