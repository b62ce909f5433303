// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/include/edge_capture.h"
#include "hal/stm32g474/gpio.h"
#include "hal/stm32g474/registers.h"

// Edges on TI4 of the encoder's timer. RM0440, General-purpose timers: input capture, DMA; Direct memory
// access controller: circular mode; DMA request multiplexer, table of its inputs.
//
// The encoder uses channels 1 to 3 of TIM2. Channel 4 captures the count at both edges of its input (CC4P and
// CC4NP), and DMA1 channel 3 puts each into a ring before the next one can come: no interrupt, nothing in the
// tick, and an input that bounces or is noisy costs the processor nothing. The channel's counter tells how
// many there are; their directions follow from the level behind the last one, for edges take turns.
namespace slipstack::stm32g474 {

template <class TimerBlock, class DmaBlock, class DmamuxBlock, class GpioBlock>
class TimerEdges {
 public:
  static constexpr std::uint32_t kRing = EdgeCapture::kKept + 1;

  TimerEdges(TimerBlock& timer, DmaBlock& dma, DmamuxBlock& dmamux, InputPin<GpioBlock> pin)
      : timer_(timer), dma_(dma), dmamux_(dmamux), pin_(pin) {}

  // After the encoder, which sets the timer's channels up.
  void start() {
    dma_.ccr3 = 0;
    dmamux_.c2cr = kDMAMUX_CxCR_DMAREQ_ID(59);  // TIM2_CH4
    dma_.ifcr = kDMA_IFCR_CGIF3(1);
    dma_.cpar3 = address_of(timer_.ccr4);
    dma_.cmar3 = address_of(ring_[0]);
    dma_.cndtr3 = kRing;
    taken_ = 0;
    // Words to words, round and round.
    dma_.ccr3 = kDMA_CCR_PSIZE(2) | kDMA_CCR_MSIZE(2) | kDMA_CCR_MINC(1) | kDMA_CCR_CIRC(1) | kDMA_CCR_EN(1);
    set_bits(timer_.dier, kTIM_DIER_CC4DE(1));
  }

  // As EdgeCapture has it. 20 reads of registers where there is an edge, two where there is none.
  std::size_t take(std::span<CapturedEdge> edges) {
    State now = state();
    if (now.head == taken_ && !now.wrapped) return 0;
    if (!settled(now)) return 0;
    if (now.wrapped) dma_.ifcr = kDMA_IFCR_CGIF3(1);
    const bool overrun = now.wrapped && now.head >= taken_;
    std::uint32_t count = overrun ? kRing - 1 : (now.head - taken_) % kRing;
    if (count > edges.size()) count = static_cast<std::uint32_t>(edges.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t behind = count - i;  // 1: the last one
      edges[i] = {static_cast<std::int32_t>(ring_[(now.head - behind) % kRing]),
                  now.high == (behind % 2 == 1)};
    }
    taken_ = now.head;
    return count;
  }

 private:
  struct State {
    std::uint32_t head = 0;  // where the next edge goes
    bool wrapped = false;    // the ring has been filled to its end since the last take()
    bool high = false;
    bool operator==(const State&) const = default;
  };
  State state() const {
    return {(kRing - static_cast<std::uint32_t>(dma_.cndtr3)) % kRing,
            (static_cast<std::uint32_t>(dma_.isr) & kDMA_ISR_TCIF3.mask) != 0, pin_.high()};
  }
  // The pin is ahead of the ring by the timer's filter and the DMA, less than 0.2 us: what is the same for
  // longer belongs together. False: the input moves all the time, another call will find it at rest.
  bool settled(State& now) const {
    constexpr int kReads = 6;  // of three registers, some ten cycles of 170 MHz each
    for (int same = 0, left = 4 * kReads; left > 0; --left) {
      const State again = state();
      same = again == now ? same + 1 : 0;
      now = again;
      if (same == kReads) return true;
    }
    return false;
  }

  template <class Place>
  static std::uint32_t address_of(Place& place) {
    return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&place));
  }

  TimerBlock& timer_;
  DmaBlock& dma_;
  DmamuxBlock& dmamux_;
  InputPin<GpioBlock> pin_;
  std::array<volatile std::uint32_t, kRing> ring_{};
  std::uint32_t taken_ = 0;
};

}  // namespace slipstack::stm32g474
