// SPDX-License-Identifier: Apache-2.0
// The excitation (2320h) on the simulated axis: when it runs, what ends it, what the trace shows of it.
#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/can/bench.h"
#include "tests/can/sdo/block_master.h"

namespace slipstack::can {
namespace {

constexpr std::uint32_t kDeviceState = 0x08000022;
constexpr std::uint32_t kRunning = 1;

/// An enabled axis, excited by 1 A from 20 to 400 Hz in periods of 0.1 s.
struct Excited {
  Excited() {
    bench.configure();
    bench.enable(1);
    settings();
  }
  void settings() {
    EXPECT_EQ(bench.write(0x2320, 3, 0, 1), 0U);
    EXPECT_EQ(bench.write_real(0x2320, 4, 1.0F), 0U);
    EXPECT_EQ(bench.write_real(0x2320, 6, 20.0F), 0U);
    EXPECT_EQ(bench.write_real(0x2320, 7, 400.0F), 0U);
    EXPECT_EQ(bench.write(0x2320, 8, 1000, 4), 0U);
    EXPECT_EQ(bench.write(0x2320, 9, 5, 2), 0U);
  }
  std::uint32_t start() { return bench.write(0x2320, 1, 1, 1); }
  std::uint32_t state() { return bench.read(0x2320, 2); }
  /// Largest step of the commanded current in so many milliseconds, A.
  double largest_step_A(int milliseconds) {
    double largest = 0.0;
    for (int i = 0; i < 10 * milliseconds; ++i) {
      const float before = bench.loop->controller().output().current_A;
      bench.loop->step();
      bench.drive->after_tick();
      largest = std::max(
          largest, std::fabs(static_cast<double>(bench.loop->controller().output().current_A - before)));
      if (i % 10 == 9) {
        bench.now_us += 1000;
        bench.poll();
      }
    }
    return largest;
  }
  Bench bench;
};

TEST(ExcitationObjects, RunsItsPeriodsAndEndsByItself) {
  Excited axis;
  ASSERT_EQ(axis.start(), 0U);
  axis.bench.run_ms(250);
  EXPECT_EQ(axis.state(), kRunning);
  EXPECT_EQ(axis.bench.read(0x2320, 11), 2U);
  EXPECT_EQ(axis.bench.write_real(0x2320, 4, 2.0F), kDeviceState) << "settings stay while it runs";
  EXPECT_EQ(axis.start(), kDeviceState);
  axis.bench.run_ms(300);
  EXPECT_EQ(axis.state(), 2U);
  EXPECT_EQ(axis.bench.read(0x2320, 11), 5U);
  EXPECT_EQ(axis.bench.read(0x2320, 12), 0U);
  EXPECT_EQ(axis.bench.read(0x6041, 0) & 0x6F, 0x27U);
  EXPECT_EQ(axis.start(), 0U) << "and again";
}

// 2320h:12: a limit that was met while it ran; what is measured then is not linear.
TEST(ExcitationObjects, TellsTheLimitsThatItMet) {
  for (const float rate_A_per_s : {1e6F, 10.0F}) {
    Excited axis;
    ASSERT_EQ(axis.bench.write(0x6040, 0, 0x06, 2), 0U);
    axis.bench.run_ms(5);
    ASSERT_EQ(axis.bench.write_real(0x2000, 10, rate_A_per_s), 0U);
    ASSERT_EQ(axis.bench.write(0x2140, 3, axis.bench.read(0x2140, 1), 4), 0U);
    axis.bench.run_ms(5);
    axis.bench.enable(1);
    ASSERT_EQ(axis.start(), 0U);
    axis.bench.run_ms(250);
    EXPECT_EQ(axis.bench.read(0x2320, 12), rate_A_per_s < 100.0F ? std::uint32_t{kLimitCurrentRate} : 0U);
  }
}

TEST(ExcitationObjects, IsRefusedWhereItMustNotRun) {
  Bench off;
  off.configure();
  EXPECT_EQ(off.write_real(0x2320, 4, 1.0F), 0U);
  EXPECT_EQ(off.write(0x2320, 1, 1, 1), kDeviceState) << "switched off";
  for (const std::uint8_t mode : {std::uint8_t{8}, std::uint8_t{10}, std::uint8_t{6}}) {
    Bench other;
    other.configure();
    other.enable(mode);
    EXPECT_EQ(other.write_real(0x2320, 4, 1.0F), 0U);
    EXPECT_EQ(other.write(0x2320, 1, 1, 1), kDeviceState) << int{mode};
  }
  Excited axis;
  const struct {
    std::uint8_t sub;
    float value;
  } faults[] = {
      {4, 0.0F}, {4, 0.6F * static_cast<float>(axis.bench.axis.current_limit_A)}, {6, 500.0F}, {7, 3000.0F}};
  for (const auto& fault : faults) {
    axis.settings();
    EXPECT_EQ(axis.bench.write_real(0x2320, fault.sub, fault.value), 0U);
    EXPECT_EQ(axis.start(), 0x06090030U) << int{fault.sub} << ' ' << fault.value;
  }
}

// 2320h:02: nothing has run before the first start, whether the axis is driven or not; and nothing runs that
// is switched off.
TEST(ExcitationObjects, TheStateIsThatOfTheLastRun) {
  Excited axis;
  EXPECT_EQ(axis.state(), 0U);
  ASSERT_EQ(axis.bench.write(0x6040, 0, 0, 2), 0U);
  axis.bench.run_ms(2);
  EXPECT_EQ(axis.state(), 0U) << "switched off";
  axis.bench.enable(1);
  ASSERT_EQ(axis.start(), 0U);
  EXPECT_EQ(axis.state(), kRunning);
  axis.bench.run_ms(700);
  EXPECT_EQ(axis.state(), 2U);
  ASSERT_EQ(axis.bench.write(0x6040, 0, 0, 2), 0U);
  EXPECT_EQ(axis.state(), 2U) << "what is complete stays so";
  axis.bench.run_ms(20);
  EXPECT_EQ(axis.state(), 2U);
  axis.bench.enable(1);
  ASSERT_EQ(axis.start(), 0U);
  axis.bench.run_ms(10);
  ASSERT_EQ(axis.bench.write(0x6040, 0, 0, 2), 0U);
  axis.bench.run_ms(2);
  EXPECT_EQ(axis.state(), 4U);
}

// Whatever ends it: it does not come back, the current makes no step larger than the excitation's own, and
// the axis does what it was told.
TEST(ExcitationObjects, EndsWithWhateverStopsTheAxis) {
  const struct {
    const char* name;
    std::function<void(Bench&)> act;
    std::uint32_t state;
    bool soft;
  } ends[] = {
      {"command", [](Bench& b) { b.write(0x2320, 1, 0, 1); }, 3, true},
      {"halt", [](Bench& b) { b.write(0x6040, 0, 0x010F, 2); }, 4, true},
      {"quick stop", [](Bench& b) { b.write(0x6040, 0, 0x000B, 2); }, 4, false},
      {"disable", [](Bench& b) { b.write(0x6040, 0, 0x0007, 2); }, 4, false},
      {"move",
       [](Bench& b) {
         b.write(0x607A, 0, static_cast<std::uint32_t>(b.read_signed(0x6064, 0) + 5000), 4);
         b.write(0x6040, 0, 0x3F, 2);
       },
       4, true},
      {"mode", [](Bench& b) { b.write(0x6060, 0, 8, 1); }, 4, true},
      {"torque", [](Bench& b) { b.write(0x6060, 0, 10, 1); }, 4, true},
      {"fault", [](Bench& b) { b.loop->controller().inject(Fault::kFollowingError); }, 4, true},
  };
  for (const auto& end : ends) {
    for (const int ms : {137, 180, 201}) {
      Excited axis;
      ASSERT_EQ(axis.start(), 0U);
      const double own_A = axis.largest_step_A(ms);
      end.act(axis.bench);
      const double step_A = axis.largest_step_A(60);
      EXPECT_NE(axis.state(), kRunning) << end.name;
      if (std::string(end.name) != "mode") {
        EXPECT_EQ(axis.state(), end.state) << end.name;
      }
      if (end.soft) {
        EXPECT_LT(step_A, 1.5 * own_A + 0.3) << end.name;
      }
      EXPECT_FALSE(axis.bench.loop->controller().excitation().running()) << end.name;
    }
  }
}

// 605Ah = 6: quick stop holds the axis, enabled.
TEST(ExcitationObjects, EndsWithAQuickStopThatStays) {
  Excited axis;
  ASSERT_EQ(axis.bench.write(0x6040, 0, 0x0006, 2), 0U);  // a parameter is not written while enabled
  axis.bench.run_ms(2);
  ASSERT_EQ(axis.bench.write(0x605A, 0, 6, 2), 0U);
  axis.bench.enable(1);
  ASSERT_EQ(axis.start(), 0U);
  const double own_A = axis.largest_step_A(150);
  ASSERT_EQ(axis.bench.write(0x6040, 0, 0x000B, 2), 0U);
  EXPECT_LT(axis.largest_step_A(100), 1.5 * own_A + 0.3);
  EXPECT_FALSE(axis.bench.loop->controller().excitation().running());
  EXPECT_LT(axis.largest_step_A(50), 0.05);
  EXPECT_NE(axis.state(), kRunning);
  EXPECT_EQ(axis.bench.read(0x6041, 0) & 0x6F, 0x07U);
}

TEST(ExcitationObjects, DoesNotComeBackWithTheNextEnabling) {
  Excited axis;
  ASSERT_EQ(axis.start(), 0U);
  axis.bench.run_ms(150);
  ASSERT_EQ(axis.bench.write(0x6040, 0, 0x0006, 2), 0U);
  axis.bench.run_ms(20);
  EXPECT_EQ(axis.state(), 4U);
  axis.bench.enable(1);
  axis.bench.run_ms(5);
  EXPECT_LT(axis.largest_step_A(100), 0.05);
  EXPECT_EQ(axis.state(), 4U);
}

TEST(ExcitationObjects, EndsWhenTheAxisGoesTooFar) {
  Excited axis;
  ASSERT_EQ(axis.bench.write_real(0x2320, 10, 2.0e-6F), 0U);
  ASSERT_EQ(axis.start(), 0U);
  axis.bench.run_ms(200);
  EXPECT_EQ(axis.state(), 5U);
  EXPECT_EQ(axis.bench.read(0x6041, 0) & 0x6F, 0x27U) << "the axis stays enabled";
}

TEST(ExcitationObjects, RunsAtConstantVelocityAndEndsWithTheMove) {
  Excited axis;
  ASSERT_EQ(axis.bench.write(0x6081, 0, 20000, 4), 0U);
  const std::int32_t to = axis.bench.read_signed(0x6064, 0) + 10000;
  ASSERT_EQ(axis.bench.write(0x607A, 0, static_cast<std::uint32_t>(to), 4), 0U);
  ASSERT_EQ(axis.bench.write(0x6040, 0, 0x3F, 2), 0U);
  axis.bench.run_ms(100);
  ASSERT_EQ(axis.start(), 0U);
  axis.bench.run_ms(200);
  EXPECT_EQ(axis.state(), kRunning);
  axis.bench.run_ms(600);
  EXPECT_EQ(axis.state(), 4U);
  EXPECT_NEAR(axis.bench.read_signed(0x6064, 0), to, 5);
}

// In profile velocity: at the velocity that is asked for, until another one is.
TEST(ExcitationObjects, RunsInProfileVelocityUntilAnotherVelocityIsAskedFor) {
  Bench bench;
  bench.configure();
  bench.enable(3);
  for (const auto& [index, value] : {std::pair{0x6083, 500000U}, {0x6084, 500000U}, {0x60FF, 20000U}})
    ASSERT_EQ(bench.write(static_cast<std::uint16_t>(index), 0, value, 4), 0U);
  bench.run_ms(10);
  EXPECT_EQ(bench.write_real(0x2320, 4, 1.0F), 0U);
  ASSERT_EQ(bench.write(0x2320, 1, 1, 1), 0U);
  bench.run_ms(20);
  EXPECT_EQ(bench.read(0x2320, 2), 4U) << "it speeds up";
  bench.run_ms(300);
  ASSERT_EQ(bench.write(0x2320, 1, 1, 1), 0U);
  bench.run_ms(150);
  EXPECT_EQ(bench.read(0x2320, 2), kRunning);
  EXPECT_EQ(bench.read_signed(0x606B, 0), 20000);
  ASSERT_EQ(bench.write(0x60FF, 0, 10000, 4), 0U);
  bench.run_ms(20);
  EXPECT_EQ(bench.read(0x2320, 2), 4U);
  bench.run_ms(300);
  EXPECT_EQ(bench.read_signed(0x606B, 0), 10000);
  EXPECT_EQ(bench.read(0x603F, 0), 0U);
}

// Injected at the position reference, the axis follows it.
TEST(ExcitationObjects, AtThePositionReferenceTheAxisFollows) {
  Excited axis;
  ASSERT_EQ(axis.bench.write(0x2320, 3, 1, 1), 0U);
  ASSERT_EQ(axis.bench.write_real(0x2320, 5, 1.0e-4F), 0U);
  ASSERT_EQ(axis.bench.write_real(0x2320, 6, 1.0F), 0U);
  ASSERT_EQ(axis.bench.write_real(0x2320, 7, 3.0F), 0U);
  ASSERT_EQ(axis.bench.write(0x2320, 8, 10000, 4), 0U);
  ASSERT_EQ(axis.bench.write(0x2320, 9, 1, 2), 0U);
  const std::int32_t from = axis.bench.read_signed(0x6064, 0);
  ASSERT_EQ(axis.start(), 0U);
  std::int32_t farthest = 0;
  for (int i = 0; i < 900; ++i) {
    axis.bench.run_ms(1);
    farthest = std::max(farthest, std::abs(axis.bench.loop->board_encoder.next.counts - from));
  }
  EXPECT_GT(farthest, 70);
  EXPECT_LT(farthest, 160);
}

TEST(ExcitationObjects, TraceShowsItInTheSecondChannel) {
  Excited axis;
  ASSERT_EQ(axis.start(), 0U);
  axis.bench.run_ms(100);
  ASSERT_EQ(axis.bench.write(0x2300, 10, 1, 1), 0U);
  ASSERT_EQ(axis.bench.write(0x2300, 1, 1, 1), 0U);
  std::vector<float> wanted;
  for (int i = 0; i < 4096; ++i) {
    axis.bench.loop->step();
    axis.bench.drive->after_tick();
    wanted.push_back(axis.bench.loop->controller().excitation().value());
  }
  ASSERT_EQ(axis.bench.read(0x2300, 2), 3U);
  const Data data = block_upload(axis.bench, 0x2310, 127, [](int) { return false; });
  ASSERT_EQ(data.size(), 48 + 12 * 4096U);
  EXPECT_EQ(Bench::number(data, 44), 1U);
  float largest = 0.0F;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    ASSERT_EQ(Bench::number(data, 48 + 12 * i + 4), std::bit_cast<std::uint32_t>(wanted[i])) << i;
    largest = std::max(largest, wanted[i]);
  }
  // 1 A by the motor constant.
  EXPECT_NEAR(largest, axis.bench.axis.motor_constant_N_per_A, 0.01 * axis.bench.axis.motor_constant_N_per_A);
}

}  // namespace
}  // namespace slipstack::can
