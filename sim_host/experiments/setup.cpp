// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/setup.h"

#include <filesystem>
#include <sstream>

#include "sim_host/experiments/setup_files.h"
#include "sim_host/experiments/setup_table.h"
#include "sim_host/turn.h"

namespace slipstack::sim {
namespace {

constexpr std::uintmax_t kLargestFile = 1u << 20;
constexpr int kDeepest = 5;

std::string known_setups() {
  std::string names;
  for (const SetupFile& file : setup_files()) {
    names += names.empty() ? "" : ", ";
    names += file.name;
  }
  return names;
}

// Keys of `changes` over those of `base`; tables are merged, everything else is replaced. Nodes are moved: a
// copy would lose its line number.
void overlay(toml::table& base, toml::table& changes) {
  for (auto&& [key, node] : changes) {
    toml::table* below = base[key.str()].as_table();
    toml::table* above = node.as_table();
    if (below != nullptr && above != nullptr) {
      overlay(*below, *above);
    } else {
      node.visit([&base, name = key.str()](auto& value) { base.insert_or_assign(name, std::move(value)); });
    }
  }
}

toml::table parse_text(std::string_view text, const std::string& name) {
  try {
    return toml::parse(text, name);
  } catch (const toml::parse_error& problem) {
    throw SetupError(fmt::format("{}:{}: not TOML: {}; correct the line", name, problem.source().begin.line,
                                 problem.description()));
  }
}

toml::table load(const std::string& name_or_path, int depth);

toml::table resolved(toml::table table, const std::string& name, int depth) {
  const toml::node* base = table.get("based_on");
  if (base == nullptr) return table;
  if (depth >= kDeepest)
    throw SetupError(fmt::format("{}: based_on goes round or too deep; name a whole set-up", name));
  if (!base->is_string()) {
    throw SetupError(
        fmt::format("{}:{}: based_on is not a text; name a set-up", name, base->source().begin.line));
  }
  toml::table whole = load(base->value_or<std::string>(""), depth + 1);
  overlay(whole, table);
  whole.erase("based_on");
  return whole;
}

toml::table load(const std::string& name_or_path, int depth) {
  for (const SetupFile& file : setup_files()) {
    if (file.name == name_or_path) {
      return resolved(parse_text(file.text, fmt::format("{}.toml", file.name)), name_or_path, depth);
    }
  }
  std::error_code error;
  const std::filesystem::path path(name_or_path);
  if (!std::filesystem::is_regular_file(path, error)) {
    throw SetupError(fmt::format("{}: neither a set-up file nor one of {}", name_or_path, known_setups()));
  }
  if (std::filesystem::file_size(path, error) > kLargestFile) {
    throw SetupError(fmt::format("{}: larger than any set-up; give a TOML file", name_or_path));
  }
  try {
    return resolved(toml::parse_file(name_or_path), name_or_path, depth);
  } catch (const toml::parse_error& problem) {
    throw SetupError(fmt::format("{}:{}: not TOML: {}; correct the line", name_or_path,
                                 problem.source().begin.line, problem.description()));
  }
}

SensorSet read_sensors(SetupTable& table) {
  SensorSet sensors;
  sensors.sample_rate_Hz = table.number("sample_rate_Hz", kPositive);
  sensors.encoder_resolution_m = table.number_or("encoder_resolution_m", kNotNegative, 0.0);
  sensors.position_noise_m = table.number_or("position_noise_m", kNotNegative, 0.0);
  sensors.force_noise_N = table.number_or("force_noise_N", kNotNegative, 0.0);
  sensors.filter_s = table.number_or("filter_s", kNotNegative, 0.0);
  sensors.delay_s = table.number_or("delay_s", kNotNegative, 0.0);
  table.finish();
  return sensors;
}

void read_drive(SetupTable& table, Axis& axis) {
  axis.motor_constant_N_per_A = table.number("motor_constant_N_per_A", kPositive);
  axis.current_limit_A = table.number("current_limit_A", kPositive);
  axis.magnet_pitch_m = table.number("magnet_pitch_m", kPositive);
  axis.current_loop_rad_per_s = kTurn * table.number_or("current_loop_Hz", kPositive, 0.0);
  table.finish();
}

SetupDefaults read_defaults(SetupTable& table, double stroke_m) {
  SetupDefaults defaults;
  defaults.loop_amplitudes_m = table.numbers_or("loop_amplitudes_m", {0.0, 0.5 * stroke_m, true}, {});
  defaults.loop_forces_N = table.numbers_or("loop_forces_N", kPositive, {});
  defaults.loop_positions_m = table.numbers_or("loop_positions_m", {0.0, stroke_m}, {});
  defaults.loop_frequency_Hz = table.number_or("loop_frequency_Hz", kPositive, 1.0);
  defaults.step_N = table.number_or("step_N", kPositive, 0.0);
  defaults.release_m = table.number_or("release_m", {0.0, 0.5 * stroke_m, true}, 0.0);
  defaults.forces_N = table.numbers_or("forces_N", kPositive, {});
  defaults.lowest_Hz = table.number_or("lowest_Hz", kPositive, 1.0);
  defaults.highest_Hz = table.number_or("highest_Hz", kPositive, 100.0);
  defaults.frequencies = table.count_or("frequencies", 2, 10000, 40);
  defaults.most_periods = table.count_or("most_periods", 4, 1000000, 400);
  table.finish();
  return defaults;
}

TransducerSetup read_transducer(SetupTable& table) {
  TransducerSetup out;
  out.full_scale_N = table.number("full_scale_N", kPositive);
  out.sensitivity_mV_per_V = table.number("sensitivity_mV_per_V", kPositive);
  out.quadratic_mV_per_V = table.number_or("quadratic_mV_per_V", kAny, 0.0);
  out.cubic_mV_per_V = table.number_or("cubic_mV_per_V", kAny, 0.0);
  out.hysteresis_mV_per_V = table.number("hysteresis_mV_per_V", kPositive);
  out.hysteresis_length_N = table.number("hysteresis_length_N", kPositive);
  out.zero_drift_mV_per_V_per_s = table.number_or("zero_drift_mV_per_V_per_s", kAny, 0.0);
  out.noise_mV_per_V = table.number_or("noise_mV_per_V", kNotNegative, 0.0);
  out.steps = table.count_or("steps", 5, 1000, 10);
  out.step_s = table.number_or("step_s", kPositive, 45.0);
  out.preloads = table.count_or("preloads", 0, 100, 3);
  out.preload_s = table.number_or("preload_s", kPositive, 75.0);
  table.finish();
  return out;
}

void read_axis(SetupTable& file, ExperimentSetup& setup) {
  Axis& axis = setup.axis;
  axis.mass_kg = file.number("mass_kg", kPositive);
  axis.stroke_m = file.number("stroke_m", kPositive);
  setup.position_m = file.number_or("position_m", {0.0, axis.stroke_m}, 0.5 * axis.stroke_m);
  axis.elements = file.count_or("elements", 1, 100000, 200);
  axis.curve = read_curve(file);
  if (axis.curve.terms().empty())
    file.fail("no [[friction]]; an axis has at least one term of its virgin curve");
  if (auto table = file.table("drive")) {
    read_drive(*table, axis);
  } else {
    file.fail("no [drive]; say motor_constant_N_per_A, current_limit_A, magnet_pitch_m");
  }
  read_effects(file, axis);
  if (auto table = file.table("sensors")) {
    setup.sensors = read_sensors(*table);
  } else {
    file.fail("no [sensors]; say at least sample_rate_Hz");
  }
  if (auto table = file.table("defaults")) setup.defaults = read_defaults(*table, axis.stroke_m);
  axis.encoder_resolution_m = setup.sensors.encoder_resolution_m;
  axis.force_noise_N = setup.sensors.force_noise_N;
}

ExperimentSetup interpret(const toml::table& table, const std::string& name) {
  ExperimentSetup setup;
  SetupTable file(table, "");
  setup.name = name;
  std::ostringstream text;
  text << table;
  setup.text = text.str();
  setup.title = file.text("title");
  if (auto inner = file.table("transducer")) {
    setup.transducer = read_transducer(*inner);
  } else {
    read_axis(file, setup);
  }
  file.finish();
  return setup;
}

}  // namespace

ExperimentSetup read_setup(const std::string& name_or_path) {
  return interpret(load(name_or_path, 0), name_or_path);
}

ExperimentSetup parse_setup(const std::string& text, const std::string& name) {
  return interpret(resolved(parse_text(text, name), name, 0), name);
}

std::string setup_text(const std::string& name) {
  for (const SetupFile& file : setup_files()) {
    if (file.name == name) return std::string(file.text);
  }
  throw SetupError(fmt::format("{}: no set-up of that name; known: {}", name, known_setups()));
}

}  // namespace slipstack::sim
