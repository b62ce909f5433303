// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <type_traits>

#include "firmware/control/tick.h"
#include "hal/include/absolute_encoder.h"
#include "hal/include/analogue_inputs.h"
#include "hal/include/can_port.h"
#include "hal/include/edge_capture.h"
#include "hal/include/indicator.h"
#include "hal/include/nonvolatile.h"
#include "hal/include/program_memory.h"
#include "hal/include/signal_scaling.h"

namespace slipstack {

/// What a node on the bus works with: everything is used outside the tick.
struct NodeContext {
  Controller& controller;
  const TickTiming& timing;
  CanPort& can;
  Nonvolatile& nonvolatile;
  SignalScaling* scaling = nullptr;   ///< of a board whose signals can be scaled
  ProgramMemory* programs = nullptr;  ///< of a board whose firmware can be replaced over the bus
  /// Parameters that a program in the other slot has stored, where each has pages of its own.
  Nonvolatile* of_other_program = nullptr;
  AbsoluteEncoder* absolute_encoder = nullptr;  ///< of a board that can read one
  AnalogueInputs* analogue = nullptr;           ///< of a board with temperature or DC link voltage
  EdgeCapture* edges = nullptr;                 ///< of a board that catches the edges of an input
};

/// What commands the controller from outside. start() is called once, when the board runs: the place to load
/// the stored parameters and configure() the controller, which is not ready before. serve() is called in
/// every pass of the main loop and returns soon; `now_us` counts modulo 2^32.
template <class N>
concept Node = requires(N node, NodeContext context, std::uint32_t now_us) {
  node.start(context);
  node.serve(context, now_us);
};

/// What the application requires of a board: the devices of hal/include, and how it starts and waits.
/// start() begins the ticks: from then on the board calls Application::tick() at its tick rate, at the
/// highest priority; false: a device does not work, and the motor is off. wait() is called between two passes
/// of the main loop; false ends the program (an emulated board).
template <class B>
concept Board = requires(B board) {
  { board.can() } -> std::convertible_to<CanPort&>;
  { board.nonvolatile() } -> std::convertible_to<Nonvolatile&>;
  { board.indicator() } -> std::convertible_to<Indicator&>;
  { board.tick_period() } -> std::same_as<std::uint32_t>;  // Clock ticks; 0: time is not supervised
  { board.start() } -> std::same_as<bool>;
  { board.wait() } -> std::same_as<bool>;
};

/// The firmware: the control tick, and beside it the main loop that serves the node, new parameters and the
/// LED. The same on every board.
template <Board B, Node N>
class Application {
 public:
  Application(B& board, N& node)
      : board_(board),
        node_(node),
        tick_(board.encoder(), board.motor_current(), board.clock(), board.watchdog(), board.digital_io()),
        context_{tick_.controller(),
                 tick_.timing(),
                 board.can(),
                 board.nonvolatile(),
                 scaling_of(board),
                 programs_of(board),
                 of_other_program(board),
                 absolute_encoder_of(board),
                 analogue_of(board),
                 edges_of(board)} {}

  /// From the tick's interrupt.
  void tick() {
    tick_.run();
    if constexpr (requires { node_.after_tick(); }) node_.after_tick();
  }

  /// The main loop. Returns 0 when the board ends it, 1 when it does not start.
  int run() {
    if (!start()) return 1;
    do {
      serve();
    } while (board_.wait());
    return 0;
  }

  /// Starts the board, then the node; false when the board does not start.
  bool start() {
    tick_.set_period(board_.tick_period());
    if (!board_.start()) {
      board_.indicator().show(Indication::kFault);
      return false;
    }
    begin();
    return true;
  }

  /// What start() does once the board runs, and run() in each pass: for hosts with a loop of their own.
  void begin() {
    last_clock_ = board_.clock().now();
    node_.start(context_);
  }
  void serve() {
    tick_.controller().poll();
    node_.serve(context_, now_us());
    tick_.main_loop_ran();
    const Indication indication = indication_of(tick_.controller().state().state());
    if (indication != shown_) board_.indicator().show(indication);
    shown_ = indication;
  }

  Controller& controller() { return tick_.controller(); }
  const TickTiming& timing() const { return tick_.timing(); }

 private:
  using ClockType = std::remove_reference_t<decltype(std::declval<B&>().clock())>;

  static SignalScaling* scaling_of(B& board) {
    if constexpr (requires { board.scaling(); }) {
      return &board.scaling();
    } else {
      return nullptr;
    }
  }

  static ProgramMemory* programs_of(B& board) {
    if constexpr (requires { board.programs(); }) {
      return &board.programs();
    } else {
      return nullptr;
    }
  }
  static Nonvolatile* of_other_program(B& board) {
    if constexpr (requires { board.nonvolatile_of_other_program(); }) {
      return &board.nonvolatile_of_other_program();
    } else {
      return nullptr;
    }
  }

  static AbsoluteEncoder* absolute_encoder_of(B& board) {
    if constexpr (requires { board.absolute_encoder(); }) {
      return &board.absolute_encoder();
    } else {
      return nullptr;
    }
  }

  static AnalogueInputs* analogue_of(B& board) {
    if constexpr (requires { board.analogue_inputs(); }) {
      return &board.analogue_inputs();
    } else {
      return nullptr;
    }
  }

  static EdgeCapture* edges_of(B& board) {
    if constexpr (requires { board.edge_capture(); }) {
      return &board.edge_capture();
    } else {
      return nullptr;
    }
  }

  static constexpr Indication indication_of(DriveState state) {
    switch (state) {
      case DriveState::kNotReadyToSwitchOn:
        return Indication::kStarting;
      case DriveState::kSwitchOnDisabled:
        return Indication::kDisabled;
      case DriveState::kReadyToSwitchOn:
      case DriveState::kSwitchedOn:
        return Indication::kReady;
      case DriveState::kOperationEnabled:
      case DriveState::kQuickStopActive:
        return Indication::kEnabled;
      default:
        return Indication::kFault;
    }
  }

  // Clock ticks added up to microseconds; the passes are far closer together than the clock's 2^32 ticks.
  std::uint32_t now_us() {
    const std::uint32_t per_us = board_.clock().ticks_per_second() / 1'000'000U;
    const std::uint32_t now = board_.clock().now();
    const std::uint32_t whole_us = (now - last_clock_) / per_us;
    last_clock_ += whole_us * per_us;
    now_us_ += whole_us;
    return now_us_;
  }

  B& board_;
  N& node_;
  Indication shown_ = Indication::kStarting;
  std::uint32_t last_clock_ = 0;
  std::uint32_t now_us_ = 0;
  Tick<std::remove_reference_t<decltype(std::declval<B&>().encoder())>,
       std::remove_reference_t<decltype(std::declval<B&>().motor_current())>, ClockType,
       std::remove_reference_t<decltype(std::declval<B&>().watchdog())>,
       std::remove_reference_t<decltype(std::declval<B&>().digital_io())>>
      tick_;
  NodeContext context_;
};

}  // namespace slipstack
