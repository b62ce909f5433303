// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/measurement/parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/axis_units.h"
#include "workbench/base/text.h"
#include "workbench/cleaning/held_position.h"
#include "workbench/model/effect_adapters/firmware_effects.h"

namespace slipstack::workbench {
namespace {

[[noreturn]] void refuse(const Log& log, const std::string& what) {
  throw InputError(fmt::format("{}: {}", printable(log.path), what));
}

void require_one_axis(const Log& first, const Log& other) {
  if (!is_same_rate(first.sample_rate_Hz, other.sample_rate_Hz)) {
    refuse(other, fmt::format("sampled at {:.6g} Hz, but {} at {:.6g} Hz; resample one of them, or give them "
                              "to two runs",
                              other.sample_rate_Hz, printable(first.path), first.sample_rate_Hz));
  }
  if (other.mass_kg.has_value() != first.mass_kg.has_value()) {
    const Log& without = other.mass_kg ? first : other;
    const Log& with = other.mass_kg ? other : first;
    refuse(without, fmt::format("declares no {}, but {} does; add the line to each log, or remove it "
                                "from all",
                                axis_key("mass_kg"), printable(with.path)));
  }
  if (other.magnet_pitch_m && first.magnet_pitch_m && *other.magnet_pitch_m != *first.magnet_pitch_m) {
    refuse(other, fmt::format("{} is {:.6g}, but {:.6g} in {}; logs that are fitted together are "
                              "of one axis",
                              axis_key("magnet_pitch_m"), *other.magnet_pitch_m, *first.magnet_pitch_m,
                              printable(first.path)));
  }
}

void append(std::vector<double>& all, const std::vector<double>& more, bool first) {
  if (first) {
    all = more;
  } else if (more.empty() || all.empty()) {
    all.clear();
  } else {
    all.insert(all.end(), more.begin(), more.end());
  }
}

}  // namespace

bool is_same_rate(double first_Hz, double other_Hz) {
  // Largest relative difference of the sampling rates of one drive; a larger one means another drive. Chosen.
  constexpr double kSameRate = 1e-4;
  return std::abs(other_Hz - first_Hz) <= kSameRate * first_Hz;
}

JoinedLogs join(std::vector<Log> logs) {
  std::vector<LogChunk> chunks;
  for (Log& log : logs) {
    const std::size_t samples = log.position_m.size();
    const auto [low, high] = std::minmax_element(log.position_m.begin(), log.position_m.end());
    const double travel_m = *high - *low;
    chunks.push_back({std::move(log), chunks.size(), 0, samples, travel_m});
  }
  return join(std::move(chunks));
}

JoinedLogs join(std::vector<LogChunk> chunks) {
  if (chunks.empty()) throw InputError("no log");
  std::vector<std::optional<std::string>> of_updates;
  for (LogChunk& chunk : chunks) {
    const bool whole = chunk.is_whole();
    of_updates.push_back(whole ? keep_updates_of_position(chunk.log) : std::nullopt);
    if (whole) chunk.log_samples = chunk.log.position_m.size();
  }
  JoinedLogs joined;
  std::size_t next = 0;
  for (LogChunk& chunk : chunks) {
    Log& log = chunk.log;
    require_one_axis(chunks.front().log, log);
    Repairs repairs = repair(log, chunk.is_whole() ? RepairScope::whole_log : RepairScope::chunk);
    LogPart part;
    part.cut = std::move(repairs.cut);
    part.jumps = std::move(repairs.jumps);
    part.impacts = std::move(repairs.impacts);
    part.repaired = std::move(repairs.notes);
    const std::optional<std::string>& note = of_updates[joined.parts.size()];
    if (note) part.repaired.insert(part.repaired.begin(), *note);
    part.path = log.path;
    part.log = chunk.log_index;
    part.log_travel_m = chunk.log_travel_m;
    part.start_s = static_cast<double>(chunk.first_sample) / log.sample_rate_Hz;
    part.first_sample = next;
    part.sample_count = log.position_m.size();
    part.mass_kg = log.mass_kg;
    part.encoder_resolution_m = log.encoder_resolution_m.value_or(0.0);
    next += part.sample_count;
    if (part.log >= joined.log_samples.size()) joined.log_samples.resize(part.log + 1);
    joined.log_samples[part.log] = chunk.log_samples;
    joined.parts.push_back(std::move(part));
  }
  if (chunks.size() == 1) {
    joined.log = std::move(chunks.front().log);
    return joined;
  }
  const Log& first = chunks.front().log;
  Log& all = joined.log;
  all.path = first.path;
  all.sample_rate_Hz = first.sample_rate_Hz;
  all.start_time_s = first.start_time_s;
  all.mass_kg = first.mass_kg;
  all.motor_constant_N_per_A = first.motor_constant_N_per_A;
  all.header = first.header;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    Log& log = chunks[i].log;
    for (auto column : {&Log::position_m, &Log::force_N, &Log::reference_position_m, &Log::velocity_mps,
                        &Log::normal_force_N, &Log::temperature_C}) {
      append(all.*column, log.*column, i == 0);
      std::vector<double>().swap(log.*column);
    }
    if (log.magnet_pitch_m) all.magnet_pitch_m = log.magnet_pitch_m;
    if (log.encoder_resolution_m) {
      all.encoder_resolution_m = std::max(all.encoder_resolution_m.value_or(0.0), *log.encoder_resolution_m);
    }
    if (i > 0 && chunks[i].log_index == chunks[i - 1].log_index) continue;
    for (const std::string& note : log.notes) {
      all.notes.push_back(joined.log_samples.size() > 1 ? printable(log.path) + ": " + note : note);
    }
  }
  return joined;
}

std::vector<Interval> usable_intervals(const LogPart& part, std::size_t from) {
  std::vector<Interval> all;
  std::size_t first = from;
  for (const Interval& cut : part.cut) {
    if (cut.first > first) all.push_back({first, cut.first});
    first = std::max(first, cut.end);
  }
  if (part.sample_count > first) all.push_back({first, part.sample_count});
  return all;
}

std::vector<double> part_of(const std::vector<double>& values, const LogPart& part) {
  const auto first = values.begin() + static_cast<std::ptrdiff_t>(part.first_sample);
  return {first, first + static_cast<std::ptrdiff_t>(part.sample_count)};
}

const std::vector<std::string>& effects_of_each_log() {
  static const std::vector<std::string> effects = [] {
    std::vector<std::string> ids;
    for (const EffectDescription& effect : catalogue()) {
      if (effect.traits.per_log) ids.push_back(effect.id());
    }
    return ids;
  }();
  return effects;
}

}  // namespace slipstack::workbench
