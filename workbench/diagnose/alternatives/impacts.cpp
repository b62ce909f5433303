// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/impacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/axis_words.h"
#include "workbench/base/quantity.h"

namespace slipstack::workbench {
namespace {

/// The largest deviation from the mean of the samples on either side [N].
double height_N(const std::vector<double>& force_N, const Interval& pulse) {
  const double before_N = force_N[pulse.first == 0 ? pulse.end : pulse.first - 1];
  const double after_N = force_N[std::min(pulse.end, force_N.size() - 1)];
  double most_N = 0.0;
  for (std::size_t i = pulse.first; i < pulse.end; ++i)
    most_N = std::max(most_N, std::abs(force_N[i] - 0.5 * (before_N + after_N)));
  return most_N;
}

}  // namespace

std::optional<Structure> impacts_in_drive(const Measurement& measurement) {
  std::size_t count = 0;
  double most_N = 0.0;
  double time_s = 0.0;
  for (const LogPart& part : measurement.parts()) {
    for (const Interval& impact : part.impacts) {
      ++count;
      const double own_N = height_N(measurement.log().force_N,
                                    {part.first_sample + impact.first, part.first_sample + impact.end});
      if (own_N <= most_N) continue;
      most_N = own_N;
      time_s = measurement.time_s(part.first_sample + impact.first);
    }
  }
  if (count == 0) return {};
  return Structure{
      Coordinate::reversal, 0.0, time_s,
      fmt::format(
          "{} pulses of the {} come as it changes its sign, the largest of {} at {}: impacts of a drive "
          "with play (backlash or a loose coupling)",
          count, force_word(), quantity_with_interval(most_N, 2.0 * measurement.force_noise_N(), "N"),
          when_of(measurement, time_s, measurement.tick_s())),
      Eigen::VectorXd::Zero(measurement.row_count())};
}

}  // namespace slipstack::workbench
