// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/include/motor_current.h"
#include "hal/stm32g474/registers.h"

// The motor current: a set-point by DAC (servo amplifier with a +-10 V input, in current mode) or by PWM, and
// its measurement by ADC.
namespace slipstack::stm32g474 {

// A current as a code of a converter: code = zero_code + codes_per_A * current, rounded, kept within [lowest,
// highest].
struct CurrentScale {
  float zero_code;
  float codes_per_A;  // negative turns the direction round
  std::uint32_t lowest_code;
  std::uint32_t highest_code;

  // What is not a number becomes zero current.
  constexpr std::uint32_t to_code(float current_A) const {
    const float number_A = current_A == current_A ? current_A : 0.0F;
    const float lowest = static_cast<float>(lowest_code);
    const float highest = static_cast<float>(highest_code);
    float code = zero_code + codes_per_A * number_A;
    code = code < lowest ? lowest : code;
    code = code > highest ? highest : code;
    return static_cast<std::uint32_t>(code + 0.5F);
  }

  constexpr float to_current_A(std::uint32_t code) const {
    return (static_cast<float>(code) - zero_code) / codes_per_A;
  }
};

// DAC1 output 1, 12 bits, buffered. RM0440, Digital-to-analog converter (DAC).
template <class DacBlock>
class DacOutput {
 public:
  DacOutput(DacBlock& dac, const CurrentScale& scale) : dac_(dac), scale_(scale) {}

  // Puts out zero current. False when the converter does not come up (polls: 20 us at 170 MHz and more; it
  // takes 7.5 us, DS12288).
  [[nodiscard]] bool start() {
    dac_.cr = 0;
    dac_.mcr = kDAC_MCR_MODE1(0) | kDAC_MCR_HFSEL(2);  // to the pin, buffer on; bus clock above 160 MHz
    dac_.dhr12r1 = scale_.to_code(0.0F);
    dac_.cr = kDAC_CR_EN1(1);
    return wait_for(dac_.sr, kDAC_SR_DAC1RDY.mask, kDAC_SR_DAC1RDY.mask, 2000);
  }

  void set(float current_A) { dac_.dhr12r1 = scale_.to_code(current_A); }
  void disable() { set(0.0F); }
  void set_scale(const CurrentScale& scale) { scale_ = scale; }

 private:
  DacBlock& dac_;
  CurrentScale scale_;
};

// TIM1 centre-aligned: up and down in 2 * limit counts of the core clock.
struct PwmPlan {
  std::uint32_t limit_counts;      // ARR
  std::uint32_t dead_time_counts;  // between one switch off and the other on
  float lowest_duty;               // of either side, so that the charge pump and the ADC have their time
  float highest_duty;
};

constexpr bool keeps_limits(const PwmPlan& plan) {
  return plan.limit_counts >= 256 && plan.limit_counts <= 0xFFFF && plan.dead_time_counts <= 127 &&
         plan.lowest_duty > 0.0F && plan.lowest_duty < 0.5F && plan.highest_duty > 0.5F &&
         plan.highest_duty < 1.0F;
}

constexpr PwmPlan plan_pwm(std::uint32_t timer_Hz, std::uint32_t switching_Hz, std::uint32_t dead_time_ns,
                           float lowest_duty, float highest_duty) {
  return {timer_Hz / (2 * switching_Hz),
          static_cast<std::uint32_t>((std::uint64_t{timer_Hz} * dead_time_ns + 999'999'999) / 1'000'000'000),
          lowest_duty, highest_duty};
}

// Where PWM's compare value stands for a current: half the limit is zero.
constexpr CurrentScale pwm_scale(const PwmPlan& plan, float amperes_at_full_duty) {
  const float limit = static_cast<float>(plan.limit_counts);
  return {0.5F * limit, 0.5F * limit / amperes_at_full_duty,
          static_cast<std::uint32_t>(plan.lowest_duty * limit + 0.5F),
          static_cast<std::uint32_t>(plan.highest_duty * limit + 0.5F)};
}

// TIM1: channels 1 and 1N, 2 and 2N drive the two legs of a bridge in opposition (a half bridge or an
// amplifier with a PWM input takes the first alone: 50 % is zero current), and channel 4 triggers the ADC at
// the counter's peak: there, in the middle of the period, all low switches conduct and none changes. RM0440,
// Advanced-control timers: centre-aligned mode, complementary outputs, break function.
template <class TimerBlock>
class PwmOutput {
 public:
  PwmOutput(TimerBlock& timer, const PwmPlan& plan, float amperes_at_full_duty)
      : timer_(timer), plan_(plan), scale_(pwm_scale(plan, amperes_at_full_duty)) {}

  // Counts and triggers, outputs off.
  void start() {
    timer_.cr1 = kTIM_CR1_CMS(1) | kTIM_CR1_ARPE(1);
    timer_.psc = 0;
    timer_.arr = plan_.limit_counts;
    timer_.rcr = 1;  // new duty cycles are taken over once a period, at the bottom
    timer_.ccmr1 = kTIM_CCMR1_OC1M(6) | kTIM_CCMR1_OC1PE(1) | kTIM_CCMR1_OC2M(6) | kTIM_CCMR1_OC2PE(1);
    timer_.ccmr2 = kTIM_CCMR2_OC4M(7) | kTIM_CCMR2_OC4PE(1);  // PWM mode 2: high around the peak
    timer_.ccr4 = plan_.limit_counts - 1;
    timer_.cr2 = kTIM_CR2_MMS2(7);  // OC4REF is TRGO2, for the ADC; outputs low when idle
    set_duty(scale_.to_code(0.0F));
    timer_.ccer =
        kTIM_CCER_CC1E(1) | kTIM_CCER_CC1NE(1) | kTIM_CCER_CC2E(1) | kTIM_CCER_CC2NE(1) | kTIM_CCER_CC4E(1);
    clear_bits(timer_.af1, kTIM_AF1_BKINE.mask);  // no pin breaks; a locked-up core and a lost crystal do
    timer_.bdtr = kTIM_BDTR_DTG.place(plan_.dead_time_counts) | kTIM_BDTR_OSSI(1) | kTIM_BDTR_OSSR(1) |
                  kTIM_BDTR_BKE(1) | kTIM_BDTR_BKP(1);
    timer_.egr = kTIM_EGR_UG(1);
    timer_.sr = 0;
    set_bits(timer_.cr1, kTIM_CR1_CEN(1));
  }

  void set(float current_A) {
    set_duty(scale_.to_code(current_A));
    set_bits(timer_.bdtr, kTIM_BDTR_MOE(1));
  }

  void disable() {
    clear_bits(timer_.bdtr, kTIM_BDTR_MOE.mask);
    set_duty(scale_.to_code(0.0F));
  }
  void set_scale(const CurrentScale& scale) { scale_ = scale; }

 private:
  void set_duty(std::uint32_t compare) {
    timer_.ccr1 = compare;
    timer_.ccr2 = plan_.limit_counts - compare;
  }

  TimerBlock& timer_;
  PwmPlan plan_;
  CurrentScale scale_;
};

enum class AdcFault : std::uint8_t { kNone, kNotCalibrated, kNotReady };

// ADC1, three injected conversions at every TRGO2 of TIM1: the current, and behind it what SlowInputs reads
// (analogue_inputs.h). RM0440, Analog-to-digital converters (ADC): ADC
// on-off control, calibration, injected channel management, external triggers (JEXTSEL 8: tim1_trgo2).
template <class AdcBlock, class CommonBlock>
class CurrentInput {
 public:
  // scale: of the measurement; codes outside (lowest_code, highest_code) are an open or shorted sensor.
  CurrentInput(AdcBlock& adc, CommonBlock& common, const CurrentScale& scale)
      : adc_(adc), common_(common), scale_(scale) {}

  // Input 6, 24.5 cycles of sampling at 42.5 MHz: a result 0.87 us after the trigger. Then inputs 14 and 11,
  // 92.5 cycles each, for dividers of up to 10 kOhm: the sequence ends 5.8 us after the trigger, and the next
  // one begins 25 us after it. `wait_us(n)` waits at least n us.
  template <class WaitUs>
  [[nodiscard]] AdcFault start(WaitUs wait_us) {
    constexpr std::uint32_t kPolls = 100'000;  // calibration takes 112 cycles of the ADC's clock (DS12288)
    adc_.cr = 0;                               // out of deep power-down
    adc_.cr = kADC_CR_ADVREGEN(1);
    wait_us(20);  // the regulator's start-up time (DS12288, tADCVREG_STUP)
    change_bits(common_.ccr, kADC_CCR_CKMODE.mask, kADC_CCR_CKMODE(3));  // bus clock / 4
    // Bits of CR are set by writing 1; writing one again while another acts is not allowed: no
    // read-modify-write.
    adc_.cr = kADC_CR_ADVREGEN(1) | kADC_CR_ADCAL(1);
    if (!wait_for(adc_.cr, kADC_CR_ADCAL.mask, 0, kPolls)) return AdcFault::kNotCalibrated;
    wait_us(1);  // ADEN may be set four ADC cycles after ADCAL has gone (RM0440)
    adc_.isr = kADC_ISR_ADRDY(1);
    adc_.cr = kADC_CR_ADVREGEN(1) | kADC_CR_ADEN(1);
    if (!wait_for(adc_.isr, kADC_ISR_ADRDY.mask, kADC_ISR_ADRDY.mask, kPolls)) return AdcFault::kNotReady;
    change_bits(adc_.smpr1, kADC_SMPR1_SMP6.mask, kADC_SMPR1_SMP6(3));
    change_bits(adc_.smpr2, kADC_SMPR2_SMP11.mask | kADC_SMPR2_SMP14.mask,
                kADC_SMPR2_SMP11(5) | kADC_SMPR2_SMP14(5));
    adc_.cfgr = kADC_CFGR_JQDIS(1);
    adc_.jsqr = kADC_JSQR_JL(2) | kADC_JSQR_JEXTSEL(8) | kADC_JSQR_JEXTEN(1) | kADC_JSQR_JSQ1(6) |
                kADC_JSQR_JSQ2(14) | kADC_JSQR_JSQ3(11);
    adc_.isr = kADC_ISR_JEOS(1);
    adc_.cr = kADC_CR_ADVREGEN(1) | kADC_CR_JADSTART(1);
    return AdcFault::kNone;
  }

  void set_scale(const CurrentScale& scale) { scale_ = scale; }

  // The latest conversion; not valid when there was none since the last call, or the sensor is at a rail.
  CurrentReading measured() {
    const bool fresh = (adc_.isr & kADC_ISR_JEOS.mask) != 0;
    adc_.isr = kADC_ISR_JEOS(1);
    const std::uint32_t code = kADC_JDR1_JDATA.read(adc_.jdr1);
    return {scale_.to_current_A(code), fresh && code > scale_.lowest_code && code < scale_.highest_code};
  }

 private:
  AdcBlock& adc_;
  CommonBlock& common_;
  CurrentScale scale_;
};

// A set-point, a measurement, and a pin that switches the power stage on, together what
// hal/include/motor_current.h asks for.
template <class Output, class Input, class GpioBlock>
class MotorDrive {
 public:
  MotorDrive(Output& output, Input& input, GpioBlock& enable_port, std::uint32_t enable_pin)
      : output_(output), input_(input), enable_port_(enable_port), enable_pin_(enable_pin) {}

  void set(float current_A) {
    output_.set(current_A);
    enable_port_.bsrr = 1U << enable_pin_;
  }
  void disable() {
    enable_port_.bsrr = 1U << (enable_pin_ + 16);
    output_.disable();
  }
  CurrentReading measured() { return input_.measured(); }

 private:
  Output& output_;
  Input& input_;
  GpioBlock& enable_port_;
  std::uint32_t enable_pin_;
};

}  // namespace slipstack::stm32g474
