// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "tests/loop/axis_loop.h"

// The pick-and-place axis, pushed from outside, with a model that is wrong by a stated part.
namespace slipstack::observer {

inline constexpr double kPhase = 0.37;  // of the encoder of AxisLoop, counts

/// Root mean square and largest magnitude of what is added.
struct Spread {
  double sum = 0.0;
  double peak = 0.0;
  int count = 0;

  void add(double value) {
    sum += value * value;
    peak = std::max(peak, std::fabs(value));
    ++count;
  }
  double rms() const { return count > 0 ? std::sqrt(sum / count) : 0.0; }
};

/// How axis and drive differ from those that the model was made for.
struct Setting {
  std::uint64_t seed = 1;
  double level_error = 0.03;  ///< of the model's friction: it says so much more than there is
  double mass_error = 0.01;
  double resolution_m = 0.0;  ///< 0: that of the axis
  std::size_t late_ticks = 0;
  std::function<void(AxisParameters&)> drive = {};
  std::function<void(sim::Axis&)> differs = {};  ///< from the axis that the model is of
  double start_m = 0.2;
  std::optional<sim::Bench> bench = {};  ///< else the pick-and-place axis of the seed
};

/// Gains with which the loop hunts where it is seven ticks late.
inline void make_ten_times_stiffer(AxisParameters& axis) {
  axis.position_gain_per_s *= 10.0F;
  axis.velocity_gain_N_s_per_m *= 10.0F;
  axis.integral_per_s *= 10.0F;
  axis.observer_bandwidth_rad_per_s = 1000.0F;
}

/// Its loop, enabled and at rest.
class ObservedAxis {
 public:
  explicit ObservedAxis(const Setting& setting)
      : bench_(setting.bench ? *setting.bench : sim::draw_bench(sim::Setup::kPickAndPlace, setting.seed)) {
    if (setting.resolution_m > 0.0) bench_.axis.encoder_resolution_m = setting.resolution_m;
    const ModelParameters model =
        loop::identified_model(bench_.axis, setting.level_error, setting.mass_error);
    if (setting.differs) setting.differs(bench_.axis);
    loop_ = std::make_unique<loop::AxisLoop>(bench_.axis, setting.start_m);
    loop_->late_ticks = setting.late_ticks;
    loop_->step();  // the counts are known before there are parameters
    AxisParameters parameters = loop::pick_and_place_parameters(bench_.axis);
    if (setting.drive) setting.drive(parameters);
    EXPECT_EQ(controller().configure(parameters, model), ParameterStatus::kOk);
    loop_->run(0.01);
    EXPECT_TRUE(loop_->enable());
    loop_->run(0.1);
  }

  Controller& controller() { return loop_->controller(); }
  loop::AxisLoop& loop() { return *loop_; }
  const sim::Axis& axis() const { return bench_.axis; }
  double friction_N() const { return bench_.axis.curve.saturation_N(); }

  /// Reference less true position, m.
  double error_m() {
    const auto& reference = controller().reference();
    const double counts = static_cast<double>(reference.counts()) + static_cast<double>(reference.fraction());
    return (counts - kPhase) * bench_.axis.encoder_resolution_m - loop_->plant.position_m();
  }
  /// Moves by this way, until the reference rests, visiting each tick with the time since the begin.
  template <class Visit>
  void move(double way_m, Visit&& visit) {
    const double counts = way_m / bench_.axis.encoder_resolution_m;
    const auto target = controller().reference().counts() + static_cast<std::int32_t>(std::lround(counts));
    EXPECT_EQ(controller().move_to(target), PlanStatus::kOk);
    const double begin_s = loop_->time_s();
    do {
      step();
      visit(loop_->time_s() - begin_s);
    } while (!controller().reference().idle());
  }
  /// No fault came up.
  void expect_enabled() { EXPECT_EQ(controller().state().state(), DriveState::kOperationEnabled); }
  void step() {
    loop_->step();
    controller().poll();
  }
  /// Over this time, visiting each tick behind it.
  template <class Visit>
  void watch(double seconds, Visit&& visit) {
    const auto ticks = static_cast<int>(std::lround(seconds / loop::kTick_s));
    for (int i = 0; i < ticks; ++i) {
      step();
      visit(i * loop::kTick_s);
    }
  }

 private:
  sim::Bench bench_;
  std::unique_ptr<loop::AxisLoop> loop_;
};

}  // namespace slipstack::observer
