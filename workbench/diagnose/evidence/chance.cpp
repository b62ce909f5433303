// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/chance.h"

namespace slipstack::workbench {
namespace {

/// Standard errors within which a difference is chance.
constexpr double kChance = 2.0;

}  // namespace

bool mean_is_chance(std::span<const double> observations) {
  const auto count = static_cast<double>(observations.size());
  if (count < 2.0) return true;
  double sum = 0.0;
  double squares = 0.0;
  for (const double one : observations) {
    sum += one;
    squares += one * one;
  }
  const double variance_of_sum = count / (count - 1.0) * (squares - sum * sum / count);
  return sum * sum <= kChance * kChance * variance_of_sum;
}

}  // namespace slipstack::workbench
