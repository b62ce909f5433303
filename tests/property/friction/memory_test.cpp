// SPDX-License-Identifier: Apache-2.0
// What Masing hysteresis with non-local memory must do: closed loops return, minor loops are congruent, the
// loop is odd, the speed does not matter, and the future depends on more than position and force.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "firmware/friction/maxwell_slip.h"
#include "firmware/friction/memory_stack.h"
#include "tests/property/friction/motion.h"
#include "tests/property/friction/oracles.h"

namespace slipstack::test {
namespace {

using Stack = MemoryStack<RationalCurve<double>, 256, std::int32_t>;
using FloatStack = MemoryStack<ExponentialCurve<float>, 256, std::int32_t>;
using Elements = MaxwellSlip<10, float, std::int32_t>;

constexpr RationalCurve<double> kCurve{15.0, 12.0};

Elements make_elements() {
  constexpr std::array<std::int32_t, 10> kSlip = {1, 2, 3, 5, 8, 13, 21, 34, 55, 89};
  constexpr std::array<float, 10> kStiffness = {.31F,  .57F,  .43F,  .29F,  .17F,
                                                .083F, .047F, .029F, .011F, .0037F};
  Elements elements;
  EXPECT_EQ(elements.set_elements(kSlip, kStiffness), SetupStatus::kOk);
  return elements;
}

// A random history on range 100 whose last motion went from `low` up to `high`, at least 12 counts.
template <class Model>
struct History {
  Model model;
  std::int32_t low = 0;
  std::int32_t high = 0;
};

template <class Model>
History<Model> random_history(Model model, std::uint64_t seed) {
  NestedMotion motion(seed, 100);
  for (int i = motion.between(0, 300); i > 0; --i) model.step(motion.next());
  const std::int32_t low = motion.between(-100, 80);
  const std::int32_t high = motion.between(low + 12, 100);
  model.step(low);
  model.step(high);
  return {model, low, high};
}

// Wanders strictly between low and high and comes back to high: loops within loops, all closed at the end.
template <class Model>
float excursion(Model& model, std::int32_t low, std::int32_t high, std::uint64_t seed) {
  NestedMotion motion(seed, (high - low) / 2 - 1);
  const std::int32_t center = (low + high) / 2;
  for (int i = 0; i < 100; ++i) model.step(center + motion.next());
  return static_cast<float>(model.step(high));
}

// After the excursion nothing may tell the model from a copy that stayed: same force, same future, to the
// bit.
template <class Model>
void expect_closed_loops_return_exactly(const Model& fresh) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    auto [model, low, high] = random_history(fresh, seed);
    Model stayed = model;
    const auto force = stayed.step(high);
    ASSERT_EQ(excursion(model, low, high, seed + 999), static_cast<float>(force)) << seed;
    ASSERT_EQ(model.step(high), force) << seed;
    NestedMotion future(seed + 5000, 120);
    for (int i = 0; i < 200; ++i) {
      const std::int32_t x = future.next();
      ASSERT_EQ(model.step(x), stayed.step(x)) << "seed " << seed << " step " << i;
    }
  }
}

TEST(ClosedLoops, ReturnExactly) {
  expect_closed_loops_return_exactly(Stack(kCurve));
  expect_closed_loops_return_exactly(FloatStack({4.75F, 20.0F}));
  expect_closed_loops_return_exactly(make_elements());
}

// A loop between fixed ends has one shape, whatever happened before it.
template <class Model>
std::vector<double> loop_shape(Model& model, std::int32_t low, std::int32_t high) {
  std::vector<double> shape;
  model.step(high);
  model.step(low);
  const double bottom = static_cast<double>(model.step(low));
  for (std::int32_t x = low; x <= high; ++x) shape.push_back(static_cast<double>(model.step(x)) - bottom);
  for (std::int32_t x = high; x >= low; --x) shape.push_back(static_cast<double>(model.step(x)) - bottom);
  return shape;
}

template <class Model>
void expect_congruent_loops(const Model& fresh, double tolerance_N) {
  double greatest_offset = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    auto first = random_history(fresh, seed).model;
    auto second = random_history(fresh, seed + 12345).model;
    NestedMotion random(seed, 1);
    const std::int32_t low = random.between(-60, 20);
    const std::int32_t high = random.between(low + 5, 60);
    const std::vector<double> a = loop_shape(first, low, high);
    const std::vector<double> b = loop_shape(second, low, high);
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], tolerance_N) << seed << " at " << i;
    greatest_offset =
        std::max(greatest_offset, std::abs(static_cast<double>(first.step(low) - second.step(low))));
  }
  EXPECT_GT(greatest_offset, 1.0);  // the loops did stand at different forces
}

TEST(MinorLoops, AreCongruent) {
  expect_congruent_loops(Stack(kCurve), 1e-11);
  expect_congruent_loops(FloatStack({4.75F, 20.0F}), 2e-5);
  expect_congruent_loops(make_elements(), 2e-5);
}

TEST(Hysteresis, IsOdd) {
  Stack stack(kCurve);
  Stack mirrored_stack(kCurve);
  MemoryStack<RationalCurve<double>, 4, std::int32_t> small(kCurve);
  MemoryStack<RationalCurve<double>, 4, std::int32_t> mirrored_small(kCurve);
  Elements elements = make_elements();
  Elements mirrored_elements = make_elements();
  NestedMotion motion(42, 100);
  for (int i = 0; i < 100000; ++i) {
    const std::int32_t x = motion.next();
    ASSERT_EQ(stack.step(x), -mirrored_stack.step(-x));
    ASSERT_EQ(small.step(x), -mirrored_small.step(-x));
    ASSERT_EQ(elements.step(x), -mirrored_elements.step(-x));
    ASSERT_EQ(stack.depth(), mirrored_stack.depth());
    ASSERT_EQ(small.overflow_count(), mirrored_small.overflow_count());
  }
}

TEST(Hysteresis, DoesNotDependOnSpeedOrRest) {
  Stack at_once(kCurve);
  Stack slowly(kCurve);
  Elements elements_at_once = make_elements();
  Elements elements_slowly = make_elements();
  NestedMotion motion(43, 100);
  std::int32_t position = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::int32_t x = motion.next();
    const std::int32_t by = x > position ? 1 : -1;
    for (; position != x; position += by) {
      slowly.step(position);
      elements_slowly.step(position);
      if (position % 3 == 0) slowly.step(position);
    }
    ASSERT_EQ(slowly.step(x), at_once.step(x));
    ASSERT_EQ(elements_slowly.step(x), elements_at_once.step(x));
  }
}

TEST(Hysteresis, DoesNotDependOnWhereTheCountingBegins) {
  constexpr std::int32_t kOffset = 2147483600;  // the positions wrap around
  Stack stack(kCurve);
  Stack elsewhere(kCurve);
  Elements elements = make_elements();
  Elements elements_elsewhere = make_elements();
  elsewhere.reset(kOffset);
  elements_elsewhere.reset(kOffset);
  NestedMotion motion(44, 100);
  for (int i = 0; i < 20000; ++i) {
    const std::int32_t x = motion.next();
    const std::int32_t there = sum(x, kOffset);
    ASSERT_EQ(stack.step(x), elsewhere.step(there));
    ASSERT_EQ(elements.step(x), elements_elsewhere.step(there));
  }
}

// The same position and the same force, reached with different memory, lead to different futures.
TEST(Hysteresis, RemembersMoreThanPositionAndForce) {
  using Metres = MemoryStack<RationalCurve<double>, 16, double>;
  Metres plain({1.0, 1.0});
  const double force = plain.step(0.5);
  // Up to 3, down to `low`, up to 0.5: find the `low` that gives the same force there.
  const auto detour = [](double low) {
    Metres model({1.0, 1.0});
    model.step(3.0);
    model.step(low);
    model.step(0.5);
    return model;
  };
  double below = -3.0;
  double above = 0.5;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (below + above);
    (detour(middle).force_N() > force ? below : above) = middle;
  }
  Metres remembered = detour(above);
  ASSERT_NEAR(remembered.force_N(), force, 1e-12);
  EXPECT_GT(std::abs(remembered.step(1.5) - plain.step(1.5)), 0.01);
}

}  // namespace
}  // namespace slipstack::test
