// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/outliers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "workbench/base/statistics.h"

namespace slipstack::workbench {
namespace {

/// Outliers wider than kWidest samples, and chains of more than kLongestChain outliers of which each is
/// within kApart samples of the next, are bursts. Where one sample in a hundred is an independent outlier,
/// every fifth lies that near to the next, and one chain in ten thousand is longer.
constexpr std::size_t kWidest = 3;
constexpr std::size_t kApart = 24;
constexpr std::size_t kLongestChain = 6;

/// Intervals of neighbouring outliers; bursts are left out.
std::vector<Interval> without_bursts(const std::vector<std::size_t>& found) {
  std::vector<Interval> intervals;
  for (std::size_t first = 0, end = 0; first < found.size(); first = end) {
    end = first + 1;
    while (end < found.size() && found[end] - found[end - 1] <= kApart) ++end;
    if (end - first > kLongestChain) continue;
    std::vector<Interval> chain;
    for (std::size_t i = first; i < end; ++i) {
      // One good sample between two outliers is interpolated with them; two good ones are kept.
      const bool together =
          !chain.empty() && (found[i] == chain.back().end || found[i] - chain.back().first < kWidest);
      if (together) {
        chain.back().end = found[i] + 1;
      } else {
        chain.push_back({found[i], found[i] + 1});
      }
    }
    const bool single = std::all_of(chain.begin(), chain.end(),
                                    [](const Interval& one) { return one.end - one.first <= kWidest; });
    if (single) intervals.insert(intervals.end(), chain.begin(), chain.end());
  }
  return intervals;
}

/// The surroundings of [first, end) with which its departure is compared.
Interval around(std::size_t first, std::size_t end, std::size_t count) {
  return {first > 4 * kApart ? first - 4 * kApart : 0, std::min(count, end + 4 * kApart)};
}

/// The value that nine tenths of the values do not exceed.
double ninth_decile(std::vector<double> values) {
  const std::size_t rank = values.size() * 9 / 10;
  return value_at_rank(std::move(values), rank);
}

/// Magnitude of the difference of each sample from the median of its window.
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

/// Largest difference between neighbouring samples within five samples on either side of the interval, those
/// that touch the interval or another outlier left out.
double largest_step_beside(const std::vector<double>& values, const Interval& one,
                           const std::vector<std::size_t>& found) {
  constexpr std::size_t kReach = 6;
  double largest = 0.0;
  const auto step_to = [&](std::size_t i) {
    const auto next = std::lower_bound(found.begin(), found.end(), i - 1);
    if (next == found.end() || *next > i) largest = std::max(largest, std::abs(values[i] - values[i - 1]));
  };
  for (std::size_t k = 2; k <= kReach; ++k) {
    if (one.first >= k) step_to(one.first - k + 1);
    if (one.end + k <= values.size()) step_to(one.end + k - 1);
  }
  return largest;
}

/// An outlier departs from the median by at least this many times the usual departure and the usual step of
/// its surroundings: ringing departs everywhere, and a median cuts the tip of every peak. Chosen.
constexpr double kAboveSurroundings = 8.0;
/// And by at least this many times the largest step next to it: the tip of a short peak, which rises and
/// falls over several samples, is not an outlier. Chosen.
constexpr double kAboveNeighbours = 5.0;

/// Whether the interval departs by far more than its surroundings.
bool stands_out(const std::vector<double>& values, const std::vector<double>& departures,
                const std::vector<std::size_t>& found, const Interval& one) {
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
  return own >= kAboveSurroundings * usual &&
         own >= kAboveNeighbours * largest_step_beside(values, one, found);
}

}  // namespace

/// An outlier departs from the median of its window by this many standard deviations of the noise ...
constexpr double kOutlier = 12.0;
/// ... and by this share of the largest departure within the window. Both chosen.
constexpr double kShareOfLargestOutlier = 0.2;

std::vector<Interval> outliers(const std::vector<double>& values, double noise, double least) {
  const std::vector<double> departures = departures_from_median(values);
  const double least_departure = std::max(kOutlier * noise, least);
  std::vector<std::size_t> found;
  for (std::size_t i = kHalfWindow; i + kHalfWindow < values.size(); ++i) {
    if (departures[i] <= least_departure) continue;
    // An outlier shifts the medians of its neighbours by one step of the signal; they are no outliers.
    const auto window = departures.begin() + static_cast<std::ptrdiff_t>(i - kHalfWindow);
    const double most = *std::max_element(window, window + 2 * kHalfWindow + 1);
    if (departures[i] > kShareOfLargestOutlier * most) found.push_back(i);
  }
  std::vector<Interval> intervals = without_bursts(found);
  std::erase_if(intervals, [&](const Interval& one) { return !stands_out(values, departures, found, one); });
  return intervals;
}

std::vector<double> departures_from_cubic(const std::vector<double>& values) {
  std::vector<double> departures(values.size(), 0.0);
  for (std::size_t i = 2; i + 2 < values.size(); ++i) {
    departures[i] = values[i] - (4.0 * (values[i - 1] + values[i + 1]) - values[i - 2] - values[i + 2]) / 6.0;
  }
  return departures;
}

/// A spike departs from the cubic by this many standard deviations of the noise, and by this many times the
/// departure that nine tenths of the samples around do not exceed. The thresholds are lower than those of
/// outliers(), because the cubic predicts a single sample better than the median. Chosen.
constexpr double kSpike = 9.0;
constexpr double kSpikeAmongOthers = 4.0;
/// A spike enters the cubics of its two neighbours with weight 4/6: they depart by two thirds of it with the
/// opposite sign. At a corner of the signal they depart by half, at a step one of them by all of it.
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
  return share < least_share ? std::vector<Interval>{} : without_bursts(found);
}

}  // namespace slipstack::workbench
