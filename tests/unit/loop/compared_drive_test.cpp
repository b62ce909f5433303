// SPDX-License-Identifier: Apache-2.0
// The loop of the comparison against the controller itself.
#include "workbench/loop/comparison/compared_drive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "tests/loop/axis_loop.h"

namespace slipstack::workbench {
namespace {

struct Recorded {
  std::vector<ReferencePoint> reference;
  std::vector<float> current_A;
  double start_m = 0.0;
};

// Moves of the controller in its own loop, from the tick on in which current flows.
Recorded recorded(const sim::Axis& axis, const AxisParameters& parameters, const ModelParameters& model) {
  const auto loop = std::make_unique<loop::AxisLoop>(axis);
  loop->step();  // the counts are known before there are parameters
  EXPECT_EQ(loop->controller().configure(parameters, model), ParameterStatus::kOk);
  Recorded found;
  found.start_m = loop->plant.position_m();
  for (int i = 0; i < 20; ++i) {
    loop->step();
    loop->controller().poll();
  }
  const std::int32_t home = loop->controller().reference().counts();
  int move = 0;
  for (int i = 0; i < 30000; ++i) {
    loop->controller().command(static_cast<std::uint16_t>(i < 2 ? 0x06 : (i < 4 ? 0x07 : 0x0F)));
    loop->step();
    loop->controller().poll();
    if (!loop->controller().output().driving) continue;
    found.reference.push_back(loop->controller().history().point(loop->controller().ticks()));
    found.current_A.push_back(loop->controller().output().current_A);
    if (found.reference.size() > 100 && loop->controller().reference().idle()) {
      EXPECT_EQ(loop->controller().move_to(home + (++move % 2 == 0 ? 0 : 8000)), PlanStatus::kOk);
    }
  }
  EXPECT_GT(move, 3);
  return found;
}

TEST(ComparedDrive, GivesTheCurrentOfTheControllerBitForBit) {
  sim::Axis axis = sim::draw_bench(sim::Setup::kPickAndPlace, 3).axis;
  axis.force_noise_N = 0.0;
  AxisParameters parameters = loop::pick_and_place_parameters(axis);
  parameters.adapt_level = parameters.adapt_mass = true;
  parameters.disturbance_share = 0.3F;
  const ModelParameters model = loop::identified_model(axis, 0.2, 0.05);
  const Recorded of_controller = recorded(axis, parameters, model);
  const ComparedDrive drive(axis, parameters, model, 1);
  const DriveRun run = drive.run(of_controller.reference, of_controller.start_m, {.own_model = true});
  ASSERT_EQ(run.force_N.size(), of_controller.current_A.size());
  for (std::size_t i = 0; i < run.force_N.size(); ++i) {
    ASSERT_EQ(run.force_N[i], static_cast<double>(of_controller.current_A[i]) * axis.motor_constant_N_per_A)
        << "tick " << i;
  }
  EXPECT_NE(run.level, 1.0);
}

// A rigid axis without friction or noise, its mass known: the reference is followed to a share of a count,
// and without mass feed-forward it is not.
TEST(ComparedDrive, FollowsWithMassFeedForwardAndLagsWithout) {
  sim::Axis axis = sim::draw_bench(sim::Setup::kPickAndPlace, 3).axis;
  axis.force_noise_N = 0.0;
  axis.curve = sim::VirginCurve({{sim::CurveKind::kExponential, 1e-6, 5e-6, 1.0}});
  const AxisParameters parameters = loop::pick_and_place_parameters(axis);
  const ComparedDrive drive(axis, parameters, loop::identified_model(axis, 0.0, 0.0), 1);
  const Trajectory motion = sampled(
      [](double t_s) {
        constexpr double kRate = 2.0 * std::numbers::pi;
        return sim::MotionPoint{0.2 + 0.01 * (1.0 - std::cos(kRate * t_s)),
                                0.01 * kRate * std::sin(kRate * t_s),
                                0.01 * kRate * kRate * std::cos(kRate * t_s)};
      },
      3.0, kComparedTick_s);
  ASSERT_GE(motion.reversals.size(), 5U);
  const auto worst = [](const DriveRun& run) {
    double peak = 0.0;
    for (std::size_t i = 10000; i < run.error_m.size(); ++i) peak = std::max(peak, std::fabs(run.error_m[i]));
    return peak;
  };
  const DriveRun with = drive.run(motion, {});
  const DriveRun without = drive.run(motion, {.mass_share = 0.0});
  EXPECT_FALSE(with.lost);
  EXPECT_LT(worst(with), 2.0 * axis.encoder_resolution_m);
  EXPECT_GT(worst(without), 10.0 * worst(with));
  // Learning what the mass needs does the same.
  std::vector<double> inertia_N;
  for (const sim::MotionPoint& point : motion.points) inertia_N.push_back(axis.mass_kg * point.a_mps2);
  const DriveRun learned = drive.run(motion, {.mass_share = 0.0, .learned_N = inertia_N});
  EXPECT_LT(worst(learned), 0.2 * worst(without));
}

TEST(ComparedDrive, RefusesWhatTheFirmwareRefuses) {
  const sim::Axis axis = sim::draw_bench(sim::Setup::kPickAndPlace, 3).axis;
  EXPECT_THROW(ComparedDrive(axis, loop::pick_and_place_parameters(axis), ModelParameters{}, 1),
               std::invalid_argument);
}

}  // namespace
}  // namespace slipstack::workbench
