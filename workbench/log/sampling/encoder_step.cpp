// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/sampling/encoder_step.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace slipstack::workbench {
namespace {

constexpr std::size_t kMinimumChanges = 10;
constexpr std::size_t kMaximumChanges = 4096;
constexpr std::size_t kCandidates = 64;      // smallest distinct changes that are tried, and their fractions
constexpr int kMaximumParts = 10;            // a fast log may show 7 and 10 steps but never a single one
constexpr double kMultipleTolerance = 0.02;  // of a step; a random change passes one time in 25
constexpr double kRequiredShare = 0.99;

struct Changes {
  std::vector<double> sizes_m;  // ascending, at most kMaximumChanges, evenly spread over the log
  bool has_repeats = false;     // some samples repeat the position before
};

Changes sorted_changes(const std::vector<double>& position_m, double storage_error_m) {
  Changes changes;
  std::vector<double>& sizes = changes.sizes_m;
  for (std::size_t i = 1; i < position_m.size(); ++i) {
    const double size_m = std::abs(position_m[i] - position_m[i - 1]);
    if (size_m > storage_error_m) {
      sizes.push_back(size_m);
    } else {
      changes.has_repeats = true;
    }
  }
  if (sizes.size() > kMaximumChanges) {
    // The smallest change limits the step most, so it is kept in any case.
    const double smallest = *std::min_element(sizes.begin(), sizes.end());
    for (std::size_t i = 0; i < kMaximumChanges; ++i) sizes[i] = sizes[i * sizes.size() / kMaximumChanges];
    sizes.resize(kMaximumChanges);
    sizes.front() = smallest;
  }
  std::sort(sizes.begin(), sizes.end());
  return changes;
}

struct Match {
  double step_m = 0.0;  // the mean over all multiples found; 0: too many changes are no multiples
  bool varied = false;  // different multiples occur; a smooth motion at constant speed shows one only
};

// Tests whether the changes are multiples of `step_m`. The step from one change is too inaccurate for large
// multiples, so it is refined by the smaller ones first.
Match match_multiples(const std::vector<double>& changes, double step_m) {
  double sum_m = 0.0;
  double sum_steps = 0.0;
  const auto allowed_misses =
      static_cast<std::size_t>((1.0 - kRequiredShare) * static_cast<double>(changes.size()));
  std::size_t misses = 0;
  double fewest_steps = std::numeric_limits<double>::infinity();
  double most_steps = 0.0;
  for (const double change : changes) {
    const double estimate = sum_steps > 0.0 ? sum_m / sum_steps : step_m;
    const double steps = std::round(change / estimate);
    if (steps < 1.0 || std::abs(change - steps * estimate) > kMultipleTolerance * estimate) {
      if (++misses > allowed_misses) return {};
      continue;
    }
    sum_m += change;
    sum_steps += steps;
    fewest_steps = std::min(fewest_steps, steps);
    most_steps = std::max(most_steps, steps);
  }
  return {sum_steps > 0.0 ? sum_m / sum_steps : 0.0, most_steps > fewest_steps};
}

// Rounded to four digits where that changes the step by less than one part in a million: 1.0000003e-7 is
// 1e-7.
double rounded_step(double step_m) {
  const double scale = std::pow(10.0, 3.0 - std::floor(std::log10(step_m)));
  const double rounded = std::round(step_m * scale) / scale;
  return std::abs(rounded - step_m) <= 1e-6 * step_m ? rounded : step_m;
}

}  // namespace

std::optional<double> estimate_encoder_step(const std::vector<double>& position_m, double storage_error_m) {
  const Changes changes = sorted_changes(position_m, storage_error_m);
  const std::vector<double>& sizes = changes.sizes_m;
  if (sizes.size() < kMinimumChanges) return std::nullopt;
  double best = 0.0;
  double previous = 0.0;
  std::size_t tried = 0;
  for (const double size_m : sizes) {
    if (size_m < previous * (1.0 + kMultipleTolerance)) continue;
    previous = size_m;
    if (++tried > kCandidates) break;
    for (int parts = 1; parts <= kMaximumParts; ++parts) {
      const double candidate = size_m / parts;
      // Multiples of smaller steps cannot be distinguished from rounding.
      if (candidate <= best || candidate * kMultipleTolerance < storage_error_m) continue;
      const Match match = match_multiples(sizes, candidate);
      const bool is_grid = match.varied || changes.has_repeats;
      if (is_grid && match.step_m > best) best = match.step_m;
    }
  }
  if (best == 0.0) return std::nullopt;
  const double step_m = rounded_step(best);
  return std::isnormal(step_m) ? std::optional<double>(step_m) : std::nullopt;
}

}  // namespace slipstack::workbench
