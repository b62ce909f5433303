// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/live/kept_part.h"

#include <algorithm>
#include <cstdint>

namespace slipstack::workbench {
namespace {

constexpr double kLongestGap = 10.0;  // samples that a log may lack in one place

/// Samples between two gaps, and how far the axis went there.
struct UnbrokenPart {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::int64_t travel_counts = 0;
  std::size_t length() const { return end - begin; }
};

std::vector<UnbrokenPart> unbroken_parts(std::span<const StreamSample> samples, const StreamedAxis& axis) {
  const double longest_ticks = kLongestGap / (axis.rate_Hz * axis.tick_s);
  std::vector<UnbrokenPart> parts;
  std::int64_t lowest = 0;
  std::int64_t highest = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::int64_t counts = samples[i].counts;
    if (i == 0 || static_cast<double>(samples[i].tick - samples[i - 1].tick) > longest_ticks) {
      parts.push_back({i, i, 0});
      lowest = highest = counts;
    }
    lowest = std::min(lowest, counts);
    highest = std::max(highest, counts);
    parts.back().end = i + 1;
    parts.back().travel_counts = highest - lowest;
  }
  return parts;
}

}  // namespace

bool is_long_enough(std::size_t samples, const StreamedAxis& axis) {
  return static_cast<double>(samples) >= kLeastRecording_s * axis.rate_Hz;
}

std::vector<StreamSample> part_to_keep(std::span<const StreamSample> samples, const StreamedAxis& axis) {
  const std::vector<UnbrokenPart> parts = unbroken_parts(samples, axis);
  std::int64_t farthest = 0;
  for (const UnbrokenPart& part : parts) {
    if (is_long_enough(part.length(), axis)) farthest = std::max(farthest, part.travel_counts);
  }
  UnbrokenPart kept;
  for (const UnbrokenPart& part : parts) {
    if (2 * part.travel_counts >= farthest && part.length() > kept.length()) kept = part;
  }
  const auto own = samples.subspan(kept.begin, kept.length());
  return {own.begin(), own.end()};
}

}  // namespace slipstack::workbench
