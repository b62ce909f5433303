// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/sampling/stamps.h"

#include <cmath>
#include <utility>

#include "workbench/base/statistics.h"

namespace slipstack::workbench {

double median_step(const std::vector<double>& time_s) {
  std::vector<double> steps(time_s.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = time_s[i + 1] - time_s[i];
  return median(std::move(steps));
}

double rounded_rate_Hz(double step_s, double worst_s, std::size_t count) {
  const auto n = static_cast<double>(count);
  const double uncertainty = 4.0 * worst_s / (n * std::sqrt(n) * step_s) + 1e-12;  // relative
  const double rate_Hz = 1.0 / step_s;
  const auto close = [&](double candidate) {
    return candidate > 0.0 && std::abs(candidate - rate_Hz) <= uncertainty * rate_Hz;
  };
  const double whole_Hz = std::round(rate_Hz);
  if (close(whole_Hz)) return whole_Hz;
  const double whole_nanoseconds = std::round(step_s * 1e9);
  if (whole_nanoseconds > 0.0 && close(1e9 / whole_nanoseconds)) return 1e9 / whole_nanoseconds;
  return rate_Hz;
}

}  // namespace slipstack::workbench
