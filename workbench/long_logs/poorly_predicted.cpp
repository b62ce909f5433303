// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/poorly_predicted.h"

#include <algorithm>
#include <tuple>

#include "workbench/long_logs/log_sums.h"

namespace slipstack::workbench {
namespace {

/// A window is poorly predicted where its error is this many times the largest error in the excerpt; chosen.
constexpr double kPoorlyPredicted = 5.0;
constexpr std::size_t kMostPoorlyPredicted = 3;

/// Whether the window lies within the excerpt. The burn-in of an interval was not compared with the model.
bool was_searched(const Window& window, const std::vector<LogInterval>& excerpt,
                  const Measurement& measurement) {
  for (std::size_t i = 0; i < excerpt.size(); ++i) {
    const std::size_t known = excerpt[i].first + measurement.parts()[i].burn_in;
    if (excerpt[i].log == window.log && window.first() >= known &&
        window.end() <= excerpt[i].first + excerpt[i].count) {
      return true;
    }
  }
  return false;
}

}  // namespace

std::vector<LogInterval> poorly_predicted(const std::vector<LongLog>& logs,
                                          const std::vector<Window>& windows,
                                          const std::vector<LogInterval>& excerpt,
                                          const Measurement& measurement) {
  double reference_error_N = 0.0;
  std::vector<Window> unknown;
  for (const Window& window : windows) {
    if (window.weight <= 0.0) continue;
    if (was_searched(window, excerpt, measurement)) {
      reference_error_N = std::max(reference_error_N, window.rmse_N());
    } else {
      unknown.push_back(window);
    }
  }
  std::sort(unknown.begin(), unknown.end(), [](const Window& a, const Window& b) {
    return std::tuple(-a.rmse_N(), a.log, a.index) < std::tuple(-b.rmse_N(), b.log, b.index);
  });
  std::vector<LogInterval> found;
  for (const Window& window : unknown) {
    if (window.rmse_N() < kPoorlyPredicted * reference_error_N || found.size() == kMostPoorlyPredicted) break;
    const LongLog& log = logs[window.log];
    const std::size_t first = chunk_start(log, window.first());
    found.push_back({window.log, first, std::min(log.sample_count(), window.end()) - first});
  }
  return found;
}

}  // namespace slipstack::workbench
