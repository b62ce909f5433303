// SPDX-License-Identifier: Apache-2.0
#include "workbench/plan/limits.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/axis_units.h"
#include "workbench/base/text.h"
#include "workbench/console/output.h"

namespace slipstack::workbench {
namespace {

/// Where there is neither log nor limit of the jerk, the acceleration is reached within this time. Chosen.
constexpr double kJerkTime_s = 0.02;

/// `limits`, with the given values in their place.
AxisLimits replaced(AxisLimits limits, const GivenLimits& given,
                    std::optional<double> motor_constant_N_per_A) {
  for (const auto& [key, values] : given) {
    if (key == "stroke") {
      limits.low_m = values.size() == 2 ? values[0] : 0.0;
      limits.high_m = values.back();
    }
    if (key == "velocity") limits.velocity_mps = values[0];
    if (key == "acceleration") limits.acceleration_mps2 = values[0];
    if (key == "force") limits.force_N = values[0];
  }
  if (given.contains("current")) {
    if (!motor_constant_N_per_A) {
      throw UsageError(
          fmt::format("--limits: current says nothing without a motor constant; give a log with the line "
                      "'# {}: value', or force= instead",
                      axis_key("motor_constant_N_per_A")));
    }
    const double force_N = given.at("current")[0] * *motor_constant_N_per_A;
    limits.force_N = given.contains("force") ? std::min(limits.force_N, force_N) : force_N;
  }
  if (given.contains("jerk")) limits.jerk_mps3 = given.at("jerk")[0];
  return limits;
}

}  // namespace

GivenLimits parse_limits(const std::string& text) {
  GivenLimits given;
  if (text.empty()) return given;
  const std::vector<std::string> known{"stroke", "velocity", "acceleration", "jerk", "force", "current"};
  for (const std::string_view field : split_fields(text)) {
    const std::size_t equals = field.find('=');
    const std::string key(field.substr(0, equals));
    if (equals == std::string_view::npos || std::find(known.begin(), known.end(), key) == known.end()) {
      throw UsageError(fmt::format("--limits: {} is none of {}=number (stroke=low:high), SI units",
                                   in_quotes(field), fmt::join(known, "=, ")));
    }
    std::string_view rest = field.substr(equals + 1);
    std::vector<double>& values = given[key];
    while (true) {
      const std::string_view one = rest.substr(0, rest.find(':'));
      double value = 0.0;
      const char* const end = one.data() + one.size();
      if (one.empty() || parse_double(one.data(), end, value) != end || !std::isfinite(value)) {
        throw UsageError(fmt::format("--limits: {} is not a number; as in {}", in_quotes(one),
                                     key == "stroke" ? "stroke=0.02:0.38" : key + "=1.5"));
      }
      values.push_back(value);
      if (one.size() == rest.size()) break;
      rest.remove_prefix(one.size() + 1);
    }
    const bool pair = key == "stroke" && values.size() == 2 && values[0] < values[1];
    const bool good = pair || (values.size() == 1 && values[0] > 0.0);
    if (!good) {
      throw UsageError(
          fmt::format("--limits: {} must be {}", key,
                      key == "stroke" ? "a length, or low:high with low below high" : "one positive number"));
    }
  }
  return given;
}

AxisLimits limits_of_axis(const GivenLimits& given) {
  for (const char* key : {"stroke", "velocity", "acceleration"}) {
    if (!given.contains(key)) {
      throw UsageError(
          fmt::format("--limits: {} is missing; without --log give 'stroke=0.3,velocity=0.5,acceleration=5' "
                      "of your axis, in SI units",
                      key));
    }
  }
  AxisLimits limits = replaced({}, given, std::nullopt);
  if (limits.jerk_mps3 == 0.0) limits.jerk_mps3 = limits.acceleration_mps2 / kJerkTime_s;
  return limits;
}

AxisLimits limits_of_axis(const GivenLimits& given, const MotionExtremes& reached,
                          std::optional<double> motor_constant_N_per_A) {
  AxisLimits limits;
  limits.low_m = reached.low_m;
  limits.high_m = reached.high_m;
  limits.velocity_mps = reached.velocity_mps;
  limits.acceleration_mps2 = reached.acceleration_mps2;
  limits.jerk_mps3 = reached.jerk_mps3;
  limits.force_N = reached.force_N;
  limits.force_of_log = !given.contains("force") && !given.contains("current");
  limits = replaced(limits, given, motor_constant_N_per_A);
  const auto check = [](double value, const char* key) {
    if (value > 0.0) return;
    throw UsageError(
        fmt::format("--limits: the log shows no {} above its noise; give {}= in SI units", key, key));
  };
  check(limits.stroke_m(), "stroke");
  check(limits.velocity_mps, "velocity");
  check(limits.acceleration_mps2, "acceleration");
  check(limits.jerk_mps3, "jerk");
  check(limits.force_N, "force");
  return limits;
}

}  // namespace slipstack::workbench
