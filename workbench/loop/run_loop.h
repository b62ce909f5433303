// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace slipstack::workbench {

/// Options of `slipstack loop`; zeros and empty texts where an option was not given.
struct LoopRequest {
  std::string board = "host";
  std::string image;
  std::string setup = "pick_and_place";
  std::int64_t seed = 1;
  std::string effects = "none";
  double strength = 0.0;
  double seconds = 60.0;
  double log_rate_Hz = 2000.0;
  double push_N = 0.0;
  std::string model;
  bool adapt = false;
  std::string out;
  std::string json;
};

/// Options of `slipstack loop --compare`.
struct ComparisonRequest {
  std::string setup = "pick_and_place";
  std::int64_t seed = 1;
  std::int64_t seeds = 1;
  double encoder_nm = 0.0;  ///< resolution of the encoder; 0: that of the set-up
  bool brief = false;       ///< without what the axis may differ in
  std::string effects =
      "none";             ///< of the axis, in the training too: names, `none`, or `random`: one by seed
  double strength = 0.0;  ///< of them; 0: six times the noise floor
  std::string keep;       ///< file of the axes that are done
  std::string json;
};

/// Runs the firmware in lock-step with the simulated axis through the test programme at 10 kHz, prints the
/// result, writes the log. Throws UsageError and InputError (status 2), RunError when a run fails after its
/// start (status 1).
void run_loop(const LoopRequest& request);

/// Compares ways to compensate friction (comparison/comparison.h): prints the tables, writes all numbers.
/// Throws UsageError.
void run_comparison(const ComparisonRequest& request);

}  // namespace slipstack::workbench
