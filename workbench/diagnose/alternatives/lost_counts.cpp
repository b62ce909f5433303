// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/lost_counts.h"

#include <fmt/format.h>

#include <cmath>

#include "workbench/base/axis_units.h"
#include "workbench/base/axis_words.h"
#include "workbench/base/quantity.h"
#include "workbench/diagnose/evidence/chance.h"

namespace slipstack::workbench {

namespace {

/// Whether the jump has the direction of the motion, as where rows are missing.
bool runs_ahead(const Measurement& measurement, std::size_t sample, double jump_m) {
  if (sample == 0 || sample + 1 >= measurement.sample_count()) return false;
  return jump_m * (measurement.position_m()[sample + 1] - measurement.position_m()[sample - 1]) > 0.0;
}

}  // namespace

std::optional<Structure> lost_counts(const Measurement& measurement) {
  std::size_t count = 0;
  std::size_t ahead = 0;
  double largest_m = 0.0;
  double time_s = 0.0;
  for (const LogPart& part : measurement.parts()) {
    for (const EncoderJump& jump : part.jumps) {
      ++count;
      ahead += runs_ahead(measurement, part.first_sample + jump.sample, jump.jump_m) ? 1 : 0;
      if (std::abs(jump.jump_m) <= std::abs(largest_m)) continue;
      largest_m = jump.jump_m;
      time_s = measurement.time_s(part.first_sample + jump.sample);
    }
  }
  if (count == 0) return {};
  const bool rows_missing = ahead == count && !equal_signs_are_chance(count);
  // A log that is read at once is continued where its angle wraps; one that is read in chunks is not.
  const bool wraps = axis_is_rotary() && std::abs(std::abs(largest_m) - kTurn_rad) < 1e-3 * kTurn_rad;
  const std::string what =
      wraps ? "by one turn: the angle is counted modulo one turn, write it continued"
      : rows_missing
          ? "each the way the axis goes: rows of the log are missing there, and time stamps go on as "
            "if they were not (or the encoder makes counts up)"
          : fmt::format(
                "and no {} moves the axis: the encoder loses counts or makes them up, and positions "
                "before and after are not of one scale",
                force_word());
  return Structure{Coordinate::time, 0.0, time_s,
                   fmt::format("the position jumps by {} at {}{}, {}",
                               quantity_with_interval(largest_m, measurement.encoder_resolution_m(), "m"),
                               when_of(measurement, time_s, measurement.tick_s()),
                               count > 1 ? fmt::format(" and by less at {} other {}", count - 1,
                                                       count > 2 ? "times" : "time")
                                         : "",
                               what),
                   Eigen::VectorXd::Zero(measurement.row_count())};
}

}  // namespace slipstack::workbench
