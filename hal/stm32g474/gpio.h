// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/stm32g474/registers.h"

// Pins. RM0440, General-purpose I/Os (GPIO); which function has which number: DS12288, alternate function
// mapping.
namespace slipstack::stm32g474 {

enum class PinMode : std::uint8_t { kInput = 0, kOutput = 1, kAlternate = 2, kAnalog = 3 };
enum class PinPull : std::uint8_t { kNone = 0, kUp = 1, kDown = 2 };

struct PinSetup {
  std::uint32_t pin;  // 0 ... 15
  PinMode mode;
  std::uint32_t function = 0;  // 0 ... 15, for kAlternate
  PinPull pull = PinPull::kNone;
  std::uint32_t speed = 0;  // 0 low ... 3 very high
};

// Sets one pin up, push-pull. The function is chosen before the mode, so that the pin never shows another
// one's level.
template <class Word>
void set_up_pin(Gpio<Word>& port, const PinSetup& setup) {
  const std::uint32_t two = 2 * setup.pin;
  const std::uint32_t four = 4 * (setup.pin % 8);
  clear_bits(port.otyper, 1U << setup.pin);
  change_bits(port.ospeedr, 3U << two, (setup.speed & 3U) << two);
  change_bits(port.pupdr, 3U << two, static_cast<std::uint32_t>(setup.pull) << two);
  change_bits(port.afr[setup.pin / 8], 0xFU << four, (setup.function & 0xFU) << four);
  change_bits(port.moder, 3U << two, static_cast<std::uint32_t>(setup.mode) << two);
}

// The level of a pin, whatever its function is (RM0440: the input stage is on but for analogue pins).
template <class GpioBlock>
struct InputPin {
  const GpioBlock& port;
  std::uint32_t pin;

  bool high() const { return (static_cast<std::uint32_t>(port.idr) >> pin & 1U) != 0; }
};

// A light-emitting diode, lit by a high level. One write, safe from any priority.
template <class GpioBlock>
class Led {
 public:
  Led(GpioBlock& port, std::uint32_t pin) : port_(port), pin_(pin) {}

  void start() { set_up_pin(port_, {.pin = pin_, .mode = PinMode::kOutput}); }
  void set(bool lit) { port_.bsrr = lit ? 1U << pin_ : 1U << (pin_ + 16); }

 private:
  GpioBlock& port_;
  std::uint32_t pin_;
};

}  // namespace slipstack::stm32g474
