// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tests/unit/temporary_directory.h"
#include "workbench/log/assemble.h"
#include "workbench/log/byte_source.h"
#include "workbench/log/csv/csv.h"
#include "workbench/log/log.h"
#include "workbench/log/mat/mat.h"

namespace slipstack::workbench::test {

using slipstack::test::TemporaryDirectory;

inline Log parse_text(std::string_view text) {
  MemorySource source(text);
  return assemble_log(read_csv("log.csv", source));
}

inline Log parse_mat(std::string_view bytes) {
  MemorySource source(bytes);
  return assemble_log(read_mat("log.mat", source, bytes.size()));
}

// The message with which a text is refused; empty when it is accepted.
inline std::string refusal(std::string_view text) {
  try {
    parse_text(text);
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}

inline std::string refusal_of_mat(std::string_view bytes) {
  try {
    parse_mat(bytes);
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}

inline std::string refusal_of_file(const std::filesystem::path& path) {
  try {
    read_log(path);
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}

// The guarantee of log.h that a log from the reader violates; empty when it violates none.
inline std::string violated_guarantee(const Log& log) {
  const std::size_t count = log.position_m.size();
  if (count < Log::kMinimumSamples) return "too few samples";
  if (log.force_N.size() != count) return "force_N has another length";
  if (!(std::isfinite(log.sample_rate_Hz) && log.sample_rate_Hz > 0.0)) return "sample rate";
  if (!std::isfinite(log.start_time_s)) return "start time";
  for (const auto* const values : {&log.position_m, &log.force_N, &log.reference_position_m,
                                   &log.velocity_mps, &log.normal_force_N, &log.temperature_C}) {
    if (!values->empty() && values->size() != count) return "an optional column has another length";
    for (const double value : *values) {
      if (!std::isfinite(value)) return "a value is not finite";
    }
  }
  const auto varies = [](const std::vector<double>& values) {
    for (const double value : values) {
      if (value != values.front()) return true;
    }
    return false;
  };
  if (!varies(log.position_m)) return "the position never moves";
  if (!varies(log.force_N)) return "the force never changes";
  if (log.mass_kg && !(*log.mass_kg >= 0.0)) return "mass_kg";
  for (const auto& value : {log.motor_constant_N_per_A, log.magnet_pitch_m, log.encoder_resolution_m}) {
    if (value && !(std::isfinite(*value) && *value > 0.0)) return "a header value";
  }
  for (const auto& note : log.notes) {
    if (note.empty() || note.find('\n') != std::string::npos) return "a note is not one line";
  }
  return {};
}

inline bool has_note(const Log& log, std::string_view part) {
  return std::any_of(log.notes.begin(), log.notes.end(),
                     [part](const std::string& note) { return note.find(part) != std::string::npos; });
}

// What is wrong with an error message; empty when it is one line that names the source and what to do.
inline std::string broken_message(std::string_view message, std::string_view source) {
  if (message.find_first_of("\r\n") != std::string_view::npos) return "more than one line";
  if (message.size() > 600) return "longer than 600 characters";
  if (!message.starts_with(source)) return "does not begin with the source";
  if (message.find(';') == std::string_view::npos) return "does not say what to do";
  for (const char c : message) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) return "control characters";
  }
  return {};
}

// `count` rows "time,position,force" of a usable log: 1 kHz, encoder of 1 µm.
inline std::string usual_rows(std::size_t count = 200) {
  std::string rows;
  for (std::size_t i = 0; i < count; ++i) {
    const auto x = static_cast<long>(std::lround(40.0 * std::sin(0.05 * static_cast<double>(i))));
    char line[96];
    std::snprintf(line, sizeof line, "%.3f,%.6f,%.4f\n", static_cast<double>(i) * 1e-3,
                  static_cast<double>(x) * 1e-6, 15.0 * std::cos(0.05 * static_cast<double>(i)));
    rows += line;
  }
  return rows;
}

inline std::string usual_log() {
  return "# mass_kg: 35.45\ntime_s,position_m,force_N\n" + usual_rows();
}

// Where the measurements shared by the developers are; empty when they are not there.
inline std::filesystem::path shared_data() {
  const char* const variable = std::getenv("SLIPSTACK_SHARED");
#if !defined(SLIPSTACK_SOURCE_DIR)
#define SLIPSTACK_SOURCE_DIR "."
#endif
  const std::filesystem::path root = variable != nullptr ? variable : SLIPSTACK_SOURCE_DIR "/../shared";
  return std::filesystem::is_directory(root / "data") ? root / "data" : std::filesystem::path{};
}

}  // namespace slipstack::workbench::test
