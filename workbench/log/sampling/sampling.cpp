// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/sampling/sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "workbench/base/errors.h"
#include "workbench/log/sampling/stamps.h"

namespace slipstack::workbench {
namespace {

constexpr double kLongestForMean = 2.5;  // in median steps: coarsely rounded stamps may show two

// The mean of all steps that are not far above the median. A plain mean would include the gaps that are to be
// found; the median alone is wrong where stamps are rounded as coarsely as one step.
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

// The least-squares line.
StampLine fit_line(const std::vector<double>& time_s) {
  const auto n = static_cast<double>(time_s.size());
  const StampLine chord{time_s.front(), (time_s.back() - time_s.front()) / (n - 1.0)};
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

// The largest power of ten, from 1 s down to 1 ns, of which all stamps are multiples; 0 when there is none.
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
                     ": column time_s: the duration is beyond the range of a number; write seconds");
  }
}

Sampling uniform_sampling(const std::vector<double>& time_s, double storage_error_s, const WhereRow& where) {
  require_no_gap(time_s, where);
  const StampLine line = fit_line(time_s);
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

}  // namespace slipstack::workbench
