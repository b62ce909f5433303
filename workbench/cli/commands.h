// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/long_logs/processes/process_group.h"

namespace slipstack::workbench {

/// The options of the command line; empty strings where an option was not given.
struct Options {
  ProcessGroup* group = nullptr;  ///< processes that share the work
  std::string command_line;       ///< as it can be typed in a shell
  std::vector<std::string> logs;
  std::string log;       ///< names of the logs, separated by ", "
  std::string per_log;   ///< ids of effects whose gains differ from log to log; "none"; empty: the default
  double noise_N = 0.0;  ///< standard deviation of the force's noise before the filter; 0: estimated
  std::string model;     ///< read by compare, diagnose and add; written by fit
  std::string effects;   ///< ids separated by commas
  std::string effect;
  std::vector<std::string> user_effects;  ///< definitions of user-defined effects
  std::string out;
  std::string pages;  ///< folder
  std::string header;
  std::string report;
  std::string json;
  std::string c_header;    ///< of export
  std::string scalar;      ///< "float" or "double"
  std::string name;        ///< begin of the names in it
  double step_m = 0.0;     ///< unit of its displacement; 0: not given
  double rate_Hz = 0.0;    ///< of its ticks; 0: not given
  std::string criterion;   ///< of fit: "force" (inverse dynamics) or "simulation"
  double horizon_s = 0.0;  ///< of the runs of the latter
  bool stepwise = false;
};

/// Each command prints its result on standard output and writes the requested files, all or none. Throws
/// UsageError and InputError (exit status 2).
void run_compare(const Options& options);
void run_fit(const Options& options);
void run_diagnose(const Options& options);
void run_add(const Options& options);
void run_effects(const Options& options);
void run_export(const Options& options);

}  // namespace slipstack::workbench
