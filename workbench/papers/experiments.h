// SPDX-License-Identifier: Apache-2.0
// The experiments of the papers: what each is asked for, and the function that runs it and writes its result.
// The options on the command line are in define_papers.cpp.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "workbench/papers/experiment.h"
#include "workbench/papers/setup_choice.h"
#include "workbench/papers/sine_options.h"

namespace slipstack::workbench {

struct LoopsOptions {
  SetupChoice setup;
  std::vector<double> amplitudes_m;
  std::vector<double> forces_N;
  std::vector<double> positions_m;
  double frequency_Hz = 0.0;  ///< 0: the set-up's
  std::size_t cycles = 10;
  bool sensors = false;
  std::uint64_t seed = 1;
  std::size_t threads = 0;
  ExperimentOutputs outputs;
};
void run_loops(const std::string& command_line, const LoopsOptions& wanted);

struct StepOptions {
  SetupChoice setup;
  double force_N = 0.0;  ///< 0: the set-up's
  double seconds = 0.1;
  ExperimentOutputs outputs;
};
void run_step(const std::string& command_line, const StepOptions& wanted);

struct FreeOptions {
  SetupChoice setup;
  double release_m = 0.0;  ///< 0: the set-up's
  int turning_points = 12;
  ExperimentOutputs outputs;
};
void run_free(const std::string& command_line, const FreeOptions& wanted);

struct CharacterizeOptions {
  std::string log;
  SetupChoice setup;
  std::vector<double> preloads{1.0, 2.0, 3.5, 5.5};
  bool typical = false;
  ExperimentOutputs outputs;
};
void run_characterize(const std::string& command_line, const CharacterizeOptions& wanted);

/// A guideway as the command line gives it; NaN and empty where an option was not given.
struct GivenContact {
  double load_N = std::numeric_limits<double>::quiet_NaN();
  double angle_deg = std::numeric_limits<double>::quiet_NaN();
  double diameter_m = std::numeric_limits<double>::quiet_NaN();
  double balls = std::numeric_limits<double>::quiet_NaN();
  std::string material;
};
struct GuidewayOptions {
  std::string log;
  GivenContact from;
  GivenContact to;
  double force_ratio = 1.0;
  ExperimentOutputs outputs;
};
void run_guideway(const std::string& command_line, const GuidewayOptions& wanted);

struct TransducerOptions {
  std::string calibration;
  std::string readings;
  SetupChoice setup;
  std::uint64_t seed = 1;
  std::string write_log;
  ExperimentOutputs outputs;
};
void run_transducer(const std::string& command_line, const TransducerOptions& wanted);
/// A simulated calibration as a file, to see the format and to start from.
void write_simulated_calibration(const TransducerOptions& wanted);

struct SteppedSineOptions {
  SineOptions sine;
  std::string direction = "both";
  std::size_t repeats = 1;
  bool sensors = false;
  std::uint64_t seed = 1;
};
void run_stepped_sine(const std::string& command_line, const SteppedSineOptions& wanted);

struct DescribingOptions {
  SineOptions sine;
  bool alone = false;
};
void run_describing_function(const std::string& command_line, const DescribingOptions& wanted);

struct SensitivityOptions {
  SineOptions sine;
  double share = 0.01;
};
void run_sensitivity(const std::string& command_line, const SensitivityOptions& wanted);

struct ModelsOptions {
  std::string log;
  SetupChoice setup;
  ExperimentOutputs outputs;
};
void run_models(const std::string& command_line, const ModelsOptions& wanted);

}  // namespace slipstack::workbench
