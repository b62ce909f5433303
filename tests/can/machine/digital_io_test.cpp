// SPDX-License-Identifier: Apache-2.0
// Digital inputs and outputs: terminals by 2010h, what they mean by 60FDh and 60FEh (IEC 61800-7-201).
#include <gtest/gtest.h>

#include <cstdint>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

// Limit switches 1 and 2 that open, home switch 3, ready 4, fault 5 active low; brake on output 2.
class Wired : public Bench {
 public:
  Wired() {
    constexpr std::array<std::uint32_t, 8> kWiring = {1, 2, 3, 4, 5, 2, 0x0013, 0};
    for (std::uint8_t sub = 1; sub <= 8; ++sub) {
      EXPECT_EQ(write(0x2010, sub, kWiring[sub - 1U], sub < 7 ? 1 : 2), 0U);
    }
    loop->io.inputs = kWell;
    configure();
  }
  static constexpr std::uint32_t kWell = 0x1B;  // no switch active, ready, no fault
};

TEST(DigitalIo, NothingIsWiredAsDelivered) {
  Bench bench;
  bench.configure();
  bench.loop->io.inputs = 0xA5;
  bench.enable(1);
  EXPECT_EQ(bench.read(0x60FD, 0), 0x00A50000U) << "terminals only";
  EXPECT_EQ(bench.loop->io.outputs, 0U);
}

TEST(DigitalIo, InputsByTerminalAndPolarity) {
  Wired bench;
  EXPECT_EQ(bench.read(0x60FD, 0), 0x00080000U);
  for (std::uint32_t inputs = 0; inputs < 8; ++inputs) {
    bench.loop->io.inputs = (Wired::kWell & ~7U) | inputs;
    bench.run_ms(1);
    const std::uint32_t word = bench.read(0x60FD, 0);
    EXPECT_EQ(word & 1U, inputs & 1U ? 0U : 1U) << "negative limit, opened by the switch";
    EXPECT_EQ(word & 2U, inputs & 2U ? 0U : 2U);
    EXPECT_EQ(word & 4U, inputs & 4U);
    EXPECT_EQ(word >> 16U, 8U | (inputs ^ 3U));
  }
}

TEST(DigitalIo, TerminalsApplyWithTheAxis) {
  Wired bench;
  ASSERT_EQ(bench.write(0x2010, 3, 8, 1), 0U);
  bench.loop->io.inputs = Wired::kWell | 0x80U;
  bench.run_ms(1);
  EXPECT_EQ(bench.read(0x60FD, 0) & 4U, 0U) << "staged only";
  ASSERT_EQ(bench.write(0x2140, 3, bench.read(0x2140, 1), 4), 0U);
  bench.run_ms(2);
  EXPECT_EQ(bench.read(0x60FD, 0) & 4U, 4U);
  EXPECT_EQ(bench.write(0x2010, 3, 17, 1), 0x06090031U);
  // Ready and fault on one terminal mean nothing.
  ASSERT_EQ(bench.write(0x2010, 5, 4, 1), 0U);
  EXPECT_EQ(bench.write(0x2140, 3, bench.read(0x2140, 1), 4), 0x08000000U);
}

TEST(DigitalIo, TerminalsAreLockedWhileEnabledAndStored) {
  Wired bench;
  bench.enable(1);
  EXPECT_EQ(bench.write(0x2010, 1, 2, 1), 0x08000022U);
  ASSERT_EQ(bench.write(0x6040, 0, 0, 2), 0U);
  bench.run_ms(2);
  ASSERT_EQ(bench.write(0x1010, 1, 0x65766173, 4), 0U);
  bench.power_on();
  bench.loop->io.inputs = Wired::kWell;
  bench.begin();
  bench.run_ms(3);
  EXPECT_EQ(bench.read(0x60FD, 0), 0x00080000U);
}

TEST(DigitalIo, AnAmplifierFaultTakesTheCurrentAtAnyTime) {
  Wired bench;
  bench.enable(1);
  bench.loop->io.inputs = Wired::kWell & ~0x10U;
  bench.run_ms(1);
  EXPECT_FALSE(bench.loop->motor.enabled);
  EXPECT_EQ(bench.read(0x603F, 0), 0x5400U);
  EXPECT_EQ(bench.read(0x2212, 13), 1U);
  ASSERT_EQ(bench.write(0x6040, 0, 0x80, 2), 0U);
  bench.run_ms(1);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x4FU, 0x08U) << "no reset while it lasts";
  bench.loop->io.inputs = Wired::kWell;
  ASSERT_EQ(bench.write(0x6040, 0, 0, 2), 0U);
  bench.run_ms(1);
  ASSERT_EQ(bench.write(0x6040, 0, 0x80, 2), 0U);
  bench.run_ms(1);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x4FU, 0x40U);
  bench.loop->io.inputs = Wired::kWell & ~0x10U;
  bench.run_ms(1);
  EXPECT_EQ(bench.read(0x603F, 0), 0x5400U) << "seen while disabled, too";
}

TEST(DigitalIo, AnAmplifierThatIsNotReadyIsAFaultWhileDriven) {
  Wired bench;
  EXPECT_EQ(bench.read(0x6041, 0) & 0x10U, 0x10U) << "voltage enabled";
  bench.loop->io.inputs = Wired::kWell & ~8U;
  bench.run_ms(1);
  EXPECT_EQ(bench.read(0x603F, 0), 0U) << "it may be switched off";
  EXPECT_EQ(bench.read(0x6041, 0) & 0x10U, 0U);
  bench.loop->io.inputs = Wired::kWell;
  bench.enable(1);
  bench.loop->io.inputs = Wired::kWell & ~8U;
  bench.run_ms(1);
  EXPECT_FALSE(bench.loop->motor.enabled);
  EXPECT_EQ(bench.read(0x603F, 0), 0x5410U);
}

TEST(DigitalIo, TheBrakeIsReleasedWhileTheAxisIsDriven) {
  Wired bench;
  bench.run_ms(1);
  EXPECT_EQ(bench.loop->io.outputs, 0U);
  bench.enable(1);
  EXPECT_EQ(bench.loop->io.outputs, 2U);
  // 60FEh bit 0 sets it; the mask counts.
  ASSERT_EQ(bench.write(0x60FE, 1, 1, 4), 0U);
  bench.run_ms(1);
  EXPECT_EQ(bench.loop->io.outputs, 2U);
  ASSERT_EQ(bench.write(0x60FE, 2, 1, 4), 0U);
  bench.run_ms(1);
  EXPECT_EQ(bench.loop->io.outputs, 0U);
  ASSERT_EQ(bench.write(0x60FE, 1, 0, 4), 0U);
  bench.run_ms(1);
  EXPECT_EQ(bench.loop->io.outputs, 2U);
  bench.loop->board_encoder.next.valid = false;
  bench.run_ms(1);
  EXPECT_EQ(bench.loop->io.outputs, 0U);
  // No bit releases it.
  ASSERT_EQ(bench.write(0x60FE, 2, 0xFFFFFFFF, 4), 0U);
  ASSERT_EQ(bench.write(0x60FE, 1, 0xFFFFFFFE, 4), 0U);
  bench.run_ms(1);
  EXPECT_EQ(bench.loop->io.outputs, 0xFFFDU);
}

TEST(DigitalIo, GeneralOutputsFollowTheObjectAndItsMask) {
  Wired bench;
  ASSERT_EQ(bench.write(0x60FE, 2, 0x00050000, 4), 0U);
  ASSERT_EQ(bench.write(0x60FE, 1, 0x00FF0000, 4), 0U);
  bench.run_ms(1);
  EXPECT_EQ(bench.loop->io.outputs, 5U);
  ASSERT_EQ(bench.write(0x2010, 8, 0x0004, 2), 0U);
  ASSERT_EQ(bench.write(0x2140, 3, bench.read(0x2140, 1), 4), 0U);
  bench.run_ms(2);
  EXPECT_EQ(bench.loop->io.outputs, 1U);
}

TEST(DigitalIo, InputsTravelByPdo) {
  Wired bench;
  ASSERT_EQ(bench.write(0x1800, 1, 0xC0000180 + kNode, 4), 0U);
  ASSERT_EQ(bench.write(0x1A00, 0, 0, 1), 0U);
  ASSERT_EQ(bench.write(0x1A00, 1, 0x60FD0020, 4), 0U);
  ASSERT_EQ(bench.write(0x1A00, 0, 1, 1), 0U);
  ASSERT_EQ(bench.write(0x1800, 2, 1, 1), 0U);
  ASSERT_EQ(bench.write(0x1800, 1, 0x40000180 + kNode, 4), 0U);
  bench.nmt(1);
  bench.all();
  bench.loop->io.inputs = Wired::kWell | 4U;
  bench.run_ms(1);
  bench.send(0x80, {});
  bench.poll();
  const std::vector<Data> frames = bench.all_with(0x180 + kNode);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0], (Data{4, 0, 12, 0}));
}

}  // namespace
}  // namespace slipstack::can
