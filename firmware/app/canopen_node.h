// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/app/application.h"
#include "firmware/canopen/drive.h"

namespace slipstack {

/// The CANopen device as node of the application: `Application application{board, node};`. The trace buffer
/// lies in memory of the caller's: it is larger than everything else together.
class CanopenNode {
 public:
  /// `node_id`: where none is stored; FFh waits for LSS.
  CanopenNode(std::uint8_t node_id, std::uint32_t serial, std::span<canopen::TraceSample> trace)
      : node_id_(node_id), serial_(serial), trace_(trace) {}

  void start(NodeContext& context) {
    published_.store(nullptr, std::memory_order_relaxed);
    log_.emplace(context.nonvolatile);
    if (context.of_other_program != nullptr) take_over(*context.of_other_program);
    drive_.emplace(context.controller, context.timing, trace_, serial_, context.scaling, context.programs,
                   context.absolute_encoder, context.analogue, context.edges);
    node_.emplace(context.can, *log_, *drive_);
    node_->start(node_id_, 0);
    // Ticks are running: they must not see a drive that is half made.
    published_.store(&*drive_, std::memory_order_release);
  }
  void serve(NodeContext&, std::uint32_t now_us) {
    node_->poll(now_us);
    drive_->watch_trial(now_us, node_->takes_part());
  }

  /// From the tick's interrupt, behind the tick.
  void after_tick() {
    if (canopen::Drive* const drive = published_.load(std::memory_order_acquire)) drive->after_tick();
  }

  canopen::Node& canopen() { return *node_; }

 private:
  // What the program in the other slot has stored last, before an update or since a return to this one; what
  // it stored by another table only where this one has nothing. When that fails, what this one has is used.
  void take_over(Nonvolatile& pages) {
    RecordSlots other(pages);
    static_cast<void>(other.mount());
    const bool has_own = log_->mount() == StoreStatus::kOk;
    if (!has_own || canopen::ParameterSet::reads(other)) static_cast<void>(log_->adopt(other));
  }

  std::uint8_t node_id_;
  std::uint32_t serial_;
  canopen::TraceBuffer trace_;
  std::optional<RecordSlots> log_;
  std::optional<canopen::Drive> drive_;
  std::optional<canopen::Node> node_;
  std::atomic<canopen::Drive*> published_{nullptr};
};

}  // namespace slipstack
