// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

#include "hal/biss/receiver.h"
#include "hal/include/absolute_encoder.h"
#include "hal/include/clock.h"
#include "hal/include/encoder.h"
#include "hal/stm32g474/registers.h"

// A BiSS-C encoder on SPI3. RM0440, Serial peripheral interface; Direct memory access controller; DMA request
// multiplexer, table of its inputs. BiSS: hal/biss/frame.h.
//
// SCK is MA, which rests high; MISO is SLO, which the encoder changes on rising edges and the next rising
// edge samples: CPOL = CPHA = 1, a whole clock for cable and receivers. A frame is 128 clocks of 2.66 MHz, 48
// us, and with an encoder's time-out of at most 40 us it fits a tick of 100 us. The tick reads the position
// that the frame before has brought and starts the next one: a position is one tick old, to the microsecond.
namespace slipstack::stm32g474 {

template <class SpiBlock, class DmaBlock, class DmamuxBlock, Clock TimeSource>
class BissPort {
 public:
  static constexpr std::uint32_t kFrameBytes = 16;

  BissPort(SpiBlock& spi, DmaBlock& dma, DmamuxBlock& dmamux, TimeSource clock)
      : spi_(spi), dma_(dma), dmamux_(dmamux), clock_(clock) {}

  // Outside the tick, which does not read this encoder before it is on again.
  void start(const EncoderInterface& interface, bool reversed) {
    stop();
    receiver_.use(interface, reversed);
    dmamux_.c0cr = kDMAMUX_CxCR_DMAREQ_ID(14);  // SPI3_RX
    dmamux_.c1cr = kDMAMUX_CxCR_DMAREQ_ID(15);  // SPI3_TX
    dma_.cpar1 = address_of(spi_.dr);
    dma_.cmar1 = address_of(sampled_[0]);
    dma_.cpar2 = address_of(spi_.dr);
    dma_.cmar2 = address_of(kNothing);
    spi_.cr2 = kSPI_CR2_DS(7) | kSPI_CR2_FRXTH(1) | kSPI_CR2_RXDMAEN(1) | kSPI_CR2_TXDMAEN(1);
    spi_.cr1 = kSPI_CR1_CPHA(1) | kSPI_CR1_CPOL(1) | kSPI_CR1_MSTR(1) | kSPI_CR1_BR(5) | kSPI_CR1_SSM(1) |
               kSPI_CR1_SSI(1) | kSPI_CR1_SPE(1);
  }
  // No clock any more; a frame under way is dropped.
  void stop() {
    dma_.ccr1 = 0;
    dma_.ccr2 = 0;
    spi_.cr1 = 0;
    under_way_.store(false, std::memory_order_relaxed);
  }
  FrameCounters counters() const { return receiver_.counters(); }

  // What hal/include/encoder.h asks for.
  EncoderReading read() {
    begin_frame();
    return receiver_.read();
  }

  // DMA1 channel 1: a frame is complete. Below the tick.
  void on_interrupt() {
    dma_.ifcr = kDMA_IFCR_CGIF1(1);
    std::array<std::uint8_t, kFrameBytes> frame;
    for (std::uint32_t i = 0; i < kFrameBytes; ++i) frame[i] = sampled_[i];
    receiver_.received(frame, began_);
    under_way_.store(false, std::memory_order_release);
  }

 private:
  // A frame that has not been received by now is given time for; one that never ends does not stop the line.
  static constexpr std::uint32_t kPatience = 3;

  void begin_frame() {
    if (under_way_.load(std::memory_order_acquire)) [[unlikely]] {
      receiver_.late();
      if (++late_ <= kPatience) return;
    }
    late_ = 0;
    dma_.ccr1 = 0;
    dma_.ccr2 = 0;
    dma_.ifcr = kDMA_IFCR_CGIF1(1) | kDMA_IFCR_CGIF2(1);
    dma_.cndtr1 = kFrameBytes;
    dma_.cndtr2 = kFrameBytes;
    under_way_.store(true, std::memory_order_relaxed);
    began_ = clock_.now();
    dma_.ccr1 = kDMA_CCR_MINC(1) | kDMA_CCR_TCIE(1) | kDMA_CCR_EN(1);
    dma_.ccr2 = kDMA_CCR_DIR(1) | kDMA_CCR_EN(1);  // begins to clock
  }

  template <class Place>
  static std::uint32_t address_of(Place& place) {
    return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&place));
  }

  static constexpr std::uint8_t kNothing = 0;  // sent: MOSI is not connected

  SpiBlock& spi_;
  DmaBlock& dma_;
  DmamuxBlock& dmamux_;
  TimeSource clock_;
  biss::Receiver receiver_;
  std::array<volatile std::uint8_t, kFrameBytes> sampled_{};
  std::uint32_t began_ = 0;
  std::uint32_t late_ = 0;
  std::atomic<bool> under_way_{false};
};

// The encoder that the axis has: incremental, or absolute by its interface. What is not used costs the tick
// one comparison.
template <class Quadrature, class Biss>
class AxisEncoder final : public AbsoluteEncoder {
 public:
  AxisEncoder(Quadrature& quadrature, Biss& biss) : quadrature_(quadrature), biss_(biss) {}

  // ---- outside the tick ----

  void use(const EncoderInterface& interface) override {
    const bool absolute = interface.kind == EncoderInterface::Kind::kBissC;
    absolute_.store(false, std::memory_order_release);
    if (!absolute) return biss_.stop();
    biss_.start(interface, reversed_);
    absolute_.store(true, std::memory_order_release);
  }
  FrameCounters counters() const override { return biss_.counters(); }
  // Before use().
  void set_reversed(bool reversed) {
    reversed_ = reversed;
    quadrature_.set_reversed(reversed);
  }

  bool absolute() const { return absolute_.load(std::memory_order_relaxed); }

  // ---- in the tick ----

  EncoderReading read() {
    return absolute_.load(std::memory_order_acquire) ? biss_.read() : quadrature_.read();
  }
  bool take_index(std::int32_t& counts) {
    return !absolute_.load(std::memory_order_relaxed) && quadrature_.take_index(counts);
  }

 private:
  Quadrature& quadrature_;
  Biss& biss_;
  bool reversed_ = false;
  std::atomic<bool> absolute_{false};
};

}  // namespace slipstack::stm32g474
