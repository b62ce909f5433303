// SPDX-License-Identifier: Apache-2.0
#include "hal/stm32g474/motor_current.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <tuple>

#include "hal/stm32g474/analogue_inputs.h"
#include "tests/unit/stm32g474/simulated_word.h"

namespace slipstack::stm32g474 {
namespace {
using test::Journal;
using test::SimWord;

constexpr CurrentScale kDacScale{2048.0F, 204.75F, 1, 4095};
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(CurrentScale, IsLinearRoundedAndBounded) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> current(-15.0F, 15.0F);
  int bounded = 0;
  for (int i = 0; i < 20'000; ++i) {
    const float current_A = current(random);
    const double exact = 2048.0 + 204.75 * static_cast<double>(current_A);
    const std::uint32_t code = kDacScale.to_code(current_A);
    ASSERT_GE(code, 1U);
    ASSERT_LE(code, 4095U);
    if (exact < 1.0 || exact > 4095.0) {
      ++bounded;
      ASSERT_EQ(code, exact < 1.0 ? 1U : 4095U);
    } else {
      ASSERT_NEAR(static_cast<double>(code), exact, 0.5 + 1e-3);
      ASSERT_NEAR(kDacScale.to_current_A(code), current_A, 0.51F / 204.75F);
    }
  }
  EXPECT_GT(bounded, 5'000);
}

TEST(CurrentScale, WhatIsNoNumberIsNoCurrent) {
  EXPECT_EQ(kDacScale.to_code(kNan), 2048U);
  EXPECT_EQ(kDacScale.to_code(-kNan), 2048U);
  EXPECT_EQ(kDacScale.to_code(kInfinity), 4095U);
  EXPECT_EQ(kDacScale.to_code(-kInfinity), 1U);
  EXPECT_EQ(kDacScale.to_code(std::numeric_limits<float>::max()), 4095U);
}

TEST(CurrentScale, TurnsRound) {
  constexpr CurrentScale kTurned{2100.0F, -100.0F, 0, 4095};
  EXPECT_EQ(kTurned.to_code(1.0F), 2000U);
  EXPECT_EQ(kTurned.to_code(-1.0F), 2200U);
  EXPECT_EQ(kTurned.to_code(kNan), 2100U);
}

struct SimDac {
  Dac<SimWord> registers;
  bool works = true;
  SimDac() {
    registers.sr.on_read = [this](std::uint32_t) {
      return works && (registers.cr.value & 1U) != 0 ? kDAC_SR_DAC1RDY.mask : 0U;
    };
  }
};

TEST(DacOutput, PutsOutZeroBeforeItIsOn) {
  SimDac dac;
  Journal journal;
  journal.watch(dac.registers.cr, "CR");
  journal.watch(dac.registers.dhr12r1, "DHR");
  dac.registers.dhr12r1.value = 4095;
  DacOutput output(dac.registers, kDacScale);
  ASSERT_TRUE(output.start());
  const int zero = journal.first("DHR", 0xFFF, 2048);
  const int on = journal.first("CR", 1, 1);
  EXPECT_GE(zero, 0);
  EXPECT_LT(zero, on) << "the amplifier would see the old code";
  EXPECT_EQ(dac.registers.mcr.value & 7U, 0U);
  EXPECT_EQ(dac.registers.mcr.value >> 14U, 2U);  // bus clock above 160 MHz
  output.set(-2.0F);
  EXPECT_EQ(dac.registers.dhr12r1.value, 1639U);  // 2048 - 409.5, rounded up
  output.disable();
  EXPECT_EQ(dac.registers.dhr12r1.value, 2048U);
}

TEST(DacOutput, SaysWhenTheConverterIsNotReady) {
  SimDac dac;
  dac.works = false;
  DacOutput output(dac.registers, kDacScale);
  EXPECT_FALSE(output.start());
}

constexpr PwmPlan kPlan = plan_pwm(170'000'000, 40'000, 500, 0.05F, 0.95F);

TEST(PwmPlan, CountsHalfAPeriodUpAndRoundsDeadTimeUp) {
  EXPECT_EQ(kPlan.limit_counts, 2125U);
  EXPECT_EQ(kPlan.dead_time_counts, 85U);
  EXPECT_EQ(plan_pwm(170'000'000, 40'000, 501, 0.05F, 0.95F).dead_time_counts, 86U);
  EXPECT_TRUE(keeps_limits(kPlan));
  EXPECT_FALSE(keeps_limits(plan_pwm(170'000'000, 1'000, 500, 0.05F, 0.95F)));    // 17 bits
  EXPECT_FALSE(keeps_limits(plan_pwm(170'000'000, 500'000, 500, 0.05F, 0.95F)));  // too coarse
  EXPECT_FALSE(
      keeps_limits(plan_pwm(170'000'000, 40'000, 800, 0.05F, 0.95F)));  // DTG beyond its linear range
  EXPECT_FALSE(keeps_limits(plan_pwm(170'000'000, 40'000, 500, 0.0F, 0.95F)));
  EXPECT_FALSE(keeps_limits(plan_pwm(170'000'000, 40'000, 500, 0.05F, 1.0F)));
}

TEST(PwmOutput, IsCentreAlignedComplementaryAndOffAtFirst) {
  Timer<SimWord> timer;
  timer.af1.value = 1;  // after reset
  PwmOutput output(timer, kPlan, 10.0F);
  output.start();
  EXPECT_EQ(timer.cr1.value, 0xA1U);  // centre-aligned 1, preloaded, on
  EXPECT_EQ(timer.arr.value, 2125U);
  EXPECT_EQ(timer.rcr.value, 1U);
  EXPECT_EQ(timer.ccmr1.value, 0x6868U);  // PWM mode 1, preloaded, twice
  EXPECT_EQ(timer.ccer.value, 0x1055U);   // 1, 1N, 2, 2N, and 4 for the trigger
  EXPECT_EQ(timer.bdtr.value & 0xFFU, 85U);
  EXPECT_EQ(timer.bdtr.value & (1U << 15U), 0U) << "outputs must be off";
  EXPECT_NE(timer.bdtr.value & (1U << 12U), 0U) << "break on";
  EXPECT_EQ(timer.af1.value, 0U) << "an open pin must not break";
  EXPECT_EQ(timer.ccr1.value, 1063U);
  EXPECT_EQ(timer.ccr2.value, 1062U);
}

// The ADC's trigger rises once a period, at the peak, when no output changes: nearest edge 5 % of the period
// away.
TEST(PwmOutput, TriggersTheConverterInTheMiddleOfThePeriod) {
  Timer<SimWord> timer;
  PwmOutput output(timer, kPlan, 10.0F);
  output.start();
  EXPECT_EQ((timer.cr2.value >> 20U) & 0xFU, 7U);   // TRGO2 is OC4REF
  EXPECT_EQ(timer.ccmr2.value & 0xFF00U, 0x7800U);  // PWM mode 2: high while the count is beyond CCR4
  const std::uint32_t trigger = timer.ccr4.value;
  EXPECT_EQ(trigger, timer.arr.value - 1);
  for (float current_A = -20.0F; current_A <= 20.0F; current_A += 0.25F) {
    output.set(current_A);
    for (const std::uint32_t edge : {timer.ccr1.value, timer.ccr2.value}) {
      ASSERT_GE(trigger - edge, 105U) << current_A;
    }
  }
}

TEST(PwmOutput, KeepsTheDutyWithinItsLimits) {
  Timer<SimWord> timer;
  PwmOutput output(timer, kPlan, 10.0F);
  output.start();
  std::mt19937 random(11);
  std::uniform_real_distribution<float> current(-30.0F, 30.0F);
  std::uint32_t lowest = 0xFFFF;
  std::uint32_t highest = 0;
  for (int i = 0; i < 10'000; ++i) {
    const float current_A = i == 0 ? kNan : i == 1 ? kInfinity : i == 2 ? -kInfinity : current(random);
    output.set(current_A);
    const std::uint32_t one = timer.ccr1.value;
    ASSERT_EQ(one + timer.ccr2.value, 2125U) << "the legs are opposed";
    lowest = std::min(lowest, one);
    highest = std::max(highest, one);
    if (std::abs(current_A) < 8.0F) {
      const double expected = 1062.5 + 106.25 * static_cast<double>(current_A);
      ASSERT_NEAR(one, expected, 0.51);
    }
  }
  EXPECT_EQ(lowest, 106U);    // 5 %: 106.25
  EXPECT_EQ(highest, 2019U);  // 95 %: 2018.75
}

TEST(PwmOutput, OutputsAreOnFromTheFirstSetPointUntilDisabled) {
  Timer<SimWord> timer;
  PwmOutput output(timer, kPlan, 10.0F);
  output.start();
  output.set(1.0F);
  EXPECT_NE(timer.bdtr.value & (1U << 15U), 0U);
  EXPECT_EQ(timer.bdtr.value & 0xFFU, 85U) << "dead time must survive";
  output.disable();
  EXPECT_EQ(timer.bdtr.value & (1U << 15U), 0U);
  EXPECT_EQ(timer.ccr1.value, 1063U);
}

// An ADC that insists on its order: regulator, 20 us, calibration, enabling, only then conversions.
struct SimAdc {
  Adc<SimWord> registers;
  AdcCommon<SimWord> common;
  bool calibrates = true;
  bool gets_ready = true;
  bool calibrated = false;
  bool misused = false;
  std::uint32_t waited_us = 0;
  std::uint32_t waited_at_calibration_us = 0;

  SimAdc() {
    registers.cr.value = 0x20000000;  // deep power-down after reset
    registers.cr.on_write = [this](SimWord& self, std::uint32_t written) {
      const std::uint32_t regulator = written & (1U << 28U);
      if ((written & (1U << 31U)) != 0) {
        if (regulator == 0 || (self.value & 1U) != 0) misused = true;
        waited_at_calibration_us = waited_us;
        calibrated = calibrates;
        self.value = regulator | (calibrates ? 0U : 1U << 31U);
        return;
      }
      if ((written & 1U) != 0) {
        if (!calibrated || (self.value & 0xFU) != 0) misused = true;
        if (gets_ready) registers.isr.value |= 1U;
      }
      if ((written & 8U) != 0 && (self.value & 1U) == 0) misused = true;
      self.value = regulator | (written & (1U << 29U)) | ((self.value | written) & 0xFU);
    };
    test::clear_by_one(registers.isr);
  }
  void convert(std::uint32_t code) {
    registers.jdr1.value = code;
    registers.isr.value |= kADC_ISR_JEOS.mask;
  }
};

constexpr CurrentScale kAdcScale{2048.0F, 100.0F, 8, 4087};

TEST(CurrentInput, StartsInTheManualsOrder) {
  SimAdc adc;
  CurrentInput input(adc.registers, adc.common, kAdcScale);
  EXPECT_EQ(input.start([&adc](std::uint32_t us) { adc.waited_us += us; }), AdcFault::kNone);
  EXPECT_FALSE(adc.misused);
  EXPECT_GE(adc.waited_at_calibration_us, 20U);
  EXPECT_EQ(adc.common.ccr.value & 0x30000U, 0x30000U);  // bus clock / 4
  EXPECT_EQ(adc.registers.cr.value & 0x9U, 0x9U);        // enabled, waits for triggers
  // Inputs 6, 14 and 11, in this order, at the rising edge of external trigger 8, TIM1's TRGO2.
  EXPECT_EQ(adc.registers.jsqr.value, 11U << 21U | 14U << 15U | 6U << 9U | 1U << 7U | 8U << 2U | 2U);
  EXPECT_EQ((adc.registers.smpr1.value >> 18U) & 7U, 3U);
  EXPECT_EQ(adc.registers.smpr2.value, 5U << 12U | 5U << 3U);
  EXPECT_NE(adc.registers.cfgr.value & (1U << 31U), 0U);  // no queue of contexts
}

TEST(CurrentInput, SaysWhatDoesNotAnswer) {
  const auto no_wait = [](std::uint32_t) {};
  SimAdc uncalibrated;
  uncalibrated.calibrates = false;
  EXPECT_EQ(CurrentInput(uncalibrated.registers, uncalibrated.common, kAdcScale).start(no_wait),
            AdcFault::kNotCalibrated);
  SimAdc never_ready;
  never_ready.gets_ready = false;
  EXPECT_EQ(CurrentInput(never_ready.registers, never_ready.common, kAdcScale).start(no_wait),
            AdcFault::kNotReady);
}

TEST(CurrentInput, MeasuresOnceAndDistrustsTheRails) {
  SimAdc adc;
  CurrentInput input(adc.registers, adc.common, kAdcScale);
  ASSERT_EQ(input.start([](std::uint32_t) {}), AdcFault::kNone);
  EXPECT_FALSE(input.measured().valid) << "nothing was converted yet";
  adc.convert(2248);
  const CurrentReading reading = input.measured();
  EXPECT_TRUE(reading.valid);
  EXPECT_FLOAT_EQ(reading.current_A, 2.0F);
  EXPECT_FALSE(input.measured().valid) << "the trigger has stopped";
  for (const auto& [code, valid] :
       {std::pair{0U, false}, {8U, false}, {9U, true}, {4086U, true}, {4087U, false}, {4095U, false}}) {
    adc.convert(code);
    EXPECT_EQ(input.measured().valid, valid) << code;
  }
}

TEST(SlowInputs, ReadBehindTheCurrentAndDistrustTheRails) {
  SimAdc adc;
  SlowInputs inputs(adc.registers);
  EXPECT_TRUE(inputs.has_temperature() && inputs.has_bus_voltage());
  adc.registers.jdr1.value = 1;
  adc.registers.jdr2.value = 1024;
  adc.registers.jdr3.value = 2048;
  EXPECT_FLOAT_EQ(inputs.temperature().volts, 0.825F);
  EXPECT_FLOAT_EQ(inputs.bus_voltage().volts, 1.65F);
  for (const auto& [code, warm, bus] : {std::tuple{0U, false, true},
                                        {8U, false, true},
                                        {9U, true, true},
                                        {4086U, true, true},
                                        {4087U, false, false},
                                        {4095U, false, false}}) {
    adc.registers.jdr2.value = code;
    adc.registers.jdr3.value = code;
    EXPECT_EQ(inputs.temperature().valid, warm) << code;
    EXPECT_EQ(inputs.bus_voltage().valid, bus) << code << ": a link without voltage reads 0";
  }
}

TEST(MotorDrive, SwitchesThePowerStageAroundTheSetPoint) {
  SimDac dac;
  SimAdc adc;
  Gpio<SimWord> port;
  Journal journal;
  journal.watch(dac.registers.dhr12r1, "DHR");
  journal.watch(port.bsrr, "BSRR");
  DacOutput output(dac.registers, kDacScale);
  CurrentInput input(adc.registers, adc.common, kAdcScale);
  MotorDrive drive(output, input, port, 5);
  static_assert(MotorCurrent<decltype(drive)>);
  drive.set(1.0F);
  EXPECT_LT(journal.first("DHR", 0xFFF, 2253), journal.first("BSRR", 0xFFFFFFFF, 1U << 5U))
      << "set-point before power";
  const std::size_t before = journal.writes().size();
  drive.disable();
  ASSERT_EQ(journal.writes().size(), before + 2);
  EXPECT_EQ(journal.writes()[before].name, "BSRR");
  EXPECT_EQ(journal.writes()[before].value, 1U << 21U);
  EXPECT_EQ(journal.writes()[before + 1].value, 2048U);
}

}  // namespace
}  // namespace slipstack::stm32g474
