// SPDX-License-Identifier: Apache-2.0
// The adaptation against the law of its header, in double: its constants from the axis in SI, what it sees
// through the low-pass, when a move surprises it, and where level and mass are kept. The least squares are
// those of rail_least_squares.h, which learning_test.cpp compares with a dense solution.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>

#include "firmware/control/force/adaptation.h"
#include "tests/unit/draw.h"

namespace slipstack {
namespace {

double exact(float value) {
  return static_cast<double>(value);
}

AxisParameters drawn_learner(test::Draw& draw) {
  AxisParameters axis;
  axis.tick_s = static_cast<float>(draw.uniform(0.5e-4, 2e-4));
  axis.encoder_resolution_m = static_cast<float>(draw.log_uniform(1e-7, 1e-5));
  axis.observer_bandwidth_rad_per_s = static_cast<float>(draw.uniform(150.0, 900.0));
  axis.velocity_limit_mps = static_cast<float>(draw.log_uniform(0.05, 2.0));
  axis.acceleration_limit_mps2 = static_cast<float>(draw.uniform(1.0, 20.0));
  axis.level_lowest = static_cast<float>(draw.uniform(0.4, 0.8));
  axis.level_highest = static_cast<float>(draw.uniform(1.2, 1.8));
  axis.level_memory_s = static_cast<float>(draw.log_uniform(0.2, 10.0));
  const auto which = draw.below(4);
  axis.adapt_level = which != 1;
  axis.adapt_mass = which != 0;
  return axis;
}

TEST(AdaptationLaw, ItsConstantsAreThoseOfTheAxis) {
  test::Draw draw(21);
  const auto near = [](double value, double wanted, const char* what) {
    EXPECT_NEAR(value, wanted, 2e-5 * std::abs(wanted)) << what;
  };
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE(i);
    const AxisParameters axis = drawn_learner(draw);
    const double dry_N = i % 10 == 0 ? 0.0 : draw.log_uniform(0.1, 200.0),
                 mass_kg = draw.log_uniform(1.0, 200.0);
    const Adaptation::Bounds bound =
        Adaptation::bounds(axis, static_cast<float>(dry_N), static_cast<float>(mass_kg));
    const double tick_s = exact(axis.tick_s), bandwidth = exact(axis.observer_bandwidth_rad_per_s);
    const double pass = 1.0 - std::exp(-bandwidth * tick_s);
    near(exact(bound.pass), pass, "low-pass");
    near(exact(bound.lag_ticks), 3.0 * (1.0 - pass) / pass, "its lag");
    EXPECT_NEAR(bound.rest_ticks, 0.02 / tick_s - 0.5, 0.501) << "20 ms of rest";
    EXPECT_EQ(bound.lowest, axis.level_lowest);
    EXPECT_EQ(bound.highest, axis.level_highest);
    near(exact(bound.cells_per_count), exact(axis.encoder_resolution_m) / 0.008, "cells of 8 mm");
    const double typical_N = dry_N > 0.0 ? dry_N : 1.0, typical = 0.5 * exact(axis.acceleration_limit_mps2);
    near(exact(bound.typical_N), typical_N, "friction");
    near(exact(bound.typical_mps2), typical, "acceleration");
    EXPECT_EQ(bound.whole, axis.adapt_level);
    EXPECT_EQ(bound.part, axis.adapt_level && axis.adapt_mass);
    EXPECT_EQ(bound.mass, axis.adapt_mass);
    EXPECT_NEAR(exact(bound.lightest_kg), axis.adapt_mass ? -0.5 * mass_kg : 0.0, 1e-4 * mass_kg);
    EXPECT_NEAR(exact(bound.heaviest_kg), axis.adapt_mass ? mass_kg : 0.0, 1e-4 * mass_kg);
    // A lag of the estimate, or the eighth of a cell that the fastest axis passes.
    const double ticks = std::max(3.0 / bandwidth, 0.001 / exact(axis.velocity_limit_mps)) / tick_s;
    const auto& [whole, part, mass] = bound.priors;
    near(exact(part.first), 0.01 * 4.0 * ticks, "part");
    near(exact(part.least), 0.001 * 4.0 * ticks, "part");
    near(exact(part.forgets), 1.0 / (4.0 * ticks), "part");
    near(exact(whole.first), 0.25 * exact(part.first), "whole");
    near(exact(whole.least), 0.25 * exact(part.least), "whole");
    near(exact(whole.forgets), tick_s / exact(axis.level_memory_s), "whole");
    const double share = std::clamp(std::pow(typical_N / (mass_kg * typical), 2), 1e-3, 1e3);
    near(exact(mass.first), share * exact(part.first), "mass");
    near(exact(mass.least), share * exact(part.least), "mass");
    near(exact(mass.forgets), 1.0 / (40.0 * ticks), "mass");
  }
}

class AdaptationInDouble {
 public:
  using Squares = Adaptation::LeastSquares;
  static constexpr int kCells = static_cast<int>(Adaptation::kCells);

  explicit AdaptationInDouble(const Adaptation::Bounds& bound) : bound_(bound) {
    squares_->begin(bound.priors);
  }

  void step(const Adaptation::Said& said) {
    // Residual, friction and mass through the same low-pass of third order; what has been learned as well.
    filter(dry_, exact(said.dry_N));
    filter(acceleration_, exact(said.acceleration_mps2));
    filter(learned_, level * exact(said.dry_N) + added_kg * exact(said.acceleration_mps2));
    const auto [cell, beyond] = at(said.counts, exact(said.velocity) * exact(bound_.lag_ticks));
    const double now_N = level_at(cell, beyond) * dry_[2] + added_kg * acceleration_[2];
    const double error_N = exact(said.residual_N) + learned_[2] - now_N;
    if (std::isnan(error_N)) {
      rest();
    } else {
      learn(cell, beyond, error_N);
    }
    if (learns_ && ++ticks_ == Adaptation::kTogether) solve();
    const auto [here, share] = at(said.counts, 0.0);
    level = std::clamp(level_at(here, share), exact(bound_.lowest), exact(bound_.highest));
  }

  double level = 1.0, added_kg = 0.0;
  int surprises = 0;

 private:
  void filter(std::array<double, 3>& stages, double input) const {
    for (double& stage : stages) input = stage += exact(bound_.pass) * (input - stage);
  }
  std::pair<int, double> at(std::int32_t counts, double behind) const {
    const double place = (counts - behind) * exact(bound_.cells_per_count);
    const double whole = std::floor(place);
    const int cell = ((static_cast<int>(whole) % kCells) + kCells) % kCells;
    return {cell, place - whole};
  }
  double level_at(int cell, double beyond) const {
    return whole_ + (1.0 - beyond) * parts_[static_cast<std::size_t>(cell)] +
           beyond * parts_[static_cast<std::size_t>((cell + 1) % kCells)];
  }
  void learn(int cell, double beyond, double error_N) {
    learns_ = true;
    rested_ = 0;
    const double dry = dry_[2] / exact(bound_.typical_N);
    squares_->add(
        bound_.priors,
        {.whole = static_cast<float>(bound_.whole ? dry : 0.0),
         .part = static_cast<float>(bound_.part ? dry : 0.0),
         .mass = static_cast<float>(bound_.mass ? acceleration_[2] / exact(bound_.typical_mps2) : 0.0),
         .cell = static_cast<std::uint32_t>(cell),
         .beyond = static_cast<float>(beyond),
         .error = static_cast<float>(error_N)});
    // Once in a move: three times as far off as in the two before, or beyond what a level there explains; of
    // which half is enough where ten measurements' worth is known.
    const bool known = exact(squares_->known(static_cast<std::uint32_t>(cell), static_cast<float>(beyond))) >
                       10.0 * exact(bound_.priors.part.first);
    const double by_level_N =
        (known ? 0.5 : 1.0) * (exact(bound_.highest) - exact(bound_.lowest)) * exact(bound_.typical_N);
    if (settling_ > 0.0) {
      settling_ -= 1.0;
      return;
    }
    largest_N_ = std::max(largest_N_, std::abs(error_N));
    const bool moved_twice = last_N_ > 0.0 && before_last_N_ > 0.0;
    const bool more = moved_twice && largest_N_ > 3.0 * std::max(last_N_, before_last_N_);
    if (told_ || (!more && std::abs(error_N) <= by_level_N)) return;
    told_ = true;
    ++surprises;
    largest_N_ = 0.0;
    settling_ = 4.0 * exact(bound_.lag_ticks);
    squares_->doubt_mass(0.01F);
  }
  // A move is over once the axis has rested for long enough.
  void rest() {
    if (++rested_ != bound_.rest_ticks) return;
    settling_ = 0.0;
    told_ = false;
    if (largest_N_ == 0.0) return;
    before_last_N_ = last_N_;
    last_N_ = largest_N_;
    largest_N_ = 0.0;
  }
  void solve() {
    ticks_ = 0;
    learns_ = false;
    const double lowest = exact(bound_.lowest), highest = exact(bound_.highest), most = highest - lowest;
    const double newton = exact(bound_.typical_N), mps2 = exact(bound_.typical_mps2);
    const double lightest = exact(bound_.lightest_kg), heaviest = exact(bound_.heaviest_kg);
    const auto change = squares_->solve(
        bound_.priors,
        {static_cast<float>((lowest - whole_) * newton), static_cast<float>((highest - whole_) * newton),
         static_cast<float>((lightest - added_kg) * mps2), static_cast<float>((heaviest - added_kg) * mps2)},
        [&](std::size_t i, float part) {
          parts_[i] = std::clamp(parts_[i] + exact(part) / newton, -most, most);
        });
    whole_ = std::clamp(whole_ + exact(change.whole) / newton, lowest, highest);
    added_kg = std::clamp(added_kg + exact(change.mass) / mps2, lightest, heaviest);
  }

  Adaptation::Bounds bound_;
  std::unique_ptr<Squares> squares_ = std::make_unique<Squares>();
  std::array<double, 3> dry_{}, acceleration_{}, learned_{};
  std::array<double, Adaptation::kCells> parts_{};
  double whole_ = 1.0;
  double largest_N_ = 0.0, last_N_ = 0.0, before_last_N_ = 0.0, settling_ = 0.0;
  int rested_ = 0, ticks_ = 0;
  bool told_ = false, learns_ = false;
};

// Moves of random axes there and back, with pauses, friction that differs along the rail and a payload that
// comes and goes.
TEST(AdaptationLaw, LevelAndMassAreThoseOfTheLaw) {
  test::Draw draw(22);
  int surprises = 0, different = 0;
  double most_kg = 0.0, most_level = 0.0;
  for (int run = 0; run < 24; ++run) {
    SCOPED_TRACE(run);
    const AxisParameters axis = drawn_learner(draw);
    const double dry_N = draw.log_uniform(2.0, 40.0), mass_kg = draw.uniform(10.0, 60.0);
    const Adaptation::Bounds bound =
        Adaptation::bounds(axis, static_cast<float>(dry_N), static_cast<float>(mass_kg));
    const auto adaptation = std::make_unique<Adaptation>();
    adaptation->begin(bound);
    AdaptationInDouble law(bound);
    const double tick_s = exact(axis.tick_s), resolution_m = exact(axis.encoder_resolution_m);
    const double bandwidth = exact(axis.observer_bandwidth_rad_per_s);
    double x_m = draw.uniform(-0.1, 0.1), payload_kg = 0.0;
    std::array<double, 3> missing{};
    bool same = true;
    for (int move = 0; move < 14 && same; ++move) {
      if (draw.below(3) == 0) payload_kg = draw.uniform(-0.6, 1.2) * mass_kg;
      // Friction that is not learned would be taken for a mass where the acceleration is a rounding error.
      const double level = axis.adapt_level ? draw.uniform(0.5, 1.7) : 1.0;
      const double along = axis.adapt_level ? 0.2 : 0.0;
      const double peak =
          exact(axis.velocity_limit_mps) * draw.uniform(0.2, 1.0) * (move % 2 == 0 ? 1.0 : -1.0);
      const int ramp = 30 + static_cast<int>(draw.below(200)), plateau = static_cast<int>(draw.below(200));
      const int pause = static_cast<int>(draw.uniform(0.5, 3.0) * bound.rest_ticks);
      for (int i = 0; i < 2 * ramp + plateau + pause; ++i) {
        const bool up = i < ramp, down = i >= ramp + plateau && i < 2 * ramp + plateau;
        const bool moves = i < 2 * ramp + plateau;
        const double a = moves ? (up ? peak : down ? -peak : 0.0) / (ramp * tick_s) : 0.0;
        const double v = up      ? peak * i / ramp
                         : down  ? peak * (2 * ramp + plateau - i) / ramp
                         : moves ? peak
                                 : 0.0;
        x_m += v * tick_s;
        const double dry = moves ? std::copysign(dry_N, peak) : 0.0;
        // The axis misses what it has and the model has not, seen through the estimate.
        double seen =
            (level + along * std::sin(40.0 * x_m) - law.level) * dry + (payload_kg - law.added_kg) * a;
        for (double& stage : missing) seen = stage += (1.0 - std::exp(-bandwidth * tick_s)) * (seen - stage);
        Adaptation::Said said;
        said.counts = static_cast<std::int32_t>(std::lround(x_m / resolution_m));
        said.velocity = static_cast<float>(v * tick_s / resolution_m);
        said.dry_N = static_cast<float>(dry);
        said.acceleration_mps2 = static_cast<float>(a);
        said.residual_N = std::abs(v) > 0.05 * std::abs(peak)
                              ? static_cast<float>(seen + 0.02 * draw.normal())
                              : std::numeric_limits<float>::quiet_NaN();
        adaptation->step(bound, said);
        law.step(said);
        same = same && std::abs(exact(adaptation->level()) - law.level) < 2e-3 &&
               std::abs(exact(adaptation->added_kg()) - law.added_kg) < 2e-3 * mass_kg;
      }
      most_kg = std::max(most_kg, std::abs(law.added_kg) / mass_kg);
      most_level = std::max(most_level, std::abs(law.level - 1.0));
    }
    surprises += law.surprises;
    different += same ? 0 : 1;
  }
  // A surprise that is one by the last bit of a float only is another way from there on.
  EXPECT_LE(different, 2);
  EXPECT_GT(surprises, 40);
  EXPECT_GT(most_kg, 0.6);
  EXPECT_GT(most_level, 0.3);
}

}  // namespace
}  // namespace slipstack
