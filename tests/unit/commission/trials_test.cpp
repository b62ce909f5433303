// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/trials.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "sim_host/rng.h"
#include "tests/unit/temporary_directory.h"
#include "workbench/model/effect_adapters/firmware_effects.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {
namespace {

using slipstack::test::TemporaryDirectory;

TEST(IsLower, BeyondTheSpreadOnly) {
  EXPECT_TRUE(is_lower({1.0, 1.1, 0.9, 1.0}, {2.0, 2.1, 1.9, 2.0}));
  EXPECT_FALSE(is_lower({2.0, 2.1, 1.9, 2.0}, {1.0, 1.1, 0.9, 1.0}));
  EXPECT_FALSE(is_lower({1.0, 1.1, 0.9, 1.0}, {1.0, 1.1, 0.9, 1.0}));
  // 0.1 less, with standard errors of 0.0408 each: 1.7 of the difference.
  EXPECT_FALSE(is_lower({1.0, 1.1, 0.9, 1.0}, {1.1, 1.2, 1.0, 1.1}));
  // 0.2 less: 3.5 of them.
  EXPECT_TRUE(is_lower({1.0, 1.1, 0.9, 1.0}, {1.2, 1.3, 1.1, 1.2}));
  EXPECT_FALSE(is_lower({}, {1.0}));
  EXPECT_FALSE(is_lower({1.0}, {}));
}

TEST(IsLower, HardlyEverWhereNothingIsLower) {
  sim::Rng rng(3, "spread");
  int lower = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<double> a, b;
    for (int j = 0; j < 4; ++j) {
      a.push_back(1.0 + 0.1 * rng.normal());
      b.push_back(1.0 + 0.1 * rng.normal());
    }
    lower += is_lower(a, b) ? 1 : 0;
  }
  EXPECT_LT(lower, 40);  // Student, 6 degrees of freedom: 1.2 % above 3
  EXPECT_GT(lower, 8);
}

/// Follows by a rule: a model's error stands for its mass.
class RuledAxis final : public LiveAxis {
 public:
  const Nameplate& nameplate() const override { return plate; }
  double used_s() const override { return used; }
  double position_m() const override { return 0.2; }
  Direction check_direction() override { return Direction::kRight; }
  void reverse_motor() override {}
  AxisRecord pulse(double, double) override { return {}; }
  std::string deploy(const DriveSettings&, const Terms& terms) override {
    const double mass = mass_kg(terms);
    deployed.push_back(mass);
    if (mass == refused_kg) return "the controller refuses its parameters (status 2)";
    runs_kg = mass;
    return "";
  }
  AxisRecord run(const SetPoints& motion) override {
    AxisRecord record;
    record.rate_Hz = 2.0 * motion.rate_Hz;
    for (std::size_t i = 0; i < 2 * motion.size() + 6; ++i) {
      const double at_m = motion.position_m[std::min(i / 2, motion.size() - 1)];
      record.position_m.push_back(at_m);
      record.reference_m.push_back(at_m);
      record.force_N.push_back(rng_.normal());
      record.error_m.push_back(1e-6 * errors_um.at(runs_kg) * rng_.normal());
    }
    used += motion.duration_s();
    if (runs_kg == faults_kg) record.fault = "the drive stopped with fault 8611h at 200.0 mm";
    record.lost_hold = lost_hold;
    return record;
  }
  void switch_off() override {}

  Nameplate plate{1e-6, 60.0, 10.0, 0.4, 1.0, {}, 1e-4};
  double used = 0.0;
  double refused_kg = 0.0;
  double faults_kg = 0.0;
  bool lost_hold = true;
  double runs_kg = 0.0;
  std::vector<double> deployed;
  std::map<double, double> errors_um;

 private:
  sim::Rng rng_{5, "ruled"};
};

std::string model_of_mass(double mass_kg) {
  Term inertia;
  inertia.effect = &effect_with_role(Role::inertia);
  inertia.gains = inertia.lower = inertia.upper = {mass_kg};
  Model model;
  model.source = {"log", 1000, 0.1, 0.1, 0.1};
  model.terms = model.target_terms = {inertia};
  return to_toml(model);
}

struct Tried {
  RuledAxis axis;
  TemporaryDirectory folder;
  std::vector<ModelTrial> trials;
  std::vector<std::string> notes;
};

/// Models of 1, 2, 3 kg and so on; the mass alone is that of the first.
void try_on(Tried& tried, std::size_t models) {
  CommissionFolder of_axis(tried.folder / "axis", "ruled");
  nlohmann::json listed = nlohmann::json::array();
  for (std::size_t i = 1; i <= models; ++i) {
    const std::string file = "model_" + std::to_string(i) + ".toml";
    of_axis.write(file, model_of_mass(static_cast<double>(i)));
    listed.push_back({{"added", "step " + std::to_string(i)}, {"effect", ""}, {"file", file}});
  }
  Progress progress([](const std::string&, double) {});
  Stages stages(tried.axis, of_axis, progress);
  PreparedAxis axis;
  axis.limits = {0.02, 0.38, 0.5, 5.0, 150.0, 300.0, false};
  tried.trials = try_models(stages, axis, listed);
  tried.notes = stages.notes;
}

TEST(ModelTrials, WhatIsNoBetterIsTakenBackAtOnce) {
  Tried tried;
  tried.axis.errors_um = {{1.0, 8.0}, {2.0, 3.0}, {3.0, 5.0}, {4.0, 2.0}};
  try_on(tried, 4);
  ASSERT_EQ(tried.trials.size(), 5U);
  // The first model has the same mass, and follows no better than the mass alone.
  EXPECT_EQ(tried.trials[1].kept, false);
  EXPECT_EQ(tried.trials[2].kept, true);
  EXPECT_EQ(tried.trials[3].kept, false);
  EXPECT_EQ(tried.trials[4].kept, true);
  EXPECT_EQ(tried.axis.runs_kg, 4.0);
  const std::vector<double> order{1.0, 1.0, 1.0, 2.0, 3.0, 2.0, 4.0, 4.0};
  EXPECT_EQ(tried.axis.deployed, order);
  ASSERT_EQ(tried.notes.size(), 2U);
  EXPECT_NE(tried.notes[1].find("step 3 was taken back"), std::string::npos);
  EXPECT_NEAR(spread_of(tried.trials[2].rms_m).mean, 3e-6, 0.1e-6);
}

TEST(ModelTrials, AFaultOrARefusalTakesTheModelBackAndEndsNothing) {
  Tried tried;
  tried.axis.errors_um = {{1.0, 8.0}, {2.0, 3.0}, {3.0, 1.0}, {4.0, 2.0}};
  tried.axis.refused_kg = 2.0;
  tried.axis.faults_kg = 3.0;
  try_on(tried, 4);
  EXPECT_EQ(tried.trials[2].kept, false);
  EXPECT_EQ(tried.trials[3].kept, false);
  EXPECT_EQ(tried.trials[4].kept, true);
  EXPECT_NE(tried.notes[1].find("refuses"), std::string::npos);
  EXPECT_NE(tried.notes[2].find("8611h"), std::string::npos);
  EXPECT_EQ(tried.axis.runs_kg, 4.0);
}

TEST(ModelTrials, AFaultOfAnythingElseEndsThemWithTheLastModelThatWasKept) {
  Tried tried;
  tried.axis.errors_um = {{1.0, 8.0}, {2.0, 3.0}, {3.0, 1.0}};
  tried.axis.faults_kg = 3.0;
  tried.axis.lost_hold = false;
  EXPECT_THROW(try_on(tried, 3), CommissionStopped);
  EXPECT_EQ(tried.axis.runs_kg, 2.0);
}

TEST(ModelTrials, TheMassAloneMustWork) {
  Tried tried;
  tried.axis.errors_um = {{1.0, 8.0}};
  tried.axis.faults_kg = 1.0;
  EXPECT_THROW(try_on(tried, 1), CommissionStopped);
}

}  // namespace
}  // namespace slipstack::workbench
