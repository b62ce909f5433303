// SPDX-License-Identifier: Apache-2.0
// What the adaptation learns: its least squares against a dense solution in double, and what it tells apart.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "firmware/control/force/adaptation.h"

namespace slipstack {
namespace {

// The same problem as a full matrix in double: unknowns are the parts, whole, mass.
template <std::size_t kCells>
class DenseLeastSquares {
 public:
  using Sparse = RailLeastSquares<kCells>;
  static constexpr int kWhole = kCells, kMass = kCells + 1, kSize = kCells + 2;

  explicit DenseLeastSquares(const typename Sparse::Priors& priors) : priors_(priors) {
    for (int i = 0; i < kSize; ++i) matrix_(i, i) = static_cast<double>(of(i).first);
  }
  void add(const typename Sparse::Measurement& seen) {
    const int near = static_cast<int>(seen.cell % kCells), far = (near + 1) % static_cast<int>(kCells);
    const double beyond = static_cast<double>(seen.beyond), part = static_cast<double>(seen.part);
    Eigen::VectorXd factors = Eigen::VectorXd::Zero(kSize);
    factors(near) = (1.0 - beyond) * part;
    factors(far) = beyond * part;
    factors(kWhole) = static_cast<double>(seen.whole);
    factors(kMass) = static_cast<double>(seen.mass);
    for (const int i : {near, far}) forget(i, kept(i, factors(i)), true);
    for (const int i : {kWhole, kMass}) kept_[static_cast<std::size_t>(i - kWhole)] *= kept(i, factors(i));
    matrix_ += factors * factors.transpose();
    if (far == 0) {
      // The ends of the line are not beside each other.
      const double both = factors(near) * factors(far);
      matrix_(near, far) -= both;
      matrix_(far, near) -= both;
      matrix_(near, near) += both;
      matrix_(far, far) += both;
    }
    right_ += factors * static_cast<double>(seen.error);
  }
  double known_of_part(int i) const { return matrix_(i, i); }
  /// Parts, whole, mass; those of `held` have this value.
  Eigen::VectorXd solve(double held_mass = std::nan("")) {
    forget(kWhole, kept_[0], false);
    forget(kMass, kept_[1], false);
    kept_ = {1.0, 1.0};
    Eigen::MatrixXd all = matrix_;
    for (int i = 0; i < kSize; ++i) all(i, i) += static_cast<double>(of(i).least);
    Eigen::VectorXd change(kSize);
    if (std::isnan(held_mass)) {
      change = all.ldlt().solve(right_);
    } else {
      change(kMass) = held_mass;
      change.head(kMass) = all.topLeftCorner(kMass, kMass)
                               .ldlt()
                               .solve(right_.head(kMass) - all.col(kMass).head(kMass) * held_mass);
    }
    right_.setZero();
    return change;
  }

 private:
  const typename Sparse::Prior& of(int i) const {
    return i == kWhole ? priors_.whole : i == kMass ? priors_.mass : priors_.part;
  }
  double kept(int i, double factor) const {
    return 1.0 / (1.0 + 0.5 * static_cast<double>(of(i).forgets) * factor * factor);
  }
  void forget(int i, double kept, bool right) {
    matrix_.row(i) *= kept;
    matrix_.col(i) *= kept;
    if (right) right_(i) *= kept;
  }

  typename Sparse::Priors priors_;
  Eigen::MatrixXd matrix_ = Eigen::MatrixXd::Zero(kSize, kSize);
  Eigen::VectorXd right_ = Eigen::VectorXd::Zero(kSize);
  std::array<double, 2> kept_{1.0, 1.0};
};

constexpr std::size_t kFew = 7;
using FewCells = RailLeastSquares<kFew>;
constexpr FewCells::Priors kPriors{
    .whole = {0.5F, 0.05F, 1e-3F}, .part = {2.0F, 0.2F, 1e-2F}, .mass = {4.0F, 0.1F, 3e-3F}};
constexpr float kFar = 1e9F;

template <class Visit>
void drive_randomly(std::uint32_t seed, int rounds, Visit&& visit) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  for (int round = 0; round < rounds; ++round) {
    std::vector<FewCells::Measurement> seen;
    // A stretch that is passed, around the end of the cells too.
    const auto first = static_cast<std::uint32_t>(random() % 1000);
    for (std::uint32_t i = 0; i < 10; ++i)
      seen.push_back({.whole = 1.0F + 0.3F * unit(random),
                      .part = unit(random) > 0.0F ? 1.0F : -1.0F,
                      .mass = 2.0F * unit(random),
                      .cell = first + i / 4,
                      .beyond = 0.25F * static_cast<float>(i % 4),
                      .error = unit(random)});
    visit(seen, random);
  }
}

void add_to_both(FewCells& few, DenseLeastSquares<kFew>& dense,
                 const std::vector<FewCells::Measurement>& seen) {
  for (const auto& one : seen) {
    few.add(kPriors, one);
    dense.add(one);
  }
}

TEST(RailLeastSquares, IsTheDenseSolutionToRounding) {
  FewCells few;
  few.begin(kPriors);
  DenseLeastSquares<kFew> dense(kPriors);
  double largest = 0.0;
  drive_randomly(3, 500, [&](const auto& seen, auto&) {
    add_to_both(few, dense, seen);
    std::array<float, kFew> parts{};
    const auto change =
        few.solve(kPriors, {-kFar, kFar, -kFar, kFar}, [&](std::size_t i, float part) { parts[i] = part; });
    const Eigen::VectorXd should = dense.solve();
    ASSERT_NEAR(change.whole, should(dense.kWhole), 2e-4);
    ASSERT_NEAR(change.mass, should(dense.kMass), 2e-4);
    for (std::size_t i = 0; i < kFew; ++i) ASSERT_NEAR(parts[i], should(static_cast<int>(i)), 2e-4) << i;
    largest = std::max(largest, should.cwiseAbs().maxCoeff());
  });
  EXPECT_GT(largest, 0.1) << "or it compared nothing";
}

// What is known of a place is the information of the two values beside it, by their shares.
TEST(RailLeastSquares, KnowsOfAPlaceWhatItKnowsBesideIt) {
  FewCells few;
  few.begin(kPriors);
  DenseLeastSquares<kFew> dense(kPriors);
  drive_randomly(6, 50, [&](const auto& seen, auto&) {
    add_to_both(few, dense, seen);
    for (std::uint32_t cell = 0; cell < 2 * kFew; ++cell) {
      const double near = dense.known_of_part(static_cast<int>(cell % kFew));
      const double far = dense.known_of_part(static_cast<int>((cell + 1) % kFew));
      for (const double beyond : {0.0, 0.3, 0.8}) {
        const double wanted = (1.0 - beyond) * near + beyond * far;
        ASSERT_NEAR(few.known(cell, static_cast<float>(beyond)), wanted, 1e-4 * wanted) << cell;
      }
    }
  });
}

TEST(RailLeastSquares, HoldsTheMassAtItsLimitAndTheOthersAreBestBesideIt) {
  FewCells few;
  few.begin(kPriors);
  DenseLeastSquares<kFew> dense(kPriors);
  int held = 0;
  drive_randomly(4, 500, [&](const auto& seen, auto&) {
    add_to_both(few, dense, seen);
    constexpr float kMost = 0.004F;
    std::array<float, kFew> parts{};
    const auto change =
        few.solve(kPriors, {-kFar, kFar, -kMost, kMost}, [&](std::size_t i, float part) { parts[i] = part; });
    ASSERT_LE(std::abs(change.mass), kMost);
    const bool at_limit = std::abs(change.mass) == kMost;
    held += at_limit ? 1 : 0;
    const Eigen::VectorXd should = at_limit ? dense.solve(static_cast<double>(change.mass)) : dense.solve();
    ASSERT_NEAR(change.mass, should(dense.kMass), 2e-4);
    ASSERT_NEAR(change.whole, should(dense.kWhole), 2e-4);
    for (std::size_t i = 0; i < kFew; ++i) ASSERT_NEAR(parts[i], should(static_cast<int>(i)), 2e-4) << i;
  });
  EXPECT_GT(held, 50);
  EXPECT_LT(held, 500);
}

// For the level as a whole alone, in closed form: what was known before fades by the forgetting, each tick
// adds dry^2.
TEST(Adaptation, IsTheLeastSquaresEstimateWithForgetting) {
  AxisParameters axis;
  axis.adapt_level = true;
  axis.level_memory_s = 0.5F;
  Adaptation::Bounds bounds = Adaptation::bounds(axis, 12.0F, 35.0F);
  bounds.pass = 1.0F;  // a residual without lag
  bounds.lag_ticks = 0.0F;
  Adaptation adaptation;
  adaptation.begin(bounds);
  const auto& prior = bounds.priors.whole;
  const double kept = std::pow(1.0 + 0.5e-4 / 0.5, -2.0);
  double known = static_cast<double>(prior.first), should = 1.0;
  for (int i = 0; i < 40000; ++i) {
    // 1.3, and 0.9 from the middle on.
    const double level = i < 20000 ? 1.3 : 0.9;
    const float dry_N = (i / 1000) % 2 == 0 ? 12.0F : -12.0F;
    const auto missed = static_cast<float>(level - static_cast<double>(adaptation.level())) * dry_N;
    adaptation.step(bounds, {0, 0.0F, dry_N, 3.0F, missed});
    if ((i + 1) % Adaptation::kTogether != 0) continue;
    constexpr double kTogether = Adaptation::kTogether;
    known = (known + kTogether) * std::pow(kept, kTogether);
    should += kTogether * (level - should) / (known + static_cast<double>(prior.least));
    ASSERT_NEAR(static_cast<double>(adaptation.level()), should, 1e-3) << i;
  }
  EXPECT_NEAR(adaptation.level(), 0.9F, 1e-2F);
  EXPECT_EQ(adaptation.added_kg(), 0.0F);
}

/// An axis that moves to and fro with rests between, the level of whose friction is a sine over the place;
/// what is missing comes through the low-pass of the state estimate.
class MovingAxis {
 public:
  explicit MovingAxis(const Adaptation::Bounds& bounds) : bounds_(bounds) {}

  double added_kg = 10.0;
  static double level_at(double x_m) { return 1.1 + 0.3 * std::sin(2.0 * std::numbers::pi * x_m / 0.2); }

  /// To the other side within 0.4 s, along the polynomial of least jerk, and 50 ms of rest there. By how much
  /// the level was wrong, rms over the way.
  double move(Adaptation& adaptation) {
    constexpr int kTicks = 4000, kRest = 500;
    const double way_m = way_ > 0 ? 0.26 : -0.26, begin_m = -0.5 * way_m, last_s = kTicks * 1e-4;
    double squares = 0.0;
    for (int i = 0; i < kTicks + kRest; ++i) {
      const double s = std::min(1.0, i / static_cast<double>(kTicks)), t = s * s;
      const double x_m = begin_m + way_m * t * s * (10.0 - 15.0 * s + 6.0 * t);
      const double velocity = way_m / last_s * 30.0 * t * (1.0 - 2.0 * s + t);
      const double acceleration = way_m / (last_s * last_s) * 60.0 * s * (1.0 - 3.0 * s + 2.0 * t);
      const double dry_N = std::copysign(12.0, way_m);
      const double wrong = static_cast<double>(adaptation.level()) - level_at(x_m);
      double missed_N =
          -wrong * dry_N + (added_kg - static_cast<double>(adaptation.added_kg())) * acceleration;
      for (double& stage : stages_)
        missed_N = stage += static_cast<double>(bounds_.pass) * (missed_N - stage);
      // As the tick says it: nothing while the reference is slow.
      const bool says = std::abs(velocity) > 5e-3;
      adaptation.step(bounds_,
                      {static_cast<std::int32_t>(std::lround(x_m * 1e6)), static_cast<float>(velocity * 1e2),
                       static_cast<float>(dry_N), static_cast<float>(acceleration),
                       says ? static_cast<float>(missed_N) : std::nanf("")});
      if (i < kTicks) squares += wrong * wrong;
    }
    way_ = -way_;
    return std::sqrt(squares / kTicks);
  }

 private:
  const Adaptation::Bounds& bounds_;
  int way_ = 1;
  std::array<double, 3> stages_{};
};

AxisParameters learning_axis() {
  AxisParameters axis;
  axis.adapt_level = axis.adapt_mass = true;
  axis.acceleration_limit_mps2 = 10.0F;
  return axis;
}

TEST(Adaptation, TellsLevelPlaceAndMassApartAsSoonAsItHasComeBack) {
  const Adaptation::Bounds bounds = Adaptation::bounds(learning_axis(), 12.0F, 35.0F);
  Adaptation adaptation;
  adaptation.begin(bounds);
  MovingAxis axis(bounds);
  const double first = axis.move(adaptation);
  for (int i = 0; i < 2; ++i) axis.move(adaptation);
  EXPECT_NEAR(adaptation.added_kg(), 10.0F, 0.1F);
  EXPECT_LT(axis.move(adaptation), 0.15 * first);
  for (int i = 0; i < 6; ++i) axis.move(adaptation);
  const double last = axis.move(adaptation);
  EXPECT_LT(last, 0.01);
  EXPECT_GT(last, 1e-4) << "linear between values 8 mm apart: some of it remains";
}

// What was learned of the rail stays: only the mass is another one.
TEST(Adaptation, LearnsAnotherPayloadWithinTheMoveThatCarriesIt) {
  const Adaptation::Bounds bounds = Adaptation::bounds(learning_axis(), 12.0F, 35.0F);
  Adaptation adaptation;
  adaptation.begin(bounds);
  MovingAxis axis(bounds);
  for (int i = 0; i < 10; ++i) axis.move(adaptation);
  // Taken up and put down with every move.
  for (const double kg : {-5.0, 16.0, 0.0, 16.0, 0.0, 12.0, 0.0, 12.0, 0.0, 12.0}) {
    axis.added_kg = kg;
    EXPECT_LT(axis.move(adaptation), 0.05) << kg;
    EXPECT_NEAR(adaptation.added_kg(), kg, 0.1) << kg;
    EXPECT_LT(axis.move(adaptation), 0.02) << kg;
  }
}

// What is learned at one place is linear between values 8 mm apart, and nothing beyond the next one.
TEST(Adaptation, APlaceSaysNothingOfPlacesBeyondTheNextValue) {
  Adaptation::Bounds bounds = Adaptation::bounds(learning_axis(), 12.0F, 35.0F);
  bounds.whole = bounds.mass = false;
  const auto at = [](int thousandths_m) { return 1000 * thousandths_m; };
  for (const int learned_mm : {-32, 0, 48}) {
    Adaptation adaptation;
    adaptation.begin(bounds);
    // Until the low-pass of the residual has forgotten how it began.
    for (int i = 0; i < 20000; ++i)
      adaptation.step(bounds, {at(learned_mm), 0.0F, 12.0F, 0.0F, (1.3F - adaptation.level()) * 12.0F});
    EXPECT_NEAR(adaptation.level(), 1.3F, 2e-3F);
    for (int away_mm = -20; away_mm <= 20; away_mm += 2) {
      adaptation.step(bounds, {at(learned_mm + away_mm), 0.0F, 12.0F, 0.0F, std::nanf("")});
      const float share = std::max(0.0F, 1.0F - static_cast<float>(std::abs(away_mm)) / 8.0F);
      EXPECT_NEAR(adaptation.level(), 1.0F + 0.3F * share, 3e-3F) << learned_mm << " mm and " << away_mm;
    }
  }
}

TEST(Adaptation, StaysBoundedForAnyInput) {
  AxisParameters axis;
  axis.adapt_level = axis.adapt_mass = true;
  axis.level_lowest = 0.6F;
  axis.level_highest = 1.4F;
  const Adaptation::Bounds bounds = Adaptation::bounds(axis, 15.0F, 35.0F);
  std::mt19937 random(9);
  Adaptation adaptation;
  adaptation.begin(bounds);
  const float inf = std::numeric_limits<float>::infinity();
  const float wild[] = {0.0F, 1.0F, -1.0F,         1e-30F, 1e30F, -1e30F,
                        inf,  -inf, std::nanf(""), 15.0F,  1e17F, 1e3F};
  const auto any = [&] { return wild[random() % std::size(wild)]; };
  for (int i = 0; i < 100000; ++i) {
    const auto counts = static_cast<std::int32_t>(random());
    const float velocity = any(), dry_N = any(), acceleration = any();
    adaptation.step(bounds, {counts, velocity, dry_N, acceleration, any()});
    ASSERT_GE(adaptation.level(), 0.6F);
    ASSERT_LE(adaptation.level(), 1.4F);
    ASSERT_GE(adaptation.added_kg(), -17.5F);
    ASSERT_LE(adaptation.added_kg(), 35.0F);
  }
  // And nothing of it stays: it learns as before.
  for (int i = 0; i < 20000; ++i)
    adaptation.step(bounds, {0, 0.0F, 15.0F, 0.0F, (1.2F - adaptation.level()) * 15.0F});
  EXPECT_NEAR(adaptation.level(), 1.2F, 1e-2F);
}

// Limits in other units while it learns: what was known of how the unknowns go together does not fit them.
TEST(Adaptation, AnotherAccelerationLimitLosesNothingThatWasLearned) {
  AxisParameters axis = learning_axis();
  const Adaptation::Bounds before = Adaptation::bounds(axis, 12.0F, 35.0F);
  axis.acceleration_limit_mps2 = 40.0F;
  const Adaptation::Bounds after = Adaptation::bounds(axis, 12.0F, 35.0F);
  Adaptation adaptation;
  adaptation.begin(before);
  MovingAxis first(before), then(after);
  for (int i = 0; i < 10; ++i) first.move(adaptation);
  adaptation.limit(after);
  EXPECT_NEAR(adaptation.added_kg(), 10.0F, 0.1F);
  for (int i = 0; i < 4; ++i) EXPECT_LT(then.move(adaptation), 0.02) << i;
  EXPECT_NEAR(adaptation.added_kg(), 10.0F, 0.1F);
}

}  // namespace
}  // namespace slipstack
