// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/control/force/feedback.h"
#include "firmware/control/force/feedforward.h"
#include "firmware/control/streams/cyclic_position.h"
#include "hal/biss/receiver.h"
#include "tests/budget/friction_model.h"
#include "tests/budget/tick_under_test.h"

// The stages of the tick one by one, each as a function that is not inlined, driven by a position.
namespace slipstack::budget {

// Beside the tick there is no room for it; of zeros, as the memory in the emulator begins.
[[gnu::section(".trace")]] inline FrictionModel<float> friction_model;

struct Stages {
  AxisParameters axis = everything_on();
  StateEstimate::Gains estimate_gains =
      StateEstimate::gains(axis.encoder_resolution_m, axis.tick_s, axis.observer_bandwidth_rad_per_s);
  FaultMonitor::Bounds monitor_bounds = FaultMonitor::bounds(axis);
  Notch::Gains notch_gains = Notch::gains(180.0F, 0.2F, 0.1F, axis.tick_s);
  Adaptation::Bounds adaptation_bounds = Adaptation::bounds(axis, 15.0F, 35.0F);
  FeedForward::Scales scales{.resolution_m = 1.0e-6F,
                             .mps_per_count = 1.0e-2F,
                             .mps2_per_count = 1.0e2F,
                             .shift_up = 4,
                             .shift_down = 0,
                             .steps_per_count = 16.0F};
  Feedback::Gains feedback_gains{
      .resolution_m = 1.0e-6F,
      .mps_per_count = 1.0e-2F,
      .position_per_s = 40.0F,
      .velocity_N_s_per_m = 6000.0F,
      .integral_per_tick = 4.0e-3F,
      .notch = {Notch::gains(180.0F, 0.2F, 0.1F, 1.0e-4F), Notch::gains(410.0F, 0.1F, 0.2F, 1.0e-4F)}};
  BrakingLimits braking = braking_limits(0.15F, 0.0015F);
  StopTimes times{.quick_stop = 100, .slow_down = 100, .brake_release = 20, .brake_apply = 10};
  StateEstimate estimate;
  // Those of the tick: a second one of each would not fit the memory beside it.
  ReferenceGenerator& reference = tick_under_test.controller().reference();
  CyclicPosition& cyclic = tick_under_test.controller().cyclic_position();
  StreamPath path;
  StreamPoint stream;
  TrackingLimits tracking = TrackingLimits::of(300.0F, 0.5F);
  ReferencePoint point;
  FeedForward feedforward;
  PositionReference& reference_of_position = tick_under_test.controller().position();
  Feedback feedback;
  std::uint32_t ticks = 0;
  FaultMonitor monitor;
  StateMachine machine;
  Notch notch;
  CurrentLimit limit;
  Adaptation adaptation;
  HuntingWatch::Settings hunting_settings = HuntingWatch::settings(axis, all_effects());
  HuntingWatch hunting;
  std::uint32_t hunting_ticks = 0;
  std::uint16_t limits = 0;
};
inline Stages stages;

inline void reset_stages(std::int32_t x) {
  stages.estimate.reset(x);
  stages.reference.hold(x);
  stages.feedback.reset();
  stages.monitor.reset(x);
  stages.notch.reset();
  stages.limit.reset();
  stages.adaptation.begin(stages.adaptation_bounds);
  stages.hunting.forget();
}

[[gnu::noinline]] inline float step_estimate(std::int32_t x) {
  stages.estimate.step(stages.estimate_gains, x, 0.1F);
  return stages.estimate.velocity_mps();
}

// Some segments, some stops, some time without either.
inline void fill_reference(std::int32_t x) {
  const std::uint32_t choice = static_cast<std::uint32_t>(x) % 64U;
  if (choice == 0) stages.reference.stop();
  if (choice < 16 && stages.reference.free() > 4) {
    static_cast<void>(stages.reference.push({.ticks = static_cast<std::int32_t>(choice % 4) + 1,
                                             .start_counts = x,
                                             .velocity = to_fixed(static_cast<float>(choice) - 8.0F),
                                             .jerk = to_fixed(0.001F),
                                             .sets_position = choice % 2 == 0}));
  }
}
// SYNC every ten ticks; some set-points are missing, and sometimes the stream begins anew.
inline void fill_stream(std::int32_t x) {
  CyclicPosition& cyclic = stages.cyclic;
  cyclic.poll(stages.ticks);
  if (++stages.ticks % 10 != 0) return;
  cyclic.set_period(10.0F, 1.0e-4F);
  stages.path.set_limits(
      cyclic.path_limits({300.0F, 0.5F, 0.5F, 0.01F}, PositionRange{}, CyclicPosition::kRounding));
  if (stages.ticks % 500 == 0) cyclic.stop();
  if (stages.ticks % 500 == 20) cyclic.start();
  cyclic.sync(stages.ticks, stages.ticks % 170 != 0, x, stages.path, [](std::uint32_t) { return Motion{}; });
}
[[gnu::noinline]] inline float step_stream(std::int32_t) {
  return stages.cyclic.step(stages.ticks) ? 1.0F : 0.0F;
}
inline void move_stream(std::int32_t x) {
  stages.stream.step = static_cast<float>(x % 100) * 0.01F;
  stages.stream.counts = x;
}
[[gnu::noinline]] inline float step_tracking(std::int32_t) {
  stages.point = stages.reference.track(stages.stream, stages.tracking);
  return stages.point.velocity;
}
[[gnu::noinline]] inline float step_reference(std::int32_t) {
  stages.point = stages.reference.next(stages.braking);
  return stages.point.velocity;
}

// The friction model, and what it takes to make its sample of a point of the reference.
inline void move_feedforward(std::int32_t x) {
  const auto step = static_cast<float>(difference(x, stages.point.counts));
  stages.point = {x, 0.25F, step, step - stages.point.velocity};
  ++stages.ticks;
}
[[gnu::noinline]] inline float step_feedforward(std::int32_t x) {
  stages.feedforward.observe(stages.scales, stages.point, x, stages.estimate, false);
  return stages.feedforward.step(friction_model, stages.scales, stages.point, 1.1F,
                                 stages.reference_of_position);
}

// Both notches are in it.
[[gnu::noinline]] inline float step_feedback(std::int32_t) {
  const float error_m = Feedback::error_m(stages.feedback_gains, stages.point, stages.estimate);
  const float force_N =
      stages.feedback.step(stages.feedback_gains, stages.point, error_m, stages.estimate.velocity_mps());
  stages.feedback.integrate(stages.feedback_gains, 0.9F * force_N, force_N);
  return force_N;
}

[[gnu::noinline]] inline float step_monitor(std::int32_t x) {
  const TickInputs inputs{{x, 0, x % 61 != 0}, {static_cast<float>(x % 7), x % 13 != 0}, x % 101 == 0};
  return static_cast<float>(stages.monitor.check(stages.monitor_bounds, inputs, x + x % 5000, 3.0F, true));
}

[[gnu::noinline]] inline float step_machine(std::int32_t x) {
  const auto control = static_cast<std::uint16_t>(x);
  const Fault fault = x % 97 == 0 ? Fault::kTickOverrun : Fault::kNone;
  const auto standing = [x] { return x % 3 == 0; };
  stages.machine.step(control, fault, true, standing, stages.times);
  return static_cast<float>(stages.machine.state());
}

[[gnu::noinline]] inline float step_notch(std::int32_t x) {
  return stages.notch.step(stages.notch_gains, static_cast<float>(x) * 1.0e-3F);
}

[[gnu::noinline]] inline float step_limit(std::int32_t x) {
  return stages.limit.step(10.0F, 2.0F, static_cast<float>(x) * 1.0e-2F, stages.limits);
}

[[gnu::noinline]] inline float step_adaptation(std::int32_t x) {
  stages.adaptation.step(stages.adaptation_bounds,
                         {x, static_cast<float>(x % 3), static_cast<float>(x) * 1.0e-2F,
                          static_cast<float>(x % 7), static_cast<float>(x % 11)});
  return stages.adaptation.level();
}

// An axis that the compensation of its friction makes swing, between counts that flicker.
[[gnu::noinline]] inline float step_hunting(std::int32_t x) {
  const std::uint32_t phase = stages.hunting_ticks++ % 200U;
  const float swing = static_cast<float>(phase < 100U ? phase : 200U - phase);
  const auto counts = static_cast<std::int32_t>(stages.hunting.friction_share() * swing) + (x & 1);
  stages.hunting.step(stages.hunting_settings, {}, counts, HuntingWatch::Drive::kPosition);
  return stages.hunting.friction_share() + stages.hunting.oscillation().swing_counts;
}

// A BiSS-C frame of 36 bits: its reception, in an interrupt below the tick, and what the tick reads.
struct EncoderFrames {
  biss::Receiver receiver;
  std::array<std::uint8_t, 16> sampled{};
  EncoderReading reading;
};
inline EncoderFrames encoder_frames;
inline void reset_frames(std::int32_t) {
  encoder_frames.receiver.use({EncoderInterface::Kind::kBissC, 36, 0}, false);
}
// One clock high, then `x % 40` of acknowledge; what follows is any frame, and its check sum is nearly always
// wrong: the work is the same.
inline void sample_frame(std::int32_t x) {
  const auto acknowledge = static_cast<std::uint32_t>(x) % 40U + 1U;
  for (std::uint32_t i = 0; i < encoder_frames.sampled.size(); ++i) {
    const std::uint32_t noise = (static_cast<std::uint32_t>(x) + i) * 2654435761U >> 24U;
    encoder_frames.sampled[i] = static_cast<std::uint8_t>(noise);
  }
  const auto set = [](std::uint32_t bit, bool high) {
    std::uint8_t& byte = encoder_frames.sampled[bit / 8];
    const std::uint32_t mask = 0x80U >> bit % 8U;
    byte = static_cast<std::uint8_t>(high ? byte | mask : byte & ~mask);
  };
  set(0, true);
  for (std::uint32_t bit = 1; bit <= acknowledge; ++bit) set(bit, false);
  set(acknowledge + 1, true);
}
[[gnu::noinline]] inline float receive_frame(std::int32_t x) {
  encoder_frames.receiver.received(encoder_frames.sampled, static_cast<std::uint32_t>(x));
  return 0.0F;
}
[[gnu::noinline]] inline float read_frame(std::int32_t) {
  encoder_frames.reading = encoder_frames.receiver.read();
  return 0.0F;
}
inline void receive_any_frame(std::int32_t x) {
  sample_frame(x);
  receive_frame(x);
}

}  // namespace slipstack::budget
