// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/chance.h"

#include <cmath>
#include <numbers>

namespace slipstack::workbench {
namespace {

/// Standard errors within which a difference is chance: the limit of an interval of 95 %, as every interval
/// in the output has it.
constexpr double kChance = 2.0;

}  // namespace

bool mean_is_chance(std::span<const double> observations) {
  if (observations.size() < 2) return true;
  const auto count = static_cast<double>(observations.size());
  double sum = 0.0;
  double squares = 0.0;
  for (const double one : observations) {
    sum += one;
    squares += one * one;
  }
  const double variance_of_sum = count / (count - 1.0) * (squares - sum * sum / count);
  return sum * sum <= kChance * kChance * variance_of_sum;
}

bool equal_signs_are_chance(std::size_t count) {
  const auto signs = static_cast<double>(count);
  return signs * signs <= kChance * kChance * signs;
}

bool is_chance(double probability, double tried) {
  return probability * tried >= std::erfc(kChance / std::numbers::sqrt2);
}

}  // namespace slipstack::workbench
