// SPDX-License-Identifier: Apache-2.0
// Hunting over the bus: a master that holds the position over cyclic torque, a drive that compensates twice
// the friction that there is.
#include <cmath>
#include <cstdint>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

constexpr std::uint8_t kTorque = 10;
constexpr double kStiffness_N_per_m = 2e5;
constexpr double kDamping = 0.1;

class HuntingBench {
 public:
  explicit HuntingBench(bool watched = true) {
    bench.configure();
    EXPECT_EQ(bench.write(0x2403, 0, 0, 2), 0U);
    EXPECT_EQ(bench.write_real(0x2000, 0x25, 1.0F), 0U);
    if (!watched) {
      EXPECT_EQ(bench.write_real(0x2202, 1, 0.0F), 0U);
    }
    for (std::uint8_t sub = 2; sub < 12; ++sub) {
      EXPECT_EQ(bench.write_real(0x2101, sub, 2.0F * bench.read_real(0x2101, sub)), 0U);
    }
    EXPECT_EQ(bench.write(0x2140, 3, bench.read(0x2140, 1), 4), 0U);
    bench.run_ms(2);
    bench.enable(kTorque);
    rated_N_ = static_cast<double>(bench.read(0x6076, 0)) * 1e-3;
    begin_ = bench.read_signed(0x6064, 0);
  }

  /// The master, a set-point every millisecond, and a push at its begin.
  void run(double seconds, bool pushes) {
    const double damping = 2.0 * kDamping * std::sqrt(kStiffness_N_per_m * bench.axis.mass_kg);
    for (int ms = 0; ms < seconds * 1e3; ++ms) {
      bench.loop->pushed_N = pushes && ms < 50 ? 30.0 : 0.0;
      const double now_m =
          (bench.loop->controller().measured_counts() - begin_) * bench.axis.encoder_resolution_m;
      velocity_mps_ += 0.3 * ((now_m - last_m_) / 1e-3 - velocity_mps_);
      last_m_ = now_m;
      const double force_N = -kStiffness_N_per_m * now_m - damping * velocity_mps_;
      const auto thousandths = static_cast<std::int32_t>(std::lround(1e3 * force_N / rated_N_));
      ASSERT_EQ(bench.write(0x6071, 0, static_cast<std::uint32_t>(thousandths) & 0xFFFF, 2), 0U);
      bench.run_ms(1);
      for (const Data& data : bench.all_with(0x080 + kNode)) emergencies.push_back(data);
    }
  }
  bool warns() { return (bench.read(0x6041, 0) & 0x80) != 0; }

  Bench bench;
  std::vector<Data> emergencies;

 private:
  double rated_N_ = 0.0;
  std::int32_t begin_ = 0;
  double last_m_ = 0.0;
  double velocity_mps_ = 0.0;
};

TEST(HuntingObjects, TellTheCauseAndTakeItBack) {
  HuntingBench hunts;
  Bench& bench = hunts.bench;
  EXPECT_EQ(bench.read(0x2202, 2), 0U);
  EXPECT_EQ(bench.read_real(0x2202, 6), 1.0F);
  hunts.run(1.8, true);
  EXPECT_EQ(bench.read(0x2202, 2), 1U) << "being tried";
  EXPECT_LT(bench.read_real(0x2202, 6), 1.0F);
  EXPECT_EQ(bench.read(0x2202, 8), 1U);
  hunts.run(10.0, false);
  EXPECT_EQ(bench.read(0x2202, 3), 4U) << "it hunts only when it is pushed";
  EXPECT_FALSE(hunts.warns());
  hunts.run(12.0, true);
  EXPECT_EQ(bench.read(0x2202, 2), 2U);
  EXPECT_EQ(bench.read(0x2202, 3), 1U);
  EXPECT_NEAR(bench.read_real(0x2202, 4), 12.0F, 1.5F);
  EXPECT_GT(bench.read_real(0x2202, 5), 2e-4F);
  EXPECT_LT(bench.read_real(0x2202, 5), 3e-3F);
  EXPECT_EQ(bench.read_real(0x2202, 6), 0.0F);
  EXPECT_EQ(bench.read_real(0x2202, 7), 1.0F);
  EXPECT_EQ(bench.read_real(0x2200, 4), 0.0F) << "the level in force";
  EXPECT_TRUE(hunts.warns());
  EXPECT_EQ(bench.read(0x1001, 0), 1U);
  EXPECT_EQ(bench.read(0x1003, 1), 0x9FF01U) << "of source 9";
  ASSERT_EQ(hunts.emergencies.size(), 1U);
  EXPECT_EQ(Bench::number(hunts.emergencies[0], 0, 2), 0xFF01U);
  EXPECT_EQ(Bench::number(hunts.emergencies[0], 4, 2), 1U) << "the friction";
  EXPECT_NEAR(Bench::number(hunts.emergencies[0], 6, 2), 12.0, 2.0) << "Hz";
  // Back, until it hunts again.
  EXPECT_EQ(bench.write(0x2202, 9, 2, 1), 0x06090031U);
  ASSERT_EQ(bench.write(0x2202, 9, 1, 1), 0U);
  hunts.run(0.3, false);
  EXPECT_EQ(bench.read(0x2202, 2), 0U);
  EXPECT_EQ(bench.read_real(0x2202, 6), 1.0F);
  EXPECT_FALSE(hunts.warns());
  EXPECT_EQ(bench.read(0x1001, 0), 0U);
}

TEST(HuntingObjects, CanBeSwitchedOff) {
  HuntingBench hunts(false);
  hunts.run(4.0, true);
  EXPECT_EQ(hunts.bench.read(0x2202, 8), 0U);
  EXPECT_EQ(hunts.bench.read_real(0x2202, 6), 1.0F);
}

}  // namespace
}  // namespace slipstack::can
