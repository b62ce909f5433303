// SPDX-License-Identifier: Apache-2.0
// The force of the controller against the law of docs/control.md, written down once more in double precision:
// on random axes, in motion, through changes of mode and of parameters, excited, with and without limits of
// the current.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <numbers>

#include "firmware/control/controller.h"
#include "tests/unit/draw.h"

namespace slipstack {
namespace {

// (s^2 + 2 depth zeta w s + w^2) / (s^2 + 2 zeta w s + w^2), bilinear, the centre frequency kept. Transposed
// direct form II: which form it has decides how it goes on when its constants change.
class LawNotch {
 public:
  double step(const NotchParameters& own, double tick_s, double in) {
    const auto f = static_cast<double>(own.frequency_Hz);
    if (f <= 0.0) {
      const double out = first_ + in;
      first_ = second_;
      second_ = 0.0;
      return out;
    }
    const double w = std::tan(std::numbers::pi * f * tick_s);
    const double wide = 2.0 * static_cast<double>(own.damping) * w;
    const double deep = wide * static_cast<double>(own.depth);
    const double scale = 1.0 / (1.0 + wide + w * w), middle = 2.0 * (w * w - 1.0);
    const double out = first_ + (1.0 + deep + w * w) * scale * in;
    first_ = middle * scale * (in - out) + second_;
    second_ = scale * ((1.0 - deep + w * w) * in - (1.0 - wide + w * w) * out);
    return out;
  }

 private:
  double first_ = 0.0, second_ = 0.0;
};

// The law of a tick. What the controller publishes goes in where the law does not say it: the model's force
// and the reference.
class Law {
 public:
  void use(const AxisParameters& axis, double mass_kg) {
    axis_ = axis;
    mass_kg_ = mass_kg;
  }
  void rest_at(std::int32_t counts) {
    x_m_ = counts * d(axis_.encoder_resolution_m);
    v_ = disturbance_ = 0.0;
  }
  void observe(std::int32_t counts) {
    const double t = d(axis_.tick_s), q = std::exp(-d(axis_.observer_bandwidth_rad_per_s) * t);
    const double gained = (expected_ + disturbance_) * t;
    const double predicted = x_m_ + (v_ + 0.5 * gained) * t;
    const double off = counts * d(axis_.encoder_resolution_m) - predicted;
    x_m_ = predicted + (1.0 - q * q * q) * off;
    v_ += gained + 1.5 * (1.0 - q) * (1.0 - q) * (1.0 + q) * off / t;
    disturbance_ += std::pow(1.0 - q, 3) * off / (t * t);
  }
  // The observer's correction of the friction: the integral gives up its share, the estimate expects it.
  void correct(double corrected_N) {
    integral_N_ -= (1.0 - d(axis_.disturbance_share)) * corrected_N;
    disturbance_ += corrected_N / mass_kg_;
  }
  void forget_feedback() {
    integral_N_ = proportional_N_ = 0.0;
    notch_ = {};
  }
  // Of the loop's excitation, in this tick: added to the position error and to the force.
  void excite(double added_m, double added_N) {
    added_m_ = added_m;
    added_N_ = added_N;
  }
  double error_m(const ReferencePoint& at) const {
    return (at.counts + d(at.fraction)) * d(axis_.encoder_resolution_m) - x_m_;
  }
  double feedback_N(const ReferencePoint& at) {
    const double wanted = d(at.velocity) * d(axis_.encoder_resolution_m) / d(axis_.tick_s) +
                          d(axis_.position_gain_per_s) * (error_m(at) + added_m_);
    proportional_N_ = d(axis_.velocity_gain_N_s_per_m) * (wanted - v_);
    const double t = d(axis_.tick_s);
    return notch_[1].step(axis_.notch[1], t,
                          notch_[0].step(axis_.notch[0], t, proportional_N_ + integral_N_));
  }
  double disturbance_N() const { return d(axis_.disturbance_share) * mass_kg_ * disturbance_; }
  double residual_N() const { return -mass_kg_ * disturbance_; }
  double velocity_mps() const { return v_; }
  // Fades, limits; the current.
  double apply(double asked_N, bool fade, std::uint32_t& limits) {
    if (fade) fading_N_ = wanted_N_ - asked_N;
    wanted_N_ = asked_N + fading_N_;
    fading_N_ *= std::exp(-3.0 * d(axis_.tick_s) / d(axis_.swap_time_s));
    const double per_A = d(axis_.motor_constant_N_per_A);
    const double largest_A = d(axis_.current_limit_A),
                 step_A = d(axis_.current_rate_A_per_s) * d(axis_.tick_s);
    const double asked_A = wanted_N_ / per_A;
    const double within_A = std::clamp(asked_A, -largest_A, largest_A);
    const double now_A = std::clamp(within_A, current_A_ - step_A, current_A_ + step_A);
    if (within_A != asked_A) limits |= kLimitCurrent;
    if (now_A != within_A) limits |= kLimitCurrentRate;
    // Which of two sides of a limit a value lies on that is at the limit is not asked.
    at_limit_ = std::abs(std::abs(asked_A) - largest_A) < 1e-3 ||
                std::abs(std::abs(within_A - current_A_) - step_A) < 1e-3;
    current_A_ = now_A;
    return now_A;
  }
  bool at_limit() const { return at_limit_; }
  void expect(double acceleration_counts, double model_N) {
    const double t = d(axis_.tick_s);
    applied_N_ = current_A_ * d(axis_.motor_constant_N_per_A);
    expected_ = acceleration_counts * d(axis_.encoder_resolution_m) / (t * t) +
                (applied_N_ - added_N_ - model_N) / mass_kg_;
  }
  void expect_nothing() { expected_ = 0.0; }
  void integrate() {
    integral_N_ += d(axis_.integral_per_s) * d(axis_.tick_s) * (proportional_N_ + applied_N_ - wanted_N_);
  }

 private:
  static double d(float value) { return static_cast<double>(value); }

  AxisParameters axis_;
  double mass_kg_ = 1.0;
  double added_m_ = 0.0, added_N_ = 0.0;
  double x_m_ = 0.0, v_ = 0.0, disturbance_ = 0.0, expected_ = 0.0;
  double integral_N_ = 0.0, proportional_N_ = 0.0;
  double wanted_N_ = 0.0, fading_N_ = 0.0, applied_N_ = 0.0, current_A_ = 0.0;
  bool at_limit_ = false;
  std::array<LawNotch, 2> notch_;
};

// A controller on a mass with other friction than its model's; the law beside it, on the same counts.
class AxisUnderLaw {
 public:
  explicit AxisUnderLaw(std::uint64_t seed) : draw(seed) {
    axis.encoder_resolution_m = static_cast<float>(draw.log_uniform(2e-8, 2e-6));
    axis.tick_s = static_cast<float>(draw.uniform(0.5e-4, 2e-4));
    axis.velocity_limit_mps = static_cast<float>(draw.log_uniform(0.05, 1.5));
    axis.following_error_m = 1.0F;
    axis.over_current_A = axis.stall_current_A = 1e3F;
    axis.unseen_motion_m = 0.0F;
    draw_parameters();
  }
  // All that may change in a running controller.
  void draw_parameters() {
    mass_kg = draw.uniform(5.0, 60.0);
    axis.motor_constant_N_per_A = static_cast<float>(draw.uniform(20.0, 90.0));
    axis.observer_bandwidth_rad_per_s = static_cast<float>(draw.uniform(200.0, 800.0));
    axis.position_gain_per_s = static_cast<float>(draw.uniform(10.0, 50.0));
    axis.velocity_gain_N_s_per_m = static_cast<float>(mass_kg * draw.uniform(50.0, 150.0));
    axis.integral_per_s = static_cast<float>(draw.uniform(0.0, 30.0));
    axis.disturbance_share = static_cast<float>(draw.below(3)) * 0.4F;
    for (NotchParameters& notch : axis.notch) {
      notch = {.frequency_Hz = draw.below(3) == 0 ? 0.0F : static_cast<float>(draw.uniform(250.0, 1500.0)),
               .damping = static_cast<float>(draw.uniform(0.05, 0.4)),
               .depth = static_cast<float>(draw.uniform(0.0, 1.0))};
    }
    axis.swap_time_s = static_cast<float>(draw.uniform(2e-3, 0.05));
    axis.torque_friction_share = static_cast<float>(draw.uniform(0.0, 1.0));
    axis.compensate = draw.below(4) != 0;
    axis.adapt_level = draw.below(2) == 0;
    axis.adapt_mass = draw.below(2) == 0;
    const bool weak = draw.below(3) == 0;
    axis.current_limit_A = static_cast<float>(weak ? draw.uniform(1.0, 4.0) : 500.0);
    axis.current_rate_A_per_s = static_cast<float>(draw.below(3) == 0 ? draw.uniform(200.0, 3000.0) : 1e8);
    model = {};
    const bool payload = draw.below(2) == 0;
    std::get<EffectParameters<Inertia<float>, float>>(model) = {
        {static_cast<float>(payload ? 0.6 * mass_kg : mass_kg)}, {}, true};
    std::get<EffectParameters<PayloadMass<float>, float>>(model) = {
        {static_cast<float>(0.4 * mass_kg)}, {}, payload};
    std::get<EffectParameters<Coulomb<float>, float>>(model) = {
        {static_cast<float>(draw.uniform(1.0, 20.0))}, {2e-3F}, true};
    std::get<EffectParameters<Viscous<float>, float>>(model) = {
        {static_cast<float>(draw.uniform(1.0, 50.0))}, {}, true};
    auto& hysteresis = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(model);
    hysteresis.enabled = draw.below(2) == 0;
    hysteresis.shapes[0] = 20e-6F;
    hysteresis.gains[0] = static_cast<float>(draw.uniform(0.2, 2.0) * 1e6);
    delay_ticks = draw.below(2) == 0 ? 0 : 1 + static_cast<int>(draw.below(5));
    std::get<EffectParameters<TimeDelay<float>, float>>(model) = {
        {}, {static_cast<float>(delay_ticks) * axis.tick_s, 0.0F}, delay_ticks > 0};
  }
  void configure() { ASSERT_EQ(controller->configure(axis, model), ParameterStatus::kOk); }
  void enable() {
    tick();
    for (const int word : {0x06, 0x07, 0x0F}) {
      controller->command(static_cast<std::uint16_t>(word));
      tick();
      tick();
    }
    ASSERT_EQ(controller->state().state(), DriveState::kOperationEnabled);
  }
  void demand(bool torque, double target_N, double added_N) {
    offset_N = static_cast<float>(added_N);
    target = static_cast<float>(target_N);
    controller->command(Command{0x0FU | (torque ? kTorqueMode : 0U), target, offset_N});
    torque_ = torque;
  }

  void excite() {
    ExcitationSettings settings;
    by_force_ = draw.below(2) == 0;
    settings.place = by_force_ ? ExcitationPlace::kCurrent : ExcitationPlace::kPosition;
    settings.amplitude = static_cast<float>(by_force_ ? draw.uniform(2.0, 20.0) : draw.uniform(1e-6, 2e-5));
    settings.largest_deviation_m = 1e-3F;
    settings.period_ticks = 150 + static_cast<std::uint32_t>(draw.below(200));
    settings.lowest = 2;
    settings.highest = 20;
    controller->excitation().begin(settings);
  }

  // One tick of controller, law and mass; compares.
  void tick() {
    TickInputs in;
    in.encoder.counts =
        static_cast<std::int32_t>(std::floor(x_m / static_cast<double>(axis.encoder_resolution_m)));
    in.current.current_A = now_A_;
    const bool drove = controller->output().driving;
    const Excitation& excitation = controller->excitation();
    const ReferenceGenerator& reference = controller->reference();
    excited_ = excitation.takes_part();
    const bool ends = reference.braking() || reference.plan_waits() || !excitation.running();
    const bool left = left_it_;
    const ControlOutput out = controller->step(in);
    controller->poll();
    // A current that is limited may let the axis run away.
    stopped = controller->state().faults().latched() != Fault::kNone;
    if (stopped) return;
    const bool changed = controller->parameters().number != number_;
    if (changed) {
      number_ = controller->parameters().number;
      law_.use(axis, mass_kg);
      if (number_ == 1) law_.rest_at(in.encoder.counts);
    }
    left_it_ = excited_ && !excitation.takes_part();
    excited_ = excited_ && out.driving && !torque_;
    const auto added = static_cast<double>(excitation.value());
    law_.excite(excited_ && !by_force_ ? added : 0.0, excited_ && by_force_ ? added : 0.0);
    added_N_ = excited_ && by_force_ ? added : 0.0;
    excited_ticks += excited_ ? 1 : 0;
    fades_ = drove && (excited_ ? ends : changed || follows_ != torque_ || left);
    compare(in.encoder.counts, out, drove);
    now_A_ = out.current_A;
    move(static_cast<double>(out.current_A));
    last_ = controller->history().point(controller->ticks());
    last_dry_N_ = dry_N();
  }
  bool torque() const { return torque_; }
  int limited = 0, bounded = 0, excited_ticks = 0;
  bool stopped = false;

  test::Draw draw;
  AxisParameters axis;
  ModelParameters model{};
  double mass_kg = 30.0;
  int delay_ticks = 0;
  double x_m = 0.1, v_mps = 0.0;
  float target = 0.0F, offset_N = 0.0F;
  std::unique_ptr<Controller> controller = std::make_unique<Controller>();

 private:
  double dry_N() const { return static_cast<double>(controller->friction().dry_friction_N); }
  // At rest the observer may have moved the hysteresis.
  double corrected_N(const ReferencePoint& now) const {
    constexpr float kRests = 0x1p-10F;
    const bool rests = axis.integral_per_s > 0.0F && std::abs(now.velocity) < kRests &&
                       (followed_ || std::abs(last_.velocity) < kRests);
    return rests ? static_cast<double>(controller->output().level) * (dry_N() - last_dry_N_) : 0.0;
  }
  void compare(std::int32_t counts, const ControlOutput& out, bool drove) {
    if (!out.driving) {
      law_.expect_nothing();
      law_.observe(counts);
      EXPECT_EQ(out.current_A, 0.0F);
      EXPECT_EQ(out.feedback_N, 0.0F);
      followed_ = true;
      return;
    }
    const bool other_mode = drove && follows_ != torque_;
    const TickHistory& history = controller->history();
    const std::uint32_t number = controller->ticks();
    const ReferencePoint& now = history.point(number);
    const ReferencePoint& behind = history.point(number - static_cast<std::uint32_t>(delay_ticks));
    const auto model_N = static_cast<double>(out.feedforward_N);
    law_.observe(counts);
    if (other_mode || !drove) law_.forget_feedback();
    follows_ = torque_;
    std::uint32_t limits = 0;
    double asked_N = 0.0, feedback_N = 0.0;
    if (torque_) {
      const double wanted_N =
          static_cast<double>(target) + static_cast<double>(axis.torque_friction_share) * model_N;
      const auto gain = static_cast<double>(axis.velocity_gain_N_s_per_m);
      const auto fastest = static_cast<double>(axis.velocity_limit_mps);
      asked_N = std::clamp(wanted_N, gain * (-fastest - law_.velocity_mps()),
                           gain * (fastest - law_.velocity_mps()));
      if (asked_N != wanted_N) limits |= kLimitVelocity;
      bounded += asked_N != wanted_N ? 1 : 0;
    } else {
      if (!excited_) law_.correct(corrected_N(now));
      feedback_N = law_.feedback_N(behind);
      asked_N = model_N + feedback_N - law_.disturbance_N() + added_N_;
      EXPECT_NEAR(static_cast<double>(out.position_error_m), law_.error_m(behind),
                  1e-6 * std::abs(law_.error_m(behind)) + 1e-9);
    }
    EXPECT_NEAR(static_cast<double>(out.velocity_mps), law_.velocity_mps(), 1e-6);
    EXPECT_NEAR(static_cast<double>(out.residual_N), law_.residual_N(),
                1e-3 * std::abs(law_.residual_N()) + tolerance_N());
    EXPECT_NEAR(static_cast<double>(out.feedback_N), feedback_N, tolerance_N());
    const double should_A = law_.apply(asked_N + static_cast<double>(offset_N), fades_, limits);
    if (controller->reference().braking()) limits |= kLimitReference;
    const double off_N =
        (static_cast<double>(out.current_A) - should_A) * static_cast<double>(axis.motor_constant_N_per_A);
    ASSERT_LE(std::abs(off_N), tolerance_N()) << number;
    constexpr std::uint32_t kVelocity = kLimitVelocity;
    if (!law_.at_limit()) {
      EXPECT_EQ(out.limits & ~kVelocity, limits & ~kVelocity) << number;
    }
    limited += (limits & (kLimitCurrent | kLimitCurrentRate)) != 0 ? 1 : 0;
    law_.expect(torque_ ? 0.0 : static_cast<double>(behind.acceleration), model_N);
    if (!torque_) law_.integrate();
    followed_ = torque_;
  }
  // What floats of a velocity make of it: 2^-24 of it in each of some steps, times the gain.
  double tolerance_N() const { return 0.02 + 1e-6 * static_cast<double>(axis.velocity_gain_N_s_per_m); }
  void move(double current_A) {
    const double t = static_cast<double>(axis.tick_s);
    const double force_N = current_A * static_cast<double>(axis.motor_constant_N_per_A) -
                           8.0 * std::tanh(v_mps / 1e-3) - 12.0 * v_mps;
    const double change = force_N / 30.0 * t;
    x_m += (v_mps + 0.5 * change) * t;
    v_mps += change;
  }

  Law law_;
  std::uint32_t number_ = 0;
  float now_A_ = 0.0F;
  double added_N_ = 0.0;  // by the excitation
  bool by_force_ = true;
  bool excited_ = false, left_it_ = false;  // in this tick, and after the last one
  bool fades_ = false;
  bool torque_ = false;
  bool follows_ = false;
  bool followed_ = true;  // the reference lay where the axis was
  ReferencePoint last_;
  double last_dry_N_ = 0.0;
};

// Other parameters with the same model: what was learned of its friction stays. With another model it begins
// anew.
TEST(ForceLaw, WhatIsLearnedStaysWithTheModel) {
  AxisUnderLaw one(3);
  one.axis.compensate = one.axis.adapt_level = true;
  one.axis.adapt_mass = false;
  one.axis.current_limit_A = 500.0F;
  one.axis.current_rate_A_per_s = 1e8F;
  auto& coulomb = std::get<EffectParameters<Coulomb<float>, float>>(one.model);
  coulomb.gains[0] = 20.0F;  // the axis has 8 N
  one.configure();
  one.enable();
  const auto run = [&](double metres, int ticks) {
    const double counts = (one.x_m + metres) / static_cast<double>(one.axis.encoder_resolution_m);
    ASSERT_EQ(one.controller->move_to(static_cast<std::int32_t>(counts)), PlanStatus::kOk);
    for (int i = 0; i < ticks && !one.stopped; ++i) one.tick();
  };
  for (int move = 0; move < 6; ++move) run(move % 2 == 0 ? 0.02 : -0.02, 8000);
  ASSERT_FALSE(one.stopped);
  const float learned = one.controller->output().level;
  EXPECT_LT(learned, 0.9F);
  for (int i = 0; i < 3; ++i) {
    one.axis.position_gain_per_s += 5.0F;
    one.configure();
    for (int tick = 0; tick < 50; ++tick) one.tick();
    EXPECT_NEAR(one.controller->output().level, learned, 0.02F) << i;
  }
  coulomb.gains[0] = 19.0F;
  one.configure();
  for (int tick = 0; tick < 3; ++tick) one.tick();
  EXPECT_EQ(one.controller->output().level, 1.0F);
}

TEST(ForceLaw, TheForceIsThatOfTheLawOnRandomAxes) {
  int limited = 0, bounded = 0, changes = 0, stopped = 0, excited = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    AxisUnderLaw one(seed);
    one.configure();
    one.enable();
    for (int part = 0; part < 12 && !one.stopped; ++part) {
      const auto what = one.draw.below(4);
      const double far = one.draw.uniform(-0.02, 0.02);
      if (what == 0 && !one.torque() && !one.controller->excitation().takes_part()) {
        one.draw_parameters();
        one.configure();
        ++changes;
      } else if (what == 1) {
        one.demand(!one.torque(), one.draw.uniform(-60.0, 60.0), one.draw.uniform(-10.0, 10.0));
      } else if (what == 2 && one.torque()) {
        one.demand(true, one.draw.uniform(-60.0, 60.0), one.draw.uniform(-10.0, 10.0));
      } else if (what == 2 && one.controller->reference().idle()) {
        one.excite();
      } else if (!one.torque()) {
        const double counts = (one.x_m + far) / static_cast<double>(one.axis.encoder_resolution_m);
        static_cast<void>(one.controller->move_to(static_cast<std::int32_t>(counts)));
      }
      const std::size_t ticks = 50 + one.draw.below(500);
      for (std::size_t i = 0; i < ticks && !one.stopped; ++i) {
        one.tick();
        if (::testing::Test::HasFailure()) return;
      }
    }
    limited += one.limited;
    stopped += one.stopped ? 1 : 0;
    bounded += one.bounded;
    excited += one.excited_ticks;
  }
  EXPECT_LT(stopped, 10);
  EXPECT_GT(limited, 500);
  EXPECT_GT(bounded, 500);
  EXPECT_GT(changes, 30);
  EXPECT_GT(excited, 1000);
}

}  // namespace
}  // namespace slipstack
