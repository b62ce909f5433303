// SPDX-License-Identifier: Apache-2.0
// Times the fit of a model to a log and nothing else, for fit_against_scipy.py: reading, conditioning,
// standard errors and the model file are outside the clock.
//   fit_bench LOG EFFECT...      prints seconds, processor seconds and relative error, as JSON
#include <chrono>
#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/nonlinear/robust.h"
#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/log/log.h"

int main(int count, char** words) {
  using namespace slipstack::workbench;
  if (count < 3) {
    std::fputs("fit_bench: give a log and the effects to fit\n", stderr);
    return 2;
  }
  Measurement measurement(read_log(words[1]), ConditioningOptions{});
  weigh_rows(measurement);
  const std::vector<std::string> effects(words + 2, words + count);
  const std::clock_t processor = std::clock();
  const auto start = std::chrono::steady_clock::now();
  const RobustFit fit = fit_robustly(measurement, fit_effects(measurement, effects, {}));
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
  const nlohmann::json result = {
      {"seconds", passed.count()},
      {"processor_s", static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC},
      {"relative_error", fit.model.relative_error}};
  std::puts(result.dump().c_str());
  return 0;
}
