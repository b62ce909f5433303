// SPDX-License-Identifier: Apache-2.0
// Samples whose stamps are not uniform: read as uniform where the motion shows that they are, else
// interpolated.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "workbench/base/errors.h"
#include "workbench/base/statistics.h"
#include "workbench/log/sampling/sampling.h"
#include "workbench/log/sampling/stamps.h"

namespace slipstack::workbench {
namespace {

constexpr double kLongestIrregularStep = 10.0;  // in median steps; chosen

// The value at `t` of the cubic through four points.
double cubic_through(const std::array<double, 4>& at, const std::array<double, 4>& values, double t) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    double weight = 1.0;
    for (std::size_t k = 0; k < 4; ++k) {
      if (k != i) weight *= (t - at[k]) / (at[i] - at[k]);
    }
    sum += weight * values[i];
  }
  return sum;
}

// The index of each stamp on a uniform grid, from the steps between stamps; empty when two share an index.
std::vector<std::size_t> places_of(const std::vector<double>& time_s) {
  const double step_s = median_step(time_s);
  std::vector<std::size_t> places(time_s.size(), 0);
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    const double steps = std::round((time_s[i] - time_s[i - 1]) / step_s);
    if (!(steps >= 1.0 && steps <= kLongestIrregularStep)) return {};
    places[i] = places[i - 1] + static_cast<std::size_t>(steps);
  }
  return places;
}

// Least-squares line through the stamps over their indices on the grid.
StampLine fit_line(const std::vector<double>& time_s, const std::vector<std::size_t>& places) {
  const auto n = static_cast<double>(time_s.size());
  const StampLine chord{time_s.front(),
                        (time_s.back() - time_s.front()) / static_cast<double>(places.back())};
  double mean_place = 0.0;
  double mean_s = 0.0;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    mean_place += static_cast<double>(places[i]) / n;
    mean_s += (time_s[i] - chord.at(places[i])) / n;
  }
  double moment = 0.0;
  double square = 0.0;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    const double from_mean = static_cast<double>(places[i]) - mean_place;
    moment += from_mean * (time_s[i] - chord.at(places[i]) - mean_s);
    square += from_mean * from_mean;
  }
  const double slope_s = moment / square;
  return {chord.offset_s + mean_s - slope_s * mean_place, chord.step_s + slope_s};
}

// A stamp belongs to a grid point where it is nearer to it than to the next one.
constexpr double kOwnPlace = 0.5;  // of a step
// Positions are compared in this share of the samples, those where the two assumptions (uniform sampling,
// stamps as written) predict the most different positions. Chosen.
constexpr double kCompared = 0.1;
// Uniform sampling is accepted where its prediction errors are smaller by this factor. Chosen.
constexpr double kClearlyBetter = 2.0;

// Whether the cubic through the neighbours predicts positions much better over the grid than over the stamps.
bool smoother_by_place(const std::vector<double>& time_s, const std::vector<std::size_t>& places,
                       const std::vector<double>& position) {
  struct Prediction {
    double difference = 0.0, error_by_place = 0.0, error_by_time = 0.0;  // in units of the position
  };
  std::vector<Prediction> predictions;
  predictions.reserve(position.size());
  for (std::size_t i = 2; i + 2 < position.size(); ++i) {
    std::array<double, 4> place{}, time{}, value{};
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t j = i + k - 2 + (k >= 2 ? 1 : 0);
      place[k] = static_cast<double>(places[j]) - static_cast<double>(places[i]);
      time[k] = time_s[j] - time_s[i];
      value[k] = position[j] - position[i];
    }
    const double by_place = cubic_through(place, value, 0.0);
    const double by_time = cubic_through(time, value, 0.0);
    predictions.push_back({std::abs(by_place - by_time), std::abs(by_place), std::abs(by_time)});
  }
  const auto compared = static_cast<std::ptrdiff_t>(kCompared * static_cast<double>(predictions.size()));
  if (compared == 0) return false;
  std::nth_element(predictions.begin(), predictions.begin() + compared, predictions.end(),
                   [](const Prediction& a, const Prediction& b) { return a.difference > b.difference; });
  // Medians, because outliers of the position are among these samples too.
  std::vector<double> by_place, by_time;
  for (auto one = predictions.begin(); one != predictions.begin() + compared; ++one) {
    by_place.push_back(one->error_by_place);
    by_time.push_back(one->error_by_time);
  }
  return kClearlyBetter * median(std::move(by_place)) < median(std::move(by_time));
}

}  // namespace

std::optional<EvenSamples> evenly_sampled(const std::vector<double>& time_s,
                                          const std::vector<double>& position) {
  std::vector<std::size_t> places = places_of(time_s);
  if (places.empty()) return {};
  const StampLine line = fit_line(time_s, places);
  double worst_s = 0.0;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    worst_s = std::max(worst_s, std::abs(time_s[i] - line.at(places[i])));
  }
  if (worst_s <= kJitterTolerance * line.step_s || worst_s > kOwnPlace * line.step_s) return {};
  if (!smoother_by_place(time_s, places, position)) return {};
  return EvenSamples{
      {rounded_rate_Hz(line.step_s, worst_s, time_s.size()), line.offset_s}, std::move(places), worst_s};
}

ResamplingGrid resampling_grid(const std::vector<double>& time_s, const WhereRow& where) {
  const double step_s = median_step(time_s);
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    const double gap_s = time_s[i] - time_s[i - 1];
    if (gap_s <= kLongestIrregularStep * step_s) continue;
    throw InputError(
        fmt::format("{}: column time_s: a gap of {:.6g} s is too long to interpolate where the median step "
                    "is {:.6g} s; cut "
                    "the log there",
                    where(i), gap_s, step_s));
  }
  const double length_s = time_s.back() - time_s.front();
  // The last grid point is kept where only rounding puts it after the last stamp.
  const auto steps = static_cast<std::size_t>(length_s / step_s + 1e-6);
  return {{1.0 / step_s, time_s.front()}, steps + 1};
}

std::vector<double> resampled(const std::vector<double>& time_s, const std::vector<double>& values,
                              const ResamplingGrid& grid) {
  std::vector<double> result(grid.count);
  std::size_t right = 1;
  for (std::size_t i = 0; i < grid.count; ++i) {
    const double t = grid.sampling.start_s + static_cast<double>(i) / grid.sampling.rate_Hz;
    while (right + 1 < time_s.size() && time_s[right] < t) ++right;
    const double step_s = time_s[right] - time_s[right - 1];
    const double weight = std::clamp((t - time_s[right - 1]) / step_s, 0.0, 1.0);
    result[i] = std::lerp(values[right - 1], values[right], weight);
  }
  return result;
}

std::vector<double> resampled_smoothly(const std::vector<double>& time_s, const std::vector<double>& values,
                                       const ResamplingGrid& grid) {
  if (time_s.size() < 4) return resampled(time_s, values, grid);
  std::vector<double> result(grid.count);
  std::size_t right = 1;
  for (std::size_t i = 0; i < grid.count; ++i) {
    const double t = grid.sampling.start_s + static_cast<double>(i) / grid.sampling.rate_Hz;
    while (right + 1 < time_s.size() && time_s[right] < t) ++right;
    const std::size_t first = std::min(right > 2 ? right - 2 : 0, time_s.size() - 4);
    std::array<double, 4> at{}, value{};
    for (std::size_t k = 0; k < 4; ++k) {
      at[k] = time_s[first + k] - t;
      value[k] = values[first + k];
    }
    result[i] = cubic_through(at, value, 0.0);
  }
  return result;
}

}  // namespace slipstack::workbench
