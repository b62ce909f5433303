// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/outliers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "workbench/base/statistics.h"

namespace slipstack::workbench {
namespace {

/// Wild samples next to each other, and in a chain of samples so near to each other: more are a burst. Of
/// wild samples that have nothing to do with each other, one in a hundred, every fifth is as near to the
/// next, and one chain in ten thousand is longer.
constexpr std::size_t kWidest = 3;
constexpr std::size_t kApart = 24;
constexpr std::size_t kLongestChain = 6;

/// Neighbours together, chains that are bursts left out.
std::vector<Interval> apart_from_bursts(const std::vector<std::size_t>& wild) {
  std::vector<Interval> intervals;
  for (std::size_t first = 0, end = 0; first < wild.size(); first = end) {
    end = first + 1;
    while (end < wild.size() && wild[end] - wild[end - 1] <= kApart) ++end;
    if (end - first > kLongestChain) continue;
    std::vector<Interval> chain;
    for (std::size_t i = first; i < end; ++i) {
      // A good sample between two wild ones goes with them, two good ones hold what was there.
      const bool together =
          !chain.empty() && (wild[i] == chain.back().end || wild[i] - chain.back().first < kWidest);
      if (together) {
        chain.back().end = wild[i] + 1;
      } else {
        chain.push_back({wild[i], wild[i] + 1});
      }
    }
    const bool single = std::all_of(chain.begin(), chain.end(),
                                    [](const Interval& one) { return one.end - one.first <= kWidest; });
    if (single) intervals.insert(intervals.end(), chain.begin(), chain.end());
  }
  return intervals;
}

/// The samples by which it is judged how far one stands out: [first, end).
Interval around(std::size_t first, std::size_t end, std::size_t count) {
  return {first > 4 * kApart ? first - 4 * kApart : 0, std::min(count, end + 4 * kApart)};
}

/// What nine in ten of them do not exceed.
double ninth_decile(std::vector<double> values) {
  const std::size_t rank = values.size() * 9 / 10;
  return value_at_rank(std::move(values), rank);
}

/// What each sample differs by from the median of its window.
std::vector<double> departures_from_median(const std::vector<double>& values) {
  std::vector<double> departures(values.size(), 0.0);
  for (std::size_t i = kHalfWindow; i + kHalfWindow < values.size(); ++i) {
    std::array<double, 2 * kHalfWindow + 1> window{};
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(i - kHalfWindow), window.size(), window.begin());
    std::nth_element(window.begin(), window.begin() + kHalfWindow, window.end());
    departures[i] = std::abs(values[i] - window[kHalfWindow]);
  }
  return departures;
}

/// Of the five samples on either side, those next to the stretch and other wild ones left out.
double largest_step_beside(const std::vector<double>& values, const Interval& one,
                           const std::vector<std::size_t>& wild) {
  constexpr std::size_t kReach = 6;
  double largest = 0.0;
  const auto step_to = [&](std::size_t i) {
    const auto next = std::lower_bound(wild.begin(), wild.end(), i - 1);
    if (next == wild.end() || *next > i) largest = std::max(largest, std::abs(values[i] - values[i - 1]));
  };
  for (std::size_t k = 2; k <= kReach; ++k) {
    if (one.first >= k) step_to(one.first - k + 1);
    if (one.end + k <= values.size()) step_to(one.end + k - 1);
  }
  return largest;
}

/// A wild sample stands out of its neighbours' median by this many times as much as samples around it do, or
/// as they step: ringing stands out everywhere, and a median cuts the tip of every peak.
constexpr double kOutlierAmongOthers = 8.0;
/// Nor is the tip of a short peak wild, which rises and falls by steps on either side.
constexpr double kOutlierAmongNeighbours = 5.0;

/// Whether the stretch departs by far more than what is around it.
bool stands_out(const std::vector<double>& values, const std::vector<double>& departures,
                const std::vector<std::size_t>& wild, const Interval& one) {
  const double own = *std::max_element(departures.begin() + static_cast<std::ptrdiff_t>(one.first),
                                       departures.begin() + static_cast<std::ptrdiff_t>(one.end));
  const Interval near = around(one.first, one.end, values.size());
  std::vector<double> others, steps;
  others.reserve(near.size());
  steps.reserve(near.size());
  for (std::size_t i = near.first + 1; i < near.end; ++i) {
    if (i < one.first || i >= one.end) others.push_back(departures[i]);
    steps.push_back(std::abs(values[i] - values[i - 1]));
  }
  const double usual = std::max(ninth_decile(std::move(others)), median(std::move(steps)));
  return own >= kOutlierAmongOthers * usual &&
         own >= kOutlierAmongNeighbours * largest_step_beside(values, one, wild);
}

}  // namespace

/// A wild sample stands this many standard deviations of the noise out of its neighbours' median ...
constexpr double kOutlier = 12.0;
/// ... and by this share of the wildest within the window.
constexpr double kShareOfLargestOutlier = 0.2;

std::vector<Interval> outliers(const std::vector<double>& values, double noise, double least) {
  const std::vector<double> departures = departures_from_median(values);
  const double least_departure = std::max(kOutlier * noise, least);
  std::vector<std::size_t> wild;
  for (std::size_t i = kHalfWindow; i + kHalfWindow < values.size(); ++i) {
    if (departures[i] <= least_departure) continue;
    // One wild sample moves the medians of its neighbours by a step of the signal: they are not wild.
    const auto window = departures.begin() + static_cast<std::ptrdiff_t>(i - kHalfWindow);
    const double most = *std::max_element(window, window + 2 * kHalfWindow + 1);
    if (departures[i] > kShareOfLargestOutlier * most) wild.push_back(i);
  }
  std::vector<Interval> intervals = apart_from_bursts(wild);
  std::erase_if(intervals, [&](const Interval& one) { return !stands_out(values, departures, wild, one); });
  return intervals;
}

std::vector<double> departures_from_cubic(const std::vector<double>& values) {
  std::vector<double> departures(values.size(), 0.0);
  for (std::size_t i = 2; i + 2 < values.size(); ++i) {
    departures[i] = values[i] - (4.0 * (values[i - 1] + values[i + 1]) - values[i - 2] - values[i + 2]) / 6.0;
  }
  return departures;
}

/// One sample alone is wild by less, where what its neighbours say of it, a cubic, is known so well: this
/// many standard deviations of the noise, and times what nine in ten samples around differ by from theirs.
constexpr double kSpike = 9.0;
constexpr double kSpikeAmongOthers = 4.0;
/// It makes its neighbours differ by two thirds of that, the other way. A corner makes them differ by half of
/// that, a step by all of it on one side.
constexpr double kLeastEcho = 0.52;
constexpr double kMostEcho = 0.9;
std::vector<Interval> spikes(const std::vector<double>& values, double noise, double least_share) {
  const std::vector<double> departures = departures_from_cubic(values);
  std::vector<std::size_t> found;
  for (std::size_t i = 3; i + 3 < values.size(); ++i) {
    const double own = std::abs(departures[i]);
    if (own <= kSpike * noise) continue;
    const double before = -departures[i - 1] / departures[i];
    const double behind = -departures[i + 1] / departures[i];
    if (std::min(before, behind) < kLeastEcho || std::max(before, behind) > kMostEcho) continue;
    const Interval near = around(i, i, values.size());
    std::vector<double> others;
    others.reserve(near.size());
    for (std::size_t k = near.first; k < near.end; ++k) others.push_back(std::abs(departures[k]));
    if (own > kSpikeAmongOthers * ninth_decile(std::move(others))) found.push_back(i);
  }
  const double share = static_cast<double>(found.size()) / static_cast<double>(values.size());
  return share < least_share ? std::vector<Interval>{} : apart_from_bursts(found);
}

}  // namespace slipstack::workbench
