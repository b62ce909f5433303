// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "hal/stm32g474/can.h"
#include "hal/stm32g474/clock_tree.h"
#include "hal/stm32g474/digital_io.h"
#include "hal/stm32g474/encoder.h"
#include "hal/stm32g474/flash_pages.h"
#include "hal/stm32g474/gpio.h"
#include "hal/stm32g474/lamp.h"
#include "hal/stm32g474/motor_current.h"
#include "hal/stm32g474/peripherals.h"
#include "hal/stm32g474/timing.h"
#include "hal/stm32g474/uart.h"
#include "hal/stm32g474/unique_id.h"

// The NUCLEO-G474RE with what is wired to it (README.md has the table of pins). Only for the target.
namespace slipstack::stm32g474 {

using Port = Gpio<HardwareWord>;
using BoardEncoder = QuadratureEncoder<Timer<HardwareWord>, CycleClock<Dwt<HardwareWord>>>;
using BoardCan = Can<Fdcan<HardwareWord>, CanMessageRam<HardwareWord>>;
using BoardCurrentInput = CurrentInput<Adc<HardwareWord>, AdcCommon<HardwareWord>>;

// The part's memory bus. The barriers let the NMI of a bad word come before the next instruction.
struct FlashMemory {
  std::uint32_t read_word(std::uint32_t address) const {
    const std::uint32_t word = hardware_word(address);
    asm volatile("dsb \n isb \n nop \n nop" ::: "memory");
    return word;
  }
  void write_word(std::uint32_t address, std::uint32_t value) const { hardware_word(address) = value; }
};

// Shared with the NMI's handler.
extern CarefulRead careful_read;

// Power stage off, zero current. For the handlers of faults: uses nothing but the registers.
void force_safe_state();

enum class DriveKind : std::uint8_t { kDac, kPwm };
enum class BoardFault : std::uint8_t { kNone, kClock, kDac, kAdc, kCan, kWatchdog, kTick };

// What differs from one axis to the next. The defaults suit an amplifier of 1 A/V and a current sensor of 0.1
// V/A around 1.65 V.
struct BoardSetup {
  std::uint32_t tick_rate_Hz = 10'000;
  std::uint32_t watchdog_us = 20'000;
  EncoderSetup encoder;
  // DAC code 2048 is 0 V after the level shifter, 0 ... 4095 is -10 ... +10 V.
  CurrentScale dac_scale{2048.0F, 204.75F, 1, 4095};
  PwmPlan pwm = plan_pwm(kCore_Hz, 40'000, 500, 0.05F, 0.95F);
  float amperes_at_full_duty = 10.0F;
  CurrentScale adc_scale{2048.0F, 4096.0F / 33.0F, 8, 4087};
  DigitalPins digital{.first_input = 1, .inputs = 8, .first_output = 0, .outputs = 3};  // PC1, PB0
};

static_assert(keeps_limits(BoardSetup{}.pwm));
static_assert(plan_watchdog(BoardSetup{}.watchdog_us).valid);
// The crystal's own clock is the FDCAN's: 24 quanta, sampled at 87.5 %. Without the crystal the bus clock is,
// and the 1 % of the HSI16 is more than CAN allows at any rate: better than silence on a short bus, and
// reported.
inline constexpr CanBitTiming kCanTimingCrystal = plan_can_timing(kHse_Hz, 1'000'000);
inline constexpr CanBitTiming kCanTimingHsi = plan_can_timing(kCore_Hz, 1'000'000);
static_assert(kCanTimingCrystal.valid() && kCanTimingCrystal.bit_rate(kHse_Hz) == 1'000'000);
static_assert(kCanTimingHsi.valid() && kCanTimingHsi.bit_rate(kCore_Hz) == 1'000'000);
static_assert(kCanTimingCrystal.clock_tolerance_ppm() >= 1'000, "ten times a crystal's 100 ppm");

template <DriveKind kDrive>
struct DriveOutput;
template <>
struct DriveOutput<DriveKind::kDac> {
  using Type = DacOutput<Dac<HardwareWord>>;
};
template <>
struct DriveOutput<DriveKind::kPwm> {
  using Type = PwmOutput<Timer<HardwareWord>>;
};

// Everything on the board, as hal/include wants it. One object, of static life.
template <DriveKind kDrive>
class Board {
 public:
  using Output = typename DriveOutput<kDrive>::Type;
  using Motor = MotorDrive<Output, BoardCurrentInput, Port>;

  explicit Board(const BoardSetup& setup)
      : setup_(setup),
        clock_(hardware<Dwt>(kDWT_BASE)),
        encoder_(hardware<Timer>(kTIM2_BASE), clock_),
        pwm_(hardware<Timer>(kTIM1_BASE), setup.pwm, setup.amperes_at_full_duty),
        dac_(hardware<Dac>(kDAC1_BASE), setup.dac_scale),
        current_input_(hardware<Adc>(kADC1_BASE), hardware<AdcCommon>(kADC12_COMMON_BASE), setup.adc_scale),
        digital_io_(port(kGPIOC_BASE), port(kGPIOB_BASE), setup.digital),
        motor_(output(), current_input_, port(kGPIOB_BASE), kEnablePin),
        can_(hardware<Fdcan>(kFDCAN1_BASE), hardware<CanMessageRam>(kSRAMCAN_BASE)),
        flash_(hardware<Flash>(kFLASH_BASE), flash_memory_, careful_read),
        led_(port(kGPIOA_BASE), 5),
        lamp_(led_),
        tick_timer_(hardware<Timer>(kTIM6_BASE)),
        uart_(hardware<Usart>(kUSART2_BASE)),
        watchdog_(hardware<Iwdg>(kIWDG_BASE)) {
    // Here and not in start(): objects that are constructed after the board may ask.
    watchdog_.note_last_reset(take_reset_cause(hardware<Rcc>(kRCC_BASE)) == ResetCause::kWatchdog);
  }

  // Clocks, pins, every device; the tick and the watchdog last. After the first fault the rest does not
  // start, and the power stage is off. `filters` and `joins` as for Can::start().
  [[nodiscard]] BoardFault start(std::span<const CanFilter> filters, bool joins = true) {
    force_safe_state();
    const ClockStart clock = start_clock_tree(hardware<Rcc>(kRCC_BASE), hardware<Pwr>(kPWR_BASE),
                                              hardware<Flash>(kFLASH_BASE), wait_us);
    if (clock.fault != ClockFault::kNone) return BoardFault::kClock;
    crystal_ = clock.source == ClockSource::kHse;
    switch_clocks_on();
    set_up_pins();
    set_bits(hardware_word(kDEMCR), 1U << 24U);
    clock_.start();
    static_cast<void>(uart_.start(kCore_Hz, 115'200));
    encoder_.start(setup_.encoder);
    // A locked-up core switches TIM1's outputs off by hardware. Flash errors do not: those of the parameter
    // pages have an owner, the others end in the NMI.
    hardware<Syscfg>(kSYSCFG_BASE).cfgr2 = kSYSCFG_CFGR2_CLL(1);
    pwm_.start();  // with the DAC as well: it triggers the ADC
    if (kDrive == DriveKind::kDac && !dac_.start()) return BoardFault::kDac;
    if (current_input_.start(wait_us) != AdcFault::kNone) return BoardFault::kAdc;
    const CanBitTiming& timing = crystal_ ? kCanTimingCrystal : kCanTimingHsi;
    if (can_.start(timing, filters, crystal_ ? kHse_Hz : kCore_Hz, joins) != CanFault::kNone)
      return BoardFault::kCan;
    return start_interrupts();
  }

  /// Of the part: no two boards have the same, but for one pair in 2^32.
  static std::uint32_t serial_number() {
    return serial_from(
        {hardware_word(kUniqueId), hardware_word(kUniqueId + 4), hardware_word(kUniqueId + 8)});
  }

  BoardEncoder& encoder() { return encoder_; }
  Motor& motor_current() { return motor_; }
  CycleClock<Dwt<HardwareWord>>& clock() { return clock_; }
  IndependentWatchdog<Iwdg<HardwareWord>>& watchdog() { return watchdog_; }
  DigitalPort<Port>& digital_io() { return digital_io_; }
  BoardCan& can() { return can_; }
  FlashPages<Flash<HardwareWord>, FlashMemory>& nonvolatile() { return flash_; }
  Lamp<Led<Port>>& indicator() { return lamp_; }
  TickTimer<Timer<HardwareWord>>& tick_timer() { return tick_timer_; }
  Uart<Usart<HardwareWord>>& uart() { return uart_; }
  bool runs_on_crystal() const { return crystal_; }

 private:
  static constexpr std::uint32_t kEnablePin = 5;     // PB5
  static constexpr std::uint32_t kTickPriority = 0;  // nothing holds the tick up
  static constexpr std::uint32_t kCanPriority = 4;
  static constexpr std::uint32_t kLampPriority = 15;

  static Port& port(std::uint32_t address) { return hardware<Gpio>(address); }

  Output& output() {
    if constexpr (kDrive == DriveKind::kDac) {
      return dac_;
    } else {
      return pwm_;
    }
  }

  void switch_clocks_on() {
    auto& rcc = hardware<Rcc>(kRCC_BASE);
    set_bits(rcc.ahb2enr, kRCC_AHB2ENR_GPIOAEN(1) | kRCC_AHB2ENR_GPIOBEN(1) | kRCC_AHB2ENR_GPIOCEN(1) |
                              kRCC_AHB2ENR_ADC12EN(1) | kRCC_AHB2ENR_DAC1EN(1));
    set_bits(rcc.apb1enr1, kRCC_APB1ENR1_TIM2EN(1) | kRCC_APB1ENR1_TIM6EN(1) | kRCC_APB1ENR1_USART2EN(1) |
                               kRCC_APB1ENR1_FDCANEN(1));
    set_bits(rcc.apb2enr, kRCC_APB2ENR_SYSCFGEN(1) | kRCC_APB2ENR_TIM1EN(1));
    // FDCAN: the crystal itself, or PCLK1.
    change_bits(rcc.ccipr, kRCC_CCIPR_FDCANSEL.mask,
                crystal_ ? kRCC_CCIPR_FDCANSEL(0) : kRCC_CCIPR_FDCANSEL(2));
    static_cast<void>(rcc.apb2enr & 1U);
    hardware<FdcanConfig>(kFDCAN_CONFIG_BASE).ckdiv = kFDCAN_CKDIV_PDIV(0);
    // A debugger that halts the core halts the watchdog too.
    set_bits(hardware<Dbgmcu>(kDBGMCU_BASE).apb1fzr1, kDBGMCU_APB1FZR1_DBG_IWDG_STOP(1));
  }

  // Functions by DS12288, table "Alternate function".
  void set_up_pins() {
    auto& a = port(kGPIOA_BASE);
    auto& b = port(kGPIOB_BASE);
    const auto alternate = [](std::uint32_t pin, std::uint32_t function, PinPull pull, std::uint32_t speed) {
      return PinSetup{pin, PinMode::kAlternate, function, pull, speed};
    };
    set_up_pin(a, alternate(0, 1, PinPull::kUp, 0));                      // TIM2_CH1: A
    set_up_pin(a, alternate(1, 1, PinPull::kUp, 0));                      // TIM2_CH2: B
    set_up_pin(b, alternate(10, 1, PinPull::kDown, 0));                   // TIM2_CH3: index
    set_up_pin(a, alternate(2, 7, PinPull::kNone, 1));                    // USART2_TX
    set_up_pin(a, alternate(3, 7, PinPull::kUp, 0));                      // USART2_RX
    set_up_pin(a, alternate(11, 9, PinPull::kUp, 0));                     // FDCAN1_RX
    set_up_pin(a, alternate(12, 9, PinPull::kNone, 1));                   // FDCAN1_TX
    set_up_pin(port(kGPIOC_BASE), {.pin = 0, .mode = PinMode::kAnalog});  // ADC12_IN6
    digital_io_.start();
    b.bsrr = 1U << (kEnablePin + 16);
    set_up_pin(b, {.pin = kEnablePin, .mode = PinMode::kOutput, .pull = PinPull::kDown});
    led_.start();
    if constexpr (kDrive == DriveKind::kDac) {
      set_up_pin(a, {.pin = 4, .mode = PinMode::kAnalog});  // DAC1_OUT1
    } else {
      set_up_pin(a, alternate(8, 6, PinPull::kDown, 2));   // TIM1_CH1
      set_up_pin(b, alternate(13, 6, PinPull::kDown, 2));  // TIM1_CH1N
      set_up_pin(a, alternate(9, 6, PinPull::kDown, 2));   // TIM1_CH2
      set_up_pin(b, alternate(14, 6, PinPull::kDown, 2));  // TIM1_CH2N
    }
  }

  BoardFault start_interrupts() {
    auto& nvic = hardware<Nvic>(kNVIC_BASE);
    // SysTick draws the lamp: reload, count, priority, then on with the core's clock (Armv7-M ARM, B3.3).
    hardware_word(0xE000E014) = kCore_Hz / 1000 * kLampStep_ms - 1;
    hardware_word(0xE000E018) = 0;
    change_bits(hardware_word(0xE000ED20), 0xFF000000U, kLampPriority << 28U);
    hardware_word(0xE000E010) = 7;
    enable_interrupt(nvic, kFDCAN1_IT0_IRQ, kCanPriority);
    enable_interrupt(nvic, kTIM6_DAC_IRQ, kTickPriority);
    // The watchdog before the tick: a tick that never comes is seen.
    if (!watchdog_.start(plan_watchdog(setup_.watchdog_us))) return BoardFault::kWatchdog;
    if (!tick_timer_.start(setup_.tick_rate_Hz)) return BoardFault::kTick;
    return BoardFault::kNone;
  }

  BoardSetup setup_;
  CycleClock<Dwt<HardwareWord>> clock_;
  BoardEncoder encoder_;
  PwmOutput<Timer<HardwareWord>> pwm_;
  DacOutput<Dac<HardwareWord>> dac_;
  BoardCurrentInput current_input_;
  DigitalPort<Port> digital_io_;
  Motor motor_;
  BoardCan can_;
  FlashMemory flash_memory_;
  FlashPages<Flash<HardwareWord>, FlashMemory> flash_;
  Led<Port> led_;
  Lamp<Led<Port>> lamp_;
  TickTimer<Timer<HardwareWord>> tick_timer_;
  Uart<Usart<HardwareWord>> uart_;
  IndependentWatchdog<Iwdg<HardwareWord>> watchdog_;
  bool crystal_ = false;
};

}  // namespace slipstack::stm32g474
