// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/held_position.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/statistics.h"

namespace slipstack::workbench {

PositionUpdates updates_of_position(const std::vector<double>& position_m) {
  constexpr std::size_t kFewest = 50;  // changes; of fewer nothing follows
  constexpr double kSeveral = 3.0;     // encoder steps in the median change; chosen
  constexpr double kNearlyAll = 0.98;  // of the changes; chosen
  std::vector<std::size_t> changed;
  for (std::size_t i = 1; i < position_m.size(); ++i) {
    if (position_m[i] != position_m[i - 1]) changed.push_back(i);
  }
  if (changed.size() < kFewest) return {};
  std::vector<double> apart;
  for (std::size_t k = 1; k < changed.size(); ++k)
    apart.push_back(static_cast<double>(changed[k] - changed[k - 1]));
  const auto period = static_cast<std::size_t>(median(apart));
  if (period < 2) return {};
  std::vector<double> size_m;
  size_m.reserve(changed.size());
  for (const std::size_t i : changed) size_m.push_back(std::abs(position_m[i] - position_m[i - 1]));
  if (median(size_m) < kSeveral * *std::min_element(size_m.begin(), size_m.end())) return {};
  std::vector<std::size_t> at_place(period);
  for (const std::size_t i : changed) ++at_place[i % period];
  const auto most = std::max_element(at_place.begin(), at_place.end());
  if (static_cast<double>(*most) < kNearlyAll * static_cast<double>(changed.size())) return {};
  return {period, static_cast<std::size_t>(most - at_place.begin())};
}

std::optional<std::string> keep_updates_of_position(Log& log) {
  const PositionUpdates updates = updates_of_position(log.position_m);
  if (updates.period == 1 || log.position_m.size() / updates.period <= Log::kMinimumSamples) return {};
  for (const auto column : kSampleColumns) {
    std::vector<double>& values = log.*column;
    std::size_t kept = 0;
    for (std::size_t i = updates.first; i < values.size(); i += updates.period) values[kept++] = values[i];
    values.resize(kept);
  }
  log.start_time_s += static_cast<double>(updates.first) / log.sample_rate_Hz;
  log.sample_rate_Hz /= static_cast<double>(updates.period);
  return fmt::format(
      "the position changes only every {} samples: only the rows in which it is new are used ({:.4g} Hz)",
      updates.period, log.sample_rate_Hz);
}

}  // namespace slipstack::workbench
