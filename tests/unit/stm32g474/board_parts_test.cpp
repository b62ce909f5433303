// SPDX-License-Identifier: Apache-2.0
// Pins, LED, interrupt controller, serial port.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "hal/stm32g474/clock_tree.h"
#include "hal/stm32g474/core.h"
#include "hal/stm32g474/gpio.h"
#include "hal/stm32g474/led_indicator.h"
#include "hal/stm32g474/uart.h"
#include "hal/stm32g474/unique_id.h"
#include "tests/unit/stm32g474/simulated_word.h"

namespace slipstack::stm32g474 {
namespace {
using test::Journal;
using test::SimWord;

TEST(Pins, AreSetUpOneByOne) {
  Gpio<SimWord> port;
  port.moder.value = 0xABFFFFFF;  // port A after reset
  port.afr[0].value = 0x11111111;
  port.afr[1].value = 0x22222222;
  Journal journal;
  journal.watch(port.moder, "MODER");
  journal.watch(port.afr[1], "AFR");
  set_up_pin(port, {.pin = 11, .mode = PinMode::kAlternate, .function = 9, .pull = PinPull::kUp, .speed = 2});
  EXPECT_EQ(port.moder.value, 0xABBFFFFFU);
  EXPECT_EQ(port.afr[1].value, 0x22229222U);
  EXPECT_EQ(port.afr[0].value, 0x11111111U);
  EXPECT_EQ(port.pupdr.value, 1U << 22U);
  EXPECT_EQ(port.ospeedr.value, 2U << 22U);
  EXPECT_LT(journal.first("AFR", 0, 0), journal.first("MODER", 0, 0));
  set_up_pin(port, {.pin = 0, .mode = PinMode::kOutput});
  EXPECT_EQ(port.moder.value & 3U, 1U);
}

TEST(LedIndicator, IsSwitchedByOneWrite) {
  Gpio<SimWord> port;
  Led led(port, 5);
  led.start();
  led.set(true);
  EXPECT_EQ(port.bsrr.value, 1U << 5U);
  led.set(false);
  EXPECT_EQ(port.bsrr.value, 1U << 21U);
}

// CiA 303-3: period and time lit, in ms; flashes in a period.
TEST(LedIndicator, DrawsThePatternsOfCia303) {
  const auto measure = [](Indication indication, std::uint32_t period_ms) {
    std::uint32_t lit = 0;
    std::uint32_t flashes = 0;
    const std::uint32_t steps = period_ms / kPatternStep_ms;
    for (std::uint32_t step = steps; step < 2 * steps; ++step) {
      const bool now = led_lit(indication, step);
      EXPECT_EQ(now, led_lit(indication, step + steps)) << "not periodic";
      if (now) ++lit;
      if (now && !led_lit(indication, step - 1)) ++flashes;
    }
    return std::pair{lit * kPatternStep_ms, flashes};
  };
  EXPECT_EQ(measure(Indication::kStarting, 100), (std::pair{50U, 1U}));
  EXPECT_EQ(measure(Indication::kDisabled, 1200), (std::pair{200U, 1U}));
  EXPECT_EQ(measure(Indication::kReady, 400), (std::pair{200U, 1U}));
  EXPECT_EQ(measure(Indication::kEnabled, 1000), (std::pair{1000U, 0U}));
  EXPECT_EQ(measure(Indication::kFault, 1600), (std::pair{400U, 2U}));
}

TEST(LedIndicator, ShowsWhatItIsTold) {
  Gpio<SimWord> port;
  Led led(port, 5);
  LedIndicator indicator(led);
  indicator.show(Indication::kEnabled);
  for (int i = 0; i < 100; ++i) {
    indicator.step();
    ASSERT_EQ(port.bsrr.value, 1U << 5U);
  }
}

TEST(Interrupts, HaveTheirPriorityInTheUpperBits) {
  Nvic<SimWord> nvic;
  nvic.ipr[13].value = 0xFFFFFFFF;
  nvic.ipr[5].value = 0x11223344;
  for (SimWord* word : {&nvic.iser[0], &nvic.iser[1]}) {
    word->on_write = [](SimWord& self, std::uint32_t written) { self.value |= written; };
  }
  enable_interrupt(nvic, kTIM6_DAC_IRQ, 0);
  EXPECT_EQ(nvic.iser[1].value, 1U << 22U);
  EXPECT_EQ(nvic.ipr[13].value, 0xFF00FFFFU) << "interrupt 54 is byte 2 of word 13";
  enable_interrupt(nvic, kFDCAN1_IT0_IRQ, 4);
  EXPECT_EQ(nvic.iser[0].value, 1U << 21U);
  EXPECT_EQ(nvic.ipr[5].value, 0x11224044U);
}

TEST(Uart, DividesTheBusClock) {
  EXPECT_EQ(uart_divider(kCore_Hz, 115'200), 1476U);
  for (const std::uint32_t baud : {2'600U, 9'600U, 115'200U, 921'600U, 2'000'000U, 10'000'000U}) {
    const std::uint32_t divider = uart_divider(kCore_Hz, baud);
    ASSERT_GE(divider, 16U) << baud;
    EXPECT_NEAR(170e6 / divider / baud, 1.0, 0.015) << baud;
  }
  EXPECT_EQ(uart_divider(kCore_Hz, 0), 0U);
  EXPECT_EQ(uart_divider(kCore_Hz, 2'000), 0U);       // 17 bits
  EXPECT_EQ(uart_divider(kCore_Hz, 12'000'000), 0U);  // less than 16
  EXPECT_EQ(uart_divider(16'000'000, 950'000), 17U);  // 0.9 % off
  EXPECT_EQ(uart_divider(16'000'000, 975'000), 0U);   // 2.6 % off
}

TEST(Uart, SendsAndReceivesWithoutWaiting) {
  Usart<SimWord> usart;
  std::string sent;
  std::uint32_t room = 8;
  usart.isr.on_read = [&](std::uint32_t value) { return value | (room > 0 ? 1U << 7U : 0U); };
  usart.tdr.on_write = [&](SimWord&, std::uint32_t written) {
    ASSERT_GT(room, 0U);
    --room;
    sent.push_back(static_cast<char>(written));
  };
  Uart uart(usart);
  ASSERT_TRUE(uart.start(kCore_Hz, 115'200));
  EXPECT_EQ(usart.brr.value, 1476U);
  EXPECT_EQ(usart.cr1.value, 1U << 29U | 0xDU);
  EXPECT_FALSE(uart.start(kCore_Hz, 1));
  uart.write("12345678");
  EXPECT_FALSE(uart.put('9'));
  uart.write("ab");  // gives up
  EXPECT_EQ(sent, "12345678");
  char character = 0;
  EXPECT_FALSE(uart.get(character));
  usart.isr.value = 1U << 5U | 1U << 3U;
  usart.rdr.value = 'x';
  EXPECT_TRUE(uart.get(character));
  EXPECT_EQ(character, 'x');
  EXPECT_EQ(usart.icr.value, 1U << 3U) << "after an overrun nothing more would come";
}

// Parts of a lot differ in few bits, those of a wafer in the coordinates only.
TEST(UniqueId, NeighboursHaveDifferentSerialNumbers) {
  std::set<std::uint32_t> serials;
  for (std::uint32_t x = 0; x < 100; ++x) {
    for (std::uint32_t y = 0; y < 100; ++y)
      serials.insert(serial_from({y << 16U | x, 0x31473231, 0x20353041}));
  }
  EXPECT_EQ(serials.size(), 10000U);
  EXPECT_FALSE(serials.contains(0));
  // FNV-1a of twelve zero bytes, by its definition: the offset basis times the prime to the twelfth.
  std::uint32_t expected = 2166136261U;
  for (int i = 0; i < 12; ++i) expected *= 16777619U;
  EXPECT_EQ(serial_from({0, 0, 0}), expected);
}

}  // namespace
}  // namespace slipstack::stm32g474
