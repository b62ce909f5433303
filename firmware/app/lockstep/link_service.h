// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>

#include "firmware/app/lockstep/set_point_queue.h"
#include "firmware/control/tick.h"
#include "hal/plant_link/plant_link.h"

namespace slipstack::lockstep {

/// What the host writes into PlantLink::parameters.
struct ParameterBlock {
  AxisParameters axis;
  ModelParameters model;
};
static_assert(sizeof(ParameterBlock) <= sizeof(PlantLink::parameters));
static_assert(std::tuple_size_v<ModelParameters> <= PlantLink::kEffects && kFaultCount <= PlantLink::kFaults);

/// On the host: writes the parameter block that the next change of parameter_sequence applies.
inline void write_parameters(PlantLink& link, const ParameterBlock& block) {
  // A tuple of floats and flags, laid out alike on both sides.
  std::memcpy(link.parameters.data(), static_cast<const void*>(&block), sizeof block);
  link.parameter_bytes = sizeof block;
}

/// Passes the requests of the host to the controller and the state of the controller to the host. Outside the
/// tick.
class LinkService {
 public:
  explicit LinkService(PlantLink& link) : link_(link) {}

  /// last_status when the parameter block has another size: host and firmware differ in version.
  static constexpr std::uint32_t kWrongSize = 255;

  /// Before a tick: what the host has requested since the last one.
  void apply_requests(Controller& controller) {
    if (link_.parameter_sequence != blocks_) {
      blocks_ = link_.parameter_sequence;
      apply_parameters(controller);
    }
    if (link_.move_sequence != moves_) {
      moves_ = link_.move_sequence;
      link_.last_status = static_cast<std::uint32_t>(controller.move_to(link_.move_counts));
    }
    if (link_.stream_sequence != set_points_) {
      set_points_ = link_.stream_sequence;
      queue_set_point(controller);
    }
    const std::uint32_t word = link_.control_word;
    if (word == PlantLink::kCommandedByBus) return;
    const std::uint32_t mode = link_.torque_mode != 0 ? kTorqueMode : 0;
    controller.command(Command{.word = (word & 0xFFFFU) | mode, .target_N = link_.target_N});
  }

  /// After a tick: everything that the host may want to record.
  void publish(const Controller& controller, const TickTiming& timing) {
    const ControlOutput& out = controller.output();
    link_.state = static_cast<std::uint32_t>(controller.state().state());
    link_.limits = out.limits;
    link_.reference_counts = out.reference_counts;
    link_.reference_idle = controller.reference().idle() ? 1 : 0;
    link_.reference_underruns = controller.reference().underruns();
    link_.position_error_m = out.position_error_m;
    link_.velocity_mps = out.velocity_mps;
    link_.feedforward_N = out.feedforward_N;
    link_.feedback_N = out.feedback_N;
    link_.residual_N = out.residual_N;
    link_.level = out.level;
    link_.ticks = controller.ticks();
    link_.longest_period = timing.longest_period;
    link_.longest_duration = timing.longest_duration;
    link_.overruns = timing.overruns;
    link_.memory_depth = controller.memory().depth();
    link_.memory_overflow = controller.memory().overflow_count();
    link_.model_hash = controller.parameters().hash;
    const auto& by_effect_N = controller.friction().by_effect_N;
    for (std::size_t i = 0; i < by_effect_N.size(); ++i) link_.by_effect_N[i] = by_effect_N[i];
    const FaultRecord& faults = controller.state().faults();
    link_.fault = static_cast<std::uint32_t>(faults.latched());
    for (std::size_t i = 0; i < kFaultCount; ++i) {
      link_.fault_counts[i] = faults.count(static_cast<Fault>(i));
    }
  }

 private:
  void apply_parameters(Controller& controller) {
    if (link_.parameter_bytes != sizeof block_) {
      link_.last_status = kWrongSize;
      return;
    }
    // A tuple of floats and flags: copied as the host laid it out.
    std::memcpy(static_cast<void*>(&block_), link_.parameters.data(), sizeof block_);
    link_.last_status = static_cast<std::uint32_t>(controller.configure(block_.axis, block_.model));
  }

  // A stream of set-points begins at the position where the axis stands, and moves within the axis's limits.
  void queue_set_point(Controller& controller) {
    ReferenceGenerator& reference = controller.reference();
    if (reference.idle()) stream_.start(reference, static_cast<std::int32_t>(link_.stream_period));
    const SetPointQueue::Bounds bounds{controller.stream_limits(), controller.stop_deceleration(),
                                       controller.range()};
    const bool queued = stream_.push(reference, bounds, link_.stream_counts, link_.stream_fraction);
    if (!queued) link_.stream_refused = link_.stream_refused + 1;
  }

  PlantLink& link_;
  std::uint32_t moves_ = 0;
  std::uint32_t blocks_ = 0;
  std::uint32_t set_points_ = 0;
  SetPointQueue stream_;
  ParameterBlock block_;
};

}  // namespace slipstack::lockstep
