// SPDX-License-Identifier: Apache-2.0
// The constants of the tick: each is what the parameters say in SI units, computed here in double, on random
// axes; with the user's bounds and without.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>

#include "firmware/control/parameters/control_set.h"
#include "tests/unit/draw.h"

namespace slipstack {
namespace {

double wide(float value) {
  return static_cast<double>(value);
}

class Constants : public ::testing::Test {
 protected:
  // Of an axis and a model with everything that becomes a constant.
  void draw_axis() {
    const auto drawn = [this](double low, double high) {
      return static_cast<float>(draw_.log_uniform(low, high));
    };
    axis_ = {};
    axis_.encoder_resolution_m = drawn(2e-8, 1e-5);
    axis_.tick_s = drawn(0.5e-4, 4e-4);
    axis_.motor_constant_N_per_A = drawn(5.0, 200.0);
    axis_.position_gain_per_s = drawn(5.0, 80.0);
    axis_.velocity_gain_N_s_per_m = drawn(300.0, 2e4);
    axis_.integral_per_s = draw_.below(3) == 0 ? 0.0F : drawn(1.0, 80.0);
    axis_.disturbance_share = static_cast<float>(draw_.uniform(0.0, 1.0));
    axis_.current_rate_A_per_s = drawn(1e2, 1e5);
    axis_.current_limit_A = drawn(1.0, 50.0);
    axis_.velocity_limit_mps = drawn(0.05, 2.0);
    axis_.acceleration_limit_mps2 = drawn(0.5, 30.0);
    axis_.quick_stop_mps2 = drawn(0.5, 30.0);
    axis_.jerk_limit_mps3 = drawn(20.0, 2000.0);
    axis_.swap_time_s = drawn(1e-3, 0.1);
    axis_.adapt_level = draw_.below(3) == 0;
    axis_.adapt_mass = draw_.below(3) == 0;
    axis_.adaptation_speed_mps = drawn(1e-3, 0.1);
    axis_.observe_friction = draw_.below(3) != 0;
    axis_.friction_band_counts = static_cast<float>(draw_.uniform(0.0, 5.0));
    axis_.torque_friction_share = static_cast<float>(draw_.uniform(0.0, 1.0));
    axis_.check_direction = draw_.below(2) == 0;
    axis_.check_distance_m = drawn(1e-6, 1e-3);
    axis_.check_current_A = drawn(0.1, 20.0);
    axis_.check_rate_A_per_s = drawn(1.0, 100.0);
    axis_.unseen_motion_m = draw_.below(4) == 0 ? 0.0F : drawn(1e-6, 1e-2);
    axis_.compensate = draw_.below(3) != 0;
    model_ = {};
    inertia_kg_ = draw_.uniform(2.0, 60.0);
    payload_kg_ = draw_.below(2) == 0 ? 0.0 : draw_.uniform(1.0, 20.0);
    std::get<EffectParameters<Inertia<float>, float>>(model_) = {{static_cast<float>(inertia_kg_)}, {}, true};
    std::get<EffectParameters<PayloadMass<float>, float>>(model_) = {
        {static_cast<float>(payload_kg_)}, {}, payload_kg_ > 0.0};
    coulomb_N_ = draw_.below(3) == 0 ? 0.0 : draw_.uniform(1.0, 50.0);
    std::get<EffectParameters<Coulomb<float>, float>>(model_) = {
        {static_cast<float>(coulomb_N_)}, {1e-3F}, coulomb_N_ > 0.0};
    auto& hysteresis = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(model_);
    hysteresis.enabled = draw_.below(2) == 0;
    hysteresis.shapes[0] = drawn(1e-5, 1e-3);
    delay_s_ = draw_.below(2) == 0 ? 0.0 : draw_.uniform(0.0, 20.0) * wide(axis_.tick_s);
    std::get<EffectParameters<TimeDelay<float>, float>>(model_) = {
        {}, {static_cast<float>(0.3 * delay_s_), static_cast<float>(0.7 * delay_s_)}, delay_s_ > 0.0};
  }
  double mass_kg() const { return inertia_kg_ + payload_kg_; }
  double counts_per_m() const { return 1.0 / wide(axis_.encoder_resolution_m); }
  double tick_s() const { return wide(axis_.tick_s); }

  template <class Real>
  static void near(Real value, double wanted, const char* what) {
    EXPECT_NEAR(static_cast<double>(value), wanted, 1e-5 * std::abs(wanted)) << what;
  }

  test::Draw draw_{11};
  AxisParameters axis_;
  ModelParameters model_{};
  double inertia_kg_ = 0.0, payload_kg_ = 0.0, coulomb_N_ = 0.0, delay_s_ = 0.0;
  std::unique_ptr<ControlSet> set_ = std::make_unique<ControlSet>();
};

TEST_F(Constants, OfTheForce) {
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE(i);
    draw_axis();
    ASSERT_EQ(set_->prepare(axis_, model_, {}), ParameterStatus::kOk);
    const double mps = wide(axis_.encoder_resolution_m) / tick_s();
    EXPECT_TRUE(set_->valid);
    near(set_->mass_kg, mass_kg(), "mass");
    near(set_->per_mass_kg, 1.0 / mass_kg(), "of mass");
    near(set_->inertia_kg, inertia_kg_, "inertia");
    near(set_->mps_per_count, mps, "velocity");
    near(set_->mps2_per_count, mps / tick_s(), "acceleration");
    near(set_->counts_per_mps, 1.0 / mps, "counts");
    near(set_->A_per_N, 1.0 / wide(axis_.motor_constant_N_per_A), "current");
    near(set_->disturbance_kg, wide(axis_.disturbance_share) * mass_kg(), "disturbance");
    EXPECT_NEAR(set_->uncompensated_share, 1.0 - wide(axis_.disturbance_share), 1e-6);
    near(set_->torque_share, wide(axis_.torque_friction_share), "torque");
    near(set_->largest_step_A, wide(axis_.current_rate_A_per_s) * tick_s(), "rate");
    // What fades is a twentieth after the swap time.
    EXPECT_NEAR(wide(set_->blend_keep), std::exp(-3.0 * tick_s() / wide(axis_.swap_time_s)), 3e-7);
    if (axis_.adapt_level || axis_.adapt_mass) {
      near(set_->adaptation_counts, wide(axis_.adaptation_speed_mps) / mps, "adaptation");
    } else {
      EXPECT_GT(set_->adaptation_counts, 1e12F) << "no velocity is";
    }
    near(set_->feedback.resolution_m, wide(axis_.encoder_resolution_m), "resolution");
    near(set_->feedback.mps_per_count, mps, "velocity of the feedback");
    near(set_->feedback.position_per_s, wide(axis_.position_gain_per_s), "Kp");
    near(set_->feedback.velocity_N_s_per_m, wide(axis_.velocity_gain_N_s_per_m), "Kv");
    near(set_->feedback.integral_per_tick, wide(axis_.integral_per_s) * tick_s(), "Ki");
  }
}

// Scales of the model's inputs: places in steps of the hysteresis, the delay in whole ticks and the rest.
TEST_F(Constants, OfTheModel) {
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE(i);
    draw_axis();
    ASSERT_EQ(set_->prepare(axis_, model_, {}), ParameterStatus::kOk);
    const FeedForward::Scales& scales = set_->scales;
    near(scales.resolution_m, wide(axis_.encoder_resolution_m), "resolution");
    near(scales.mps_per_count, wide(axis_.encoder_resolution_m) / tick_s(), "velocity");
    near(scales.mps2_per_count, wide(axis_.encoder_resolution_m) / tick_s() / tick_s(), "acceleration");
    const double steps = std::ldexp(1.0, set_->displacement_shift);
    EXPECT_EQ(scales.shift_up, std::max(set_->displacement_shift, 0));
    EXPECT_EQ(scales.shift_down, std::max(-set_->displacement_shift, 0));
    EXPECT_EQ(scales.steps_per_count, steps);
    EXPECT_EQ(scales.band, std::floor(wide(axis_.friction_band_counts) * steps + 0.5));
    EXPECT_EQ(scales.rest > 0.0F, axis_.observe_friction && axis_.integral_per_s > 0.0F);
    EXPECT_LT(scales.rest, 2e-3F) << "of a count";
    const double ticks = delay_s_ / tick_s();
    EXPECT_LE(std::abs(set_->lead - ticks), 0.5001);
    EXPECT_NEAR(set_->lead + wide(scales.ahead), ticks + 0.5, 1e-4) << "the middle of the tick";
    // Without compensation nothing but the mass is left, and the mass is.
    Sample<float> sample;
    sample.velocity_mps = 1.0F;
    set_->model.reset(sample);
    near(set_->model.step(sample).total_N, axis_.compensate ? coulomb_N_ : 0.0, "friction");
    sample.acceleration_mps2 = 2.0F;
    near(set_->model.step(sample).total_N, (axis_.compensate ? coulomb_N_ : 0.0) + 2.0 * mass_kg(), "all");
    set_->add_mass(1.5F);
    near(set_->model.step(sample).total_N, (axis_.compensate ? coulomb_N_ : 0.0) + 2.0 * (mass_kg() + 1.5),
         "with a load");
  }
}

TEST_F(Constants, OfTheDirectionCheck) {
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE(i);
    draw_axis();
    ASSERT_EQ(set_->prepare(axis_, model_, {}), ParameterStatus::kOk);
    const DirectionCheck::Settings& check = set_->direction;
    const double newton_per_A = wide(axis_.motor_constant_N_per_A);
    EXPECT_EQ(check.wanted, axis_.check_direction);
    EXPECT_NEAR(check.stand_ticks, 0.02 / tick_s() + 0.5, 0.51) << "20 ms, and not less";
    EXPECT_NEAR(check.distance_counts, std::max(4.0, wide(axis_.check_distance_m) * counts_per_m() - 0.5),
                0.51);
    near(check.largest_N, wide(axis_.check_current_A) * newton_per_A, "force");
    near(check.step_N, wide(axis_.check_rate_A_per_s) * newton_per_A * tick_s(), "its rate");
    const double rise = wide(axis_.check_current_A) / (wide(axis_.check_rate_A_per_s) * tick_s());
    EXPECT_NEAR(check.hold_ticks, 0.25 * rise - 0.5, 0.51 + 1e-5 * rise);
  }
}

TEST_F(Constants, OfAnEncoderThatStands) {
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE(i);
    draw_axis();
    ASSERT_EQ(set_->prepare(axis_, model_, {}), ParameterStatus::kOk);
    const UnseenMotion::Settings& unseen = set_->unseen;
    if (axis_.unseen_motion_m == 0.0F) {
      EXPECT_GT(unseen.most_counts, 1e12F) << "never";
      continue;
    }
    near(unseen.most_counts, std::max(8.0, wide(axis_.unseen_motion_m) * counts_per_m()), "way");
    const double newton_per_A = wide(axis_.motor_constant_N_per_A);
    const double per_A = newton_per_A / mass_kg() * tick_s() * tick_s() * counts_per_m();
    near(unseen.counts_per_A, per_A, "of a current");
    const double dry_N = wide(dry_friction_N(model_));
    const double friction_A = dry_N > 0.0 ? 1.25 * dry_N / newton_per_A + 0.01 * wide(axis_.current_limit_A)
                                          : wide(axis_.check_current_A);
    near(unseen.friction_A, friction_A, "friction");
    near(unseen.friction, friction_A * per_A, "friction in counts");
    // Two counts of a stop of 20 N/um.
    near(unseen.pressed, (friction_A + 2.0 * 2e7 / counts_per_m() / newton_per_A) * per_A, "pressed");
  }
}

// Of all that bounds a motion, the smallest counts.
TEST_F(Constants, OfTheMotion) {
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE(i);
    draw_axis();
    const double per_mps = tick_s() * counts_per_m(), per_mps2 = per_mps * tick_s(),
                 per_mps3 = per_mps2 * tick_s();
    UserBounds user;
    const auto bound = [&](float& value, float of_the_axis, double scale) {
      if (draw_.below(3) == 0) return wide(of_the_axis);
      const double wanted = wide(of_the_axis) * draw_.log_uniform(0.2, 3.0);
      value = static_cast<float>(wanted * scale);
      return std::min(wanted, wide(of_the_axis));
    };
    const double velocity = bound(user.velocity_mps, axis_.velocity_limit_mps, 1.0);
    const double profile = std::min(
        velocity, bound(user.profile_velocity_counts_per_s, axis_.velocity_limit_mps, counts_per_m()));
    const double speeding =
        bound(user.acceleration_counts_per_s2, axis_.acceleration_limit_mps2, counts_per_m());
    const double slowing =
        bound(user.deceleration_counts_per_s2, axis_.acceleration_limit_mps2, counts_per_m());
    const double quick = bound(user.quick_stop_counts_per_s2, axis_.quick_stop_mps2, counts_per_m());
    const double slow = bound(user.slow_down_counts_per_s2, axis_.quick_stop_mps2, counts_per_m());
    const double slow_jerk = bound(user.slow_down_counts_per_s3, axis_.jerk_limit_mps3, counts_per_m());
    user.brake_release_s = static_cast<float>(draw_.uniform(0.0, 0.3));
    user.brake_apply_s = static_cast<float>(draw_.uniform(0.0, 0.3));
    user.range = {-1000, 2000};
    user.switches = i % 2 == 0;
    user.number = 7;
    const MotionBounds bounds = MotionBounds::of(axis_, user);
    near(bounds.velocity_mps, velocity, "velocity");
    near(bounds.motion.velocity, profile * per_mps, "of moves");
    near(bounds.motion.acceleration, speeding * per_mps2, "speeding");
    near(bounds.motion.deceleration, slowing * per_mps2, "slowing");
    near(bounds.motion.jerk, wide(axis_.jerk_limit_mps3) * per_mps3, "jerk");
    near(bounds.quick_stop.deceleration_counts, quick * per_mps2, "quick stop");
    near(bounds.slow_down.deceleration_counts, slow * per_mps2, "slow down");
    // The way of a stop from rest's jerk phase and on: from the largest velocity, v / 2 (v / a + a / j).
    const double v = velocity * per_mps, a = quick * per_mps2, j = wide(axis_.jerk_limit_mps3) * per_mps3;
    EXPECT_GE(wide(bounds.stopping.from(static_cast<float>(v), 0.0F)),
              v > a * a / j ? 0.5 * v * (v / a + a / j) * 0.999 : v * std::sqrt(v / j) * 0.999);
    const MotionLimits stream = bounds.of_stream(axis_);
    near(stream.velocity, v, "of a stream");
    near(stream.acceleration, wide(axis_.acceleration_limit_mps2) * per_mps2, "of a stream");
    near(stream.deceleration, wide(axis_.acceleration_limit_mps2) * per_mps2, "of a stream");
    near(stream.jerk, j, "of a stream");
    EXPECT_EQ(bounds.range.lowest, -1000);
    EXPECT_EQ(bounds.range.highest, 2000);
    EXPECT_EQ(bounds.switches, i % 2 == 0);
    EXPECT_EQ(bounds.number, 7U);
    EXPECT_NEAR(bounds.times.brake_release, wide(user.brake_release_s) / tick_s() - 0.5, 0.51);
    EXPECT_NEAR(bounds.times.brake_apply, wide(user.brake_apply_s) / tick_s() - 0.5, 0.51);
    // A stop that the user made longer has its time: from 1.5 times the velocity, and as long as a jerk
    // takes.
    const auto time = [&](double deceleration, double jerk, bool set_by_user) {
      const double ramp = 1.5 * wide(axis_.velocity_limit_mps) / deceleration + 2.0 * deceleration / jerk;
      const double usual = wide(axis_.stop_timeout_s);
      return (set_by_user ? std::max(usual, ramp) : usual) / tick_s();
    };
    const double quick_ticks = time(quick, wide(axis_.jerk_limit_mps3), quick < wide(axis_.quick_stop_mps2));
    EXPECT_NEAR(bounds.times.quick_stop, quick_ticks, 1.0 + 1e-5 * quick_ticks);
    const double slow_ticks =
        time(slow, slow_jerk, slow < wide(axis_.quick_stop_mps2) || slow_jerk < wide(axis_.jerk_limit_mps3));
    EXPECT_NEAR(bounds.times.slow_down, slow_ticks, 1.0 + 1e-5 * slow_ticks);
  }
}

}  // namespace
}  // namespace slipstack
