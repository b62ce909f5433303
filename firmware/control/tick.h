// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/control/controller.h"
#include "hal/include/clock.h"
#include "hal/include/digital_io.h"
#include "hal/include/encoder.h"
#include "hal/include/motor_current.h"
#include "hal/include/watchdog.h"

namespace slipstack {

/// How regularly the tick ran, in Clock ticks.
struct TickTiming {
  std::uint32_t longest_period = 0;
  std::uint32_t longest_duration = 0;
  std::uint32_t overruns = 0;
};

/// The control tick: reads the board, runs the controller, writes the board. The same on every platform;
/// called by a timer interrupt of the highest priority, by the emulator's loop, or by a test. Calls are
/// resolved at compile time: nothing in it goes through a pointer.
template <Encoder E, MotorCurrent M, Clock C, Watchdog W, DigitalIo D>
class Tick {
 public:
  Tick(E& encoder, M& motor, C& clock, W& watchdog, D& io)
      : encoder_(encoder), motor_(motor), clock_(clock), watchdog_(watchdog), io_(io) {
    motor_.disable();
    if (watchdog_.caused_last_reset()) controller_.inject(Fault::kWatchdog);
  }

  /// The period that the timer keeps, in Clock ticks; 0 switches the supervision of time off.
  void set_period(std::uint32_t clock_ticks) {
    longest_ = clock_ticks == 0 ? 0xFFFFFFFF : clock_ticks;
    latest_ = clock_ticks == 0 ? 0xFFFFFFFF : clock_ticks + clock_ticks / 2;
    latest_main_loop_ = clock_ticks == 0 ? 0xFFFFFFFF : clock_.ticks_per_second() / 2;
    main_loop_ran();
  }

  /// From the main loop, in every pass. After half a second without a pass the watchdog is no longer
  /// refreshed: the longest pass stores parameters, which erases pages of flash (22 ms each, DS12288).
  void main_loop_ran() { main_loop_at_.store(clock_.now(), std::memory_order_relaxed); }

  /// One tick.
  void run() {
    const std::uint32_t begin = clock_.now();
    if constexpr (IndexedEncoder<E>) {
      std::int32_t index_counts = 0;
      if (encoder_.take_index(index_counts)) [[unlikely]]
        controller_.index_passed(index_counts);
    }
    TickInputs inputs{encoder_.read(), motor_.measured(), late(begin), io_.read()};
    if (!inputs.encoder.valid) [[unlikely]]
      controller_.bridge(inputs.encoder);
    const ControlOutput& out = controller_.step(inputs);
    if (out.driving) {
      motor_.set(out.current_A);
    } else {
      motor_.disable();
    }
    io_.write(controller_.digital_outputs());
    // Of a main loop that stands still nothing else would be noticed: moves end, heartbeats do not.
    if (begin - main_loop_at_.load(std::memory_order_relaxed) <= latest_main_loop_) watchdog_.refresh();
    duration_ = clock_.now() - begin;
    if (duration_ > timing_.longest_duration) timing_.longest_duration = duration_;
  }

  Controller& controller() { return controller_; }
  const TickTiming& timing() const { return timing_; }

 private:
  // Late: half a period or more, or the tick before took longer than a period.
  bool late(std::uint32_t begin) {
    const std::uint32_t period = begin - last_begin_;
    last_begin_ = begin;
    if (controller_.ticks() == 0) return false;
    if (period > timing_.longest_period) timing_.longest_period = period;
    const bool is_late = period > latest_ || duration_ > longest_;
    if (is_late) [[unlikely]]
      ++timing_.overruns;
    return is_late;
  }

  E& encoder_;
  M& motor_;
  C& clock_;
  W& watchdog_;
  D& io_;
  TickTiming timing_;
  std::uint32_t longest_ = 0xFFFFFFFF;
  std::uint32_t latest_ = 0xFFFFFFFF;
  std::uint32_t latest_main_loop_ = 0xFFFFFFFF;
  std::atomic<std::uint32_t> main_loop_at_{0};
  std::uint32_t last_begin_ = 0;
  std::uint32_t duration_ = 0;
  Controller controller_;
};

}  // namespace slipstack
