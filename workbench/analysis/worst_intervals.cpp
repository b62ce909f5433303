// SPDX-License-Identifier: Apache-2.0
#include "workbench/analysis/worst_intervals.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "workbench/diagnose/evidence/held_out.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kIntervals = 60;  // enough to show where, few enough to be stable; chosen

// A reversal is seen when the axis has come back by this many steps of the encoder: its noise is one. Chosen.
constexpr double kReversedSteps = 4.0;

struct Sum {
  double squares = 0.0;
  double weight = 0.0;
  WorstInterval interval;
};

void take(Sum& sum, double time_s, double position_m, double velocity_mps, double residual_N) {
  WorstInterval& in = sum.interval;
  if (sum.weight == 0.0) {
    in = {time_s, time_s, 0.0, position_m, position_m, 0.0};
  }
  in.to_s = time_s;
  in.low_m = std::min(in.low_m, position_m);
  in.high_m = std::max(in.high_m, position_m);
  in.fastest_mps = std::max(in.fastest_mps, std::abs(velocity_mps));
  sum.squares += residual_N * residual_N;
  sum.weight += 1.0;
  in.rmse_N = std::sqrt(sum.squares / sum.weight);
}

}  // namespace

std::vector<WorstInterval> worst_intervals(const Measurement& measurement, const Eigen::VectorXd& residual_N,
                                           std::size_t count) {
  const Eigen::VectorXd time_s = row_times(measurement);
  const Eigen::VectorXd position_m = at_rows(measurement, measurement.position_m());
  const Eigen::VectorXd velocity_mps = at_rows(measurement, measurement.velocity_mps());
  std::vector<Sum> sums(kIntervals);
  const Eigen::Index rows = residual_N.size();
  for (Eigen::Index row = 0; row < rows; ++row) {
    if (measurement.row_usable()(row) == 0.0) continue;
    Sum& sum = sums[static_cast<std::size_t>(row) * kIntervals / static_cast<std::size_t>(rows)];
    take(sum, time_s(row), position_m(row), velocity_mps(row), residual_N(row));
  }
  std::erase_if(sums, [](const Sum& sum) { return sum.weight < 10.0; });
  std::sort(sums.begin(), sums.end(),
            [](const Sum& a, const Sum& b) { return a.interval.rmse_N > b.interval.rmse_N; });
  std::vector<WorstInterval> worst;
  for (std::size_t i = 0; i < std::min(count, sums.size()); ++i) worst.push_back(sums[i].interval);
  return worst;
}

nlohmann::json worst_json(const std::vector<WorstInterval>& intervals) {
  nlohmann::json list = nlohmann::json::array();
  for (const WorstInterval& one : intervals) {
    list.push_back({{"from_s", one.from_s},
                    {"to_s", one.to_s},
                    {"rmse_N", one.rmse_N},
                    {"low_m", one.low_m},
                    {"high_m", one.high_m},
                    {"fastest_mps", one.fastest_mps}});
  }
  return list;
}

Eigen::VectorXd since_reversal_s(const Measurement& measurement) {
  const std::vector<double>& position_m = measurement.position_m();
  const double back_m = kReversedSteps * measurement.encoder_resolution_m();
  std::vector<double> since_s(position_m.size(), 0.0);
  for (const LogPart& part : measurement.parts()) {
    std::size_t turned = part.first_sample;   // sample of the last reversal
    std::size_t extreme = part.first_sample;  // of the farthest position since
    double direction = 0.0;
    for (std::size_t i = part.first_sample; i < part.end_sample(); ++i) {
      const double moved_m = position_m[i] - position_m[extreme];
      if (direction == 0.0) {
        if (std::abs(moved_m) > back_m) direction = moved_m > 0.0 ? 1.0 : -1.0;
      } else if (direction * moved_m > 0.0) {
        extreme = i;
      } else if (direction * moved_m < -back_m) {
        direction = -direction;
        turned = extreme;
        extreme = i;
      }
      since_s[i] = static_cast<double>(i - turned) * measurement.tick_s();
    }
  }
  return at_rows(measurement, since_s);
}

}  // namespace slipstack::workbench
