// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>

#include "hal/include/absolute_encoder.h"
#include "hal/include/signal_scaling.h"
#include "hal/stm32g474/analogue_inputs.h"
#include "hal/stm32g474/biss_port.h"
#include "hal/stm32g474/can.h"
#include "hal/stm32g474/clock_tree.h"
#include "hal/stm32g474/digital_io.h"
#include "hal/stm32g474/edge_capture.h"
#include "hal/stm32g474/encoder.h"
#include "hal/stm32g474/flash_pages.h"
#include "hal/stm32g474/gpio.h"
#include "hal/stm32g474/led_indicator.h"
#include "hal/stm32g474/motor_current.h"
#include "hal/stm32g474/program_flash.h"
#include "hal/stm32g474/safe_outputs.h"
#include "hal/stm32g474/timing.h"
#include "hal/stm32g474/uart.h"
#include "hal/stm32g474/unique_id.h"

// The NUCLEO-G474RE with what is wired to it (README.md has the table of pins).
namespace slipstack::stm32g474 {

// Shared with the NMI's handler.
extern CarefulRead careful_read;

enum class DriveKind : std::uint8_t { kDac, kPwm };
enum class BoardFault : std::uint8_t { kNone, kClock, kDac, kAdc, kCan, kWatchdog, kTick };

// What differs from one axis to the next. The defaults suit an amplifier of 1 A/V and a current sensor of 0.1
// V/A around 1.65 V.
struct BoardSetup {
  std::uint32_t tick_rate_Hz = 10'000;
  std::uint32_t watchdog_us = 20'000;
  EncoderSetup encoder;
  SignalScales scales;  // until the stored ones are known
  PwmPlan pwm = plan_pwm(kCore_Hz, 40'000, 500, 0.05F, 0.95F);
  float amperes_at_full_duty = 10.0F;
  DigitalPins digital = kDigitalPins;
};

// The level shifter makes -10 ... +10 V of codes 0 ... 4095, and 0 V of 2048.
inline constexpr CurrentScale dac_scale(const SignalScales& scales) {
  constexpr float kCodesPerVolt = 204.75F;
  const float codes_per_A = kCodesPerVolt / scales.command_A_per_V;
  return {static_cast<float>(kDacZeroCode) + kCodesPerVolt * scales.command_zero_V,
          scales.motor_reversed ? -codes_per_A : codes_per_A, 1, 4095};
}
// 12 bits of 3.3 V; the outermost eight codes are an open or shorted sensor.
inline constexpr CurrentScale monitor_scale(const SignalScales& scales) {
  constexpr float kCodesPerVolt = 4096.0F / 3.3F;
  const float codes_per_A = kCodesPerVolt / scales.monitor_A_per_V;
  return {kCodesPerVolt * scales.monitor_zero_V, scales.motor_reversed ? -codes_per_A : codes_per_A, 8, 4087};
}

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

// Everything on the board, as hal/include wants it. One object, of static life. Hardware: `Part`, or a
// simulated one.
template <DriveKind kDrive, class Hardware>
class Board {
 public:
  using Word = typename Hardware::Word;
  using Port = Gpio<Word>;
  using BoardClock = CycleClock<Dwt<Word>>;
  using IncrementalEncoder = QuadratureEncoder<Timer<Word>, BoardClock>;
  using BoardBiss = BissPort<Spi<Word>, Dma<Word>, Dmamux<Word>, BoardClock>;
  using BoardEncoder = AxisEncoder<IncrementalEncoder, BoardBiss>;
  using BoardEdges = TimerEdges<Timer<Word>, Dma<Word>, Dmamux<Word>, Port>;
  using BoardCan = Can<Fdcan<Word>, CanMessageRam<Word>>;
  using BoardCurrentInput = CurrentInput<Adc<Word>, AdcCommon<Word>>;
  using Pwm = PwmOutput<Timer<Word>>;
  using DacOut = DacOutput<Dac<Word>>;
  using Output = std::conditional_t<kDrive == DriveKind::kDac, DacOut, Pwm>;
  using Motor = MotorDrive<Output, BoardCurrentInput, Port>;

  explicit Board(const BoardSetup& setup)
      : setup_(setup),
        clock_(block<Dwt>(kDWT_BASE)),
        incremental_(block<Timer>(kTIM2_BASE), clock_),
        biss_(block<Spi>(kSPI3_BASE), block<Dma>(kDMA1_BASE), block<Dmamux>(kDMAMUX_BASE), clock_),
        encoder_(incremental_, biss_),
        captured_pin_{port(kGPIOA_BASE), kCapturedPin},
        edges_(block<Timer>(kTIM2_BASE), block<Dma>(kDMA1_BASE), block<Dmamux>(kDMAMUX_BASE), captured_pin_),
        edge_capture_(*this),
        pwm_(block<Timer>(kTIM1_BASE), setup.pwm, setup.amperes_at_full_duty),
        dac_(block<Dac>(kDAC1_BASE), dac_scale(setup.scales)),
        current_input_(block<Adc>(kADC1_BASE), block<AdcCommon>(kADC12_COMMON_BASE),
                       monitor_scale(setup.scales)),
        slow_inputs_(block<Adc>(kADC1_BASE)),
        digital_io_(port(kGPIOC_BASE), port(kGPIOB_BASE), captured_pin_, setup.digital),
        motor_(output(), current_input_, port(kGPIOB_BASE), kEnablePin),
        can_(block<Fdcan>(kFDCAN1_BASE), block<CanMessageRam>(kSRAMCAN_BASE)),
        programs_(block<Flash>(kFLASH_BASE), flash_memory_, careful_read),
        flash_(block<Flash>(kFLASH_BASE), flash_memory_, careful_read,
               parameters_in(static_cast<std::uint32_t>(programs_.running() ^ 1U))),
        other_flash_(block<Flash>(kFLASH_BASE), flash_memory_, careful_read,
                     parameters_in(static_cast<std::uint32_t>(programs_.running()))),
        led_(port(kGPIOA_BASE), 5),
        indicator_(led_),
        scaling_(*this),
        tick_timer_(block<Timer>(kTIM6_BASE)),
        uart_(block<Usart>(kUSART2_BASE)),
        watchdog_(block<Iwdg>(kIWDG_BASE)) {
    // Here and not in start(): objects that are constructed after the board may ask.
    watchdog_.note_last_reset(take_reset_cause(block<Rcc>(kRCC_BASE)) == ResetCause::kWatchdog);
  }

  // The enable signal low, the command at zero current; only then clocks, pins, every device; the tick and
  // the watchdog last. After the first fault the rest does not start, and the power stage is off. `filters`
  // and `joins` as for Can::start().
  [[nodiscard]] BoardFault start(std::span<const CanFilter> filters, bool joins = true) {
    secure_outputs<Hardware>();
    if (!start_command()) return BoardFault::kDac;
    const ClockStart clock = start_clock_tree(block<Rcc>(kRCC_BASE), block<Pwr>(kPWR_BASE),
                                              block<Flash>(kFLASH_BASE), Hardware::wait_us);
    if (clock.fault != ClockFault::kNone) return BoardFault::kClock;
    crystal_ = clock.source == ClockSource::kHse;
    switch_clocks_on();
    set_up_pins();
    set_bits(Hardware::word(kDEMCR), 1U << 24U);
    clock_.start();
    static_cast<void>(uart_.start(kCore_Hz, 115'200));
    incremental_.start(setup_.encoder);
    edges_.start();
    // A locked-up core switches TIM1's outputs off by hardware. Flash errors do not: those of the parameter
    // pages have an owner, the others end in the NMI.
    block<Syscfg>(kSYSCFG_BASE).cfgr2 = kSYSCFG_CFGR2_CLL(1);
    pwm_.start();  // with the DAC as well: it triggers the ADC
    if (current_input_.start(Hardware::wait_us) != AdcFault::kNone) return BoardFault::kAdc;
    const CanBitTiming& timing = crystal_ ? kCanTimingCrystal : kCanTimingHsi;
    if (can_.start(timing, filters, crystal_ ? kHse_Hz : kCore_Hz, joins) != CanFault::kNone)
      return BoardFault::kCan;
    return start_interrupts();
  }

  /// Of the part: no two boards have the same, but for one pair in 2^32.
  static std::uint32_t serial_number() {
    return serial_from(
        {Hardware::word(kUniqueId), Hardware::word(kUniqueId + 4), Hardware::word(kUniqueId + 8)});
  }

  BoardEncoder& encoder() { return encoder_; }
  AbsoluteEncoder& absolute_encoder() { return encoder_; }
  EdgeCapture& edge_capture() { return edge_capture_; }
  IncrementalEncoder& incremental_encoder() { return incremental_; }
  BoardBiss& biss() { return biss_; }
  Motor& motor_current() { return motor_; }
  BoardClock& clock() { return clock_; }
  IndependentWatchdog<Iwdg<Word>>& watchdog() { return watchdog_; }
  DigitalPort<Port>& digital_io() { return digital_io_; }
  AnalogueInputs& analogue_inputs() { return slow_inputs_; }
  BoardCan& can() { return can_; }
  FlashPages<Flash<Word>, Hardware>& nonvolatile() { return flash_; }
  /// Where the program in the other bank stores.
  FlashPages<Flash<Word>, Hardware>& nonvolatile_of_other_program() { return other_flash_; }
  ProgramMemory& programs() { return programs_; }
  LedIndicator<Led<Port>>& indicator() { return indicator_; }
  TickTimer<Timer<Word>>& tick_timer() { return tick_timer_; }
  Uart<Usart<Word>>& uart() { return uart_; }
  SignalScaling& scaling() { return scaling_; }
  bool runs_on_crystal() const { return crystal_; }

 private:
  static constexpr std::uint32_t kCapturedPin = 10;  // PA10
  static constexpr std::uint32_t kTickPriority = 0;  // nothing holds the tick up
  static constexpr std::uint32_t kCanPriority = 4;
  static constexpr std::uint32_t kFramePriority = 4;  // neither interrupts the other: one stack for both
  static constexpr std::uint32_t kIndicatorPriority = 15;

  // 2500h: constants of the drivers, so that the tick converts as before.
  class Scaling final : public SignalScaling {
   public:
    explicit Scaling(Board& board) : board_(board) {}
    void set_scales(const SignalScales& scales) override {
      board_.encoder_.set_reversed(scales.encoder_reversed);
      board_.output().set_scale(command_scale(board_.setup_, scales));
      board_.current_input_.set_scale(monitor_scale(scales));
    }
    float largest_A(const SignalScales& scales) const override {
      return kDrive == DriveKind::kDac ? largest_of_10_V(scales) : board_.setup_.amperes_at_full_duty;
    }

   private:
    Board& board_;
  };

  // Of a probe, while the timer counts the axis.
  class CapturedInput final : public EdgeCapture {
   public:
    explicit CapturedInput(Board& board) : board_(board) {}
    std::uint8_t terminal() const override {
      return board_.encoder_.absolute()
                 ? std::uint8_t{0}
                 : static_cast<std::uint8_t>(board_.setup_.digital.captured_terminal());
    }
    std::size_t take(std::span<CapturedEdge> edges) override { return board_.edges_.take(edges); }

   private:
    Board& board_;
  };

  static CurrentScale command_scale(const BoardSetup& setup, const SignalScales& scales) {
    if constexpr (kDrive == DriveKind::kDac) {
      return dac_scale(scales);
    } else {
      return pwm_scale(setup.pwm,
                       scales.motor_reversed ? -setup.amperes_at_full_duty : setup.amperes_at_full_duty);
    }
  }

  template <template <class> class Block>
  static Block<Word>& block(std::uint32_t address) {
    return Hardware::template block<Block>(address);
  }
  static Port& port(std::uint32_t address) { return block<Gpio>(address); }

  Output& output() {
    if constexpr (kDrive == DriveKind::kDac) {
      return dac_;
    } else {
      return pwm_;
    }
  }

  // The converter puts out zero current before its pin is connected. Before the clock tree, which may wait
  // for a crystal: until then the amplifier sees what the board's bias gives.
  [[nodiscard]] bool start_command() {
    if constexpr (kDrive == DriveKind::kPwm) return true;
    auto& rcc = block<Rcc>(kRCC_BASE);
    set_bits(rcc.ahb2enr, kRCC_AHB2ENR_GPIOAEN(1) | kRCC_AHB2ENR_DAC1EN(1));
    static_cast<void>(rcc.ahb2enr & 1U);
    const bool ready = dac_.start();
    if (ready) set_up_pin(port(kGPIOA_BASE), {.pin = kCommandPin, .mode = PinMode::kAnalog});
    return ready;
  }

  void switch_clocks_on() {
    auto& rcc = block<Rcc>(kRCC_BASE);
    set_bits(rcc.ahb1enr, kRCC_AHB1ENR_DMA1EN(1) | kRCC_AHB1ENR_DMAMUX1EN(1));
    set_bits(rcc.ahb2enr, kRCC_AHB2ENR_GPIOAEN(1) | kRCC_AHB2ENR_GPIOBEN(1) | kRCC_AHB2ENR_GPIOCEN(1) |
                              kRCC_AHB2ENR_ADC12EN(1) | kRCC_AHB2ENR_DAC1EN(1));
    set_bits(rcc.apb1enr1, kRCC_APB1ENR1_TIM2EN(1) | kRCC_APB1ENR1_TIM6EN(1) | kRCC_APB1ENR1_SPI3EN(1) |
                               kRCC_APB1ENR1_USART2EN(1) | kRCC_APB1ENR1_FDCANEN(1));
    set_bits(rcc.apb2enr, kRCC_APB2ENR_SYSCFGEN(1) | kRCC_APB2ENR_TIM1EN(1));
    // FDCAN: the crystal itself, or PCLK1.
    change_bits(rcc.ccipr, kRCC_CCIPR_FDCANSEL.mask,
                crystal_ ? kRCC_CCIPR_FDCANSEL(0) : kRCC_CCIPR_FDCANSEL(2));
    static_cast<void>(rcc.apb2enr & 1U);
    block<FdcanConfig>(kFDCAN_CONFIG_BASE).ckdiv = kFDCAN_CKDIV_PDIV(0);
    // A debugger that halts the core halts the watchdog too.
    set_bits(block<Dbgmcu>(kDBGMCU_BASE).apb1fzr1, kDBGMCU_APB1FZR1_DBG_IWDG_STOP(1));
  }

  // Functions by DS12288, table "Alternate function".
  void set_up_pins() {
    auto& a = port(kGPIOA_BASE);
    auto& b = port(kGPIOB_BASE);
    const auto alternate = [](std::uint32_t pin, std::uint32_t function, PinPull pull, std::uint32_t speed) {
      return PinSetup{pin, PinMode::kAlternate, function, pull, speed};
    };
    set_up_pin(a, alternate(0, 1, PinPull::kUp, 0));                // TIM2_CH1: A
    set_up_pin(a, alternate(1, 1, PinPull::kUp, 0));                // TIM2_CH2: B
    set_up_pin(b, alternate(10, 1, PinPull::kDown, 0));             // TIM2_CH3: index
    set_up_pin(a, alternate(kCapturedPin, 10, PinPull::kDown, 0));  // TIM2_CH4: captured input
    set_up_pin(a, alternate(2, 7, PinPull::kNone, 1));              // USART2_TX
    set_up_pin(a, alternate(3, 7, PinPull::kUp, 0));                // USART2_RX
    set_up_pin(a, alternate(11, 9, PinPull::kUp, 0));               // FDCAN1_RX
    set_up_pin(a, alternate(12, 9, PinPull::kNone, 1));             // FDCAN1_TX
    auto& c = port(kGPIOC_BASE);
    set_up_pin(c, {.pin = 0, .mode = PinMode::kAnalog});   // ADC12_IN6
    set_up_pin(b, {.pin = 11, .mode = PinMode::kAnalog});  // ADC12_IN14: temperature
    set_up_pin(b, {.pin = 12, .mode = PinMode::kAnalog});  // ADC1_IN11: DC link
    set_up_pin(c, alternate(10, 6, PinPull::kUp, 1));      // SPI3_SCK: MA
    set_up_pin(c, alternate(11, 6, PinPull::kUp, 0));      // SPI3_MISO: SLO
    digital_io_.start();
    led_.start();
    if constexpr (kDrive == DriveKind::kPwm) {
      set_up_pin(a, alternate(8, 6, PinPull::kDown, 2));   // TIM1_CH1
      set_up_pin(b, alternate(13, 6, PinPull::kDown, 2));  // TIM1_CH1N
      set_up_pin(a, alternate(9, 6, PinPull::kDown, 2));   // TIM1_CH2
      set_up_pin(b, alternate(14, 6, PinPull::kDown, 2));  // TIM1_CH2N
    }
  }

  BoardFault start_interrupts() {
    auto& nvic = block<Nvic>(kNVIC_BASE);
    // SysTick draws the LED: reload, count, priority, then on with the core's clock (Armv7-M ARM, B3.3).
    Hardware::word(0xE000E014) = kCore_Hz / 1000 * kPatternStep_ms - 1;
    Hardware::word(0xE000E018) = 0;
    change_bits(Hardware::word(0xE000ED20), 0xFF000000U, kIndicatorPriority << 28U);
    Hardware::word(0xE000E010) = 7;
    enable_interrupt(nvic, kFDCAN1_IT0_IRQ, kCanPriority);
    enable_interrupt(nvic, kDMA1_Channel1_IRQ, kFramePriority);
    enable_interrupt(nvic, kTIM6_DAC_IRQ, kTickPriority);
    // The watchdog before the tick: a tick that never comes is seen.
    if (!watchdog_.start(plan_watchdog(setup_.watchdog_us))) return BoardFault::kWatchdog;
    if (!tick_timer_.start(setup_.tick_rate_Hz)) return BoardFault::kTick;
    return BoardFault::kNone;
  }

  BoardSetup setup_;
  BoardClock clock_;
  IncrementalEncoder incremental_;
  BoardBiss biss_;
  BoardEncoder encoder_;
  InputPin<Port> captured_pin_;
  BoardEdges edges_;
  CapturedInput edge_capture_;
  Pwm pwm_;
  DacOut dac_;
  BoardCurrentInput current_input_;
  SlowInputs<Adc<Word>> slow_inputs_;
  DigitalPort<Port> digital_io_;
  Motor motor_;
  BoardCan can_;
  Hardware flash_memory_;
  ProgramFlash<Hardware, Flash<Word>, Hardware> programs_;
  FlashPages<Flash<Word>, Hardware> flash_;  // in the bank that does not run
  FlashPages<Flash<Word>, Hardware> other_flash_;
  Led<Port> led_;
  LedIndicator<Led<Port>> indicator_;
  Scaling scaling_;
  TickTimer<Timer<Word>> tick_timer_;
  Uart<Usart<Word>> uart_;
  IndependentWatchdog<Iwdg<Word>> watchdog_;
  bool crystal_ = false;
};

}  // namespace slipstack::stm32g474
