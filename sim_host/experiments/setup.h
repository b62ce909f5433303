// SPDX-License-Identifier: Apache-2.0
// A set-up: the axis, its sensors, and the defaults of the experiments; read from a TOML file.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim_host/plant/axis.h"

namespace slipstack::sim {

/// A set-up or a request that is not possible. what() is one line: where, what is wrong, what to do.
struct SetupError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The sensors of the laboratory.
struct SensorSet {
  double sample_rate_Hz = 10000.0;
  double encoder_resolution_m = 0.0;  // 0: none
  double position_noise_m = 0.0;      // white, standard deviation per sample
  double force_noise_N = 0.0;
  double filter_s = 0.0;  // first-order filter of the position
  double delay_s = 0.0;   // of the position
};

/// The defaults of the command line.
struct SetupDefaults {
  std::vector<double> loop_amplitudes_m;
  std::vector<double> loop_forces_N;
  std::vector<double> loop_positions_m;
  double loop_frequency_Hz = 1.0;
  double step_N = 0.0;
  double release_m = 0.0;
  std::vector<double> forces_N;  // stepped sine
  double lowest_Hz = 1.0;
  double highest_Hz = 100.0;
  std::size_t frequencies = 40;
  std::size_t most_periods = 400;  // longest wait at one frequency
};

/// The transducer of [3]: reading in mV/V over load in N.
struct TransducerSetup {
  double full_scale_N = 0.0;
  double sensitivity_mV_per_V = 2.0;
  double quadratic_mV_per_V = 0.0;  // linearity deviation, coefficients of u·(1 − u) and u·(1 − u)·(1 − 2u),
  double cubic_mV_per_V = 0.0;  // u = load / full scale
  double hysteresis_mV_per_V = 0.0;
  double hysteresis_length_N = 0.0;
  double zero_drift_mV_per_V_per_s = 0.0;
  double noise_mV_per_V = 0.0;
  std::size_t steps = 10;
  double step_s = 45.0;
  std::size_t preloads = 3;
  double preload_s = 75.0;
};

struct ExperimentSetup {
  std::string name;   // as it was requested
  std::string title;  // for people
  std::string text;   // all its keys, with those of its base: identifies the set-up
  Axis axis;
  double position_m = 0.0;  // where on the stroke experiments take place
  SensorSet sensors;
  SetupDefaults defaults;
  std::optional<TransducerSetup> transducer;

  bool is_axis() const { return !axis.curve.terms().empty(); }
};

/// Reads a set-up: the name of one that ships with the program (setup_files()), or the path of a TOML file.
/// `based_on` in a file names another one, of which it changes some keys. Every key is checked: unknown ones,
/// missing ones, wrong types, values out of bounds (negative mass, level or stiffness, a curve that is not
/// concave) throw SetupError with file, line, what is wrong and what to do.
ExperimentSetup read_setup(const std::string& name_or_path);

/// The same from a text; `name` takes the place of the file in messages.
ExperimentSetup parse_setup(const std::string& text, const std::string& name);

/// The text of a set-up that ships with the program; throws SetupError when there is none of that name.
std::string setup_text(const std::string& name);

}  // namespace slipstack::sim
