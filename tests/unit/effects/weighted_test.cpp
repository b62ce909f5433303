// SPDX-License-Identifier: Apache-2.0
// The shorter forms of gains x basis that the controller runs, against the bases that were fitted.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "firmware/effects/model.h"
#include "tests/unit/effects/effect_support.h"

namespace slipstack {
namespace {

using test::Draw;

/// Gains within the bounds of the first, of the size that an axis has.
template <class E, class Real>
std::array<Real, E::gain_count> random_gains(Draw& draw) {
  std::array<Real, E::gain_count> gains{};
  for (Real& gain : gains) {
    const double size = E::gains[0].acts == Acts::dry ? draw.log_uniform(1e2, 1e6) : draw.uniform(0.1, 0.9);
    gain = static_cast<Real>(E::gains[0].lower < 0.0F ? draw.sign() * size : size);
  }
  return gains;
}

/// What the short form may lose, for each unit of gain: rounding, or what the tables say of themselves.
template <class E>
constexpr double kLoss = 4e-7;
template <class R>
constexpr double kLoss<Stribeck<R>> = 4.9e-4;
template <class R>
constexpr double kLoss<FrictionalLag<R>> = 4.9e-4;
template <class R>
constexpr double kLoss<ForceRipple<R>> = 5e-4;
template <class R>
constexpr double kLoss<MotorConstantRipple<R>> = 5e-4;
template <class R>
constexpr double kLoss<QuadraticDrag<R>> = 1e-4;  // 6.5e-6 of the fastest motion's v^n
template <int N>
constexpr double kLoss<PreslidingHysteresis<float, N>> = 0.0;  // has a test of its own

TEST(Weighted, AgreesWithTheBasis) {
  int checked = 0;
  test::for_each_effect<float>([&]<class E>(std::type_identity<E>) {
    if constexpr (Weighted<E, float> && kLoss < E >> 0.0) {
      ++checked;
      double worst = 0.0;
      for (std::uint64_t seed = 0; seed < 20; ++seed) {
        Draw draw(seed);
        const auto shapes = test::as<float>(test::random_shapes<E>(draw));
        const auto gains = random_gains<E, float>(draw);
        E basis_form;
        E short_form;
        const Scales<float> scales{.tick_s = 1e-4F, .metres_per_displacement = 1e-7F};
        basis_form.prepare(shapes, scales);
        short_form.prepare(shapes, scales);
        if constexpr (PreparesGains<E, float>) short_form.prepare_weighted(gains);
        const auto motion = test::random_motion(seed, 500);
        basis_form.reset(test::on_target(motion[0]));
        short_form.reset(test::on_target(motion[0]));
        for (const Sample<double>& sample : motion) {
          std::array<float, E::gain_count> basis{};
          basis_form.basis(test::on_target(sample), basis);
          double sum = 0.0;
          double size = 0.0;
          for (std::size_t g = 0; g < basis.size(); ++g) {
            const double part = static_cast<double>(gains[g]) * static_cast<double>(basis[g]);
            sum += part;
            size += std::abs(static_cast<double>(gains[g]));
          }
          const float is = short_form.weighted(test::on_target(sample), gains);
          worst = std::max(worst, std::abs(static_cast<double>(is) - sum) / size);
        }
      }
      EXPECT_LT(worst, kLoss<E>) << E::text.id;
      EXPECT_GT(worst, 0.0) << E::text.id;
    }
  });
  EXPECT_GE(checked, 1);
}

// The packed hysteresis keeps stiffnesses to 16 bits of the largest one: each element's force is off by at
// most half such a bit times its stretch, whatever the motion.
TEST(Weighted, PackedHysteresisKeepsStiffnessToSixteenBits) {
  using Effect = PreslidingHysteresis<float>;
  double closest = 0.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Draw draw(seed + 200);
    std::array<double, kTargetElements> slip_m{};
    double total_m = 0.0;
    for (double& slip : slip_m) {
      slip = test::kResolution_m * std::round(draw.log_uniform(1.0, 1.6e4));
      total_m += slip;
    }
    std::array<float, kTargetElements> stiffness{};
    for (std::size_t i = 0; i < stiffness.size(); ++i) {
      stiffness[i] = static_cast<float>(draw.log_uniform(0.1, 2.0) / slip_m[i]);
    }
    const Scales<float> scales{.tick_s = 1e-4F, .metres_per_displacement = 1e-7F};
    Effect basis_form;
    Effect short_form;
    basis_form.prepare(test::as<float>(slip_m), scales);
    short_form.prepare(test::as<float>(slip_m), scales);
    short_form.prepare_weighted(stiffness);
    basis_form.reset({.displacement = 5});
    short_form.reset({.displacement = 5});
    const double half_bit =
        0.5 * static_cast<double>(*std::max_element(stiffness.begin(), stiffness.end())) / 32767.0;
    double level_N = 0.0;
    for (std::size_t i = 0; i < slip_m.size(); ++i) level_N += static_cast<double>(stiffness[i]) * slip_m[i];
    const double allowed_N = half_bit * total_m + 1e-6 * level_N;
    std::int32_t x = 5;
    for (int k = 0; k < 4000; ++k) {
      x += static_cast<std::int32_t>(draw.sign() * draw.log_uniform(1.0, 3e4));
      std::array<float, kTargetElements> basis{};
      basis_form.basis({.displacement = x}, basis);
      double sum_N = 0.0;
      for (std::size_t i = 0; i < basis.size(); ++i) {
        sum_N += static_cast<double>(stiffness[i]) * static_cast<double>(basis[i]);
      }
      const double error_N =
          std::abs(static_cast<double>(short_form.weighted({.displacement = x}, stiffness)) - sum_N);
      ASSERT_LE(error_N, allowed_N) << seed << ' ' << k;
      closest = std::max(closest, error_N / allowed_N);
    }
  }
  EXPECT_GT(closest, 0.1);
}

}  // namespace
}  // namespace slipstack
