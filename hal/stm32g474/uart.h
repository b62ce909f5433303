// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "hal/stm32g474/registers.h"

namespace slipstack::stm32g474 {

// The divider for a rate, oversampling by 16; 0 when the rate cannot be had within 1.5 %.
constexpr std::uint32_t uart_divider(std::uint32_t clock_Hz, std::uint32_t baud) {
  if (baud == 0) return 0;
  const std::uint32_t divider = (clock_Hz + baud / 2) / baud;
  if (divider < 16 || divider > 0xFFFF) return 0;
  const std::uint32_t real = clock_Hz / divider;
  const std::uint32_t error = real > baud ? real - baud : baud - real;
  return error * 200 <= baud * 3 ? divider : 0;
}

// USART2, 8 data bits, no parity, one stop bit: lines for diagnosis. RM0440, Universal
// synchronous/asynchronous receiver transmitter.
template <class UsartBlock>
class Uart {
 public:
  explicit Uart(UsartBlock& usart) : usart_(usart) {}

  [[nodiscard]] bool start(std::uint32_t clock_Hz, std::uint32_t baud) {
    const std::uint32_t divider = uart_divider(clock_Hz, baud);
    if (divider == 0) return false;
    usart_.cr1 = 0;
    usart_.brr = divider;
    usart_.cr1 = kUSART_CR1_FIFOEN(1) | kUSART_CR1_TE(1) | kUSART_CR1_RE(1) | kUSART_CR1_UE(1);
    return true;
  }

  // Never waits: false when the transmit FIFO (8 bytes) is full.
  bool put(char character) {
    if ((usart_.isr & kUSART_ISR_TXE.mask) == 0) return false;
    usart_.tdr = static_cast<std::uint8_t>(character);
    return true;
  }

  // Never waits: false when nothing was received. An overrun is cleared, or nothing would be received again.
  bool get(char& character) {
    const std::uint32_t status = usart_.isr;
    if ((status & kUSART_ISR_ORE.mask) != 0) usart_.icr = kUSART_ICR_ORECF(1);
    if ((status & kUSART_ISR_RXNE.mask) == 0) return false;
    character = static_cast<char>(kUSART_RDR_RDR.read(usart_.rdr) & 0xFFU);
    return true;
  }

  // Waits until all is in the FIFO, but not for a transmitter that does not go on: for the main loop only.
  void write(std::string_view text) {
    for (const char character : text) {
      for (std::uint32_t polls = 100'000; polls > 0 && !put(character); --polls) {
      }
    }
  }

 private:
  UsartBlock& usart_;
};

}  // namespace slipstack::stm32g474
