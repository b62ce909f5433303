// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/lost_counts.h"

#include <fmt/format.h>

#include <cmath>

#include "workbench/diagnose/quantity.h"

namespace slipstack::workbench {

std::optional<Structure> lost_counts(const Measurement& measurement) {
  std::size_t count = 0;
  double largest_m = 0.0;
  double time_s = 0.0;
  for (const LogPart& part : measurement.parts()) {
    for (const EncoderJump& jump : part.jumps) {
      ++count;
      if (std::abs(jump.jump_m) <= std::abs(largest_m)) continue;
      largest_m = jump.jump_m;
      time_s = measurement.time_s(part.first_sample + jump.sample);
    }
  }
  if (count == 0) return {};
  return Structure{
      "time", 0.0, time_s,
      fmt::format(
          "the position jumps by {} at {}{}, and no force moves the axis: the encoder loses counts or "
          "makes them up, and positions before and after are not of one scale",
          quantity(largest_m, "m"), when_of(measurement, time_s),
          count > 1 ? fmt::format(" and less at {} other {}", count - 1, count > 2 ? "times" : "time") : ""),
      Eigen::VectorXd::Zero(measurement.row_count())};
}

}  // namespace slipstack::workbench
