// SPDX-License-Identifier: Apache-2.0
// Cyclic synchronous position and velocity with jitter, another clock, lost, late and held frames: no fault,
// no step of the reference, and the following error of a perfect clock.
#include <algorithm>
#include <cstdlib>
#include <map>
#include <ostream>
#include <tuple>
#include <utility>

#include "tests/bench/cyclic_position/cyclic_axis.h"
#include "tests/bench/cyclic_position/unsteady_master.h"

namespace slipstack::bench {
namespace {

constexpr std::array kDisturbances = {
    Disturbance{.name = "uniform", .jitter = Jitter::kUniform},
    Disturbance{.name = "gaussian", .jitter = Jitter::kGaussian},
    Disturbance{.name = "desktop", .jitter = Jitter::kDesktop},
    Disturbance{.name = "slow", .clock_ppm = 200.0},
    Disturbance{.name = "fast", .clock_ppm = -200.0},
    Disturbance{.name = "lost", .lost = 0.01},
    Disturbance{.name = "late", .late_at = 700},
    Disturbance{.name = "held", .held_every = 97, .held_periods = 2.6},
    Disturbance{.name = "all",
                .jitter = Jitter::kDesktop,
                .clock_ppm = 120.0,
                .lost = 0.01,
                .held_every = 997,
                .held_periods = 3.2},
};

std::int64_t periods() {
  const char* wanted = std::getenv("SLIPSTACK_CYCLIC_PERIODS");
  return wanted != nullptr ? std::atoll(wanted) : 2000;
}

// To and fro over 100 mm at up to 0.2 m/s, with a finer motion on it.
double path_m(double time_s) {
  if (time_s < 0.0) return 0.0;
  return 0.05 * (1.0 - std::cos(4.0 * time_s)) + 2e-4 * (1.0 - std::cos(40.0 * time_s));
}

double path_mps(double time_s) {
  if (time_s < 0.0) return 0.0;
  return 0.2 * std::sin(4.0 * time_s) + 8e-3 * std::sin(40.0 * time_s);
}

struct Outcome {
  Seen seen;
  Fault fault = Fault::kNone;
  std::uint32_t bridged = 0, gaps = 0;
  double largest_deviation_m = 0.0;  ///< of the reference from the path as many periods ago as it should be
};

enum class Stream : std::uint8_t { kPosition, kVelocity };

Outcome run(Stream stream, std::uint32_t period_ms, const Disturbance& disturbance) {
  const bool velocity = stream == Stream::kVelocity;
  CyclicAxis axis(period_ms);
  if (velocity) axis.map_velocity();
  axis.drive().enable(velocity ? 9 : 8);
  axis.drive().nmt(0x01);
  const double period_s = 1e-3 * period_ms;
  const double rest_s = 40.0 * period_s;  // the master shows where the axis is, then moves
  UnsteadyMaster master(axis.drive().master, can::kNode, period_s, disturbance, [&](double time_s) {
    if (velocity)
      return static_cast<std::int32_t>(std::lround(path_mps(time_s - rest_s) / axis.resolution_m()));
    return axis.home() +
           static_cast<std::int32_t>(std::lround(path_m(time_s - rest_s) / axis.resolution_m()));
  });
  if (velocity) master.set_point_id = 0x500;
  axis.mark();
  Outcome outcome;
  while (master.sent() < periods() && outcome.fault == Fault::kNone) {
    master.run_until(axis.time_s());
    axis.tick();
    outcome.fault = axis.fault();
    const double master_s = axis.time_s() / (1.0 + 1e-6 * disturbance.clock_ppm);
    const double wanted_m = path_m(master_s - rest_s - (velocity ? 2.5 : 3.0) * period_s);
    outcome.largest_deviation_m =
        std::max(outcome.largest_deviation_m, std::abs(axis.reference_m() - wanted_m));
  }
  outcome.seen = axis.seen;
  outcome.bridged = axis.controller().cyclic_position().bridged();
  outcome.gaps = axis.controller().cyclic_position().gaps();
  return outcome;
}

class UnsteadyBus : public ::testing::TestWithParam<std::tuple<Stream, std::uint32_t, Disturbance>> {};

TEST_P(UnsteadyBus, NoFaultNoStepAndTheFollowingErrorOfAPerfectClock) {
  const auto& [stream, period_ms, disturbance] = GetParam();
  static std::map<std::pair<Stream, std::uint32_t>, Outcome> references;
  const auto [reference, is_new] = references.try_emplace({stream, period_ms});
  if (is_new) reference->second = run(stream, period_ms, kPerfect);
  const Outcome& perfect = reference->second;
  const Outcome outcome = run(stream, period_ms, disturbance);
  ASSERT_EQ(perfect.fault, Fault::kNone);
  EXPECT_EQ(outcome.fault, Fault::kNone) << static_cast<int>(outcome.fault);
  const AxisParameters axis = CyclicAxis(period_ms).axis();
  std::printf(
      "%s %-9s %2u ms: %.3f m/s  %.2f m/s2  %.0f m/s3  rms %.3f um (%.3f)  largest %.2f um (%.2f)  off the "
      "path %.1f um "
      "(%.1f)  bridged %u  gaps %u\n",
      stream == Stream::kVelocity ? "csv" : "csp", disturbance.name, period_ms, outcome.seen.velocity_mps,
      outcome.seen.acceleration_mps2, outcome.seen.jerk_mps3, 1e6 * outcome.seen.rms_error_m(),
      1e6 * perfect.seen.rms_error_m(), 1e6 * outcome.seen.error_m, 1e6 * perfect.seen.error_m,
      1e6 * outcome.largest_deviation_m, 1e6 * perfect.largest_deviation_m, outcome.bridged, outcome.gaps);
  // A stop after a gap has a deceleration of its own.
  const float largest = outcome.gaps == 0 ? axis.acceleration_limit_mps2
                                          : std::max(axis.acceleration_limit_mps2, axis.quick_stop_mps2);
  EXPECT_LE(outcome.seen.velocity_mps, 1.001 * static_cast<double>(axis.velocity_limit_mps));
  EXPECT_LE(outcome.seen.acceleration_mps2, 1.001 * static_cast<double>(largest) + 0.01);
  // Gaps too: the stop after them, and the way back to the stream. Rounding to counts is followed; where the
  // path changes its jerk, one tick has 4/3 of it (jerk_test.cpp). What the drift of the clocks makes of its
  // rate comes on top.
  const double rounding = stream == Stream::kVelocity ? 0.0 : 6.0 * 1e-6 / std::pow(1e-3 * period_ms, 3);
  EXPECT_LE(outcome.seen.jerk_mps3,
            4.0 / 3.0 * (static_cast<double>(axis.jerk_limit_mps3) + rounding) + 60.0);
  EXPECT_LE(outcome.seen.rms_error_m(), 1.2 * perfect.seen.rms_error_m());
  EXPECT_GE(outcome.seen.rms_error_m(), 0.8 * perfect.seen.rms_error_m());
  EXPECT_GT(outcome.seen.velocity_mps, 0.19) << "it moved";
}

INSTANTIATE_TEST_SUITE_P(Bus, UnsteadyBus,
                         ::testing::Combine(::testing::Values(Stream::kPosition, Stream::kVelocity),
                                            ::testing::Values(1U, 2U, 4U, 10U),
                                            ::testing::ValuesIn(kDisturbances)),
                         [](const auto& drawn) {
                           const bool velocity = std::get<0>(drawn.param) == Stream::kVelocity;
                           return std::string(velocity ? "velocity_" : "") + std::get<2>(drawn.param).name +
                                  "_" + std::to_string(std::get<1>(drawn.param)) + "ms";
                         });

}  // namespace
}  // namespace slipstack::bench
