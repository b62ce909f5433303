// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/friction/maxwell_slip.h"
#include "firmware/friction/memory_stack.h"
#include "firmware/friction/packed_maxwell_slip.h"
#include "firmware/friction/virgin_curves.h"
#include "tests/budget/exported_friction.h"
#include "tests/budget/friction_model.h"
#include "tests/budget/stages.h"
#include "tests/budget/tick_under_test.h"

// The observers that are measured and traced, with parameters of the size of the pick-and-place axis (1 um
// encoder, 15 N, some ten counts of pre-sliding), as one list of plain functions.
namespace slipstack::budget {

struct Observer {
  const char* name;
  void (*reset)(std::int32_t x);
  float (*step)(std::int32_t x);
  void (*before)(std::int32_t x) = nullptr;  // what comes ahead of step(x) and is not measured
  bool (*works)() = nullptr;                 // whether the last step did what is to be measured
};

inline constexpr std::array<std::int32_t, 10> kSlipDistance = {1, 2, 3, 5, 8, 13, 21, 34, 55, 300};
inline constexpr std::array<float, 10> kStiffness = {0.31F,  0.57F,  0.43F,  0.29F,  0.17F,
                                                     0.083F, 0.047F, 0.029F, 0.011F, 0.0037F};
inline constexpr RationalCurve<float> kRational{15.0F, 12.0F};

inline MaxwellSlip<10, float, std::int32_t> maxwell_slip;
inline PackedMaxwellSlip<10> packed_maxwell_slip;
inline PackedMaxwellSlip<6> packed_maxwell_slip_6;
inline MemoryStack<RationalCurve<float>, 16, std::int32_t> memory_stack{kRational};
inline MemoryStack<PiecewiseLinearCurve<10, float>, 16, std::int32_t> piecewise_stack{{}};

template <auto& model>
inline constexpr auto kReset = [](std::int32_t x) { model.reset(x); };

// Not inlined, so that a call is a call: what is measured is the function from its first instruction to its
// return.
template <auto& model>
[[gnu::noinline]] float step(std::int32_t x) {
  return model.step(x);
}

inline CountedMotion counted_motion;

inline void reset_friction_model(std::int32_t x) {
  counted_motion.reset(x);
  friction_model.reset(counted_motion.sample());
}
inline void move_friction_model(std::int32_t x) {
  counted_motion.move(x);
}
[[gnu::noinline]] inline float step_friction_model(std::int32_t) {
  return friction_model.step(counted_motion.sample()).total_N;
}

// The same model as `slipstack export` writes it in C.
inline exported_state exported_friction;

inline exported_motion exported_motion_of(const Sample<float>& sample) {
  return {sample.time_s, sample.displacement, sample.position_m, sample.velocity_mps,
          sample.acceleration_mps2};
}
inline exported_motion exported_motion_now;
inline void reset_exported(std::int32_t x) {
  counted_motion.reset(x);
  exported_motion_now = exported_motion_of(counted_motion.sample());
  exported_init(&exported_friction, &exported_motion_now);
}
inline void move_exported(std::int32_t x) {
  counted_motion.move(x);
  exported_motion_now = exported_motion_of(counted_motion.sample());
}
[[gnu::noinline]] inline float step_exported(std::int32_t) {
  return exported_step(&exported_friction, &exported_motion_now);
}

inline constexpr std::array kObservers = {
    Observer{"maxwell_slip_10", kReset<maxwell_slip>, step<maxwell_slip>},
    Observer{"packed_maxwell_slip_10", kReset<packed_maxwell_slip>, step<packed_maxwell_slip>},
    Observer{"packed_maxwell_slip_6", kReset<packed_maxwell_slip_6>, step<packed_maxwell_slip_6>},
    Observer{"memory_stack_rational_16", kReset<memory_stack>, step<memory_stack>},
    Observer{"memory_stack_piecewise_16", kReset<piecewise_stack>, step<piecewise_stack>},
    Observer{"friction_model_all_effects", reset_friction_model, step_friction_model, move_friction_model},
    Observer{"exported_c_all_effects", reset_exported, step_exported, move_exported},
    Observer{"stage_state_estimate", reset_stages, step_estimate},
    Observer{"stage_reference", reset_stages, step_reference, fill_reference},
    Observer{"stage_stream", reset_stages, step_stream, fill_stream},
    Observer{"stage_tracking", reset_stages, step_tracking, move_stream},
    Observer{"stage_feedforward", reset_stages, step_feedforward, move_feedforward},
    Observer{"stage_feedback", reset_stages, step_feedback, move_feedforward},
    Observer{"stage_fault_monitor", reset_stages, step_monitor},
    Observer{"stage_state_machine", reset_stages, step_machine},
    Observer{"stage_notch", reset_stages, step_notch},
    Observer{"stage_current_limit", reset_stages, step_limit},
    Observer{"encoder_frame", reset_frames, receive_frame, sample_frame},
    Observer{"encoder_frame_read", reset_frames, read_frame, receive_any_frame},
    Observer{"stage_adaptation", reset_stages, step_adaptation},
    Observer{"stage_hunting", reset_stages, step_hunting},
    Observer{"control_tick_all_effects", reset_tick<false, 1>, run_tick, prepare_tick, tick_drives},
    Observer{"control_tick_excited", reset_tick<true, 1>, run_tick, prepare_tick, tick_drives},
    Observer{"control_tick_many_events", reset_tick<false, 50>, run_tick, prepare_tick, tick_drives},
    Observer{"control_tick_every_event", reset_tick<false, 200>, run_tick, prepare_tick, tick_drives},
};

// Gives every observer its parameters; false if one refuses them.
inline bool set_up_observers() {
  friction_model.prepare(all_effects(), kScales);
  tick_under_test.set_period(100);
  constexpr std::array<float, 10> kKnots = {1.0F, 2.0F, 3.0F, 5.0F, 8.0F, 13.0F, 21.0F, 34.0F, 55.0F, 300.0F};
  constexpr std::array<float, 10> kSlopes = {1.9F,  1.6F,  1.1F,  0.7F,  0.45F,
                                             0.25F, 0.15F, 0.06F, 0.02F, 0.004F};
  PiecewiseLinearCurve<10, float> curve;
  if (curve.set_slopes(kKnots, kSlopes) != SetupStatus::kOk) return false;
  piecewise_stack.set_curve(curve);
  if (maxwell_slip.set_elements(kSlipDistance, kStiffness) != SetupStatus::kOk) return false;
  if (packed_maxwell_slip.set_elements(kSlipDistance, kStiffness) != SetupStatus::kOk) return false;
  const std::span<const std::int32_t> slip_6(kSlipDistance.data(), 6);
  const std::span<const float> stiffness_6(kStiffness.data(), 6);
  return packed_maxwell_slip_6.set_elements(slip_6, stiffness_6) == SetupStatus::kOk;
}

}  // namespace slipstack::budget
