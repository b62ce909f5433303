// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <map>

#include "tests/golden/shared_data.h"
#include "workbench/papers/analysis/friction_models.h"

// Six friction models of the literature on two real measurements, fitted to the same rows.
namespace slipstack::workbench {
namespace {

std::map<FrictionKind, double> errors_on(const std::filesystem::path& path, bool inertia) {
  const Measurement measurement(read_log(path));
  FrictionData data;
  data.motion = {measurement.tick_s(), measurement.position_m(), measurement.velocity_mps()};
  data.force_N = measurement.force_N();
  data.observe = [&](std::span<const double> signal) { return measurement.filtered(signal); };
  if (inertia) data.others.push_back(measurement.acceleration_mps2());
  std::map<FrictionKind, double> errors;
  for (const FrictionKind kind : kFrictionKinds) {
    errors[kind] = fit_friction(kind, data, 40).relative_error;
  }
  return errors;
}

TEST(FrictionModels, TribometerNeedsElements) {
  const auto path = shared_file("tribometer/tribometer_loops.csv");
  SKIP_WITHOUT(path);
  auto error = errors_on(path, false);
  EXPECT_LT(error[FrictionKind::kMaxwellSlip], 0.06);
  EXPECT_GT(error[FrictionKind::kMaxwellSlip], 0.04);
  EXPECT_LT(error[FrictionKind::kGms], 1.02 * error[FrictionKind::kMaxwellSlip]);
  // One exponential is no stick-slip loop; a static curve has no loop at all.
  EXPECT_NEAR(error[FrictionKind::kDahl], 0.112, 0.01);
  EXPECT_LT(error[FrictionKind::kBoucWen], error[FrictionKind::kDahl]);
  EXPECT_GT(error[FrictionKind::kBoucWen], 1.2 * error[FrictionKind::kMaxwellSlip]);
  EXPECT_GT(error[FrictionKind::kCoulombStribeck], 0.5);
}

TEST(FrictionModels, EmpsHardlyTellsThemApart) {
  const auto path = shared_file("emps/emps_estimation.csv");
  SKIP_WITHOUT(path);
  // Published with mass, Coulomb, viscous friction and offset: 4.08 % [5].
  for (const auto& [kind, error] : errors_on(path, true)) {
    EXPECT_NEAR(error, 0.0408, 0.0025) << name(kind);
  }
}

}  // namespace
}  // namespace slipstack::workbench
