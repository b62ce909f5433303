// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/long_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <new>
#include <string_view>
#include <utility>

#include "workbench/log/assemble.h"
#include "workbench/log/columns.h"
#include "workbench/log/csv.h"
#include "workbench/log/input_file.h"
#include "workbench/log/mat.h"
#include "workbench/log/sampling.h"
#include "workbench/log/text.h"

namespace slipstack::workbench {
namespace {

/// Rows between places at which reading may go on.
constexpr std::size_t kRowsPerPlace = 32768;
/// Rates of two stretches of a log agree better than this, or samples are missing.
constexpr double kSameRate = 1e-3;
constexpr double kShortestStep = 0.5;  ///< in steps, from one stretch to the next
constexpr double kLongestStep = 1.5;

constexpr std::array kColumns{&Log::position_m,   &Log::force_N,        &Log::reference_position_m,
                              &Log::velocity_mps, &Log::normal_force_N, &Log::temperature_C};

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void take(const std::vector<double>& values) {
    for (const double value : values) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
};

/// Glances of positions that come in any number at a time.
class Glancing {
 public:
  void take(const std::vector<double>& position_m) {
    for (const double x : position_m) {
      const auto at = static_cast<float>(x);
      if (count_++ % kGlanceSamples == 0) glances.push_back({at, at, at});
      glances.back().low_m = std::min(glances.back().low_m, at);
      glances.back().high_m = std::max(glances.back().high_m, at);
    }
  }
  std::vector<Glance> glances;

 private:
  std::size_t count_ = 0;
};

}  // namespace

struct LongLog::State {
  Log head;  ///< with its samples where the log is in memory
  std::size_t samples = 0;
  std::vector<Glance> glances;
  double travel_m = 0.0;

  // Of a log that stays in its file.
  std::unique_ptr<InputFile> file;
  RawTable table;  ///< header and column names
  std::vector<LineReader::Place> places;

  void survey(const std::string& name);

 private:
  std::string name_of(const ColumnPlan& plan, Quantity quantity) const {
    return table.source + ": column " + table.columns[plan[quantity]->column].name;
  }
};

/// Reads the file from end to end, a stretch of rows at a time, and keeps of each only where it begins.
void LongLog::State::survey(const std::string& name) {
  FileSource source(*file, 0);
  CsvReader reader(name, source);
  Glancing glancing;
  Range position_m, force_N;
  double last_s = 0.0;
  for (;;) {
    const LineReader::Place place = reader.place();
    RawTable rows = reader.rows(kRowsPerPlace);
    const std::size_t count = rows.columns.front().values.size();
    if (count == 0) break;
    const bool first = samples == 0;
    const std::string where = rows.where_row(0);
    if (first) table = CsvReader::without_rows(rows);
    // What is left at the end may be too short to tell its rate.
    const bool tells = count >= Log::kMinimumSamples;
    const Log piece = assemble_piece(std::move(rows), tells ? nullptr : &head);
    if (first) {
      head = piece;
      for (const auto column : kColumns) (head.*column).clear();
    }
    const double step_s = 1.0 / head.sample_rate_Hz;
    const double gap_s = piece.start_time_s - last_s;
    if (!first && (gap_s < kShortestStep * step_s || gap_s > kLongestStep * step_s)) {
      throw InputError(
          fmt::format("{}: column time_s: a step of {:.6g} s where the others are {:.6g} s; cut the "
                      "log there",
                      where, gap_s, step_s));
    }
    if (std::abs(piece.sample_rate_Hz - head.sample_rate_Hz) > kSameRate * head.sample_rate_Hz) {
      throw InputError(
          fmt::format("{}: sampled at {:.6g} Hz from here on, at {:.6g} Hz before; cut the log there", where,
                      piece.sample_rate_Hz, head.sample_rate_Hz));
    }
    if (piece.encoder_resolution_m) {
      head.encoder_resolution_m = std::min(*piece.encoder_resolution_m,
                                           head.encoder_resolution_m.value_or(*piece.encoder_resolution_m));
    }
    last_s = piece.start_time_s + static_cast<double>(count - 1) * step_s;
    position_m.take(piece.position_m);
    force_N.take(piece.force_N);
    glancing.take(piece.position_m);
    places.push_back(place);
    samples += count;
  }
  head.notes = reader.rows(0).notes;
  if (table.header.find("encoder_resolution_m") == table.header.end() && head.encoder_resolution_m) {
    head.notes.push_back(
        fmt::format("encoder_resolution_m is not in the header; the positions move in steps of {:.6g} m",
                    *head.encoder_resolution_m));
  }
  const ColumnPlan plan = plan_columns(table, read_header_values(table));
  require_motion(name_of(plan, Quantity::kPosition), position_m.low, position_m.high,
                 head.encoder_resolution_m);
  require_force(name_of(plan, plan[Quantity::kForce] ? Quantity::kForce : Quantity::kCurrent), force_N.low,
                force_N.high);
  glances = std::move(glancing.glances);
  travel_m = position_m.high - position_m.low;
}

LongLog LongLog::open(const std::filesystem::path& path, std::size_t in_memory_bytes) {
  const std::string name = printable(path.string());
  auto state = std::make_shared<State>();
  auto file = std::make_unique<InputFile>(name, path);
  const auto stays_in_file = [&] {
    if (file->size() <= in_memory_bytes) return false;
    std::array<char, kMatHeaderSize> head{};
    if (looks_like_mat({head.data(), file->read_at(0, head.data(), head.size())})) return false;
    FileSource source(*file, 0);
    return !read_header_values(CsvReader(name, source).rows(0)).irregular_sampling;
  };
  if (stays_in_file()) {
    state->file = std::move(file);
    state->survey(name);
    state->head.path = path.string();
    return LongLog(std::move(state));
  }
  state->head = read_log(path);
  state->samples = state->head.position_m.size();
  Glancing glancing;
  glancing.take(state->head.position_m);
  state->glances = std::move(glancing.glances);
  Range position_m;
  position_m.take(state->head.position_m);
  state->travel_m = position_m.high - position_m.low;
  return LongLog(std::move(state));
}

const Log& LongLog::head() const {
  return state_->head;
}

std::size_t LongLog::sample_count() const {
  return state_->samples;
}

double LongLog::travel_m() const {
  return state_->travel_m;
}

const std::vector<Glance>& LongLog::glances() const {
  return state_->glances;
}

Log LongLog::piece(std::size_t first, std::size_t count) const {
  const State& state = *state_;
  Log piece;
  if (state.file == nullptr) {
    piece.path = state.head.path;
    piece.sample_rate_Hz = state.head.sample_rate_Hz;
    piece.mass_kg = state.head.mass_kg;
    piece.motor_constant_N_per_A = state.head.motor_constant_N_per_A;
    piece.magnet_pitch_m = state.head.magnet_pitch_m;
    piece.encoder_resolution_m = state.head.encoder_resolution_m;
    piece.start_time_s = state.head.start_time_s + static_cast<double>(first) / state.head.sample_rate_Hz;
    for (const auto column : kColumns) {
      const std::vector<double>& all = state.head.*column;
      if (all.empty()) continue;
      const auto from = all.begin() + static_cast<std::ptrdiff_t>(first);
      (piece.*column).assign(from, from + static_cast<std::ptrdiff_t>(count));
    }
    return piece;
  }
  const std::size_t place = first / kRowsPerPlace;
  FileSource source(*state.file, state.places[place].byte);
  CsvReader reader(state.table, source, state.places[place]);
  reader.skip(first - place * kRowsPerPlace);
  RawTable rows = reader.rows(count);
  if (rows.columns.front().values.size() != count) {
    throw InputError(state.table.source +
                     ": the file has become shorter while it was read; wait until it is whole");
  }
  piece = assemble_piece(std::move(rows), &state.head);
  piece.path = state.head.path;
  return piece;
}

Log LongLog::take() {
  if (state_->file == nullptr) return std::move(state_->head);
  return piece(0, state_->samples);
}

}  // namespace slipstack::workbench
