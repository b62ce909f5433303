// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/include/analogue_inputs.h"
#include "hal/stm32g474/registers.h"

namespace slipstack::stm32g474 {

/// Temperature and DC link voltage: the second and third conversion of the sequence that CurrentInput starts,
/// every period of TIM1. That the converter stands still is seen by the first, the current.
template <class AdcBlock>
class SlowInputs final : public AnalogueInputs {
 public:
  explicit SlowInputs(AdcBlock& adc) : adc_(adc) {}

  bool has_temperature() const override { return true; }
  bool has_bus_voltage() const override { return true; }
  AnalogueReading temperature() override {
    const std::uint32_t code = kADC_JDR2_JDATA.read(adc_.jdr2);
    return {volts(code), code > kLowRail && code < kHighRail};
  }
  // A link without voltage reads 0. So does a broken wire, and is taken for it.
  AnalogueReading bus_voltage() override {
    const std::uint32_t code = kADC_JDR3_JDATA.read(adc_.jdr3);
    return {volts(code), code < kHighRail};
  }

 private:
  // 12 bits of 3.3 V; the outermost eight codes are an open or shorted wire.
  static constexpr std::uint32_t kLowRail = 8;
  static constexpr std::uint32_t kHighRail = 4087;
  static float volts(std::uint32_t code) { return static_cast<float>(code) * (3.3F / 4096.0F); }

  AdcBlock& adc_;
};

}  // namespace slipstack::stm32g474
