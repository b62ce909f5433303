// SPDX-License-Identifier: Apache-2.0
#include "hal/stm32g474/board.h"

namespace slipstack::stm32g474 {

static_assert(Encoder<BoardEncoder>);
static_assert(Clock<CycleClock<Dwt<HardwareWord>>>);
static_assert(Watchdog<IndependentWatchdog<Iwdg<HardwareWord>>>);
static_assert(DigitalIo<DigitalPort<Port>>);
static_assert(MotorCurrent<Board<DriveKind::kDac>::Motor> && MotorCurrent<Board<DriveKind::kPwm>::Motor>);

CarefulRead careful_read;

void force_safe_state() {
  auto& rcc = hardware<Rcc>(kRCC_BASE);
  // A peripheral without its clock takes no writes; after reset all are in the safe state anyway.
  // Enable, and the digital outputs: a low output sets the brake.
  if ((rcc.ahb2enr & kRCC_AHB2ENR_GPIOBEN.mask) != 0) {
    hardware<Gpio>(kGPIOB_BASE).bsrr = ((1U << 5U) | 7U) << 16U;
  }
  if ((rcc.apb2enr & kRCC_APB2ENR_TIM1EN.mask) != 0) {
    clear_bits(hardware<Timer>(kTIM1_BASE).bdtr, kTIM_BDTR_MOE.mask);
  }
  if ((rcc.ahb2enr & kRCC_AHB2ENR_DAC1EN.mask) != 0) hardware<Dac>(kDAC1_BASE).dhr12r1 = 2048;
}

}  // namespace slipstack::stm32g474
