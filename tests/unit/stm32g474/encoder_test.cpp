// SPDX-License-Identifier: Apache-2.0
#include "hal/stm32g474/encoder.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/stm32g474/simulated_word.h"

namespace slipstack::stm32g474 {
namespace {
using test::SimWord;

struct SimClock {
  const std::uint32_t* time;
  std::uint32_t now() const { return *time; }
  std::uint32_t ticks_per_second() const { return 170'000'000; }
};

// TIM2 as far as the encoder uses it: flags cleared by writing 0, CC3IF also by reading CCR3.
struct SimTimer {
  Timer<SimWord> registers;
  std::uint32_t time = 0;
  QuadratureEncoder<Timer<SimWord>, SimClock> encoder{registers, SimClock{&time}};

  SimTimer() {
    test::clear_by_zero(registers.sr);
    registers.ccr3.on_read = [this](std::uint32_t value) {
      registers.sr.value &= ~kTIM_SR_CC3IF.mask;
      return value;
    };
    registers.egr.on_write = [this](SimWord&, std::uint32_t written) {
      if ((written & 1U) != 0) registers.cnt.value = 0;
    };
  }
  void move(std::int32_t counts) { registers.cnt.value += static_cast<std::uint32_t>(counts); }
  void pass_index() {
    if ((registers.sr.value & kTIM_SR_CC3IF.mask) != 0) registers.sr.value |= kTIM_SR_CC3OF.mask;
    registers.ccr3.value = registers.cnt.value;
    registers.sr.value |= kTIM_SR_CC3IF.mask;
  }
};

TEST(QuadratureEncoder, SetsTheTimerUp) {
  SimTimer timer;
  timer.registers.cnt.value = 77;
  timer.encoder.start({.reversed = false, .filter = 3});
  EXPECT_EQ(timer.registers.smcr.value, 3U);          // both edges of both inputs
  EXPECT_EQ(timer.registers.arr.value, 0xFFFFFFFFU);  // all 32 bits
  EXPECT_EQ(timer.registers.ccmr1.value, 0x3131U);    // TI1, TI2, filter 3
  EXPECT_EQ(timer.registers.ccmr2.value, 0x3131U);    // TI3, TI4, filter 3
  EXPECT_EQ(timer.registers.ccer.value, 0xB100U);     // capture 3 on, rising; 4 on, both edges
  EXPECT_EQ(timer.registers.cr1.value, 1U);
  EXPECT_EQ(timer.registers.ecr.value, 0U) << "the index must not reset the count";
  EXPECT_EQ(timer.encoder.counts(), 0);
  timer.encoder.start({.reversed = true, .filter = 15});
  EXPECT_EQ(timer.registers.ccer.value, 0xB102U);  // TI1 inverted
  EXPECT_EQ(timer.registers.ccmr1.value, 0xF1F1U);
}

TEST(QuadratureEncoder, CountsAcrossTheWrap) {
  SimTimer timer;
  timer.encoder.start({});
  timer.move(std::numeric_limits<std::int32_t>::max());
  EXPECT_EQ(timer.encoder.counts(), std::numeric_limits<std::int32_t>::max());
  timer.move(1);
  EXPECT_EQ(timer.encoder.counts(), std::numeric_limits<std::int32_t>::min());
  timer.move(-3);
  EXPECT_EQ(timer.encoder.counts(), std::numeric_limits<std::int32_t>::max() - 2);
}

TEST(QuadratureEncoder, ReadsCountsWithTheirTime) {
  SimTimer timer;
  timer.encoder.start({});
  timer.move(-12345);
  timer.time = 4'000'000'000;
  const EncoderReading reading = timer.encoder.read();
  EXPECT_EQ(reading.counts, -12345);
  EXPECT_EQ(reading.latched, 4'000'000'000U);
  EXPECT_TRUE(reading.valid);
}

TEST(QuadratureEncoder, ReadingIsNotValidAfterALostEdge) {
  SimTimer timer;
  timer.encoder.start({});
  EXPECT_TRUE(timer.encoder.read().valid);
  timer.registers.sr.value |= kTIM_SR_TERRF.mask | kTIM_SR_UIF.mask;
  EXPECT_FALSE(timer.encoder.read().valid);
  EXPECT_EQ(timer.registers.sr.value, kTIM_SR_UIF.mask) << "only its own flag is cleared";
  EXPECT_TRUE(timer.encoder.read().valid);
  EXPECT_EQ(timer.encoder.transition_errors(), 1U);
  timer.encoder.start({});
  EXPECT_EQ(timer.encoder.transition_errors(), 0U);
}

TEST(QuadratureEncoder, HoldsTheCountOfTheIndex) {
  SimTimer timer;
  timer.encoder.start({});
  std::int32_t counts = 0;
  EXPECT_FALSE(timer.encoder.take_index(counts));
  timer.move(-500);
  timer.pass_index();
  timer.move(900);
  ASSERT_TRUE(timer.encoder.take_index(counts));
  EXPECT_EQ(counts, -500);
  EXPECT_EQ(timer.encoder.counts(), 400) << "homing must not move the count";
  EXPECT_FALSE(timer.encoder.take_index(counts)) << "each passage once";
  timer.pass_index();
  timer.move(100);
  timer.pass_index();
  ASSERT_TRUE(timer.encoder.take_index(counts));
  EXPECT_EQ(counts, 500);
  EXPECT_EQ(timer.encoder.missed_marks(), 1U);
  EXPECT_FALSE(timer.encoder.take_index(counts));
  EXPECT_EQ(timer.registers.sr.value & kTIM_SR_CC3OF.mask, 0U);
}

}  // namespace
}  // namespace slipstack::stm32g474
