// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/block_bootstrap.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

namespace slipstack::workbench {
namespace {

constexpr std::size_t kDraws = 1000;
constexpr std::uint64_t kSeed = 1989;

}  // namespace

ConfidenceInterval block_bootstrap(const std::vector<double>& squared_errors,
                                   const std::vector<double>& weights) {
  const std::size_t blocks = squared_errors.size();
  if (blocks == 0) return {};
  std::mt19937_64 random(kSeed);
  std::vector<double> errors(kDraws);
  for (double& error : errors) {
    double sum = 0.0;
    double weight = 1e-300;
    for (std::size_t i = 0; i < blocks; ++i) {
      const std::size_t block = random() % blocks;
      sum += squared_errors[block];
      weight += weights[block];
    }
    error = std::sqrt(sum / weight);
  }
  std::sort(errors.begin(), errors.end());
  return {errors[kDraws / 40], errors[kDraws - 1 - kDraws / 40]};
}

ConfidenceInterval holdout_interval(const FittedModel& fitted) {
  return block_bootstrap(fitted.block_squared_error, fitted.block_weight);
}

}  // namespace slipstack::workbench
