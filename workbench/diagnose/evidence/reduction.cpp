// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/reduction.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "workbench/estimate/uncertainty/friction_each_way.h"

namespace slipstack::workbench {

Reduction reduction(const std::vector<double>& before, const std::vector<double>& after) {
  const double before_sum = std::accumulate(before.begin(), before.end(), 1e-300);
  const double after_sum = std::accumulate(after.begin(), after.end(), 0.0);
  Reduction result{1.0 - std::sqrt(std::max(0.0, after_sum) / before_sum), 0.0};
  std::vector<double> left_out;
  for (std::size_t b = 0; b < before.size(); ++b) {
    const double rest = std::max(before_sum - before[b], 1e-300);
    left_out.push_back(1.0 - std::sqrt(std::max(0.0, after_sum - after[b]) / rest));
  }
  result.standard_error = jackknife_error(left_out);
  return result;
}

double reduction_beyond(double energy, double expected) {
  const double excess = std::clamp((energy - expected) / (1.0 - expected), 0.0, 1.0);
  return 1.0 - std::sqrt(1.0 - excess);
}

}  // namespace slipstack::workbench
