// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// UART0 of the MPS2 (CMSDK APB UART), transmit only: what an image prints. Polled; blocks while the
// transmitter is full. Formatting of our own: printf would bring a heap in.
namespace slipstack::mps2 {

// Switches the transmitter on. Called by the first write; safe to repeat.
void uart_start();

void uart_write(char character);
void uart_write(const char* text);

// Decimal, right-aligned in `width` characters.
void uart_write_unsigned(std::uint32_t value, int width = 0);

// Eight hexadecimal digits.
void uart_write_hex(std::uint32_t value);

// The other UARTs, both ways; no call waits. UART1 carries CAN frames as SLCAN.
inline constexpr std::uint32_t kUart1Address = 0x40005000;

class Uart {
 public:
  explicit Uart(std::uint32_t address) : address_(address) {}
  // Transmitter and receiver on.
  void start();
  // Takes the byte that has come; false when there is none.
  bool read(std::uint8_t& byte);
  // Sends a byte; false when the transmitter is full.
  bool write(std::uint8_t byte);

 private:
  std::uint32_t address_;
};

}  // namespace slipstack::mps2
