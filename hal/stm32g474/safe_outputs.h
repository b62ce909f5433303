// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/stm32g474/digital_io.h"
#include "hal/stm32g474/gpio.h"
#include "hal/stm32g474/registers.h"

// What the amplifier sees of this board: the enable signal and the command. In reset both pins float, and
// what holds them is on the board around the part (docs/hardware.md).
namespace slipstack::stm32g474 {

inline constexpr std::uint32_t kEnablePin = 5;       // PB5, high: power stage on
inline constexpr std::uint32_t kCommandPin = 4;      // PA4, DAC1_OUT1
inline constexpr std::uint32_t kDacZeroCode = 2048;  // half the reference: 0 V behind the level shifter

// Of the digital outputs, which set the brake while they are low.
inline constexpr DigitalPins kDigitalPins{.first_input = 1, .inputs = 8, .first_output = 0, .outputs = 3};

// Power stage off and the brake set, then zero current, whatever state the part is in: first of all after a
// reset, and in the handlers of faults. Uses the registers only, no memory and no other peripheral's state.
// The enable signal is low before anything else changes.
template <class Hardware>
void secure_outputs() {
  auto& rcc = Hardware::template block<Rcc>(kRCC_BASE);
  auto& b = Hardware::template block<Gpio>(kGPIOB_BASE);
  set_bits(rcc.ahb2enr, kRCC_AHB2ENR_GPIOBEN(1));
  static_cast<void>(rcc.ahb2enr & 1U);  // a peripheral answers two cycles after its clock (RM0440, RCC)
  constexpr std::uint32_t kOutputs = ((1U << kDigitalPins.outputs) - 1U) << kDigitalPins.first_output;
  b.bsrr = ((1U << kEnablePin) | kOutputs) << 16U;
  set_up_pin(b, {.pin = kEnablePin, .mode = PinMode::kOutput, .pull = PinPull::kDown});
  // Without its clock a peripheral takes no writes, and has not been used since the reset.
  if ((rcc.apb2enr & kRCC_APB2ENR_TIM1EN.mask) != 0) {
    clear_bits(Hardware::template block<Timer>(kTIM1_BASE).bdtr, kTIM_BDTR_MOE.mask);
  }
  if ((rcc.ahb2enr & kRCC_AHB2ENR_DAC1EN.mask) != 0) {
    Hardware::template block<Dac>(kDAC1_BASE).dhr12r1 = kDacZeroCode;
  }
}

// Of the part; for the vectors of a reset and of faults.
void force_safe_state();

}  // namespace slipstack::stm32g474
