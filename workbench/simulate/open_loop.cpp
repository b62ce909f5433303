// SPDX-License-Identifier: Apache-2.0
#include "workbench/simulate/open_loop.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "workbench/simulate/free_run.h"

namespace slipstack::workbench {
namespace {

void judge(OpenLoop& result) {
  double squares = 0.0;
  double mean = 0.0;
  for (const double x : result.measured_m) mean += x;
  mean /= static_cast<double>(result.measured_m.size());
  double spread = 0.0;
  for (std::size_t i = 0; i < result.position_m.size(); ++i) {
    const double error = result.position_m[i] - result.measured_m[i];
    squares += error * error;
    spread += (result.measured_m[i] - mean) * (result.measured_m[i] - mean);
    result.largest_m = std::max(result.largest_m, std::abs(error));
    result.final_m = error;
  }
  result.rmse_m = std::sqrt(squares / static_cast<double>(result.position_m.size()));
  result.fit = 1.0 - std::sqrt(squares / std::max(spread, 1e-300));
}

}  // namespace

OpenLoop simulate_open_loop(const Measurement& measurement, const Terms& terms,
                            const OpenLoopOptions& options) {
  const double tick_s = measurement.tick_s();
  OpenLoop result;
  result.first = static_cast<std::size_t>(std::max(0.0, std::round(options.start_s / tick_s)));
  std::size_t end = measurement.sample_count();
  if (options.end_s > 0.0) {
    end = std::min(end, static_cast<std::size_t>(std::round(options.end_s / tick_s)) + 1);
  }
  if (result.first + 2 > end) throw std::invalid_argument("nothing is left between start and end");
  result.steps_per_sample = free_run_steps(measurement, terms);
  result.position_m =
      free_run(measurement, terms, {0, 0, result.first, end}, result.steps_per_sample, {}, options.progress);
  const std::vector<double>& measured_m = measurement.log().position_m;
  result.measured_m.assign(measured_m.begin() + static_cast<std::ptrdiff_t>(result.first),
                           measured_m.begin() + static_cast<std::ptrdiff_t>(end));
  judge(result);
  return result;
}

}  // namespace slipstack::workbench
