// SPDX-License-Identifier: Apache-2.0
// Nothing drifts: after any number of ticks, the same reversals give the same forces, to the bit.
//
// 10^6 ticks here; with SLIPSTACK_LONG=1 in the environment 10^9, a day of a 10 kHz tick (some minutes).
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "firmware/friction/maxwell_slip.h"
#include "firmware/friction/memory_stack.h"
#include "firmware/friction/packed_maxwell_slip.h"
#include "tests/budget/motion.h"

namespace slipstack::test {
namespace {

constexpr std::array<std::int32_t, 10> kSlip = {1, 2, 3, 5, 8, 13, 21, 34, 55, 89};
constexpr std::array<float, 10> kStiffness = {.31F,  .57F,  .43F,  .29F,  .17F,
                                              .083F, .047F, .029F, .011F, .0037F};

std::uint64_t ticks_to_run() {
  const char* wish = std::getenv("SLIPSTACK_LONG");
  return wish != nullptr && std::strcmp(wish, "1") == 0 ? 1000000000ULL : 1000000ULL;
}

// Forces along a fixed course that begins with full traverses: they wipe out whatever was before.
template <class Model>
std::array<float, 40> course(Model& model, std::int32_t around) {
  constexpr std::int32_t kStroke = 10000;  // beyond every excursion of the random motion
  model.step(sum(around, kStroke));
  model.step(sum(around, -kStroke));
  std::array<float, 40> forces{};
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const std::int32_t amplitude = 120 - 3 * static_cast<std::int32_t>(i);
    forces[i] = model.step(sum(around, i % 2 == 0 ? amplitude : -amplitude));
  }
  return forces;
}

// `wander` moves the middle of the motion along the counter, around its end where the model allows.
template <class Model>
void expect_no_drift(Model& model, std::int32_t wander) {
  constexpr std::uint64_t kBetween = 100000;
  const std::uint64_t total = ticks_to_run();
  const std::array<float, 40> first = course(model, 0);
  std::int32_t around = 0;
  for (std::uint64_t tick = 0; tick < total; tick += kBetween) {
    around = sum(around, wander);
    budget::RandomMotion motion(static_cast<std::uint32_t>(tick / kBetween + 1), around);
    for (std::uint64_t i = 0; i < kBetween; ++i) model.step(motion.next());
    ASSERT_EQ(course(model, around), first) << "after " << tick + kBetween << " ticks";
  }
}

TEST(Drift, MaxwellSlip) {
  MaxwellSlip<10, float, std::int32_t> model;
  ASSERT_EQ(model.set_elements(kSlip, kStiffness), SetupStatus::kOk);
  expect_no_drift(model, 700000000);  // three times around 2^32 in the short run
}

TEST(Drift, PackedMaxwellSlip) {
  PackedMaxwellSlip<10> model;
  ASSERT_EQ(model.set_elements(kSlip, kStiffness), SetupStatus::kOk);
  expect_no_drift(model, 700000000);
}

TEST(Drift, MemoryStack) {
  MemoryStack<RationalCurve<float>, 64, std::int32_t> model({15.0F, 12.0F});
  expect_no_drift(model, 0);
}

}  // namespace
}  // namespace slipstack::test
