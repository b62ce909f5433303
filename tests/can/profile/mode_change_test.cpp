// SPDX-License-Identifier: Apache-2.0
// From every mode into every other while the axis moves: the reference keeps its limits in every tick, the
// force does not jump, the axis comes to rest where nothing is commanded, and follows what is.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

struct NamedMode {
  std::uint8_t number;
  const char* name;
};
constexpr std::array kModes = {NamedMode{1, "pp"},  NamedMode{3, "pv"},  NamedMode{6, "hm"},
                               NamedMode{8, "csp"}, NamedMode{9, "csv"}, NamedMode{10, "cst"}};

class ModeChange : public ::testing::TestWithParam<std::tuple<NamedMode, NamedMode>> {
 protected:
  ModeChange() {
    EXPECT_EQ(bench_.write(0x2012, 1, 1, 1), 0U);
    bench_.configure();
    EXPECT_EQ(bench_.write(0x60C2, 1, 2, 1), 0U);
    EXPECT_EQ(bench_.write(0x6099, 2, 150000, 4), 0U);
    EXPECT_EQ(bench_.write(0x6098, 0, 33, 1), 0U);  // an index that never comes
    EXPECT_EQ(bench_.write(0x6081, 0, 150000, 4), 0U);
    home_ = bench_.read_signed(0x6064, 0);
    bench_.nmt(0x01);
    resolution_m_ = static_cast<double>(axis().encoder_resolution_m);
  }
  Controller& controller() { return bench_.loop->controller(); }
  const AxisParameters& axis() { return controller().parameters().axis; }

  // Ticks, the main loop after each, SYNC every 2 ms with what `send` writes before; with an eye on the
  // reference and on the current.
  template <class Send>
  void run_ms(int milliseconds, const Send& send) {
    for (int tick = 0; tick < 10 * milliseconds; ++tick) {
      if (ticks_++ % 20 == 0) {
        send();
        bench_.send(0x080, {});
      }
      bench_.loop->step();
      bench_.now_us += 100;
      bench_.poll();
      while (bench_.next()) {
      }
      look();
    }
  }
  void look() {
    const ReferenceGenerator& reference = controller().reference();
    const auto fraction = static_cast<double>(reference.fraction());
    const double step =
        (static_cast<double>(difference(reference.counts(), last_)) + fraction - last_fraction_) *
        resolution_m_ / loop::kTick_s;
    const float current_A = bench_.loop->motor.set_point_A;
    if (watched_ > 2) {
      velocity_ = std::max(velocity_, std::abs(step));
      acceleration_ = std::max(acceleration_, std::abs(step - last_step_) / loop::kTick_s);
      current_step_A_ = std::max(current_step_A_, std::abs(current_A - last_A_));
    }
    ++watched_;
    last_ = reference.counts();
    last_fraction_ = fraction;
    last_step_ = step;
    last_A_ = current_A;
  }

  // What the master sends in a period of this mode, so that the axis moves towards lower counts at 0.15 m/s.
  void command(std::uint8_t mode) {
    switch (mode) {
      case 8:
        place_ -= std::min(300.0, 4.0 * ++commands_);
        bench_.write(0x607A, 0, static_cast<std::uint32_t>(static_cast<std::int32_t>(place_)), 4);
        break;
      case 3:
      case 9:
        bench_.write(0x60FF, 0, static_cast<std::uint32_t>(-std::min(150000, 2000 * ++commands_)), 4);
        break;
      case 10:
        bench_.write(0x6071, 0, bench_.loop->plant.velocity_mps() > -0.15 ? 0xFF80U : 0U, 2);
        break;
      default:
        break;
    }
  }
  void begin(std::uint8_t mode) {
    commands_ = 0;
    place_ = static_cast<double>(bench_.read_signed(0x6064, 0));
    if (mode == 1) {
      bench_.write(0x607A, 0, static_cast<std::uint32_t>(bench_.read_signed(0x6064, 0) - 160000), 4);
      bench_.write(0x6040, 0, 0x1F, 2);
    }
    if (mode == 6) bench_.write(0x6040, 0, 0x1F, 2);
  }
  double axis_mps() const { return bench_.loop->plant.velocity_mps(); }

  Bench bench_;
  std::int32_t home_ = 0;
  double resolution_m_ = 0.0;
  int ticks_ = 0;
  int watched_ = 0;
  int commands_ = 0;
  double place_ = 0.0;
  std::int32_t last_ = 0;
  double last_fraction_ = 0.0, last_step_ = 0.0;
  double velocity_ = 0.0, acceleration_ = 0.0;
  float last_A_ = 0.0F, current_step_A_ = 0.0F;
};

TEST_P(ModeChange, InMotionIsWithoutAStep) {
  const auto& [from, to] = GetParam();
  ASSERT_EQ(bench_.write(0x2403, 0, 0, 2), 0U);
  bench_.enable(from.number);
  run_ms(40, [] {});
  begin(from.number);
  run_ms(400, [this, from = from] { command(from.number); });
  ASSERT_LT(axis_mps(), -0.1) << "it moves";
  const float steady_A = current_step_A_;
  watched_ = 0;
  velocity_ = acceleration_ = 0.0;
  current_step_A_ = 0.0F;
  ASSERT_EQ(bench_.write(0x6060, 0, to.number, 1), 0U);
  ASSERT_EQ(bench_.write(0x6071, 0, 0, 2), 0U);
  bench_.write(0x6040, 0, 0x0F, 2);
  if (to.number != from.number || to.number == 6) begin(to.number);
  if (to.number == 10) {
    // No force: the axis coasts.
    run_ms(100, [] {});
  } else {
    run_ms(600, [this, to = to] { command(to.number); });
    EXPECT_LT(axis_mps(), -0.1) << "it moves again";
  }
  std::printf("%3s to %3s: %.3f m/s, %.2f m/s2, %.3f A a tick (steady %.3f)\n", from.name, to.name, velocity_,
              acceleration_, static_cast<double>(current_step_A_), static_cast<double>(steady_A));
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
  EXPECT_LE(velocity_, 1.001 * static_cast<double>(axis().velocity_limit_mps));
  if (from.number != 10 && to.number != 10) {
    const float largest = std::max(axis().acceleration_limit_mps2, axis().quick_stop_mps2);
    EXPECT_LE(acceleration_, 1.001 * static_cast<double>(largest) + 0.01);
  }
  // A step of the acceleration by its limit, 5 m/s2 and 35 kg, would be 3 A, cut to 2 A a tick. Over a period
  // of 20 ticks, from one limit to the other, it is a seventh of that.
  EXPECT_LE(current_step_A_, 0.3F);
}

INSTANTIATE_TEST_SUITE_P(Ordered, ModeChange,
                         ::testing::Combine(::testing::ValuesIn(kModes), ::testing::ValuesIn(kModes)),
                         [](const auto& pair) {
                           return std::string(std::get<0>(pair.param).name) + "_to_" +
                                  std::get<1>(pair.param).name;
                         });

}  // namespace
}  // namespace slipstack::can
