// SPDX-License-Identifier: Apache-2.0
#include "sim_host/log/write.h"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <stdexcept>

namespace slipstack::sim {

std::string log_as_csv(const Axis& axis, const SimulatedLog& log) {
  fmt::memory_buffer out;
  out.reserve(log.size() * 40 + 400);
  const auto to = std::back_inserter(out);
  fmt::format_to(to, "# mass_kg: {:.6g}\n", axis.mass_kg);
  fmt::format_to(to, "# motor_constant_N_per_A: {:.6g}\n", axis.motor_constant_N_per_A);
  fmt::format_to(to, "# magnet_pitch_m: {:.6g}\n", axis.magnet_pitch_m);
  if (axis.encoder_resolution_m > 0.0) {
    fmt::format_to(to, "# encoder_resolution_m: {:.6g}\n", axis.encoder_resolution_m);
  }
  fmt::format_to(to, "# sample_rate_Hz: {:.9g}\n", log.rate_Hz);
  const bool has_reference = !log.reference_position_m.empty();
  fmt::format_to(to, "time_s,position_m,{}force_N\n", has_reference ? "reference_position_m," : "");

  // Microseconds where they are exact; else nanoseconds, so that the steps stay even.
  const double period_us = 1e6 / log.rate_Hz;
  const bool whole_us = std::fabs(period_us - std::round(period_us)) < 1e-9;
  for (std::size_t i = 0; i < log.size(); ++i) {
    if (whole_us) {
      fmt::format_to(to, FMT_COMPILE("{:.6f},"), log.time_s(i));
    } else {
      fmt::format_to(to, FMT_COMPILE("{:.9f},"), log.time_s(i));
    }
    fmt::format_to(to, FMT_COMPILE("{:.9f},"), log.position_m[i]);
    if (has_reference) fmt::format_to(to, FMT_COMPILE("{:.9f},"), log.reference_position_m[i]);
    fmt::format_to(to, FMT_COMPILE("{:.5f}\n"), log.force_N[i]);
  }
  return fmt::to_string(out);
}

namespace {

[[noreturn]] void fail(const std::string& path, int error) {
  throw std::runtime_error(path + ": cannot write: " + std::strerror(error));
}

/// False with errno.
bool write_whole(const std::string& path, const std::string& content) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return false;
  const bool written = std::fwrite(content.data(), 1, content.size(), file) == content.size();
  const bool closed = std::fclose(file) == 0;
  return written && closed;
}

}  // namespace

void write_file(const std::string& path, const std::string& content) {
  std::error_code none;
  if (std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none)) {
    if (!write_whole(path, content)) fail(path, errno);  // a device, a pipe: a rename would replace it
    return;
  }
  const std::string draft = path + ".part";
  if (write_whole(draft, content) && std::rename(draft.c_str(), path.c_str()) == 0) return;
  const int error = errno;
  std::remove(draft.c_str());
  fail(path, error);
}

}  // namespace slipstack::sim
