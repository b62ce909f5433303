// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "workbench/log/input_error.h"
#include "workbench/log/median.h"

namespace slipstack::workbench {
namespace {

constexpr double kJitterTolerance = 0.01;       // of a step, beyond the rounding of the stamps
constexpr double kLongestIrregularStep = 10.0;  // in median steps
constexpr double kLongestForMean = 2.5;  // in median steps: what coarsely rounded stamps may still show

double median_step(const std::vector<double>& time_s) {
  std::vector<double> steps(time_s.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = time_s[i + 1] - time_s[i];
  return median(std::move(steps));
}

// The step of the samples, not led astray by the very gaps that it is to find, nor by rounding as coarse as
// the step itself: the mean of all steps that are not far above the median.
double typical_step(const std::vector<double>& time_s) {
  const double limit = kLongestForMean * median_step(time_s);
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    const double step = time_s[i] - time_s[i - 1];
    if (step > limit) continue;
    sum += step;
    ++count;
  }
  return sum / static_cast<double>(count);
}

void require_no_gap(const std::vector<double>& time_s, const WhereRow& where) {
  const double typical = typical_step(time_s);
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    const double step = time_s[i] - time_s[i - 1];
    if (step > kLongestStep * typical) {
      throw InputError(fmt::format(
          "{}: column time_s: a gap of {:.6g} s where the step is {:.6g} s; cut the log there, or write the "
          "header line '# sampling: irregular' to interpolate",
          where(i), step, typical));
    }
    if (step < kShortestStep * typical) {
      throw InputError(fmt::format(
          "{}: column time_s: a step of {:.6g} s where the others are {:.6g} s; correct the time stamps, or "
          "write the header line '# sampling: irregular' to interpolate",
          where(i), step, typical));
    }
  }
}

// Least-squares line through the stamps: stamp i ≈ offset + i·step.
struct Line {
  double offset_s = 0.0;
  double step_s = 0.0;
  double at(std::size_t i) const { return offset_s + static_cast<double>(i) * step_s; }
};

Line fit_line(const std::vector<double>& time_s) {
  const auto n = static_cast<double>(time_s.size());
  const Line chord{time_s.front(), (time_s.back() - time_s.front()) / (n - 1.0)};
  // Residuals about the chord are small, so their sums keep their digits where sums of stamps would not.
  double sum = 0.0;
  double moment = 0.0;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    const double residual = time_s[i] - chord.at(i);
    sum += residual;
    moment += (static_cast<double>(i) - 0.5 * (n - 1.0)) * residual;
  }
  const double slope = 12.0 * moment / (n * (n * n - 1.0));
  return {chord.offset_s + sum / n - 0.5 * (n - 1.0) * slope, chord.step_s + slope};
}

// The power of ten, from 1 s down to 1 ns, that all stamps are multiples of; 0 when there is none.
double decimal_rounding_s(const std::vector<double>& time_s) {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  double scale = 1.0;
  for (int digits = 0; digits <= 9; ++digits, scale *= 10.0) {
    const auto is_multiple = [scale](double t) {
      const double scaled = t * scale;
      return std::abs(scaled - std::round(scaled)) <= 1e-4 + 4.0 * kEpsilon * std::abs(scaled);
    };
    if (std::all_of(time_s.begin(), time_s.end(), is_multiple)) return 1.0 / scale;
  }
  return 0.0;
}

// The round number that the stamps cannot be told from, or the rate itself.
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

}  // namespace

void require_growing_time(const std::vector<double>& time_s, const WhereRow& where) {
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    if (time_s[i] > time_s[i - 1]) continue;
    const char* const what = time_s[i] == time_s[i - 1] ? "repeats" : "goes back";
    throw InputError(fmt::format(
        "{}: column time_s: {} {} after {}; remove the row or correct its time, and write enough digits",
        where(i), time_s[i], what, time_s[i - 1]));
  }
  if (!std::isfinite(time_s.back() - time_s.front())) {
    throw InputError(where(time_s.size() - 1) +
                     ": column time_s: the log is longer than a number can hold; write seconds");
  }
}

Sampling uniform_sampling(const std::vector<double>& time_s, double storage_error_s, const WhereRow& where) {
  require_no_gap(time_s, where);
  const Line line = fit_line(time_s);
  std::size_t worst = 0;
  double worst_s = 0.0;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    const double distance = std::abs(time_s[i] - line.at(i));
    if (distance > worst_s) {
      worst = i;
      worst_s = distance;
    }
  }
  double tolerance_s = kJitterTolerance * line.step_s + storage_error_s;
  if (worst_s > tolerance_s) tolerance_s += decimal_rounding_s(time_s);
  if (!(worst_s <= tolerance_s)) {
    throw InputError(
        fmt::format("{}: column time_s: {} is {:.3g} s off the uniform time at {:.6g} Hz; correct the time "
                    "stamps, or write "
                    "the header line '# sampling: irregular' to interpolate",
                    where(worst), time_s[worst], worst_s, 1.0 / line.step_s));
  }
  return {rounded_rate_Hz(line.step_s, worst_s, time_s.size()), time_s.front()};
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
  // A last point that rounding alone puts behind the last stamp still belongs to the grid.
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

}  // namespace slipstack::workbench
