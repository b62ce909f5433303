// SPDX-License-Identifier: Apache-2.0
// Energy: the area of a loop against the closed form, and that no motion ever takes out more than was put in.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>

#include "firmware/friction/maxwell_slip.h"
#include "firmware/friction/memory_stack.h"
#include "firmware/friction/packed_maxwell_slip.h"
#include "tests/property/friction/motion.h"
#include "tests/property/friction/oracles.h"

namespace slipstack::test {
namespace {

// Area of the loop between -A and A, by trapezoids over the model's own forces, once it has closed.
template <class Model>
double loop_area(Model& model, double amplitude) {
  constexpr int kSteps = 20000;
  model.step(amplitude);
  double area = 0;
  double x = amplitude;
  double force = model.step(amplitude);
  for (int i = 1; i <= 2 * kSteps; ++i) {
    const double next = amplitude * (i <= kSteps ? 1 - 2.0 * i / kSteps : -1 + 2.0 * (i - kSteps) / kSteps);
    const double next_force = model.step(next);
    area += 0.5 * (force + next_force) * (next - x);
    x = next;
    force = next_force;
  }
  return area;
}

// Integral of f from 0 to b by Simpson's rule.
double simpson(const std::function<double(double)>& f, double b) {
  constexpr int kIntervals = 20000;
  const double h = b / kIntervals;
  double total = f(0) + f(b);
  for (int i = 1; i < kIntervals; ++i) total += (i % 2 == 1 ? 4 : 2) * f(i * h);
  return total * h / 3;
}

// Al-Bender and Symens, Wear 258 (2005): area = 8 int_0^A y dx - 4 A y(A).
TEST(LoopArea, IsThatOfTheClosedForm) {
  for (const double delta : {0.3, 2.0, 12.0}) {
    for (const double amplitude : {0.01, 0.5, 2.0, 40.0}) {
      constexpr double kHeight = 2.0;
      MemoryStack<RationalCurve<double>, 16, double> model({kHeight, delta});
      const auto y = [=](double x) { return kHeight * (1 - std::pow(delta / (x + delta), 2)); };
      const double area = loop_area(model, amplitude);
      const double closed = 8 * simpson(y, amplitude) - 4 * amplitude * y(amplitude);
      EXPECT_NEAR(area / closed, 1.0, 1e-5) << "delta " << delta << " A " << amplitude;
      // The same paper's equivalent damping ratio for this curve: (2/pi) A / (A + 2 delta).
      const double damping = area / (2 * std::numbers::pi * amplitude * y(amplitude));
      const double expected = 2 / std::numbers::pi * amplitude / (amplitude + 2 * delta);
      EXPECT_NEAR(damping / expected, 1.0, 1e-5) << "delta " << delta << " A " << amplitude;
    }
  }
}

TEST(LoopArea, HoldsForTheOtherCurvesAndForMaxwellSlip) {
  MemoryStack<ExponentialCurve<double>, 16, double> exponential({4.75, 2.0});
  const auto y = [](double x) { return -4.75 * std::expm1(-x / 2.0); };
  EXPECT_NEAR(loop_area(exponential, 5.0) / (8 * simpson(y, 5.0) - 4 * 5.0 * y(5.0)), 1.0, 1e-6);

  // One element dissipates 4 k Delta (A - Delta) in a loop.
  constexpr std::array<double, 3> kSlip = {0.5, 1.5, 9.0};
  constexpr std::array<double, 3> kStiffness = {2.0, 0.7, 0.3};
  MaxwellSlip<5, double> elements;
  ASSERT_EQ(elements.set_elements(kSlip, kStiffness), SetupStatus::kOk);
  double expected = 0;
  for (std::size_t i = 0; i < 2; ++i) expected += 4 * kStiffness[i] * kSlip[i] * (5.0 - kSlip[i]);
  EXPECT_NEAR(loop_area(elements, 5.0) / expected, 1.0, 1e-6);
}

// Every single step: what is put in covers what is stored.
TEST(Energy, IsNeverCreatedByMaxwellSlip) {
  constexpr std::array<std::int32_t, 6> kSlip = {1, 2, 5, 13, 40, 90};
  constexpr std::array<double, 6> kStiffness = {9, 5, 4, 3, 2, 1};  // integers: the energies are exact
  MaxwellSlip<8, double, std::int32_t> elements;
  ASSERT_EQ(elements.set_elements(kSlip, kStiffness), SetupStatus::kOk);
  NestedMotion motion(7, 100);
  std::int32_t x = 0;
  double dissipated = 0;
  for (int i = 0; i < 300000; ++i) {
    const double stored = elements.stored_energy();
    const std::int32_t next = motion.next();
    const double work = elements.step(next) * (next - x);
    const double lost = work - (elements.stored_energy() - stored);
    ASSERT_GE(lost, 0.0) << "step " << i;
    dissipated += lost;
    x = next;
  }
  EXPECT_GT(dissipated, 0.0);
}

// From rest, unloaded: the work put in is never negative, at no time, with overflow or without. `slack`
// allows for the rounding of a force held in float.
template <class Model>
void expect_passive(Model& model, std::uint64_t seed, std::int32_t range, double slack) {
  NestedMotion motion(seed, range);
  double work = 0;
  double lowest = 0;
  std::int32_t x = 0;
  for (int i = 0; i < 200000; ++i) {
    const std::int32_t next = motion.next();
    work += static_cast<double>(model.step(next)) * (next - x);
    x = next;
    lowest = std::min(lowest, work);
    if (work > 1e4) work = 0, model.reset(x);  // again from the unloaded state, where a deficit can show
  }
  EXPECT_GE(lowest, -slack) << "seed " << seed << " range " << range;
}

TEST(Energy, IsNeverCreatedByTheMemoryStack) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    for (const std::int32_t range : {3, 20, 100}) {
      MemoryStack<RationalCurve<double>, 256, std::int32_t> deep({15.0, 12.0});
      MemoryStack<RationalCurve<double>, 4, std::int32_t> shallow({15.0, 12.0});
      MemoryStack<ExponentialCurve<float>, 6, std::int32_t> in_float({15.0F, 9.0F});
      expect_passive(deep, seed, range, 0.0);
      expect_passive(shallow, seed, range, 0.0);
      expect_passive(in_float, seed, range, 1e-4);
    }
  }
}

TEST(Energy, IsNeverCreatedByThePackedForm) {
  constexpr std::array<std::int32_t, 10> kSlip = {1, 2, 3, 5, 8, 13, 21, 34, 55, 89};
  constexpr std::array<float, 10> kStiffness = {.31F,  .57F,  .43F,  .29F,  .17F,
                                                .083F, .047F, .029F, .011F, .0037F};
  PackedMaxwellSlip<10> elements;
  ASSERT_EQ(elements.set_elements(kSlip, kStiffness), SetupStatus::kOk);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    elements.reset(0);
    expect_passive(elements, seed, 100, 0.0);
  }
}

}  // namespace
}  // namespace slipstack::test
