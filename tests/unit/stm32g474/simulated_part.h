// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <vector>

#include "hal/stm32g474/core.h"
#include "hal/stm32g474/registers.h"
#include "tests/unit/stm32g474/simulated_word.h"

// The whole part for Board<..., SimulatedPart>: every register of every block, the clock gates, the answers
// that a start waits for, and the two pins that the amplifier sees. One at a time.
namespace slipstack::stm32g474::test {

/// What the amplifier sees. A pin that is not driven is what the board's resistors make of it: the enable
/// low, the command at half the reference.
struct AmplifierView {
  bool enable_driven = false;
  bool enabled = false;
  bool command_driven = false;
  std::uint32_t command_code = kDacHalf;

  static constexpr std::uint32_t kDacHalf = 2048;
  bool moves() const { return enabled && command_code != kDacHalf; }
};

/// Thrown by the write after which the program is cut off.
struct CutOff : std::runtime_error {
  CutOff() : std::runtime_error("cut off") {}
};

class SimulatedPart {
 public:
  using Word = SimWord;

  SimulatedPart() { current() = this; }
  SimulatedPart(const SimulatedPart&) = delete;
  SimulatedPart& operator=(const SimulatedPart&) = delete;
  ~SimulatedPart() { current() = nullptr; }

  // ---- what Board asks ----
  struct Access {
    using Word = SimWord;
    template <template <class> class Block>
    static Block<SimWord>& block(std::uint32_t address) {
      return current()->template at<Block>(address);
    }
    static SimWord& word(std::uint32_t address) { return current()->core_[address]; }
    static void wait_us(std::uint32_t duration_us) { current()->waited_us_ += duration_us; }
    std::uint32_t read_word(std::uint32_t) const { return 0xFFFFFFFF; }
    void write_word(std::uint32_t, std::uint32_t) const {}
  };

  // ---- what a test sets and sees ----
  bool crystal_starts = true;
  bool dac_works = true;
  bool adc_works = true;
  bool pll_works = true;
  bool can_works = true;
  std::uint32_t reset_flags = 0;
  /// The program is cut off behind so many writes.
  std::size_t writes_allowed = static_cast<std::size_t>(-1);
  /// Behind every write that arrives: what the amplifier sees now.
  std::function<void(const AmplifierView&)> on_write;
  std::size_t writes() const { return writes_; }
  std::size_t polls() const { return polls_; }
  std::size_t lost_writes() const { return lost_; }  ///< to a peripheral without its clock

  AmplifierView amplifier() {
    AmplifierView view;
    auto& rcc = at<Rcc>(kRCC_BASE);
    const bool b_clocked = (rcc.ahb2enr.value & kRCC_AHB2ENR_GPIOBEN.mask) != 0;
    auto& b = at<Gpio>(kGPIOB_BASE);
    view.enable_driven = b_clocked && (b.moder.value >> 10U & 3U) == 1;
    view.enabled = view.enable_driven && (b.odr.value >> 5U & 1U) != 0;
    auto& dac = at<Dac>(kDAC1_BASE);
    auto& a = at<Gpio>(kGPIOA_BASE);
    const bool connected = (a.moder.value >> 8U & 3U) == 3;
    view.command_driven = connected && (dac.cr.value & 1U) != 0;
    if (view.command_driven) view.command_code = dac.dhr12r1.value & 0xFFF;
    return view;
  }

  /// Registers as after a reset (RM0440, each block's register map): pins analog, no clock but the flash's.
  void reset() {
    blocks_.clear();
    core_.clear();
    writes_ = lost_ = polls_ = waited_us_ = 0;
    at<Gpio>(kGPIOA_BASE).moder.value = 0xABFFFFFF;
    at<Gpio>(kGPIOB_BASE).moder.value = 0xFFFFFEBF;
    at<Gpio>(kGPIOC_BASE).moder.value = 0xFFFFFFFF;
    at<Timer>(kTIM1_BASE).af1.value = 1;
    at<Rcc>(kRCC_BASE).csr.value = reset_flags;
    at<Flash>(kFLASH_BASE).optr.value = kFLASH_OPTR_DBANK.mask;
  }

  /// As a boot loader or a debugger may leave the part: outputs driven, anything in their registers.
  template <class Random>
  void leave_outputs_anyhow(Random& random) {
    const auto word = [&random] { return static_cast<std::uint32_t>(random()); };
    auto& rcc = at<Rcc>(kRCC_BASE);
    rcc.ahb2enr.value |= word() & 0x00012007U;
    rcc.apb2enr.value |= word() & kRCC_APB2ENR_TIM1EN.mask;
    at<Gpio>(kGPIOA_BASE).moder.value = word();
    at<Gpio>(kGPIOB_BASE).moder.value = word();
    at<Gpio>(kGPIOB_BASE).odr.value = word() & 0xFFFF;
    at<Dac>(kDAC1_BASE).cr.value = word();
    at<Dac>(kDAC1_BASE).dhr12r1.value = word() & 0xFFF;
    at<Timer>(kTIM1_BASE).bdtr.value = word();
  }

  template <template <class> class Block>
  Block<SimWord>& at(std::uint32_t address) {
    auto& place = blocks_[address];
    if (!place) {
      const auto made = std::make_shared<Block<SimWord>>();
      place = made;
      watch(reinterpret_cast<SimWord*>(made.get()), sizeof *made / sizeof(SimWord), address);
      behave(*made, address);
    }
    return *static_cast<Block<SimWord>*>(place.get());
  }

 private:
  static SimulatedPart*& current() {
    static SimulatedPart* part = nullptr;
    return part;
  }

  bool clocked(std::uint32_t address) {
    auto& rcc = at<Rcc>(kRCC_BASE);
    const std::map<std::uint32_t, std::pair<SimWord*, std::uint32_t>> gates = {
        {kGPIOA_BASE, {&rcc.ahb2enr, kRCC_AHB2ENR_GPIOAEN.mask}},
        {kGPIOB_BASE, {&rcc.ahb2enr, kRCC_AHB2ENR_GPIOBEN.mask}},
        {kGPIOC_BASE, {&rcc.ahb2enr, kRCC_AHB2ENR_GPIOCEN.mask}},
        {kDAC1_BASE, {&rcc.ahb2enr, kRCC_AHB2ENR_DAC1EN.mask}},
        {kADC1_BASE, {&rcc.ahb2enr, kRCC_AHB2ENR_ADC12EN.mask}},
        {kTIM1_BASE, {&rcc.apb2enr, kRCC_APB2ENR_TIM1EN.mask}},
        {kTIM2_BASE, {&rcc.apb1enr1, kRCC_APB1ENR1_TIM2EN.mask}},
        {kTIM6_BASE, {&rcc.apb1enr1, kRCC_APB1ENR1_TIM6EN.mask}},
        {kDMA1_BASE, {&rcc.ahb1enr, kRCC_AHB1ENR_DMA1EN.mask}},
        {kDMAMUX_BASE, {&rcc.ahb1enr, kRCC_AHB1ENR_DMAMUX1EN.mask}},
        {kSPI3_BASE, {&rcc.apb1enr1, kRCC_APB1ENR1_SPI3EN.mask}},
        {kFDCAN1_BASE, {&rcc.apb1enr1, kRCC_APB1ENR1_FDCANEN.mask}}};
    const auto gate = gates.find(address);
    return gate == gates.end() || (gate->second.first->value & gate->second.second) != 0;
  }

  // Every write counts, may be the last, and is lost without a clock.
  void watch(SimWord* words, std::size_t count, std::uint32_t address) {
    for (std::size_t i = 0; i < count; ++i) {
      words[i].on_write = [this, address, offset = 4 * i](SimWord& self, std::uint32_t written) {
        if (writes_ >= writes_allowed) throw CutOff();
        ++writes_;
        if (!clocked(address)) {
          ++lost_;
        } else {
          store(self, address, static_cast<std::uint32_t>(offset), written);
        }
        if (on_write) on_write(amplifier());
      };
    }
  }

  void store(SimWord& word, std::uint32_t address, std::uint32_t offset, std::uint32_t written) {
    const bool port = address == kGPIOA_BASE || address == kGPIOB_BASE || address == kGPIOC_BASE;
    if (port && offset == 0x18) {  // BSRR: the lower half sets, the upper half resets, set wins
      auto& odr = at<Gpio>(address).odr;
      odr.value = (odr.value & ~(written >> 16U)) | (written & 0xFFFFU);
    } else {
      word.value = written;
    }
  }

  template <class Block>
  void behave(Block&, std::uint32_t) {}
  void behave(Rcc<SimWord>& rcc, std::uint32_t) {
    rcc.cr.on_read = [this](std::uint32_t value) {
      ++polls_;
      if (crystal_starts && (value & kRCC_CR_HSEON.mask) != 0) value |= kRCC_CR_HSERDY.mask;
      return pll_works && (value & kRCC_CR_PLLON.mask) != 0 ? value | kRCC_CR_PLLRDY.mask : value;
    };
    rcc.cfgr.on_read = [](std::uint32_t value) {
      return value | kRCC_CFGR_SWS.place(kRCC_CFGR_SW.read(value));
    };
  }
  void behave(Dac<SimWord>& dac, std::uint32_t) {
    dac.sr.on_read = [this, &dac](std::uint32_t) {
      ++polls_;
      return dac_works && (dac.cr.value & 1U) != 0 ? kDAC_SR_DAC1RDY.mask : 0U;
    };
  }
  void behave(Adc<SimWord>& adc, std::uint32_t) {
    adc.cr.on_read = [this](std::uint32_t value) { return adc_works ? value & ~kADC_CR_ADCAL.mask : value; };
    adc.isr.on_read = [](std::uint32_t) { return kADC_ISR_ADRDY.mask | kADC_ISR_JEOS.mask; };
  }
  void behave(Fdcan<SimWord>& can, std::uint32_t) {
    can.cccr.on_read = [this](std::uint32_t value) {
      return can_works ? value : value & ~kFDCAN_CCCR_INIT.mask;
    };
  }

  std::map<std::uint32_t, std::shared_ptr<void>> blocks_;
  std::map<std::uint32_t, SimWord> core_;
  std::size_t writes_ = 0;
  std::size_t lost_ = 0;
  std::size_t polls_ = 0;
  std::size_t waited_us_ = 0;
};

}  // namespace slipstack::stm32g474::test
