// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

namespace slipstack::sim {

/// The options of `slipstack-sim log`; 0 and empty where the axis draws its own.
struct LogRequest {
  std::string setup = "pick_and_place";
  std::int64_t seed_number = 1;
  std::uint64_t seed() const { return static_cast<std::uint64_t>(seed_number); }
  std::string effects;
  double strength = 0.0;
  bool closed_loop = false;
  std::string outside;
  double seconds = 0.0;
  double rate_Hz = 0.0;
  std::string set_points;
  std::string out;
  std::string truth;
};

/// The command line of slipstack-sim; `request` receives the options of `log`.
void define_sim(CLI::App& app, LogRequest& request);

}  // namespace slipstack::sim
