// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/record_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace slipstack::workbench {
namespace {

constexpr double kAfterReversal_s = 0.05;

double root_mean(double squares, std::size_t count) {
  return count == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(count));
}

}  // namespace

std::string log_csv(const AxisRecord& record, const Nameplate& nameplate) {
  std::string text = fmt::format("# encoder_resolution_m: {}\n# motor_constant_N_per_A: {}\n",
                                 nameplate.encoder_resolution_m, nameplate.motor_constant_N_per_A);
  if (nameplate.magnet_pitch_m) text += fmt::format("# magnet_pitch_m: {}\n", *nameplate.magnet_pitch_m);
  if (!record.time_s.empty()) text += "# sampling: irregular\n";
  text += "time_s,position_m,current_A,reference_position_m\n";
  for (std::size_t i = 0; i < record.position_m.size(); ++i) {
    const double time_s = record.time_s.empty() ? static_cast<double>(i) / record.rate_Hz : record.time_s[i];
    text += fmt::format("{:.6f},{:.10g},{:.8g},{:.10g}\n", time_s, record.position_m[i],
                        record.force_N[i] / nameplate.motor_constant_N_per_A, record.reference_m[i]);
  }
  return text;
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::fabs(value));
  return most;
}

CycleErrors cycle_errors(const AxisRecord& record, double cycle_s) {
  const std::vector<double>& errors = record.error_m;
  const auto cycle = static_cast<std::size_t>(std::lround(cycle_s * record.rate_Hz));
  const auto window = static_cast<std::size_t>(std::lround(kAfterReversal_s * record.rate_Hz));
  CycleErrors error;
  std::size_t since = window;
  double direction = 0.0;
  double squares = 0.0;
  double after = 0.0;
  std::size_t in_window = 0;
  for (std::size_t i = 1; i < errors.size(); ++i, ++since) {
    if (i % cycle == 0) {
      if (i > cycle) {
        error.rms_m.push_back(root_mean(squares, cycle));
        error.reversal_rms_m.push_back(root_mean(after, in_window));
      }
      squares = after = 0.0;
      in_window = 0;
    }
    const double moved_m = record.reference_m[i] - record.reference_m[i - 1];
    if (moved_m * direction < 0.0) since = 0;
    if (moved_m != 0.0) direction = moved_m;
    squares += errors[i] * errors[i];
    if (since >= window) continue;
    after += errors[i] * errors[i];
    ++in_window;
  }
  return error;
}

}  // namespace slipstack::workbench
