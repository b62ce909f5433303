// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/chance.h"

#include <cmath>
#include <numbers>

namespace slipstack::workbench {
namespace {

/// Standard errors within which a difference is chance: the limit of an interval of 95 %, as every interval
/// in the output has it.
constexpr double kChance = 2.0;

/// A mean and the variance of its sum.
struct Sum {
  double value = 0.0;
  double variance = 0.0;
};
Sum sum_of(std::span<const double> observations) {
  const auto count = static_cast<double>(observations.size());
  double sum = 0.0;
  double squares = 0.0;
  for (const double one : observations) {
    sum += one;
    squares += one * one;
  }
  return {sum, count / (count - 1.0) * (squares - sum * sum / count)};
}

}  // namespace

bool mean_is_chance(std::span<const double> observations) {
  if (observations.size() < 2) return true;
  const Sum sum = sum_of(observations);
  return sum.value * sum.value <= kChance * kChance * sum.variance;
}

bool equal_signs_are_chance(std::size_t count) {
  const auto signs = static_cast<double>(count);
  return signs * signs <= kChance * kChance * signs;
}

bool is_chance(double probability, double tried) {
  return probability * tried >= std::erfc(kChance / std::numbers::sqrt2);
}

double chance_of_mean(std::span<const double> observations) {
  if (observations.size() < 2) return 1.0;
  const Sum sum = sum_of(observations);
  if (!(sum.value > 0.0)) return 1.0;
  const double freedom = static_cast<double>(observations.size()) - 1.0;
  const double t2 = sum.value * sum.value / std::fmax(sum.variance, 1e-300);
  return std::pow(1.0 + t2 / freedom, -0.5 * freedom);
}

}  // namespace slipstack::workbench
