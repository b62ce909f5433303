// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <concepts>
#include <type_traits>

#include "firmware/app/application.h"
#include "firmware/app/lockstep/link_service.h"
#include "hal/plant_link/plant_link.h"

namespace slipstack::lockstep {

/// A board whose encoder and motor are at the other end of a PlantLink. Its clock advances once per turn.
template <class B>
concept LinkedBoard = Board<B> && requires(B board) {
  { board.link() } -> std::same_as<PlantLink&>;
  board.clock().turn();
};

/// The firmware's application in lock-step with a simulated plant, on an emulated board or in the process of
/// the host: the host requests a turn, the controller answers with one tick.
template <class B, Node N>
class LinkedApplication {
  static_assert(LinkedBoard<B>);

 public:
  LinkedApplication(B& board, N& node) : board_(board), service_(board.link()), application_(board, node) {}

  /// Starts the board and the node; false when the board does not start.
  bool start() { return application_.start(); }

  /// The main loop. Returns 0 when the host ends it, 1 when the board does not start.
  int run() {
    if (!start()) return 1;
    application_.serve();
    while (board_.wait()) {
      if (board_.link().host_sequence != board_.link().guest_sequence) turn();
      application_.serve();
    }
    return 0;
  }

  /// One turn: what the host requests, the tick, what the controller publishes.
  void turn() {
    PlantLink& link = board_.link();
    service_.apply_requests(application_.controller());
    board_.clock().turn();
    application_.tick();
    service_.publish(application_.controller(), application_.timing());
    // The host reads the words above as soon as it sees the new sequence number.
    std::atomic_thread_fence(std::memory_order_release);
    link.guest_sequence = link.host_sequence;
  }

  /// Outside run(), as a host with a loop of its own does.
  void serve() { application_.serve(); }
  /// From an interrupt of the board.
  void tick() { application_.tick(); }

 private:
  B& board_;
  LinkService service_;
  Application<B, N> application_;
};

/// The application that fits a board: in lock-step where the board has a PlantLink.
template <class B, Node N>
using ApplicationFor = std::conditional_t<LinkedBoard<B>, LinkedApplication<B, N>, Application<B, N>>;

}  // namespace slipstack::lockstep
