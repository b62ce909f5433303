// SPDX-License-Identifier: Apache-2.0
#include "hal/stm32g474/digital_io.h"

#include <gtest/gtest.h>

#include "tests/unit/stm32g474/simulated_word.h"

namespace slipstack::stm32g474 {
namespace {
using test::SimWord;

constexpr DigitalPins kPins{.first_input = 1, .inputs = 8, .first_output = 4, .outputs = 3};

TEST(DigitalPort, ReadsItsPinsOnly) {
  Gpio<SimWord> in;
  Gpio<SimWord> out;
  Gpio<SimWord> other;
  const DigitalPort port(in, out, {other, 10}, kPins);
  in.idr.value = 0xFFFF;
  EXPECT_EQ(port.read(), 0xFFU);
  in.idr.value = 0x0002;
  EXPECT_EQ(port.read(), 0x01U);
  in.idr.value = 0x0101;  // pin 0 is another's
  EXPECT_EQ(port.read(), 0x80U);
  other.idr.value = 0xFBFF;
  EXPECT_EQ(port.read(), 0x80U);
  other.idr.value = 0x0400;
  EXPECT_EQ(port.read(), 0x180U) << "behind the others";
  EXPECT_EQ(kPins.captured_terminal(), 9U);
}

TEST(DigitalPort, WritesItsPinsOnlyAndAllOfThem) {
  Gpio<SimWord> in;
  Gpio<SimWord> out;
  DigitalPort port(in, out, {in, 10}, kPins);
  port.write(0xFFFFFFFF);
  EXPECT_EQ(out.bsrr.value, 0x00000070U);
  port.write(0);
  EXPECT_EQ(out.bsrr.value, 0x00700000U);
  port.write(2);
  EXPECT_EQ(out.bsrr.value, 0x00500020U);
}

TEST(DigitalPort, OutputsAreLowBeforeTheyAreOutputs) {
  Gpio<SimWord> in;
  Gpio<SimWord> out;
  bool low = false;
  out.bsrr.on_write = [&](SimWord&, std::uint32_t written) { low = low || written == 0x00700000U; };
  out.moder.on_write = [&](SimWord& word, std::uint32_t written) {
    EXPECT_TRUE(low);
    word.value = written;
  };
  DigitalPort port(in, out, {in, 10}, kPins);
  port.start();
  EXPECT_TRUE(low);
  EXPECT_EQ(out.moder.value & 0x3F00U, 0x1500U);
  EXPECT_EQ(in.pupdr.value & 0x3FFFCU, 0x2AAA8U) << "an open wire reads as low";
}

}  // namespace
}  // namespace slipstack::stm32g474
