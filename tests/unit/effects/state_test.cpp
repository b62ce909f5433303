// SPDX-License-Identifier: Apache-2.0
// Set-up and reset of every effect: neither may leave traces.
#include <gtest/gtest.h>

#include <vector>

#include "tests/unit/effects/effect_support.h"

namespace slipstack {
namespace {

using test::Draw;

template <class Real>
std::vector<Sample<Real>> motion(std::uint64_t seed, std::size_t count);
template <>
std::vector<Sample<double>> motion<double>(std::uint64_t seed, std::size_t count) {
  return test::random_motion(seed, count);
}
template <>
std::vector<Sample<float>> motion<float>(std::uint64_t seed, std::size_t count) {
  std::vector<Sample<float>> samples;
  for (const Sample<double>& sample : test::random_motion(seed, count)) {
    samples.push_back(test::on_target(sample));
  }
  return samples;
}

template <class Real>
class States : public testing::Test {
 protected:
  static constexpr Scales<Real> kScales{
      .tick_s = static_cast<Real>(test::kTick_s),
      .metres_per_displacement =
          std::is_same_v<Real, float> ? static_cast<Real>(test::kResolution_m) : Real(1)};
};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(States, Precisions);

TYPED_TEST(States, ResetForgetsTheMotion) {
  using Real = TypeParam;
  const auto before = motion<Real>(1, 2000);
  const auto after = motion<Real>(2, 2000);
  test::for_each_effect<Real>([&]<class E>(std::type_identity<E>) {
    Draw draw(5);
    const auto shapes = test::as<Real>(test::random_shapes<E>(draw));
    E used;
    used.prepare(shapes, TestFixture::kScales);
    used.reset(before[0]);
    test::run(used, before);
    used.reset(after[0]);
    E fresh;
    fresh.prepare(shapes, TestFixture::kScales);
    fresh.reset(after[0]);
    EXPECT_EQ(test::run(used, after), test::run(fresh, after)) << E::text.id;
  });
}

// Parameters are sent again while the axis moves: the same ones must change nothing.
TYPED_TEST(States, PreparingTwiceIsPreparingOnce) {
  using Real = TypeParam;
  const auto samples = motion<Real>(3, 4000);
  const std::vector<Sample<Real>> first(samples.begin(), samples.begin() + 2000);
  const std::vector<Sample<Real>> second(samples.begin() + 2000, samples.end());
  test::for_each_effect<Real>([&]<class E>(std::type_identity<E>) {
    Draw draw(6);
    const auto shapes = test::as<Real>(test::random_shapes<E>(draw));
    E once;
    E twice;
    once.prepare(shapes, TestFixture::kScales);
    twice.prepare(shapes, TestFixture::kScales);
    twice.prepare(shapes, TestFixture::kScales);
    once.reset(samples[0]);
    twice.reset(samples[0]);
    EXPECT_EQ(test::run(once, first), test::run(twice, first)) << E::text.id;
    twice.prepare(shapes, TestFixture::kScales);
    EXPECT_EQ(test::run(once, second), test::run(twice, second)) << E::text.id;
  });
}

// Other parameters take over entirely: what was prepared before has no say.
TYPED_TEST(States, PreparingAgainReplacesTheParameters) {
  using Real = TypeParam;
  const auto samples = motion<Real>(4, 2000);
  test::for_each_effect<Real>([&]<class E>(std::type_identity<E>) {
    Draw draw(7);
    const auto old_shapes = test::as<Real>(test::random_shapes<E>(draw));
    const auto new_shapes = test::as<Real>(test::random_shapes<E>(draw));
    E changed;
    changed.prepare(old_shapes, TestFixture::kScales);
    changed.reset(samples[0]);
    changed.prepare(new_shapes, TestFixture::kScales);
    changed.reset(samples[0]);
    E fresh;
    fresh.prepare(new_shapes, TestFixture::kScales);
    fresh.reset(samples[0]);
    EXPECT_EQ(test::run(changed, samples), test::run(fresh, samples)) << E::text.id;
  });
}

// A basis is a function of motion, bounded like it: nothing grows in a long run, nothing is NaN.
TYPED_TEST(States, BasesStayFinite) {
  using Real = TypeParam;
  const auto samples = motion<Real>(8, 20'000);
  test::for_each_effect<Real>([&]<class E>(std::type_identity<E>) {
    Draw draw(9);
    E effect;
    effect.prepare(test::as<Real>(test::random_shapes<E>(draw)), TestFixture::kScales);
    effect.reset(samples[0]);
    double largest = 0.0;
    for (const auto& row : test::run(effect, samples)) {
      for (const Real value : row) {
        ASSERT_TRUE(std::isfinite(value)) << E::text.id;
        largest = std::max(largest, std::abs(static_cast<double>(value)));
      }
    }
    EXPECT_LT(largest, 1000.0) << E::text.id;
    EXPECT_TRUE(largest > 0.0 || E::gain_count == 0) << E::text.id;
  });
}

}  // namespace
}  // namespace slipstack
