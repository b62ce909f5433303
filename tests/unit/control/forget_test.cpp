// SPDX-License-Identifier: Apache-2.0
// What is reset is as new: after any past, the same input gives what a new object gives, bit for bit.
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "firmware/control/current/current_command.h"
#include "firmware/control/force/adaptation.h"
#include "firmware/control/force/excitation.h"
#include "firmware/control/force/feedback.h"
#include "firmware/control/homing/coded_marks.h"
#include "firmware/control/streams/set_point_periods.h"
#include "firmware/control/supervision/fault_monitor.h"
#include "tests/unit/draw.h"

namespace slipstack {
namespace {

/// What `use(object, draw)` gives of one that was used and reset, and of a new one that was reset alike.
template <class Object, class Reset, class Use>
void expect_as_new(std::uint64_t seed, Reset&& reset, Use&& use) {
  for (std::uint64_t run = 0; run < 10; ++run) {
    test::Draw past(seed + run), then(seed + 100 + run), again(seed + 100 + run);
    const auto used = std::make_unique<Object>(), fresh = std::make_unique<Object>();
    reset(*used);
    static_cast<void>(use(*used, past));
    reset(*used);
    reset(*fresh);
    ASSERT_EQ(use(*used, then), use(*fresh, again)) << run;
  }
}

float drawn(test::Draw& draw, double low, double high) {
  return static_cast<float>(draw.uniform(low, high));
}

TEST(Forget, StateEstimate) {
  const StateEstimate::Gains gains = StateEstimate::gains(1e-6F, 1e-4F, 400.0F);
  expect_as_new<StateEstimate>(
      1, [](StateEstimate& one) { one.reset(500); },
      [&](StateEstimate& one, test::Draw& draw) {
        std::vector<float> seen;
        std::int32_t counts = 500;
        for (int i = 0; i < 50; ++i) {
          seen.insert(seen.end(), {one.offset_m(), one.velocity_mps(), one.disturbance_mps2()});
          one.step(gains, counts += static_cast<std::int32_t>(draw.below(20)), drawn(draw, -5.0, 5.0));
        }
        return seen;
      });
}

TEST(Forget, Feedback) {
  Feedback::Gains gains;
  gains.resolution_m = 1e-6F;
  gains.mps_per_count = 1e-2F;
  gains.position_per_s = 30.0F;
  gains.velocity_N_s_per_m = 3000.0F;
  gains.integral_per_tick = 3e-3F;
  gains.notch = {Notch::gains(300.0F, 0.1F, 0.1F, 1e-4F), Notch::gains(700.0F, 0.2F, 0.0F, 1e-4F)};
  expect_as_new<Feedback>(
      2, [](Feedback& one) { one.reset(); },
      [&](Feedback& one, test::Draw& draw) {
        std::vector<float> seen;
        for (int i = 0; i < 50; ++i) {
          // What was wanted and applied before the first force counts too.
          one.integrate(gains, drawn(draw, -50.0, 50.0), drawn(draw, -50.0, 50.0));
          one.give_up(drawn(draw, -1.0, 1.0));
          seen.push_back(one.step(gains, {0, 0.0F, drawn(draw, -9.0, 9.0), 0.0F}, drawn(draw, -1e-4, 1e-4),
                                  drawn(draw, -0.1, 0.1)));
        }
        return seen;
      });
}

TEST(Forget, CurrentCommand) {
  ControlSet set;
  set.blend_keep = 0.97F;
  set.largest_step_A = 0.5F;
  expect_as_new<CurrentCommand>(
      3, [](CurrentCommand& one) { one.reset(); },
      [&](CurrentCommand& one, test::Draw& draw) {
        std::vector<float> seen;
        for (int i = 0; i < 60; ++i) {
          seen.push_back(one.last_A());
          const float wanted = drawn(draw, -9.0, 9.0);
          if (i % 20 == 0) one.begin_fade(wanted, i == 0);
          std::uint16_t limits = 0;
          seen.push_back(one.limited(set, 5.0F, one.faded(set, wanted), limits));
          seen.push_back(static_cast<float>(limits));
        }
        return seen;
      });
}

// From rest a force begins at once, otherwise with what was there; a fade that is ended is not there any
// more.
TEST(CurrentCommand, FadesFromTheForceBeforeUnlessThereWasNone) {
  ControlSet set;
  set.blend_keep = 0.9F;
  CurrentCommand command;
  command.begin_fade(10.0F, true);
  EXPECT_EQ(command.faded(set, 10.0F), 10.0F);
  command.begin_fade(30.0F, false);
  EXPECT_EQ(command.faded(set, 30.0F), 10.0F);
  EXPECT_NEAR(command.faded(set, 30.0F), 30.0F - 20.0F * 0.9F, 1e-5F);
  command.begin_fade(-30.0F, false);
  EXPECT_NEAR(command.faded(set, -30.0F), 12.0F, 1e-5F) << "from where the last fade had come";
  EXPECT_NEAR(command.faded(set, -30.0F), -30.0F + 42.0F * 0.9F, 1e-5F);
  command.end_fade();
  EXPECT_EQ(command.faded(set, -30.0F), -30.0F);
}

TEST(Forget, SetPointPeriods) {
  expect_as_new<SetPointPeriods>(
      4, [](SetPointPeriods& one) { one.reset(); },
      [](SetPointPeriods& one, test::Draw& draw) {
        std::vector<std::int64_t> seen;
        std::uint32_t by_time = 100;
        for (int i = 0; i < 60; ++i) {
          by_time += static_cast<std::uint32_t>(draw.below(3));
          const auto target = static_cast<std::int32_t>(300 * i + static_cast<int>(draw.below(200)));
          const SetPointPeriods::Place place = one.place(by_time, target, 1000);
          seen.insert(seen.end(), {place.period, place.counts});
        }
        return seen;
      });
}

TEST(Forget, FaultMonitor) {
  AxisParameters axis;
  axis.velocity_limit_mps = 0.2F;
  axis.following_error_m = 1e-4F;
  axis.current_mismatch_A = 2.0F;
  axis.stall_s = 1e-3F;
  const FaultMonitor::Bounds bounds = FaultMonitor::bounds(axis);
  expect_as_new<FaultMonitor>(
      5, [](FaultMonitor& one) { one.reset(7000); },
      [&](FaultMonitor& one, test::Draw& draw) {
        std::vector<int> seen;
        TickInputs in;
        in.encoder.counts = 7000;
        for (int i = 0; i < 200; ++i) {
          if (draw.below(4) == 0) in.encoder.counts += static_cast<std::int32_t>(draw.below(40));
          in.current.current_A = drawn(draw, -18.0, 18.0);
          in.overrun = draw.below(20) == 0;
          const float set_point_A = draw.below(2) == 0 ? in.current.current_A : 6.0F;
          seen.push_back(static_cast<int>(
              one.check(bounds, in, in.encoder.counts + static_cast<std::int32_t>(draw.below(110)),
                        set_point_A, draw.below(8) != 0)));
          seen.push_back(one.last_step());
        }
        return seen;
      });
}

TEST(Forget, Excitation) {
  ExcitationSettings settings;
  settings.amplitude = 5.0F;
  settings.largest_deviation_m = 1e-3F;
  settings.period_ticks = 60;
  settings.lowest = 1;
  settings.highest = 9;
  settings.periods = 2;
  expect_as_new<Excitation>(
      6, [&](Excitation& one) { one.begin(settings); },
      [](Excitation& one, test::Draw& draw) {
        std::vector<float> seen;
        const auto ticks = 20 + draw.below(200);
        for (std::size_t i = 0; i < ticks; ++i) {
          seen.push_back(one.step({}, 0.0F));
          one.note(static_cast<std::uint16_t>(draw.below(2)));
          seen.push_back(static_cast<float>(one.limits()));
          seen.push_back(static_cast<float>(one.periods()));
          seen.push_back(static_cast<float>(one.state()));
        }
        return seen;
      });
}

TEST(Forget, Adaptation) {
  AxisParameters axis;
  axis.adapt_level = axis.adapt_mass = true;
  const Adaptation::Bounds bounds = Adaptation::bounds(axis, 12.0F, 35.0F);
  expect_as_new<Adaptation>(
      7, [&](Adaptation& one) { one.begin(bounds); },
      [&](Adaptation& one, test::Draw& draw) {
        std::vector<float> seen;
        std::int32_t counts = 0;
        // Ends in the middle of what is learned at once, in a move or at rest.
        const auto ticks = 2000 + draw.below(500);
        for (std::size_t i = 0; i < ticks; ++i) {
          const bool moves = i % 700 < 400;
          counts += moves ? 40 : 0;
          one.step(bounds,
                   {counts, moves ? 40.0F : 0.0F, moves ? 12.0F : 0.0F, moves ? drawn(draw, -5.0, 5.0) : 0.0F,
                    moves ? drawn(draw, -20.0, 30.0) : std::numeric_limits<float>::quiet_NaN()});
          seen.insert(seen.end(), {one.level(), one.added_kg()});
        }
        return seen;
      });
}

TEST(Forget, CodedMarks) {
  const MarkCode code{.distance = 20000, .step = 20, .tolerance = 2};
  expect_as_new<CodedMarks>(
      8, [](CodedMarks& one) { one.restart(); },
      [&](CodedMarks& one, test::Draw& draw) {
        std::vector<std::int32_t> seen;
        const auto first = static_cast<std::int32_t>(1 + draw.below(100));
        for (std::int32_t i = 0; i < 2 + static_cast<std::int32_t>(draw.below(6)); ++i) {
          const std::int32_t k = first + i / 2;
          const bool known = one.passed(code, 777 + 20000 * k + (i % 2 == 0 ? 0 : 10000 + 20 * k));
          seen.insert(seen.end(), {known ? 1 : 0, known ? one.zero() : 0});
        }
        return seen;
      });
}

}  // namespace
}  // namespace slipstack
