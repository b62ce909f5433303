// SPDX-License-Identifier: Apache-2.0
// Every fault at random against an axis with end stops, a random master, and what must hold in every tick.
#include <gtest/gtest.h>

#include <cstdlib>
#include <deque>
#include <iostream>
#include <sstream>

#include "tests/bench/soak/axis.h"
#include "tests/bench/soak/faults.h"
#include "tests/bench/soak/invariants.h"
#include "tests/bench/soak/operator.h"

namespace slipstack::soak {
namespace {

constexpr std::int64_t kTicksOfAnAxis = 100'000;

std::int64_t from_environment(const char* name, std::int64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoll(text, nullptr, 10);
}

Build draw_build(sim::Rng& rng) {
  Build build;
  build.speed_mps = rng.pick({0.3, 2.0, 2.0, 2.0});
  build.absolute_encoder = rng.chance(0.6);
  build.brake = rng.chance(0.8);
  build.brake_release_ms = rng.pick({0U, 20U});
  build.quick_stop_option = rng.pick({0U, 1U, 2U, 2U, 5U, 6U});
  build.shutdown_option = rng.pick({0U, 1U});
  build.disable_option = rng.pick({0U, 1U});
  build.halt_option = rng.pick({1U, 2U});
  build.fault_option = rng.pick({0U, 1U, 2U, 2U});
  return build;
}

/// Sums over all axes.
struct Sums {
  std::array<std::uint32_t, Faults::kKinds> begun{};
  std::array<std::uint32_t, kFaultCount> latched{};
  std::array<std::uint32_t, 3> contacts{};
  std::array<double, 3> largest_J{};
  std::int64_t ticks = 0;
  std::int64_t driven = 0;
  double travelled_m = 0.0;
  std::int64_t violations = 0;
};

/// One axis, `seed`: built, used and broken as its random numbers say. What was wrong, and what was before.
std::string live(std::uint64_t seed, std::int64_t ticks, Sums& sums) {
  sim::Rng rng(seed, "soak");
  SoakAxis axis(draw_build(rng));
  Faults faults(rng, rng.log_uniform(0.05, 5.0));
  Operator master(axis, rng);
  Invariants invariants(axis, faults, master);
  std::deque<std::string> story;
  const auto tell = [&](std::int64_t tick, const std::string& what) {
    std::ostringstream line;
    line << tick << ": " << what << ", state " << static_cast<int>(axis.controller().state().state())
         << ", at " << axis.position_m() << " m, " << axis.velocity_mps() << " m/s";
    story.push_back(line.str());
    if (story.size() > 40) story.pop_front();
  };
  std::string wrong;
  DriveState before = DriveState::kNotReadyToSwitchOn;
  std::int64_t tick = 0;
  for (; tick < ticks && wrong.empty(); ++tick) {
    const Faults::Kind kind = faults.step();
    if (kind != Faults::kKinds) tell(tick, Faults::kNames[kind]);
    master.step(faults.bus, tick);
    if (!master.last_wish.empty()) tell(tick, "master: " + master.last_wish);
    master.last_wish.clear();
    axis.tick(faults.broken, rng, rng.chance(0.5));
    wrong = invariants.check(tick);
    if (axis.controller().state().state() != before) {
      before = axis.controller().state().state();
      tell(tick, "state");
    }
  }
  sums.ticks += tick;
  sums.driven += invariants.driven_ticks;
  sums.travelled_m += invariants.travelled_m;
  for (std::size_t i = 0; i < Faults::kKinds; ++i) sums.begun[i] += faults.begun[i];
  for (std::size_t i = 0; i < kFaultCount; ++i) sums.latched[i] += invariants.latched[i];
  for (std::size_t i = 0; i < 3; ++i) {
    sums.contacts[i] += invariants.contacts[i];
    sums.largest_J[i] = std::max(sums.largest_J[i], invariants.largest_J[i]);
  }
  if (wrong.empty()) return wrong;
  ++sums.violations;
  tell(tick, "last fault " + std::to_string(static_cast<int>(axis.controller().state().faults().latched())));
  std::ostringstream text;
  const Build& build = axis.build();
  text << "seed " << seed << ", tick " << tick - 1 << ": " << wrong << "\n  " << build.speed_mps << " m/s, "
       << (build.absolute_encoder ? "absolute" : "incremental") << (build.brake ? ", brake" : ", no brake")
       << ", options " << build.quick_stop_option << build.shutdown_option << build.disable_option
       << build.halt_option << build.fault_option << ", mode " << int{master.mode()} << "\n";
  for (const std::string& line : story) text << "  " << line << "\n";
  return text.str();
}

void print(const Sums& sums) {
  std::cout << sums.ticks << " ticks, " << sums.driven << " driven, " << sums.travelled_m << " m\nbegun:";
  for (std::size_t i = 0; i < Faults::kKinds; ++i)
    std::cout << "  " << Faults::kNames[i] << " " << sums.begun[i];
  std::cout << "\nlatched:";
  for (std::size_t i = 1; i < kFaultCount; ++i)
    std::cout << "  " << std::hex << error_code(static_cast<Fault>(i)) << std::dec << " " << sums.latched[i];
  std::cout << "\ninto the end stops: guarded " << sums.contacts[0] << " times, " << sums.largest_J[0]
            << " J; brake only " << sums.contacts[1] << ", " << sums.largest_J[1] << " J; unguarded "
            << sums.contacts[2] << ", " << sums.largest_J[2] << " J\n";
}

TEST(Soak, HoldsWhateverFails) {
  const std::int64_t ticks = from_environment("SLIPSTACK_SOAK_TICKS", 3'000'000);
  const auto first = static_cast<std::uint64_t>(from_environment("SLIPSTACK_SOAK_SEED", 1));
  const std::int64_t most = from_environment("SLIPSTACK_SOAK_VIOLATIONS", 3);
  Sums sums;
  std::string wrong;
  for (std::uint64_t seed = first; sums.ticks < ticks && sums.violations < most; ++seed) {
    wrong += live(seed, kTicksOfAnAxis, sums);
    ASSERT_FALSE(::testing::Test::HasFailure()) << "the axis cannot be set up";
  }
  print(sums);
  EXPECT_EQ(wrong, "");
  // It was used and broken: what the figures above say of 3 10^6 ticks.
  if (ticks < 1'000'000) return;
  const auto least = static_cast<std::uint32_t>(ticks / 600'000);
  for (std::size_t i = 0; i < Faults::kKinds; ++i) EXPECT_GT(sums.begun[i], least) << Faults::kNames[i];
  for (const Fault fault :
       {Fault::kEncoderLoss, Fault::kEncoderJump, Fault::kFollowingError, Fault::kOverCurrent,
        Fault::kCurrentSensor, Fault::kTickOverrun, Fault::kAmplifierFault, Fault::kAmplifierNotReady,
        Fault::kEncoderStands, Fault::kUnderVoltage, Fault::kOverVoltage})
    EXPECT_GT(sums.latched[static_cast<std::size_t>(fault)], least) << std::hex << error_code(fault);
  // These need their time, and another fault comes first.
  for (const Fault fault : {Fault::kOverTemperature, Fault::kAnalogueSensor})
    EXPECT_GT(sums.latched[static_cast<std::size_t>(fault)], 0U) << std::hex << error_code(fault);
  EXPECT_GT(sums.driven, sums.ticks / 3);
  EXPECT_GT(sums.travelled_m, 5e-6 * static_cast<double>(sums.ticks));
}

}  // namespace
}  // namespace slipstack::soak
