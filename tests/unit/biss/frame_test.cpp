// SPDX-License-Identifier: Apache-2.0
#include "hal/biss/frame.h"

#include <gtest/gtest.h>

#include <random>

#include "sim_host/sensors/biss_encoder.h"

namespace slipstack::biss {
namespace {

constexpr int kBytes = 16;

struct Draw {
  explicit Draw(std::mt19937& random)
      : setup{.bits = between(random, 8, 56),
              .delay_clocks = between(random, 0, 12),
              .processing_clocks = between(random, 1, 40)},
        position(
            std::uniform_int_distribution<std::uint64_t>(0, (std::uint64_t{1} << setup.bits) - 1)(random)) {}
  static int between(std::mt19937& random, int low, int high) {
    return std::uniform_int_distribution<int>(low, high)(random);
  }
  Frame decoded(const sim::BissEncoder::Fault& fault) const {
    return decode(sim::BissEncoder(setup).cycle(position, fault, kBytes), static_cast<unsigned>(setup.bits));
  }

  sim::BissEncoder::Setup setup;
  std::uint64_t position;
};

TEST(BissFrame, EveryPositionOfEveryEncoderIsRead) {
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    const Draw draw(random);
    const Frame frame = draw.decoded({.warning = i % 3 == 0});
    ASSERT_EQ(frame.reception, Reception::kGood) << i;
    ASSERT_EQ(frame.position, draw.position) << i;
    ASSERT_EQ(frame.warning, i % 3 == 0) << i;
  }
}

TEST(BissFrame, TheErrorBitIsToldFromABadCheckSum) {
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i)
    ASSERT_EQ(Draw(random).decoded({.error = true}).reception, Reception::kError);
}

// One disturbed bit is seen wherever it is; CDS, which is not read, disturbs nothing. A start bit that is
// missing puts the frame elsewhere, so that one in 64 passes for good: that is the limit of six bits.
TEST(BissFrame, ADisturbedBitIsSeen) {
  std::mt19937 random(3);
  int behind_a_lost_start = 0;
  for (int i = 0; i < 1000; ++i) {
    const Draw draw(random);
    for (int bit = -1; bit < 1 + draw.setup.bits + 2 + 6; ++bit) {
      const Frame frame = draw.decoded({.flipped = bit});
      if (bit == 0) {
        ASSERT_EQ(frame.reception, Reception::kGood);
        ASSERT_EQ(frame.position, draw.position);
      } else if (bit == -1) {
        behind_a_lost_start += frame.reception == Reception::kGood ? 1 : 0;
      } else {
        ASSERT_EQ(frame.reception, Reception::kBadCrc) << i << " bit " << bit;
      }
    }
  }
  EXPECT_LE(behind_a_lost_start, 1000 / 32);
}

// A line that falls in a frame, as when the supply goes, is no position: low flags are active, and the CRC is
// inverted. In its last bits nothing may be missing.
TEST(BissFrame, AFrameThatEndsEarlyIsNoPosition) {
  std::mt19937 random(4);
  for (int i = 0; i < 500; ++i) {
    const Draw draw(random);
    for (int end = 0; end < 1 + draw.setup.bits + 2 + 6; ++end) {
      const Frame frame = draw.decoded({.ends_at = end});
      if (end <= draw.setup.bits + 1) {
        ASSERT_NE(frame.reception, Reception::kGood) << i << " from bit " << end;
      } else if (frame.reception == Reception::kGood) {
        ASSERT_EQ(frame.position, draw.position);
      }
    }
  }
}

TEST(BissFrame, ALineThatRestsIsSilent) {
  for (int bits = 8; bits <= 56; ++bits) {
    const sim::BissEncoder encoder({.bits = bits});
    for (const auto& fault : {sim::BissEncoder::Fault{.unplugged = true}, {.short_circuit = true}}) {
      const Frame frame = decode(encoder.cycle(1234, fault, kBytes), static_cast<unsigned>(bits));
      EXPECT_EQ(frame.reception, Reception::kSilent);
    }
  }
}

// An encoder that takes longer than the master clocks, and a buffer that is too short.
TEST(BissFrame, AFrameThatDoesNotFitIsSilent) {
  const sim::BissEncoder late({.bits = 32, .processing_clocks = 90});
  EXPECT_EQ(decode(late.cycle(5, {}, kBytes), 32).reception, Reception::kSilent);
  const sim::BissEncoder encoder({.bits = 32, .delay_clocks = 0, .processing_clocks = 10});
  for (int bytes = 1; bytes < 7; ++bytes) {
    EXPECT_EQ(decode(encoder.cycle(5, {}, bytes), 32).reception, Reception::kSilent) << bytes;
  }
  EXPECT_EQ(decode(encoder.cycle(5, {}, 8), 32).reception, Reception::kGood);
}

}  // namespace
}  // namespace slipstack::biss
