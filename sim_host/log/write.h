// SPDX-License-Identifier: Apache-2.0
// The two files of a simulated measurement: the log that a user would have, and the truth.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_host/log/record.h"
#include "sim_host/plant/axis.h"

namespace slipstack::sim {

/// The log as CSV after the contract of the design: `# key: value` lines, one header row, then time_s,
/// position_m, force_N (and reference_position_m in a closed loop). Cost: about 0.4 µs per line.
std::string log_as_csv(const Axis& axis, const SimulatedLog& log);

/// The part of the truth file that does not describe the axis itself.
struct TruthContext {
  std::string setup;
  std::uint64_t seed = 0;
  bool closed_loop = false;
  std::vector<EffectId> effects;
  std::string outside;  // empty: nothing
};

/// The truth as JSON: effects, formulas, parameters, noise_N, encoder_m, effect_rms_N per effect,
/// force_rms_N.
std::string truth_as_json(const Axis& axis, const SimulatedLog& log, const TruthContext& context);

/// Writes `content` beside the target and renames it, so that the target never exists half-written; what is
/// no regular file (a device, a pipe) is written itself. Throws std::runtime_error with a reason.
void write_file(const std::string& path, const std::string& content);

}  // namespace slipstack::sim
