// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

// The registers of the STM32G474 that the drivers use, and no more. A block is a template on its word: on the
// target a volatile 32-bit word at the part's address (peripherals.h), in host tests a word that behaves as
// the part does. Reference: RM0440, STM32G4 series reference manual; the chapter stands by its title beside
// each block.
namespace slipstack::stm32g474 {

// Defined nowhere: a constant that does not fit its field does not compile.
void field_value_too_wide();

// A bit field of a register. Some are split (TIM SMS, TS, OCxM: the highest bit lies apart), hence a mask.
struct Field {
  std::uint32_t position;
  std::uint32_t mask;

  // The field holding a constant, all other bits zero; its bits go to the mask's bits, lowest first.
  consteval std::uint32_t operator()(std::uint32_t value) const {
    std::uint32_t word = 0;
    for (std::uint32_t bit = 1; bit != 0; bit <<= 1U) {
      if ((mask & bit) == 0) continue;
      if ((value & 1U) != 0) word |= bit;
      value >>= 1U;
    }
    if (value != 0) field_value_too_wide();
    return word;
  }

  // The same for a value known only when running, for fields in one piece; the value must fit.
  constexpr std::uint32_t place(std::uint32_t value) const { return (value << position) & mask; }

  // What a register's word holds in a field in one piece.
  constexpr std::uint32_t read(std::uint32_t word) const { return (word & mask) >> position; }

  // What the field can hold at most, for fields in one piece.
  constexpr std::uint32_t max() const { return mask >> position; }
};

// Volatile words have no compound assignment in C++20; and a reader sees that each of these reads and writes.
template <class Word>
void set_bits(Word& word, std::uint32_t mask) {
  word = word | mask;
}

template <class Word>
void clear_bits(Word& word, std::uint32_t mask) {
  word = word & ~mask;
}

// Replaces the bits of `mask` by those of `value`.
template <class Word>
void change_bits(Word& word, std::uint32_t mask, std::uint32_t value) {
  word = (word & ~mask) | value;
}

// Reads `word` until its bits `mask` equal `wanted`, at most `polls` times. False when they never did: no
// hardware that fails to answer may hang the controller. A poll takes at least 4 cycles of the core.
template <class Word>
[[nodiscard]] bool wait_for(Word& word, std::uint32_t mask, std::uint32_t wanted, std::uint32_t polls) {
  for (; polls > 0; --polls) {
    if ((word & mask) == wanted) return true;
  }
  return false;
}

// RM0440, Reset and clock control (RCC).
template <class Word>
struct Rcc {
  Word cr;
  Word icscr;
  Word cfgr;
  Word pllcfgr;
  Word reserved_10[2];
  Word cier;
  Word cifr;
  Word cicr;
  Word reserved_24[1];
  Word ahb1rstr;
  Word ahb2rstr;
  Word ahb3rstr;
  Word reserved_34[1];
  Word apb1rstr1;
  Word apb1rstr2;
  Word apb2rstr;
  Word reserved_44[1];
  Word ahb1enr;
  Word ahb2enr;
  Word ahb3enr;
  Word reserved_54[1];
  Word apb1enr1;
  Word apb1enr2;
  Word apb2enr;
  Word reserved_64[9];
  Word ccipr;
  Word reserved_8c[1];
  Word bdcr;
  Word csr;
};

// RM0440, Power control (PWR).
template <class Word>
struct Pwr {
  Word cr1;
  Word cr2;
  Word cr3;
  Word cr4;
  Word sr1;
  Word sr2;
  Word scr;
  Word reserved_1c[25];
  Word cr5;
};

// RM0440, Embedded flash memory (FLASH) for category 3 devices.
template <class Word>
struct Flash {
  Word acr;
  Word pdkeyr;
  Word keyr;
  Word optkeyr;
  Word sr;
  Word cr;
  Word eccr;
  Word reserved_1c[1];
  Word optr;
};

// RM0440, General-purpose I/Os (GPIO).
template <class Word>
struct Gpio {
  Word moder;
  Word otyper;
  Word ospeedr;
  Word pupdr;
  Word idr;
  Word odr;
  Word bsrr;
  Word lckr;
  Word afr[2];
};

// RM0440, Advanced-control timers (TIM1/TIM8/TIM20), General-purpose timers (TIM2/TIM3/TIM4/TIM5), Basic
// timers (TIM6/TIM7): one layout, of which the smaller timers have a part.
template <class Word>
struct Timer {
  Word cr1;
  Word cr2;
  Word smcr;
  Word dier;
  Word sr;
  Word egr;
  Word ccmr1;
  Word ccmr2;
  Word ccer;
  Word cnt;
  Word psc;
  Word arr;
  Word rcr;
  Word ccr1;
  Word ccr2;
  Word ccr3;
  Word ccr4;
  Word bdtr;
  Word ccr5;
  Word ccr6;
  Word ccmr3;
  Word dtr2;
  Word ecr;
  Word tisel;
  Word af1;
  Word af2;
};

// RM0440, Direct memory access controller (DMA): of the channels, the first three.
template <class Word>
struct Dma {
  Word isr;
  Word ifcr;
  Word ccr1;
  Word cndtr1;
  Word cpar1;
  Word cmar1;
  Word reserved_18[1];
  Word ccr2;
  Word cndtr2;
  Word cpar2;
  Word cmar2;
  Word reserved_2c[1];
  Word ccr3;
  Word cndtr3;
  Word cpar3;
  Word cmar3;
};

// RM0440, DMA request multiplexer (DMAMUX): channels 0 to 2 serve those three.
template <class Word>
struct Dmamux {
  Word c0cr;
  Word c1cr;
  Word c2cr;
};

// RM0440, Serial peripheral interface / inter-IC sound (SPI/I2S).
template <class Word>
struct Spi {
  Word cr1;
  Word cr2;
  Word sr;
  Word dr;
};

// RM0440, Analog-to-digital converters (ADC), registers of each ADC.
template <class Word>
struct Adc {
  Word isr;
  Word ier;
  Word cr;
  Word cfgr;
  Word cfgr2;
  Word smpr1;
  Word smpr2;
  Word reserved_1c[1];
  Word tr1;
  Word tr2;
  Word tr3;
  Word reserved_2c[1];
  Word sqr1;
  Word sqr2;
  Word sqr3;
  Word sqr4;
  Word dr;
  Word reserved_44[2];
  Word jsqr;
  Word reserved_50[4];
  Word ofr1;
  Word ofr2;
  Word ofr3;
  Word ofr4;
  Word reserved_70[4];
  Word jdr1;
  Word jdr2;
  Word jdr3;
  Word jdr4;
  Word reserved_90[4];
  Word awd2cr;
  Word awd3cr;
  Word reserved_a8[2];
  Word difsel;
  Word calfact;
};

// RM0440, Analog-to-digital converters (ADC), common registers.
template <class Word>
struct AdcCommon {
  Word csr;
  Word reserved_04[1];
  Word ccr;
  Word cdr;
};

// RM0440, Digital-to-analog converter (DAC).
template <class Word>
struct Dac {
  Word cr;
  Word swtrigr;
  Word dhr12r1;
  Word dhr12l1;
  Word dhr8r1;
  Word dhr12r2;
  Word dhr12l2;
  Word dhr8r2;
  Word dhr12rd;
  Word dhr12ld;
  Word dhr8rd;
  Word dor1;
  Word dor2;
  Word sr;
  Word ccr;
  Word mcr;
};

// RM0440, FD controller area network (FDCAN).
template <class Word>
struct Fdcan {
  Word crel;
  Word endn;
  Word reserved_08[1];
  Word dbtp;
  Word test;
  Word rwd;
  Word cccr;
  Word nbtp;
  Word tscc;
  Word tscv;
  Word tocc;
  Word tocv;
  Word reserved_30[4];
  Word ecr;
  Word psr;
  Word tdcr;
  Word reserved_4c[1];
  Word ir;
  Word ie;
  Word ils;
  Word ile;
  Word reserved_60[8];
  Word rxgfc;
  Word xidam;
  Word hpms;
  Word reserved_8c[1];
  Word rxf0s;
  Word rxf0a;
  Word rxf1s;
  Word rxf1a;
  Word reserved_a0[8];
  Word txbc;
  Word txfqs;
  Word txbrp;
  Word txbar;
  Word txbcr;
  Word txbto;
  Word txbcf;
  Word txbtie;
  Word txbcie;
  Word txefs;
  Word txefa;
};

// RM0440, FD controller area network (FDCAN), the divider that its three instances share.
template <class Word>
struct FdcanConfig {
  Word ckdiv;
};

// RM0440, Independent watchdog (IWDG).
template <class Word>
struct Iwdg {
  Word kr;
  Word pr;
  Word rlr;
  Word sr;
  Word winr;
};

// RM0440, Universal synchronous/asynchronous receiver transmitter (USART/UART).
template <class Word>
struct Usart {
  Word cr1;
  Word cr2;
  Word cr3;
  Word brr;
  Word gtpr;
  Word rtor;
  Word rqr;
  Word isr;
  Word icr;
  Word rdr;
  Word tdr;
  Word presc;
};

// RM0440, System configuration controller (SYSCFG).
template <class Word>
struct Syscfg {
  Word memrmp;
  Word cfgr1;
  Word exticr[4];
  Word scsr;
  Word cfgr2;
};

// RM0440, Debug support (DBG), MCU debug component.
template <class Word>
struct Dbgmcu {
  Word idcode;
  Word cr;
  Word apb1fzr1;
  Word apb1fzr2;
  Word apb2fz;
};

// RM0440, FD controller area network (FDCAN), message RAM: 0x350 bytes for each instance, the layout is
// fixed.
inline constexpr std::size_t kCanStandardFilters = 28;
inline constexpr std::size_t kCanExtendedFilters = 8;
inline constexpr std::size_t kCanFifoElements = 3;
inline constexpr std::size_t kCanElementWords = 18;  // two of header, 64 bytes of data

template <class Word>
struct CanElement {
  Word header[2];
  Word data[kCanElementWords - 2];
};

template <class Word>
struct CanMessageRam {
  Word standard_filters[kCanStandardFilters];
  Word extended_filters[kCanExtendedFilters][2];
  CanElement<Word> rx_fifo[2][kCanFifoElements];
  Word tx_events[kCanFifoElements][2];
  CanElement<Word> tx_buffers[kCanFifoElements];
};
static_assert(sizeof(CanMessageRam<std::uint32_t>) == 0x350);
static_assert(offsetof(CanMessageRam<std::uint32_t>, extended_filters) == 0x070);
static_assert(offsetof(CanMessageRam<std::uint32_t>, rx_fifo) == 0x0B0);
static_assert(offsetof(CanMessageRam<std::uint32_t>, tx_events) == 0x260);
static_assert(offsetof(CanMessageRam<std::uint32_t>, tx_buffers) == 0x278);

// NOLINTBEGIN(bugprone-macro-parentheses): the arguments are names and literals.
// kRCC_BASE and its kin: addresses.
#define SLIPSTACK_BASE(peripheral, address) inline constexpr std::uint32_t k##peripheral##_BASE = address;
// kTIM6_DAC_IRQ and its kin: numbers of the interrupts, 0 is the first after the processor's own exceptions.
#define SLIPSTACK_INTERRUPT(name, number) inline constexpr std::uint32_t k##name##_IRQ = number;
#define SLIPSTACK_REGISTER(block, member, peripheral, name, offset) \
  static_assert(offsetof(block<std::uint32_t>, member) == (offset));
// kRCC_CR_HSION and its kin: fields.
#define SLIPSTACK_FIELD(peripheral, register_name, field, position, mask) \
  inline constexpr Field k##peripheral##_##register_name##_##field{position, mask};
#include "hal/stm32g474/registers.def"
// NOLINTEND(bugprone-macro-parentheses)

}  // namespace slipstack::stm32g474
