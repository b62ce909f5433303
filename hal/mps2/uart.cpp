// SPDX-License-Identifier: Apache-2.0
#include "hal/mps2/uart.h"

namespace slipstack::mps2 {

namespace {

// Cortex-M System Design Kit, Technical Reference Manual, 4.3 (APB UART); base address: AN386 table 3-2.
struct UartRegisters {
  volatile std::uint32_t data;
  volatile std::uint32_t state;
  volatile std::uint32_t control;
  volatile std::uint32_t interrupt;
  volatile std::uint32_t baud_divider;
};
constexpr std::uint32_t kUart0Address = 0x40004000;
constexpr std::uint32_t kTransmitterFull = 1U << 0;
constexpr std::uint32_t kReceiverFull = 1U << 1;
constexpr std::uint32_t kTransmitterEnable = 1U << 0;
constexpr std::uint32_t kReceiverEnable = 1U << 1;
constexpr std::uint32_t kBaudDivider = 217;  // 25 MHz / 115200; the emulator does not wait

UartRegisters& uart_at(std::uint32_t address) {
  return *reinterpret_cast<UartRegisters*>(address);
}
UartRegisters& uart0() {
  return uart_at(kUart0Address);
}

}  // namespace

void uart_start() {
  uart0().baud_divider = kBaudDivider;
  uart0().control = kTransmitterEnable;
}

void uart_write(char character) {
  if ((uart0().control & kTransmitterEnable) == 0) uart_start();
  while ((uart0().state & kTransmitterFull) != 0) {
  }
  uart0().data = static_cast<std::uint32_t>(static_cast<unsigned char>(character));
}

void uart_write(const char* text) {
  for (; *text != '\0'; ++text) uart_write(*text);
}

void uart_write_unsigned(std::uint32_t value, int width) {
  char digits[10];
  int count = 0;
  do {
    digits[count++] = static_cast<char>('0' + value % 10);
    value /= 10;
  } while (value != 0);
  for (int i = count; i < width; ++i) uart_write(' ');
  while (count > 0) uart_write(digits[--count]);
}

void uart_write_hex(std::uint32_t value) {
  for (int shift = 28; shift >= 0; shift -= 4) uart_write("0123456789abcdef"[(value >> shift) & 0xFU]);
}

void Uart::start() {
  uart_at(address_).baud_divider = kBaudDivider;
  uart_at(address_).control = kTransmitterEnable | kReceiverEnable;
}

bool Uart::read(std::uint8_t& byte) {
  if ((uart_at(address_).state & kReceiverFull) == 0) return false;
  byte = static_cast<std::uint8_t>(uart_at(address_).data);
  return true;
}

bool Uart::write(std::uint8_t byte) {
  if ((uart_at(address_).state & kTransmitterFull) != 0) return false;
  uart_at(address_).data = byte;
  return true;
}

}  // namespace slipstack::mps2
