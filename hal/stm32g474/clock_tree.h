// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/stm32g474/registers.h"

// The clock tree: HSE 24 MHz (the NUCLEO-G474RE's crystal X3, UM2505 "HSE clock") or HSI16 -> PLL -> 170 MHz
// for the core, the buses and the timers. RM0440: Power control (PWR), dynamic voltage scaling, range 1
// boost; Reset and clock control (RCC), PLL; Embedded flash memory, read access latency.
namespace slipstack::stm32g474 {

enum class ClockSource : std::uint8_t { kHse, kHsi };

// hse: fit for CAN at 1 Mbit/s. hsi: within 1 % only, to start without a crystal.
struct ClockPlan {
  ClockSource source;
  std::uint32_t input_Hz;
  std::uint32_t pll_divide_in;   // M
  std::uint32_t pll_multiply;    // N
  std::uint32_t pll_divide_out;  // R
  std::uint32_t flash_wait_states;

  constexpr std::uint32_t pll_input_Hz() const { return input_Hz / pll_divide_in; }
  constexpr std::uint32_t vco_Hz() const { return pll_input_Hz() * pll_multiply; }
  constexpr std::uint32_t core_Hz() const { return vco_Hz() / pll_divide_out; }
};

// Wait states of the flash at a core clock in range 1 boost mode (RM0440, number of wait states according to
// CPU clock).
constexpr std::uint32_t flash_wait_states_boost(std::uint32_t core_Hz) {
  return core_Hz == 0 ? 0 : (core_Hz - 1) / 34'000'000;
}

// True when the plan keeps the part's limits: PLL input 2.66 ... 16 MHz, VCO 96 ... 344 MHz, core at most 170
// MHz (DS12288, PLL characteristics, range 1), fields that hold the factors, and enough wait states.
constexpr bool keeps_limits(const ClockPlan& plan) {
  const bool divides = plan.pll_divide_in > 0 && plan.input_Hz % plan.pll_divide_in == 0;
  const bool fields = plan.pll_divide_in <= 16 && plan.pll_multiply >= 8 && plan.pll_multiply <= 127 &&
                      (plan.pll_divide_out == 2 || plan.pll_divide_out == 4 || plan.pll_divide_out == 6 ||
                       plan.pll_divide_out == 8);
  if (!divides || !fields) return false;
  return plan.pll_input_Hz() >= 2'660'000 && plan.pll_input_Hz() <= 16'000'000 &&
         plan.vco_Hz() >= 96'000'000 && plan.vco_Hz() <= 344'000'000 && plan.core_Hz() <= 170'000'000 &&
         plan.flash_wait_states >= flash_wait_states_boost(plan.core_Hz()) && plan.flash_wait_states <= 15;
}

inline constexpr std::uint32_t kCore_Hz = 170'000'000;
inline constexpr std::uint32_t kHse_Hz = 24'000'000;
inline constexpr std::uint32_t kHsi_Hz = 16'000'000;
inline constexpr ClockPlan kHsePlan{ClockSource::kHse, kHse_Hz, 6, 85, 2, 4};
inline constexpr ClockPlan kHsiPlan{ClockSource::kHsi, kHsi_Hz, 4, 85, 2, 4};
static_assert(keeps_limits(kHsePlan) && kHsePlan.core_Hz() == kCore_Hz);
static_assert(keeps_limits(kHsiPlan) && kHsiPlan.core_Hz() == kCore_Hz);

enum class ClockFault : std::uint8_t { kNone, kFlashLatency, kPllNotOff, kPllNotLocked, kNotSwitched };

struct ClockStart {
  ClockFault fault;
  ClockSource source;  // kHsi when the crystal did not start
};

// Brings the core from HSI16, as after reset, to 170 MHz. `wait_us(n)` waits at least n microseconds.
// All buses run at the core's clock. With the crystal, the clock security system is on: when the crystal
// stops, the part goes on with HSI16 and raises the NMI. Bounded: about 200 ms when nothing answers.
template <class Word, class WaitUs>
ClockStart start_clock_tree(Rcc<Word>& rcc, Pwr<Word>& pwr, Flash<Word>& flash, WaitUs wait_us) {
  // The crystal takes 2 ms (DS12288, HSE oscillator characteristics); at 16 MHz and 4 cycles or more a poll,
  // this is 50 ms.
  constexpr std::uint32_t kCrystalPolls = 200'000;
  constexpr std::uint32_t kPolls = 20'000;  // for what takes microseconds

  set_bits(rcc.apb1enr1, kRCC_APB1ENR1_PWREN(1));
  static_cast<void>(rcc.apb1enr1 & 1U);       // a peripheral answers two cycles after its clock (RM0440, RCC)
  clear_bits(pwr.cr5, kPWR_CR5_R1MODE.mask);  // boost

  set_bits(rcc.cr, kRCC_CR_HSEON(1));
  const bool crystal = wait_for(rcc.cr, kRCC_CR_HSERDY.mask, kRCC_CR_HSERDY.mask, kCrystalPolls);
  if (!crystal) clear_bits(rcc.cr, kRCC_CR_HSEON.mask);
  const ClockPlan plan = crystal ? kHsePlan : kHsiPlan;

  change_bits(flash.acr, kFLASH_ACR_LATENCY.mask, kFLASH_ACR_LATENCY.place(plan.flash_wait_states));
  set_bits(flash.acr, kFLASH_ACR_PRFTEN(1) | kFLASH_ACR_ICEN(1) | kFLASH_ACR_DCEN(1));
  if (!wait_for(flash.acr, kFLASH_ACR_LATENCY.mask, kFLASH_ACR_LATENCY.place(plan.flash_wait_states),
                kPolls)) {
    return {ClockFault::kFlashLatency, plan.source};
  }

  clear_bits(rcc.cr, kRCC_CR_PLLON.mask);
  if (!wait_for(rcc.cr, kRCC_CR_PLLRDY.mask, 0, kPolls)) return {ClockFault::kPllNotOff, plan.source};
  rcc.pllcfgr = (crystal ? kRCC_PLLCFGR_PLLSRC(3) : kRCC_PLLCFGR_PLLSRC(2)) |
                kRCC_PLLCFGR_PLLM.place(plan.pll_divide_in - 1) | kRCC_PLLCFGR_PLLN.place(plan.pll_multiply) |
                kRCC_PLLCFGR_PLLR.place(plan.pll_divide_out / 2 - 1) | kRCC_PLLCFGR_PLLREN(1);
  set_bits(rcc.cr, kRCC_CR_PLLON(1));
  if (!wait_for(rcc.cr, kRCC_CR_PLLRDY.mask, kRCC_CR_PLLRDY.mask, kPolls)) {
    return {ClockFault::kPllNotLocked, plan.source};
  }

  // Above 80 MHz the core goes through half its clock for a microsecond (RM0440, PWR, range 1 normal to
  // boost).
  change_bits(rcc.cfgr, kRCC_CFGR_HPRE.mask | kRCC_CFGR_PPRE1.mask | kRCC_CFGR_PPRE2.mask, kRCC_CFGR_HPRE(8));
  change_bits(rcc.cfgr, kRCC_CFGR_SW.mask, kRCC_CFGR_SW(3));
  if (!wait_for(rcc.cfgr, kRCC_CFGR_SWS.mask, kRCC_CFGR_SWS(3), kPolls)) {
    return {ClockFault::kNotSwitched, plan.source};
  }
  wait_us(1);
  clear_bits(rcc.cfgr, kRCC_CFGR_HPRE.mask);
  if (crystal) set_bits(rcc.cr, kRCC_CR_CSSON(1));
  return {ClockFault::kNone, plan.source};
}

// Why the controller started.
enum class ResetCause : std::uint8_t { kPower, kPin, kSoftware, kWatchdog, kOther };

// Reads why, and clears it for the next start. A watchdog or software reset also pulls the pin: they come
// first.
template <class Word>
ResetCause take_reset_cause(Rcc<Word>& rcc) {
  const std::uint32_t csr = rcc.csr;
  set_bits(rcc.csr, kRCC_CSR_RMVF(1));
  if ((csr & (kRCC_CSR_IWDGRSTF.mask | kRCC_CSR_WWDGRSTF.mask)) != 0) return ResetCause::kWatchdog;
  if ((csr & kRCC_CSR_SFTRSTF.mask) != 0) return ResetCause::kSoftware;
  if ((csr & kRCC_CSR_BORRSTF.mask) != 0) return ResetCause::kPower;
  if ((csr & (kRCC_CSR_LPWRRSTF.mask | kRCC_CSR_OBLRSTF.mask)) != 0) return ResetCause::kOther;
  return ResetCause::kPin;
}

}  // namespace slipstack::stm32g474
