// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/include/clock.h"
#include "hal/include/watchdog.h"
#include "hal/stm32g474/clock_tree.h"
#include "hal/stm32g474/core.h"
#include "hal/stm32g474/registers.h"

// The tick, the clock and the watchdog.
namespace slipstack::stm32g474 {

// The cycle counter of the core: 170 MHz, wraps after 25 s.
template <class DwtBlock>
class CycleClock {
 public:
  explicit CycleClock(DwtBlock& dwt) : dwt_(&dwt) {}

  void start() {
    dwt_->cyccnt = 0;
    set_bits(dwt_->ctrl, 1U);
  }
  std::uint32_t now() const { return dwt_->cyccnt; }
  std::uint32_t ticks_per_second() const { return kCore_Hz; }

 private:
  DwtBlock* dwt_;
};

// How punctual the ticks were, in cycles of the core, since reset_extremes().
struct TickPunctuality {
  std::uint32_t ticks = 0;
  std::uint32_t overruns = 0;              // ticks that were not done when the next was due
  std::uint32_t latency_min = 0xFFFFFFFF;  // from the timer's event to the handler: max - min is the jitter
  std::uint32_t latency_max = 0;
  std::uint32_t duration_max = 0;  // from the timer's event to the handler's end
};

// TIM6 raises the tick. RM0440, Basic timers (TIM6/TIM7). The handler calls begin() first and end() last.
template <class TimerBlock>
class TickTimer {
 public:
  static constexpr std::uint32_t kMinRate_Hz = 5'000;
  static constexpr std::uint32_t kMaxRate_Hz = 40'000;

  explicit TickTimer(TimerBlock& timer) : timer_(timer) {}

  // False when the rate is outside its bounds or no divisor of the core's clock to 0.01 %: the timer does not
  // start then.
  [[nodiscard]] bool start(std::uint32_t rate_Hz) {
    if (rate_Hz < kMinRate_Hz || rate_Hz > kMaxRate_Hz) return false;
    const std::uint32_t period = (kCore_Hz + rate_Hz / 2) / rate_Hz;
    const std::uint32_t product = period * rate_Hz;
    const std::uint32_t error = product > kCore_Hz ? product - kCore_Hz : kCore_Hz - product;
    if (error > kCore_Hz / 10'000) return false;
    timer_.cr1 = 0;
    timer_.psc = 0;
    timer_.arr = period - 1;
    timer_.egr = kTIM_EGR_UG(1);
    timer_.sr = 0;
    timer_.dier = kTIM_DIER_UIE(1);
    timing_ = {};
    timer_.cr1 = kTIM_CR1_CEN(1);
    return true;
  }

  void begin() {
    const std::uint32_t latency = timer_.cnt;
    timer_.sr = ~kTIM_SR_UIF.mask;
    ++timing_.ticks;
    if (latency < timing_.latency_min) timing_.latency_min = latency;
    if (latency > timing_.latency_max) timing_.latency_max = latency;
  }

  void end() {
    // The event has come again: this tick took longer than a period, and the next follows at once.
    const bool overrun = (timer_.sr & kTIM_SR_UIF.mask) != 0;
    const std::uint32_t duration = overrun ? timer_.arr + 1 : static_cast<std::uint32_t>(timer_.cnt);
    if (overrun) ++timing_.overruns;
    if (duration > timing_.duration_max) timing_.duration_max = duration;
  }

  // Read outside the handler, the counts may be of two neighbouring ticks.
  const TickPunctuality& timing() const { return timing_; }
  void reset_extremes() {
    timing_.latency_min = 0xFFFFFFFF;
    timing_.latency_max = 0;
    timing_.duration_max = 0;
  }

 private:
  TimerBlock& timer_;
  TickPunctuality timing_;
};

// A time-out of the independent watchdog, which runs on the LSI: 32 kHz nominal, 29.5 ... 34 kHz over voltage
// and temperature (DS12288, LSI oscillator characteristics).
struct WatchdogPlan {
  std::uint32_t prescaler_code = 0;  // divides by 4 << code
  std::uint32_t reload = 0;          // 0 ... 4095
  bool valid = false;

  constexpr std::uint32_t clocks() const { return (4U << prescaler_code) * (reload + 1); }
  constexpr std::uint32_t nominal_us() const { return clocks() * 1000 / 32; }
  constexpr std::uint32_t shortest_us() const { return clocks() * 1000 / 34; }
  constexpr std::uint32_t longest_us() const {
    return static_cast<std::uint32_t>(std::uint64_t{clocks()} * 10'000 / 295);
  }
};

// The finest setting whose nominal time-out is at least timeout_us; not valid above 32.7 s or at zero.
constexpr WatchdogPlan plan_watchdog(std::uint32_t timeout_us) {
  if (timeout_us == 0 || timeout_us > 32'768'000) return {};
  const std::uint32_t clocks = static_cast<std::uint32_t>((std::uint64_t{timeout_us} * 32 + 999) / 1000);
  for (std::uint32_t code = 0; code <= 6; ++code) {
    const std::uint32_t divider = 4U << code;
    const std::uint32_t reload = (clocks + divider - 1) / divider;
    if (reload <= 4096) return {code, reload - 1, true};
  }
  return {};
}

// RM0440, Independent watchdog (IWDG). Once started, nothing but a reset stops it.
template <class IwdgBlock>
class IndependentWatchdog {
 public:
  explicit IndependentWatchdog(IwdgBlock& iwdg) : iwdg_(iwdg) {}

  // The cause of the last reset, read at start-up (take_reset_cause).
  void note_last_reset(bool by_watchdog) { caused_last_reset_ = by_watchdog; }

  // False when the plan is not valid (nothing was started) or the watchdog does not take its settings over:
  // then it runs with a time-out of half a second.
  [[nodiscard]] bool start(const WatchdogPlan& plan) {
    if (!plan.valid) return false;
    iwdg_.kr = kIWDG_KR_KEY(0xCCCC);  // starts, and the LSI with it
    iwdg_.kr = kIWDG_KR_KEY(0x5555);  // opens the settings
    iwdg_.pr = kIWDG_PR_PR.place(plan.prescaler_code);
    iwdg_.rlr = kIWDG_RLR_RL.place(plan.reload);
    // Five or six clocks of the LSI, 200 us.
    const bool taken = wait_for(iwdg_.sr, kIWDG_SR_PVU.mask | kIWDG_SR_RVU.mask, 0, 100'000);
    refresh();
    return taken;
  }

  void refresh() { iwdg_.kr = kIWDG_KR_KEY(0xAAAA); }
  bool caused_last_reset() const { return caused_last_reset_; }

 private:
  IwdgBlock& iwdg_;
  bool caused_last_reset_ = false;
};

}  // namespace slipstack::stm32g474
