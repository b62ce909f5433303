// SPDX-License-Identifier: Apache-2.0
#include "hal/stm32g474/board.h"

#include "hal/stm32g474/peripherals.h"
#include "hal/stm32g474/safe_outputs.h"

namespace slipstack::stm32g474 {

using DacBoard = Board<DriveKind::kDac, Part>;
static_assert(Encoder<DacBoard::BoardEncoder>);
static_assert(Clock<DacBoard::BoardClock>);
static_assert(Watchdog<IndependentWatchdog<Iwdg<HardwareWord>>>);
static_assert(DigitalIo<DigitalPort<DacBoard::Port>>);
static_assert(MotorCurrent<DacBoard::Motor> && MotorCurrent<Board<DriveKind::kPwm, Part>::Motor>);

CarefulRead careful_read;

void force_safe_state() {
  secure_outputs<Part>();
}

}  // namespace slipstack::stm32g474
