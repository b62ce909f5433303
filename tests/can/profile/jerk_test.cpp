// SPDX-License-Identifier: Apache-2.0
// The reference behind the bus, tick by tick: whatever is commanded in motion (targets at once, other
// profiles, halt, quick stop, the end of a halt, another mode), its jerk stays within the limit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

class Watched : public Bench {
 public:
  Watched() {
    configure();
    EXPECT_EQ(write(0x2403, 0, 0, 2), 0U);
  }
  void go(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) {
      for (int tick = 0; tick < 10; ++tick) {
        loop->step();
        drive->after_tick();
        see();
      }
      now_us += 1000;
      node->poll(now_us);
    }
  }
  void control(std::uint32_t word) { ASSERT_EQ(write(0x6040, 0, word, 2), 0U); }
  std::uint32_t counts(double metres) const {
    return static_cast<std::uint32_t>(
        static_cast<std::int32_t>(std::lround(metres / axis.encoder_resolution_m)));
  }
  bool standing() { return loop->controller().reference().standing(); }
  void begin_anew() {
    known_ = 0;
    sharpest_mps3 = 0.0;
  }

  double sharpest_mps3 = 0.0;
  double fastest_mps = 0.0;

 private:
  void see() {
    const Controller& controller = loop->controller();
    // Not driven, it lies where the axis is, in whole counts.
    if (!controller.state().follows_commands()) known_ = 0;
    const ReferencePoint& point = controller.history().point(controller.ticks());
    const double step = static_cast<double>(difference(point.counts, last_)) +
                        static_cast<double>(point.fraction) - fraction_;
    const double jerk = (step - velocity_) - acceleration_;
    acceleration_ = step - velocity_;
    velocity_ = step;
    last_ = point.counts;
    fraction_ = static_cast<double>(point.fraction);
    if (++known_ < 4) return;
    const double tick_s = loop::kTick_s;
    sharpest_mps3 =
        std::max(sharpest_mps3, std::abs(jerk) * axis.encoder_resolution_m / (tick_s * tick_s * tick_s));
    fastest_mps = std::max(fastest_mps, std::abs(step) * axis.encoder_resolution_m / tick_s);
  }

  std::int32_t last_ = 0;
  double fraction_ = 0.0, velocity_ = 0.0, acceleration_ = 0.0;
  int known_ = 0;
};

// 2000h:0D is 200 m/s3. A place has a float's fraction, 2^-24 of a count, eight times in a third difference.
class Jerk : public ::testing::Test {
 protected:
  static constexpr double kLimit_mps3 = 200.0;
  double allowed(double limit_mps3 = kLimit_mps3) const {
    const double tick_s = loop::kTick_s;
    return limit_mps3 * (1.0 + 1e-4) +
           8.0 * 0x1p-24 * bench_.axis.encoder_resolution_m / (tick_s * tick_s * tick_s);
  }
  // A path changes its jerk at once, from -j to +j at most; the tick in which it does has the mean velocity
  // of the segment that begins there, and the third difference of its places, 7/6 + 2/6 - 1/6 of j, is 4/3 of
  // j where only its last instant lies in that segment. j is the limit and what rounding makes, which is
  // followed: 6 counts per period^3 (docs/can.md). The way to the stream is a sum of five floats of the size
  // of a period's way, of which a share becomes the step, four times in a third difference.
  double of_a_stream(double period_s) const {
    const double resolution_m = bench_.axis.encoder_resolution_m;
    const double rounding_mps3 = 6.0 * resolution_m / std::pow(period_s, 3);
    const double way_m =
        static_cast<double>(bench_.loop->controller().parameters().axis.velocity_limit_mps) * period_s;
    const double off_m = 5.0 * 0x1p-24 * way_m * static_cast<double>(TrackingLimits::kShare);
    return allowed(4.0 / 3.0 * (kLimit_mps3 + rounding_mps3)) + 4.0 * off_m / std::pow(loop::kTick_s, 3);
  }
  // Enabled in a mode; halts are by this option (605Dh: 1 along the profile, 2 along the quick stop ramp).
  void begin(std::uint8_t mode, std::uint32_t halt_option) {
    bench_.control(0x06);
    bench_.go(800);
    ASSERT_EQ(bench_.write(0x605D, 0, halt_option, 2), 0U);
    bench_.enable(mode);
    bench_.go(5);
    bench_.begin_anew();
  }
  // Which limits a profile has: any, up to those of the axis.
  void draw_profile() {
    ASSERT_EQ(bench_.write(0x6081, 0, bench_.counts(uniform(0.01, 0.3)), 4), 0U);
    ASSERT_EQ(bench_.write(0x6083, 0, bench_.counts(uniform(0.5, 5.0)), 4), 0U);
    ASSERT_EQ(bench_.write(0x6084, 0, bench_.counts(uniform(0.5, 5.0)), 4), 0U);
    ASSERT_EQ(bench_.write(0x6085, 0, bench_.counts(uniform(2.0, 5.0)), 4), 0U);
    ASSERT_EQ(bench_.write(0x60A4, 1, bench_.counts(uniform(20.0, 200.0)), 4), 0U);
  }
  // A halt, for a while, out of whatever motion there is; and the end of it, at rest or still braking.
  void halt(std::uint32_t word) {
    bench_.control(word | 0x100U);
    bench_.go(1 + static_cast<int>(random_() % 120));
    bench_.control(word);
    bench_.go(1 + static_cast<int>(random_() % 80));
  }
  void rest() {
    for (int i = 0; i < 3000 && !bench_.standing(); ++i) bench_.go(1);
    ASSERT_TRUE(bench_.standing());
  }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  std::mt19937 random_{17};
  Watched bench_;
};

TEST_F(Jerk, OfProfilePositionWhateverIsCommandedInMotion) {
  for (int n = 0; n < 160; ++n) {
    if (n % 80 == 0) begin(1, n == 0 ? 1 : 2);
    if (random_() % 3 == 0) draw_profile();
    ASSERT_EQ(bench_.write(0x607A, 0, bench_.counts(uniform(-0.15, 0.15)), 4), 0U);
    bench_.control(random_() % 4 == 0 ? 0x1F : 0x3F);
    bench_.go(1);
    bench_.control(0x0F);
    bench_.go(1 + static_cast<int>(random_() % 150));
    if (random_() % 3 == 0) halt(0x0F);
    ASSERT_LE(bench_.sharpest_mps3, allowed()) << n;
  }
  EXPECT_GT(bench_.fastest_mps, 0.15);
  EXPECT_GT(bench_.sharpest_mps3, 0.9 * kLimit_mps3) << "stops have the limit of the axis";
  rest();
}

TEST_F(Jerk, OfProfileVelocityWhateverIsCommandedInMotion) {
  for (int n = 0; n < 160; ++n) {
    if (n % 80 == 0) begin(3, n == 0 ? 1 : 2);
    if (random_() % 3 == 0) draw_profile();
    ASSERT_EQ(bench_.write(0x60FF, 0, bench_.counts(uniform(-0.3, 0.3)), 4), 0U);
    bench_.go(1 + static_cast<int>(random_() % 150));
    if (random_() % 3 == 0) halt(0x0F);
    ASSERT_LE(bench_.sharpest_mps3, allowed()) << n;
  }
  EXPECT_GT(bench_.fastest_mps, 0.25);
}

// Quick stop that stays, the way out of it, and modes of profile one after the other.
TEST_F(Jerk, OfQuickStopsAndChangesOfMode) {
  ASSERT_EQ(bench_.write(0x605A, 0, 6, 2), 0U);
  begin(1, 1);
  int stops = 0;
  for (int n = 0; n < 120; ++n) {
    const bool velocity = random_() % 2 == 0;
    ASSERT_EQ(bench_.write(0x6060, 0, velocity ? 3 : 1, 1), 0U);
    bench_.go(1);
    if (velocity) {
      ASSERT_EQ(bench_.write(0x60FF, 0, bench_.counts(uniform(-0.3, 0.3)), 4), 0U);
    } else {
      ASSERT_EQ(bench_.write(0x607A, 0, bench_.counts(uniform(-0.15, 0.15)), 4), 0U);
      bench_.control(0x3F);
      bench_.go(1);
      bench_.control(0x0F);
    }
    bench_.go(1 + static_cast<int>(random_() % 150));
    if (random_() % 4 == 0) {
      bench_.control(0x0B);
      bench_.go(1 + static_cast<int>(random_() % 60));
      bench_.control(0x0F);  // also while it brakes
      bench_.go(1);
      ++stops;
    }
    ASSERT_LE(bench_.sharpest_mps3, allowed()) << n;
  }
  EXPECT_GT(stops, 15);
  EXPECT_GT(bench_.fastest_mps, 0.2);
}

// Cyclic modes: left by halt in motion, and entered again; set-points come with every SYNC, every 10 ms.
TEST_F(Jerk, OfAHaltInTheCyclicModes) {
  constexpr int kSlow_ms = 10;
  ASSERT_EQ(bench_.write(0x60C2, 1, kSlow_ms, 1), 0U);
  // A stop that has less jerk than the stream cannot take out what it speeds up with below the velocity
  // limit.
  ASSERT_EQ(bench_.write(0x60A4, 1, bench_.counts(kLimit_mps3), 4), 0U);
  bench_.nmt(1);
  for (const bool position : {true, false}) {
    begin(position ? 8 : 9, 1);
    double place_m = 0.0;
    double wanted_mps = 0.0;
    const auto stream = [&](int periods) {
      for (int i = 0; i < periods; ++i) {
        if (random_() % 20 == 0) wanted_mps = uniform(-0.35, 0.35);
        place_m += wanted_mps * kSlow_ms * 1e-3;
        const std::uint32_t value = position ? bench_.counts(place_m) : bench_.counts(wanted_mps);
        ASSERT_EQ(bench_.write(position ? 0x607A : 0x60FF, 0, value, 4), 0U);
        bench_.send(0x80, {});
        bench_.go(kSlow_ms);
      }
    };
    const auto here = [&] { place_m = bench_.read_signed(0x6064, 0) * bench_.axis.encoder_resolution_m; };
    here();
    stream(40);
    bench_.begin_anew();
    for (int n = 0; n < 40; ++n) {
      stream(10 + static_cast<int>(random_() % 30));
      bench_.control(0x10F);
      stream(1 + static_cast<int>(random_() % 20));
      bench_.control(0x0F);
      here();
      stream(10);
      ASSERT_LE(bench_.sharpest_mps3, of_a_stream(1e-3 * kSlow_ms)) << position << ' ' << n;
    }
    EXPECT_GT(bench_.fastest_mps, 0.28);
    EXPECT_GT(bench_.sharpest_mps3, 0.9 * kLimit_mps3);
  }
}

}  // namespace
}  // namespace slipstack::can
