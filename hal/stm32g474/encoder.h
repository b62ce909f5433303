// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/include/clock.h"
#include "hal/include/encoder.h"
#include "hal/stm32g474/registers.h"

// A quadrature encoder on TIM2, which counts 32 bits. RM0440, General-purpose timers: encoder interface mode,
// input capture.
//
// A on TI1, B on TI2, four counts a period. The index (reference mark) goes to TI3, whose input capture holds
// the count at which the mark passed: unlike the timer's own index input, this never resets the count under a
// running controller. TI4 captures the count at both edges of an input (edge_capture.h).
namespace slipstack::stm32g474 {

struct EncoderSetup {
  bool reversed = false;
  // Digital filter of A, B, index and captured input (RM0440, TIMx_CCMR1, IC1F): 3 is 8 samples at 170 MHz,
  // 47 ns. Edges of a 1 um scale at 2 m/s are 500 ns apart.
  std::uint32_t filter = 3;
};

template <class TimerBlock, Clock TimeSource>
class QuadratureEncoder {
 public:
  QuadratureEncoder(TimerBlock& timer, TimeSource clock) : timer_(timer), clock_(clock) {}

  // Counts from zero on.
  void start(const EncoderSetup& setup) {
    timer_.cr1 = 0;
    timer_.psc = 0;
    timer_.arr = 0xFFFFFFFF;
    timer_.ccmr1 = kTIM_CCMR1_CC1S(1) | kTIM_CCMR1_CC2S(1) | kTIM_CCMR1_IC1F.place(setup.filter) |
                   kTIM_CCMR1_IC2F.place(setup.filter);
    timer_.ccmr2 = kTIM_CCMR2_CC3S(1) | kTIM_CCMR2_IC3F.place(setup.filter) | kTIM_CCMR2_CC4S(1) |
                   kTIM_CCMR2_IC4F.place(setup.filter);
    timer_.ccer = (setup.reversed ? kTIM_CCER_CC1P(1) : 0U) | kTIM_CCER_CC3E(1) | kTIM_CCER_CC4E(1) |
                  kTIM_CCER_CC4P(1) | kTIM_CCER_CC4NP(1);
    timer_.smcr = kTIM_SMCR_SMS(3);  // both inputs, both edges
    timer_.egr = kTIM_EGR_UG(1);     // takes prescaler and limit over, zeroes the count
    timer_.sr = 0;
    timer_.cr1 = kTIM_CR1_CEN(1);
    transition_errors_ = 0;
    missed_marks_ = 0;
  }

  // The count goes on from where it is, the other way round.
  void set_reversed(bool reversed) {
    clear_bits(timer_.cr1, kTIM_CR1_CEN.mask);
    change_bits(timer_.ccer, kTIM_CCER_CC1P.mask, reversed ? kTIM_CCER_CC1P(1) : 0U);
    set_bits(timer_.cr1, kTIM_CR1_CEN(1));
  }

  // The count, modulo 2^32: differences of two counts are right across the wrap when taken as unsigned. One
  // read.
  std::int32_t counts() const { return static_cast<std::int32_t>(static_cast<std::uint32_t>(timer_.cnt)); }

  // What hal/include/encoder.h asks for: three reads of registers. Not valid in the tick after A and B
  // changed at once (transition_errors): the position is then off by a count or more.
  EncoderReading read() {
    const std::uint32_t errors_before = transition_errors_;
    const std::int32_t now_counts = counts();
    return {now_counts, clock_.now(), transition_errors() == errors_before};
  }

  // True once for each passage of the index, with the count at which it passed. A mark passed again before
  // the last was taken is counted by missed_marks().
  bool take_index(std::int32_t& counts_at_index) {
    const std::uint32_t status = timer_.sr;
    if ((status & kTIM_SR_CC3IF.mask) == 0) return false;
    if ((status & kTIM_SR_CC3OF.mask) != 0) {
      ++missed_marks_;
      timer_.sr = ~kTIM_SR_CC3OF.mask;
    }
    counts_at_index = static_cast<std::int32_t>(static_cast<std::uint32_t>(timer_.ccr3));  // clears CC3IF
    return true;
  }

  // How often A and B changed at once since the start, which a sound encoder never does: a lost edge, a loose
  // plug, or a speed beyond the filter. Several between two calls count as one.
  std::uint32_t transition_errors() {
    if ((timer_.sr & kTIM_SR_TERRF.mask) != 0) {
      timer_.sr = ~kTIM_SR_TERRF.mask;  // write 0 to clear, 1 leaves the others
      ++transition_errors_;
    }
    return transition_errors_;
  }

  std::uint32_t missed_marks() const { return missed_marks_; }

 private:
  TimerBlock& timer_;
  TimeSource clock_;
  std::uint32_t transition_errors_ = 0;
  std::uint32_t missed_marks_ = 0;
};

}  // namespace slipstack::stm32g474
