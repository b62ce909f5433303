// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/board.h"

#include <fmt/format.h>

#include "firmware/app/heartbeat_node.h"
#include "firmware/app/lockstep/linked_application.h"
#include "hal/host/link_board.h"
#include "sim_host/loop/emulated_board.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/loop/board_image.h"

namespace slipstack::workbench {
namespace {

/// The controller in this process.
class HostBoard final : public sim::LockstepBoard {
 public:
  HostBoard() { application_.start(); }
  PlantLink& link() override { return board_.link(); }
  void tick() override {
    link().host_sequence = link().host_sequence + 1;
    application_.serve();
    application_.turn();
  }

 private:
  host::LinkBoard board_;
  HeartbeatNode node_{127};
  lockstep::LinkedApplication<host::LinkBoard, HeartbeatNode> application_{board_, node_};
};

}  // namespace

void check_board(const std::string& board, const std::string& image) {
  if (board != "host" && board != "mps2-an386" && board != "mps2-an500")
    throw UsageError(fmt::format("--board: {} is none of host, mps2-an386, mps2-an500", in_quotes(board)));
  if (board == "host" && !image.empty())
    throw UsageError("--image: there is none on --board host; name an emulated board");
}

std::unique_ptr<sim::LockstepBoard> lockstep_board(const std::string& board, const std::string& image) {
  check_board(board, image);
  if (board == "host") return std::make_unique<HostBoard>();
  try {
    return std::make_unique<sim::EmulatedBoard>(board, board_image(board, image));
  } catch (const sim::LoopError& error) {
    throw UsageError(error.what());
  }
}

}  // namespace slipstack::workbench
