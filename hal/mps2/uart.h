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

}  // namespace slipstack::mps2
