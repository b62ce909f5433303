// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/measurement/clocks.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "workbench/estimate/terms/search_ranges.h"

namespace slipstack::workbench {
namespace {

/// Slip distances of the stop operators, as shares of the travel; shorter ones are the sign of the velocity.
constexpr std::array<double, 5> kSlipOfTravel{0.001, 0.004, 0.015, 0.06, 0.25};
constexpr Eigen::Index kClockTerms = MotionTerms::kCount + static_cast<Eigen::Index>(kSlipOfTravel.size());

using ClockColumns = Eigen::Matrix<double, Eigen::Dynamic, kClockTerms>;
using ClockVector = Eigen::Matrix<double, kClockTerms, 1>;
using ClockMatrix = Eigen::Matrix<double, kClockTerms, kClockTerms>;

/// The force of a stop operator of unit level over the samples.
std::vector<double> stop_operator(const Measurement& measurement, double slip_m) {
  const std::vector<double>& position_m = measurement.position_m();
  std::vector<double> force(position_m.size());
  for (const LogPart& part : measurement.parts()) {
    double deflection = 0.0;
    for (std::size_t i = part.first_sample + 1; i < part.end_sample(); ++i) {
      deflection = std::clamp(deflection + (position_m[i] - position_m[i - 1]) / slip_m, -1.0, 1.0);
      force[i] = deflection;
    }
  }
  return force;
}

/// The terms at the rows, each with a largest value of one.
ClockColumns columns_of(const Measurement& measurement, const MotionTerms& terms) {
  ClockColumns columns(measurement.row_count(), kClockTerms);
  columns.leftCols(MotionTerms::kCount) = terms.at_rows;
  const double travel_m = measurement.position_range_m().length();
  for (std::size_t i = 0; i < kSlipOfTravel.size(); ++i) {
    columns.col(MotionTerms::kCount + static_cast<Eigen::Index>(i)) =
        measurement.filtered(stop_operator(measurement, kSlipOfTravel[i] * travel_m));
  }
  for (Eigen::Index c = 0; c < kClockTerms; ++c)
    columns.col(c) /= std::max(columns.col(c).cwiseAbs().maxCoeff(), 1e-300);
  return columns;
}

/// How the force follows from the motion at a lag, both as shares of it.
struct FitAtLag {
  double left = 0.0;     ///< of the mean square of the force: unexplained
  double inertia = 0.0;  ///< of its rms: that of the inertia; negative where the mass is
  double mass = 0.0;     ///< of the declared mass; of 1 kg where a log declares none
};

/// Fits of the force by the motion at one lag after another, always at the same rows.
class FitByLag {
 public:
  FitByLag(const Measurement& measurement, const MotionTerms& terms, Eigen::Index most)
      : columns_(columns_of(measurement, terms)), force_N_(measurement.force_N()) {
    ClockMatrix normal = ClockMatrix::Zero();
    for (const LogPart& part : measurement.parts()) {
      const auto first = static_cast<Eigen::Index>(part.first_row);
      const auto count = static_cast<Eigen::Index>(part.row_count);
      for (Eigen::Index row = first + most; row < first + count - most; ++row) {
        if (measurement.row_usable()(row) == 0.0) continue;
        rows_.push_back(row);
        normal += columns_.row(row).transpose() * columns_.row(row);
      }
    }
    inertia_squares_ = normal(MotionTerms::kInertia, MotionTerms::kInertia);
    largest_inertia_N_ = terms.at_rows.col(MotionTerms::kInertia).cwiseAbs().maxCoeff();
    normal.diagonal().array() += 1e-9 * static_cast<double>(rows_.size());  // a log may not excite all terms
    normal_.compute(normal);
  }

  bool has_rows() const { return static_cast<Eigen::Index>(rows_.size()) >= 4 * kClockTerms; }
  FitAtLag operator()(Eigen::Index lag) const {
    ClockVector right = ClockVector::Zero();
    double squares_N2 = 1e-300;
    for (const Eigen::Index row : rows_) {
      const double own_N = force_N_(row + lag);
      right += own_N * columns_.row(row).transpose();
      squares_N2 += own_N * own_N;
    }
    const ClockVector gains = normal_.solve(right);
    return {std::max(0.0, 1.0 - right.dot(gains) / squares_N2),
            gains(MotionTerms::kInertia) * std::sqrt(inertia_squares_ / squares_N2),
            gains(MotionTerms::kInertia) / std::max(largest_inertia_N_, 1e-300)};
  }

 private:
  ClockColumns columns_;
  Eigen::VectorXd force_N_;
  std::vector<Eigen::Index> rows_;
  double inertia_squares_ = 0.0;
  double largest_inertia_N_ = 0.0;
  Eigen::LDLT<ClockMatrix> normal_;
};

}  // namespace

std::optional<ClockDifference> clock_difference(const Measurement& measurement, const MotionTerms& terms) {
  constexpr double kLongest_s = 0.5;
  constexpr double kDelay_s = 0.02;  // the longest that the catalogue's delay is searched for
  // Of the mean square that is left at the best of those delays. With EMPS and a simulated axis, shifted by
  // 50 to 300 ms, it falls to 0.2 to 5 %; on 720 training logs, nothing shifted, to no less than 16 %.
  constexpr double kFarBetter = 0.1;
  // A clock shows by the inertia. In slow motion without it a lag imitates what friction of another form does
  // at reversals: a simulated axis that falls from standstill asked for 264 ms at an inertia of 1.6 % of the
  // force (rms); of the shifted logs it has 70 to 95 %. Much more than all of the force is no inertia but
  // cancels other terms: in motion of one frequency those fit at any lag.
  constexpr double kMostIsInertia = 0.5;
  // Of a declared mass either way: drives are sized for loads of up to ten times the inertia of their motor.
  constexpr double kOwnMass = 10.0;
  const double row_s = 1.0 / measurement.row_rate_Hz();
  const auto most = static_cast<Eigen::Index>(std::ceil(kLongest_s / row_s));
  const FitByLag fit(measurement, terms, most);
  if (!fit.has_rows()) return {};
  double within_delay = 1.0;
  FitAtLag beyond{1.0};
  Eigen::Index best = 0;
  for (Eigen::Index lag = -most; lag <= most; ++lag) {
    const FitAtLag own = fit(lag);
    if (std::abs(static_cast<double>(lag)) * row_s <= kDelay_s) {
      within_delay = std::min(within_delay, own.left);
    } else if (own.left < beyond.left) {
      beyond = own;
      best = lag;
    }
  }
  if (beyond.left >= kFarBetter * within_delay || std::abs(best) == most) return {};
  if (beyond.inertia < kMostIsInertia || beyond.inertia * kMostIsInertia > 1.0) return {};
  const bool declared = std::all_of(measurement.parts().begin(), measurement.parts().end(),
                                    [](const LogPart& part) { return part.mass_kg.value_or(0.0) > 0.0; });
  if (declared && (beyond.mass > kOwnMass || beyond.mass * kOwnMass < 1.0)) return {};
  return ClockDifference{static_cast<double>(best) * row_s, row_s};
}

}  // namespace slipstack::workbench
