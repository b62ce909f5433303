// SPDX-License-Identifier: Apache-2.0
// An axis that its compensation makes hunt is found and quieted, and the cause is told; what is no hunting,
// or does not come from the compensation, leaves it as it is.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <string>

#include "tests/bench/observer/observed_axis.h"
#include "workbench/frequency/rigid_mass.h"

namespace slipstack::observer {
namespace {

using Each = std::function<void(double time_s)>;

/// How the axis moves over a while: the root mean square of its velocity, mm/s, and the extremes, um.
struct Motion {
  Spread mmps;
  double lowest_um = 1e12;
  double highest_um = -1e12;
  double between_um() const { return highest_um - lowest_um; }
};

Motion watch(ObservedAxis& axis, double seconds, const Each& each = {}) {
  Motion motion;
  axis.watch(seconds, [&](double time_s) {
    if (each) each(time_s);
    const double now_um = 1e6 * axis.loop().plant.position_m();
    motion.lowest_um = std::min(motion.lowest_um, now_um);
    motion.highest_um = std::max(motion.highest_um, now_um);
    motion.mmps.add(1e3 * axis.loop().plant.velocity_mps());
  });
  return motion;
}

double frequency_Hz(ObservedAxis& axis) {
  return 1.0 / (static_cast<double>(axis.controller().hunting().oscillation().period_ticks) * loop::kTick_s);
}

// ---- hunting by the compensation ----

/// The position loop of a master over cyclic torque, every millisecond, around the place where it begins.
class MasterLoop {
 public:
  MasterLoop(ObservedAxis& axis, double stiffness_N_per_m, double damping)
      : axis_(axis),
        stiffness_N_per_m_(stiffness_N_per_m),
        damping_N_s_per_m_(2.0 * damping * std::sqrt(stiffness_N_per_m * axis.axis().mass_kg)),
        begin_(axis.controller().measured_counts()) {
    axis.controller().command_all(0x0FU | kTorqueMode);
  }
  void operator()(double) {
    if (tick_++ % 10 != 0) return;
    const double now_m = (axis_.controller().measured_counts() - begin_) * axis_.axis().encoder_resolution_m;
    velocity_mps_ += 0.3 * ((now_m - last_m_) / 1e-3 - velocity_mps_);
    last_m_ = now_m;
    const double force_N = -stiffness_N_per_m_ * now_m - damping_N_s_per_m_ * velocity_mps_;
    axis_.controller().set_torque(static_cast<float>(force_N), 0.0F);
  }

 private:
  ObservedAxis& axis_;
  double stiffness_N_per_m_;
  double damping_N_s_per_m_;
  std::int32_t begin_;
  int tick_ = 0;
  double last_m_ = 0.0;
  double velocity_mps_ = 0.0;
};

/// Pushes from outside: 30 N for 50 ms, at each of these times.
Each pushed_at(ObservedAxis& axis, MasterLoop& master, double every_s) {
  return [&axis, &master, every_s](double time_s) {
    axis.loop().pushed_N = std::fmod(time_s, every_s) < 0.05 ? 30.0 : 0.0;
    master(time_s);
  };
}

// The whole friction of a model that has 5 to 100 % more than the axis is compensated in torque mode, where
// the master holds the position.
TEST(HuntingAxis, TooMuchFrictionInTorqueModeIsLowered) {
  struct Case {
    double level_error;
    double stiffness_N_per_m;
    double damping;
  };
  for (const Case& one : {Case{0.05, 2e4, 0.1},
                          {0.3, 2e4, 0.3},
                          {0.5, 2e4, 0.3},
                          {0.5, 2e5, 0.1},
                          {0.5, 2e5, 0.3},
                          {1.0, 2e4, 0.1},
                          {1.0, 2e5, 0.3}}) {
    for (const std::uint64_t seed : {1U, 2U}) {
      SCOPED_TRACE(testing::Message()
                   << one.level_error << ' ' << one.stiffness_N_per_m << ' ' << one.damping << ' ' << seed);
      const auto run = [&](bool watched) {
        Setting setting;
        setting.seed = seed;
        setting.level_error = one.level_error;
        setting.drive = [watched](AxisParameters& p) {
          p.torque_friction_share = 1.0F;
          p.hunting_swing_m = watched ? p.hunting_swing_m : 0.0F;
        };
        return ObservedAxis(setting);
      };
      ObservedAxis hunts = run(false);
      MasterLoop master(hunts, one.stiffness_N_per_m, one.damping);
      watch(hunts, 42.0, pushed_at(hunts, master, 20.0));
      const Motion before = watch(hunts, 1.0, std::ref(master));
      EXPECT_GT(before.between_um(), 100.0) << "it does hunt";

      ObservedAxis axis = run(true);
      MasterLoop same(axis, one.stiffness_N_per_m, one.damping);
      watch(axis, 5.5, pushed_at(axis, same, 20.0));
      EXPECT_GT(axis.controller().hunting().found(), 0) << "within 5.5 s";
      watch(axis, 36.5, pushed_at(axis, same, 20.0));
      const HuntingWatch& hunting = axis.controller().hunting();
      EXPECT_EQ(hunting.warning(), HuntingCause::kFriction);
      EXPECT_EQ(hunting.friction_share(), 0.0F);
      EXPECT_EQ(hunting.disturbance_share(), 1.0F);
      const Motion after = watch(axis, 1.0, std::ref(same));
      EXPECT_LT(after.between_um(), 3.0);
      EXPECT_LT(after.mmps.rms(), 1e-2 * before.mmps.rms()) << "its energy is a ten thousandth";
      std::printf("%+.0f %%, %.0e N/m: %.1f Hz, %.0f -> %.1f um, %.3g -> %.2g mm/s\n",
                  100.0 * one.level_error, one.stiffness_N_per_m, frequency_Hz(axis), before.between_um(),
                  after.between_um(), before.mmps.rms(), after.mmps.rms());
      axis.expect_enabled();
    }
  }
}

// A disturbance observer that is too fast for a loop with twice or three times the motor constant that the
// drive knows, and a delay.
TEST(HuntingAxis, ADisturbanceObserverThatIsTooFastIsLowered) {
  struct Case {
    double constant;
    std::size_t late_ticks;
    float bandwidth_rad_per_s;
  };
  for (const Case& one : {Case{2.0, 7, 2000.0F},
                          {2.0, 7, 4000.0F},
                          {3.0, 3, 2000.0F},
                          {3.0, 3, 4000.0F},
                          {3.0, 7, 1000.0F},
                          {3.0, 7, 4000.0F}}) {
    SCOPED_TRACE(testing::Message() << one.constant << ' ' << one.late_ticks << ' '
                                    << one.bandwidth_rad_per_s);
    const auto run = [&](bool watched) {
      Setting setting;
      setting.late_ticks = one.late_ticks;
      setting.differs = [&](sim::Axis& axis) { axis.motor_constant_N_per_A *= one.constant; };
      setting.drive = [&](AxisParameters& p) {
        p.motor_constant_N_per_A /= static_cast<float>(one.constant);
        p.disturbance_share = 1.0F;
        p.observer_bandwidth_rad_per_s = one.bandwidth_rad_per_s;
        p.hunting_swing_m = watched ? p.hunting_swing_m : 0.0F;
      };
      return ObservedAxis(setting);
    };
    ObservedAxis hunts = run(false);
    hunts.move(1e-3, [](double) {});
    watch(hunts, 8.0);
    const Motion before = watch(hunts, 0.5);
    EXPECT_GT(before.between_um(), 20.0) << "it does hunt";

    ObservedAxis axis = run(true);
    axis.move(1e-3, [](double) {});
    watch(axis, 1.1);
    EXPECT_EQ(axis.controller().hunting().found(), 1) << "within 1.1 s";
    watch(axis, 6.9);
    const HuntingWatch& hunting = axis.controller().hunting();
    EXPECT_EQ(hunting.warning(), HuntingCause::kDisturbanceObserver);
    EXPECT_EQ(hunting.disturbance_share(), 0.0F);
    EXPECT_EQ(hunting.friction_share(), 1.0F);
    EXPECT_EQ(hunting.found(), 1);
    const Motion after = watch(axis, 0.5);
    EXPECT_LT(after.between_um(), 3.0);
    EXPECT_LT(after.mmps.rms(), 0.05 * before.mmps.rms());
    std::printf("constant x %.0f, %zu ticks, %.0f rad/s: %.0f Hz, %.0f -> %.1f um, %.3g -> %.2g mm/s\n",
                one.constant, one.late_ticks, static_cast<double>(one.bandwidth_rad_per_s),
                frequency_Hz(axis), before.between_um(), after.between_um(), before.mmps.rms(),
                after.mmps.rms());
    axis.expect_enabled();
  }
}

// ---- hunting that does not come from it ----

TEST(HuntingAxis, ByItsGainsKeepsItsCompensation) {
  for (const float share : {0.0F, 1.0F}) {
    Setting setting;
    setting.level_error = 0.1;
    setting.late_ticks = 7;
    setting.drive = [share](AxisParameters& p) {
      p.disturbance_share = share;
      make_ten_times_stiffer(p);
    };
    ObservedAxis axis(setting);
    axis.move(1e-3, [](double) {});
    watch(axis, 6.0);
    const HuntingWatch& hunting = axis.controller().hunting();
    EXPECT_EQ(hunting.warning(), HuntingCause::kElsewhere);
    EXPECT_EQ(hunting.friction_share(), 1.0F);
    EXPECT_EQ(hunting.disturbance_share(), 1.0F);
    EXPECT_EQ(hunting.found(), 1);
    axis.expect_enabled();
  }
}

// The floor shakes the axis by a force of one frequency, while it stands: told, but not blamed.
TEST(HuntingAxis, ByTheFloorKeepsItsCompensation) {
  for (const double frequency : {5.0, 12.0, 30.0, 80.0}) {
    for (const float share : {0.0F, 1.0F}) {
      SCOPED_TRACE(testing::Message() << frequency << ' ' << share);
      Setting setting;
      setting.drive = [share](AxisParameters& p) { p.disturbance_share = share; };
      ObservedAxis axis(setting);
      const auto shakes = [&](double time_s) {
        axis.loop().pushed_N = 120.0 * std::sin(2.0 * std::numbers::pi * frequency * time_s);
      };
      const Motion motion = watch(axis, 16.0, shakes);
      EXPECT_GT(motion.between_um(), 6.0);
      const HuntingWatch& hunting = axis.controller().hunting();
      EXPECT_EQ(hunting.warning(), HuntingCause::kElsewhere);
      EXPECT_EQ(hunting.friction_share(), 1.0F);
      EXPECT_EQ(hunting.disturbance_share(), 1.0F);
      EXPECT_NEAR(frequency_Hz(axis), frequency, 0.05 * frequency);
      axis.expect_enabled();
    }
  }
}

// ---- what is no hunting ----

struct Day {
  int found = 0;
  bool blamed = false;  ///< the compensation was
};

/// Everything that a machine does all day; the forces from outside are those for an axis of 35 kg.
Day work_a_day(const Setting& setting) {
  ObservedAxis axis(setting);
  const double forces = axis.axis().mass_kg / 35.0;
  watch(axis, 2.0);
  for (const double way_m : {1e-5, 1e-4, 1e-3, 1e-2, 5e-2, -5e-2, -1e-2, -1e-3, -1e-4, -1e-5}) {
    axis.move(way_m, [](double) {});
    watch(axis, 0.4);
  }
  for (const double force_N : {5.0, -20.0, 60.0}) {
    axis.loop().pushed_N = forces * force_N;
    watch(axis, 0.2);
    axis.loop().pushed_N = 0.0;
    watch(axis, 0.4);
  }
  // A hand, 1.5 times a second. An encoder of 5 um does not show that it gives way: that is 7310h.
  const double hand_N = axis.axis().encoder_resolution_m < 4e-6 ? 40.0 * forces : 0.0;
  watch(axis, 6.0, [&](double time_s) {
    axis.loop().pushed_N = hand_N * std::sin(2.0 * std::numbers::pi * 1.5 * time_s);
  });
  axis.loop().pushed_N = 0.0;
  watch(axis, 0.5);
  axis.expect_enabled();
  const HuntingWatch& hunting = axis.controller().hunting();
  const HuntingCause warning = hunting.warning();
  return {hunting.found(),
          warning == HuntingCause::kFriction || warning == HuntingCause::kDisturbanceObserver};
}

TEST(HuntingAxis, ADaysWorkIsNone) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    for (const double level_error : {-0.3, 0.03, 0.2}) {
      for (const float share : {0.0F, 1.0F}) {
        for (const double resolution_m : {1e-8, 1e-6, 5e-6}) {
          Setting setting;
          setting.seed = seed;
          setting.level_error = level_error;
          setting.resolution_m = resolution_m;
          setting.drive = [share](AxisParameters& p) { p.disturbance_share = share; };
          EXPECT_EQ(work_a_day(setting).found, 0)
              << seed << ' ' << level_error << ' ' << share << ' ' << resolution_m;
        }
      }
    }
  }
}

/// A random axis with a share of the feedback that `slipstack tune` proposes for its mass.
Setting random_axis(std::uint64_t seed, double share) {
  Setting setting;
  setting.seed = seed;
  setting.bench = sim::draw_bench(sim::Setup::kRandom, seed);
  setting.start_m = 0.3 * setting.bench->axis.stroke_m;
  const workbench::DriveController gains =
      workbench::feedback_for_mass(setting.bench->axis.mass_kg, loop::kTick_s, 400.0, {});
  setting.drive = [gains, share](AxisParameters& p) {
    p.position_gain_per_s = static_cast<float>(share * gains.position_gain_per_s);
    p.velocity_gain_N_s_per_m = static_cast<float>(share * gains.velocity_gain_N_s_per_m);
    p.integral_per_s = static_cast<float>(share * gains.integral_per_s);
    p.velocity_limit_mps = 0.2F;
    p.acceleration_limit_mps2 = 2.0F;
    p.jerk_limit_mps3 = 100.0F;
  };
  return setting;
}

// With half of that feedback few of them ring on their pre-sliding stiffness, by the noise of their force,
// which the feedback raises: that is told, and the compensation stays. 2301 to 2332 were looked at when the
// search was made, 2401 to 2432 were not.
TEST(HuntingAxis, RandomAxesKeepTheirCompensation) {
  std::string ring;
  int found = 0;
  for (const std::uint64_t first : {2301U, 2401U}) {
    for (std::uint64_t seed = first; seed < first + 32; ++seed) {
      const Day day = work_a_day(random_axis(seed, 0.5));
      EXPECT_FALSE(day.blamed) << seed;
      if (day.found == 0) continue;
      ring += " " + std::to_string(seed);
      ++found;
    }
  }
  std::printf("%d of 64 ring:%s\n", found, ring.c_str());
  EXPECT_LE(found, 5);
}

// Led by a hand, with half of the friction compensated, and the whole.
TEST(HuntingAxis, AHandThatLeadsIsNone) {
  for (const float share : {0.5F, 1.0F}) {
    for (const double rate_Hz : {0.5, 1.0, 1.7}) {
      Setting setting;
      setting.drive = [share](AxisParameters& p) { p.torque_friction_share = share; };
      ObservedAxis axis(setting);
      axis.controller().command_all(0x0FU | kTorqueMode);
      const double begin_m = axis.loop().plant.position_m();
      watch(axis, 8.0, [&](double time_s) {
        const double rate = 2.0 * std::numbers::pi * rate_Hz;
        const double ahead_m = begin_m + 0.01 * std::sin(rate * time_s) - axis.loop().plant.position_m();
        const double faster_mps = 0.01 * rate * std::cos(rate * time_s) - axis.loop().plant.velocity_mps();
        axis.loop().pushed_N = 2000.0 * ahead_m + 600.0 * faster_mps;
      });
      EXPECT_EQ(axis.controller().hunting().found(), 0) << share << ' ' << rate_Hz;
    }
  }
}

}  // namespace
}  // namespace slipstack::observer
