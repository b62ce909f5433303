// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "workbench/base/errors.h"

namespace slipstack::workbench {

// A measurement of one axis, sampled uniformly: sample i was taken at start_time_s + i / sample_rate_Hz. On a
// rotary axis positions are in rad, forces torques in N m, the mass a moment of inertia in kg m2
// (base/axis_units.h).
// read_log() guarantees: every vector that is not empty has as many elements as position_m (at least
// kMinimumSamples), every number is finite, sample_rate_Hz > 0, position and force both vary.
struct Log {
  static constexpr std::size_t kMinimumSamples = 100;

  std::string path;
  double sample_rate_Hz = 0.0;
  double start_time_s = 0.0;

  std::vector<double> position_m;
  std::vector<double> force_N;  // as measured, or current × motor constant

  // Empty when the log has no such column.
  std::vector<double> reference_position_m;
  std::vector<double> velocity_mps;
  std::vector<double> normal_force_N;
  std::vector<double> temperature_C;

  std::optional<double> mass_kg;  // zero: inertia is neglected
  std::optional<double> motor_constant_N_per_A;
  std::optional<double> magnet_pitch_m;
  // The force is that of a commanded current: no sensor that could fail or repeat itself.
  bool commanded_current = false;
  // From the header; otherwise estimated from the positions (a note says so); empty when they lie on no grid.
  std::optional<double> encoder_resolution_m;

  std::map<std::string, std::string> header;  // every `# key: value` line, valid UTF-8
  std::vector<std::string> notes;             // what the reader assumed or ignored, one sentence each
};

// The columns with one value for each sample.
inline constexpr std::array kSampleColumns{&Log::position_m,           &Log::force_N,
                                           &Log::reference_position_m, &Log::velocity_mps,
                                           &Log::normal_force_N,       &Log::temperature_C};

// Reads a log in the CSV format of docs (`# key: value` lines, one header row, rows of numbers) or a MATLAB
// level 5 MAT-file with the same names as variables or as fields of one struct. Which of the two is decided
// by content, never by the file's name.
//
// Columns: time_s; position_m, _mm, _um or _counts (counts need `# encoder_resolution_m`); force_N, _mN, _uN
// or current_A (needs `# motor_constant_N_per_A`); optionally reference_position_m, velocity_mps,
// normal_force_N, temperature_C. Of a rotary axis: position_rad, _deg or _rev; torque_Nm, _mNm;
// velocity_radps, _degps, _revps. Time stamps must be uniform to 1 % of a step plus their own rounding; with
// `# sampling: irregular` the log is resampled on the median step instead, or read as uniform where its
// motion shows that only the stamps are uneven (sampling.h).
//
// Cost: one pass over the file in blocks of 1 MiB, about 0.15 s and 8 bytes per number for 10⁶ rows.
// Throws InputError for everything that makes the file unusable.
Log read_log(const std::filesystem::path& path);

}  // namespace slipstack::workbench
