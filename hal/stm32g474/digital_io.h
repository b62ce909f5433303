// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/include/digital_io.h"
#include "hal/stm32g474/gpio.h"

// Digital inputs and outputs on neighbouring pins of one port each, and behind the inputs the pin whose edges
// the encoder's timer captures (RM0440, GPIOx_IDR, GPIOx_BSRR).
namespace slipstack::stm32g474 {

/// Terminal 1 is the first pin.
struct DigitalPins {
  std::uint32_t first_input;
  std::uint32_t inputs;  // how many
  std::uint32_t first_output;
  std::uint32_t outputs;

  // Of the captured pin.
  constexpr std::uint32_t captured_terminal() const { return inputs + 1; }
};

template <class GpioBlock>
class DigitalPort {
 public:
  DigitalPort(GpioBlock& inputs, GpioBlock& outputs, InputPin<GpioBlock> captured, const DigitalPins& pins)
      : inputs_(inputs), outputs_(outputs), captured_(captured), pins_(pins) {}

  // Inputs are pulled down: an open wire reads as low. Outputs are low before they are outputs. The captured
  // pin is the timer's.
  void start() {
    for (std::uint32_t i = 0; i < pins_.inputs; ++i) {
      set_up_pin(inputs_, {.pin = pins_.first_input + i, .mode = PinMode::kInput, .pull = PinPull::kDown});
    }
    write(0);
    for (std::uint32_t i = 0; i < pins_.outputs; ++i) {
      set_up_pin(outputs_, {.pin = pins_.first_output + i, .mode = PinMode::kOutput, .pull = PinPull::kDown});
    }
  }

  std::uint32_t read() const {
    const std::uint32_t levels =
        (static_cast<std::uint32_t>(inputs_.idr) >> pins_.first_input) & mask(pins_.inputs);
    return captured_.high() ? levels | 1U << pins_.inputs : levels;
  }
  // One write, so that other pins of the port are not touched: the upper half resets, the lower half sets.
  void write(std::uint32_t levels) {
    const std::uint32_t all = mask(pins_.outputs) << pins_.first_output;
    const std::uint32_t high = (levels << pins_.first_output) & all;
    outputs_.bsrr = high | ((all & ~high) << 16U);
  }

 private:
  static std::uint32_t mask(std::uint32_t count) { return (1U << count) - 1U; }

  GpioBlock& inputs_;
  GpioBlock& outputs_;
  InputPin<GpioBlock> captured_;
  DigitalPins pins_;
};

}  // namespace slipstack::stm32g474
