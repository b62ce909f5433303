// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "sim_host/log/draw.h"
#include "workbench/loop/board.h"
#include "workbench/loop/lockstep_axis.h"

namespace slipstack::workbench {

/// A board to whose link something happens before a tick.
class DisturbedBoard final : public sim::LockstepBoard {
 public:
  using Happening = std::function<void(PlantLink& link, long tick)>;

  explicit DisturbedBoard(Happening happening)
      : board_(lockstep_board("host", "")), happening_(std::move(happening)) {}
  PlantLink& link() override { return board_->link(); }
  void tick() override {
    happening_(link(), ++ticks_);
    board_->tick();
  }

 private:
  std::unique_ptr<sim::LockstepBoard> board_;
  Happening happening_;
  long ticks_ = 0;
};

/// The pick-and-place axis, with viscous friction that its log shows well.
inline sim::Axis viscous_axis(std::uint64_t seed) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, seed);
  sim::add_effects(bench.axis, {sim::EffectId::kViscous}, sim::draw_programme(bench, seed), bench.rate_Hz,
                   6.0, seed);
  return bench.axis;
}

inline std::unique_ptr<LiveAxis> host_axis(const LockstepMachine& machine) {
  return lockstep_axis(lockstep_board("host", ""), machine);
}

}  // namespace slipstack::workbench
