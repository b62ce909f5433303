// SPDX-License-Identifier: Apache-2.0
// The stop operators against another way to compute them.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/unit/effects/effect_support.h"

namespace slipstack {
namespace {

using test::Draw;

/// Stop operators summed up from steps: another way than the anchors of the firmware.
template <std::size_t N>
class SummedStops {
 public:
  explicit SummedStops(const std::array<double, N>& slip_m) : slip_m_(slip_m) {}
  void move(double step_m) {
    for (std::size_t i = 0; i < N; ++i) {
      stretch_m_[i] = std::min(slip_m_[i], std::max(-slip_m_[i], stretch_m_[i] + step_m));
    }
  }
  double operator[](std::size_t i) const { return stretch_m_[i]; }

 private:
  std::array<double, N> slip_m_;
  std::array<double, N> stretch_m_{};
};

TEST(PreslidingHysteresis, IsASetOfStopOperators) {
  using Effect = PreslidingHysteresis<double>;
  Draw draw(21);
  const auto slip_m = test::random_shapes<Effect>(draw);
  Effect effect;
  effect.prepare(slip_m, {.tick_s = test::kTick_s, .metres_per_displacement = 1.0});
  effect.reset({.displacement = 0.2});
  SummedStops<kIdentifiedElements> exact(slip_m);
  double x_m = 0.2;
  std::array<double, kIdentifiedElements> out{};
  for (int i = 0; i < 50'000; ++i) {
    const double before = x_m;
    x_m += draw.sign() * draw.log_uniform(1e-9, 1e-3);
    effect.basis({.displacement = x_m}, out);
    exact.move(x_m - before);
    for (std::size_t k = 0; k < out.size(); ++k) ASSERT_NEAR(out[k], exact[k], 1e-12) << i;
  }
}

TEST(PreslidingHysteresis, CountsAreExactOnTheTarget) {
  using Effect = PreslidingHysteresis<float>;
  Draw draw(22);
  const auto slip_m = test::random_shapes<Effect>(draw);
  Effect effect;
  effect.prepare(test::as<float>(slip_m),
                 {.tick_s = 1e-4F, .metres_per_displacement = static_cast<float>(test::kResolution_m)});
  std::int32_t x = 2'000'000'000;  // wraps around on the way
  effect.reset({.displacement = x});
  SummedStops<kTargetElements> exact(slip_m);
  std::array<float, kTargetElements> out{};
  for (int i = 0; i < 50'000; ++i) {
    const auto step =
        static_cast<std::int32_t>(draw.sign() * draw.log_uniform(1.0, 1e6)) + (i < 400 ? 500'000 : 0);
    x = static_cast<std::int32_t>(static_cast<std::uint32_t>(x) + static_cast<std::uint32_t>(step));
    effect.basis({.displacement = x}, out);
    exact.move(step * test::kResolution_m);
    for (std::size_t k = 0; k < out.size(); ++k) {
      ASSERT_NEAR(static_cast<double>(out[k]), exact[k], 2e-7 * slip_m[k]) << i;
    }
  }
}

TEST(PreslidingHysteresis, UnusedElementsAreZero) {
  std::array<float, kTargetElements> slip_m{};
  slip_m[3] = 1e-6F;
  PreslidingHysteresis<float> effect;
  effect.prepare(slip_m, {.tick_s = 1e-4F, .metres_per_displacement = 1e-7F});
  effect.reset({});
  std::array<float, kTargetElements> out{};
  effect.basis({.displacement = 1000}, out);
  for (std::size_t k = 0; k < out.size(); ++k) EXPECT_FLOAT_EQ(out[k], k == 3 ? 1e-6F : 0.0F);
}

// The finest encoders count in tens of picometres; the upper bound of a slip distance is then beyond any
// count, and the others must be taken all the same.
TEST(PreslidingHysteresis, TakesEverySlipDistanceOfItsBounds) {
  for (const float resolution_m : {1e-5F, 1e-9F, 4e-10F, 2e-11F}) {
    std::array<float, kTargetElements> slip_m{};
    slip_m[0] = 1e-6F;
    slip_m[1] = PreslidingHysteresis<float>::shapes[1].upper;
    PreslidingHysteresis<float> effect;
    effect.prepare(slip_m, {.tick_s = 1e-4F, .metres_per_displacement = resolution_m});
    effect.reset({});
    std::array<float, kTargetElements> out{};
    const std::int32_t travel = 1 << 20;
    effect.basis({.displacement = travel}, out);
    const float travel_m = static_cast<float>(travel) * resolution_m;
    const float rounded_m = std::round(1e-6F / resolution_m) * resolution_m;
    EXPECT_NEAR(out[0], std::min(rounded_m, travel_m), 1e-5F * rounded_m) << resolution_m;
    EXPECT_NEAR(out[1], std::min(travel_m, 1.0F), 1e-5F * travel_m) << resolution_m;
  }
}

}  // namespace
}  // namespace slipstack
