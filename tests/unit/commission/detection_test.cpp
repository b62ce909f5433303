// SPDX-License-Identifier: Apache-2.0
// What a commissioning finds of a drive that reports its force late and of an arm that swings above the band
// of the friction, and what it says that it would not have found.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/unit/commission/axes.h"
#include "tests/unit/temporary_directory.h"
#include "workbench/commission/commission.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {
namespace {

using slipstack::test::TemporaryDirectory;

constexpr std::uint64_t kAxisSeed = 4;

struct Commissioned {
  TemporaryDirectory folder;
  CommissionResult result;

  bool notes_contain(const std::string& text) const {
    return std::any_of(result.notes.begin(), result.notes.end(),
                       [&](const std::string& note) { return note.find(text) != std::string::npos; });
  }
  /// The trial of an effect; nullptr where it was not found.
  const ModelTrial* trial(const std::string& effect) const {
    const auto found = std::find_if(result.trials.begin(), result.trials.end(),
                                    [&](const ModelTrial& one) { return one.effect == effect; });
    return found == result.trials.end() ? nullptr : &*found;
  }
  Term term(const std::string& effect) const {
    const Model model = read_controller_model(folder / "axis" / trial(effect)->file);
    return *find_term(model.terms, effect);
  }
};

void commission_with(Commissioned& done, const std::function<void(sim::Effects&)>& add) {
  sim::Axis axis = sim::draw_bench(sim::Setup::kPickAndPlace, kAxisSeed).axis;
  axis.encoder_resolution_m = 1e-7;
  add(axis.effects);
  Progress progress([](const std::string&, double) {});
  CommissionFolder folder(done.folder / "axis", "axis");
  done.result =
      commission(*host_axis({.axis = axis, .seed = kAxisSeed, .motor_reversed = false}), folder, progress);
}

// Half a sample is named as what it is; an eighth is within what clocks err, which the notes say.
TEST(Detection, ADelayOfTheReportIsFoundAndTakenBack) {
  Commissioned late;
  commission_with(late, [](sim::Effects& effects) { effects.delay = sim::RecordingDelay{250e-6, 0.0}; });
  const ModelTrial* trial = late.trial("time_delay");
  ASSERT_NE(trial, nullptr);
  EXPECT_NEAR(late.term("time_delay").shapes[0], 250e-6, 15e-6);
  EXPECT_FALSE(trial->kept) << "the axis is not late";
  EXPECT_FALSE(late.notes_contain("A delay between force and motion"));

  Commissioned little;
  commission_with(little, [](sim::Effects& effects) { effects.delay = sim::RecordingDelay{60e-6, 0.0}; });
  EXPECT_EQ(little.trial("time_delay"), nullptr);
  EXPECT_TRUE(little.notes_contain("A delay between force and motion below 125"));
}

TEST(Detection, AModeAboveTheBandOfTheFrictionIsFound) {
  const auto arm = [](double ratio) {
    return [ratio](sim::Effects& effects) {
      effects.resonance = sim::Resonance{ratio, 2.0 * std::numbers::pi * 55.0, 0.03};
    };
  };
  Commissioned swings;
  commission_with(swings, arm(0.2));
  ASSERT_NE(swings.trial("structural_resonance"), nullptr);
  EXPECT_TRUE(swings.trial("structural_resonance")->kept);
  const Term mode = swings.term("structural_resonance");
  EXPECT_NEAR(mode.shapes[0], 55.0, 0.5);
  EXPECT_NEAR(mode.shapes[1], 0.03, 0.01);
  EXPECT_NEAR(mode.gains[0], 0.2 * 35.45, 0.4);
  EXPECT_FALSE(swings.notes_contain("A structural resonance below"));

  Commissioned hardly;
  commission_with(hardly, arm(2e-4));
  EXPECT_EQ(hardly.trial("structural_resonance"), nullptr);
  EXPECT_TRUE(hardly.notes_contain("A structural resonance below"));
}

}  // namespace
}  // namespace slipstack::workbench
