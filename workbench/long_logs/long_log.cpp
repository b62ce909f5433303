// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/long_log.h"

#include <algorithm>
#include <string>
#include <utility>

#include "workbench/base/axis_units.h"
#include "workbench/base/text.h"
#include "workbench/log/assemble.h"
#include "workbench/log/csv/columns.h"
#include "workbench/log/csv/csv.h"
#include "workbench/log/input_file.h"

namespace slipstack::workbench {

struct LongLog::State {
  Survey known;                     ///< known.head holds the samples of a log in memory
  std::unique_ptr<InputFile> file;  ///< only of a log that stays in its file
};

bool LongLog::stays_in_file(const std::filesystem::path& path, std::size_t in_memory_bytes) {
  const std::string name = printable(path.string());
  const InputFile file(name, path);
  return file.size() > in_memory_bytes && reads_in_chunks(name, file);
}

LongLog LongLog::open(const std::filesystem::path& path, std::size_t in_memory_bytes) {
  if (stays_in_file(path, in_memory_bytes)) {
    const std::string name = printable(path.string());
    auto state = std::make_shared<State>();
    state->file = std::make_unique<InputFile>(name, path);
    state->known = workbench::survey(name, *state->file);
    state->known.head.path = path.string();
    return LongLog(std::move(state));
  }
  return held(read_log(path));
}

LongLog LongLog::held(Log log) {
  auto state = std::make_shared<State>();
  state->known.head = std::move(log);
  const std::vector<double>& position_m = state->known.head.position_m;
  state->known.samples = position_m.size();
  state->known.envelope.take(position_m);
  const auto [lowest, highest] = std::minmax_element(position_m.begin(), position_m.end());
  state->known.travel_m = *highest - *lowest;
  return LongLog(std::move(state));
}

LongLog LongLog::open(const std::filesystem::path& path, Survey survey) {
  const std::string name = printable(path.string());
  auto state = std::make_shared<State>();
  state->file = std::make_unique<InputFile>(name, path);
  if (state->file->size() != survey.bytes) {
    throw InputError(name + ": is not the same file for every process; give one that all of them see");
  }
  use_axis(plan_columns(survey.table, read_header_values(survey.table)).axis, name);
  state->known = std::move(survey);
  state->known.head.path = path.string();
  return LongLog(std::move(state));
}

const Survey* LongLog::survey() const {
  return state_->file == nullptr ? nullptr : &state_->known;
}

const Log& LongLog::head() const {
  return state_->known.head;
}

std::size_t LongLog::sample_count() const {
  return state_->known.samples;
}

double LongLog::travel_m() const {
  return state_->known.travel_m;
}

const Envelope& LongLog::envelope() const {
  return state_->known.envelope;
}

Log LongLog::chunk(std::size_t first, std::size_t count) const {
  const Survey& known = state_->known;
  const Log& head = known.head;
  Log chunk;
  if (state_->file == nullptr) {
    chunk.path = head.path;
    chunk.sample_rate_Hz = head.sample_rate_Hz;
    chunk.mass_kg = head.mass_kg;
    chunk.motor_constant_N_per_A = head.motor_constant_N_per_A;
    chunk.magnet_pitch_m = head.magnet_pitch_m;
    chunk.encoder_resolution_m = head.encoder_resolution_m;
    chunk.start_time_s = head.start_time_s + static_cast<double>(first) / head.sample_rate_Hz;
    for (const auto column : kSampleColumns) {
      const std::vector<double>& all = head.*column;
      if (all.empty()) continue;
      const auto from = all.begin() + static_cast<std::ptrdiff_t>(first);
      (chunk.*column).assign(from, from + static_cast<std::ptrdiff_t>(count));
    }
    return chunk;
  }
  const std::size_t place = first / kRowsPerPlace;
  FileSource source(*state_->file, known.places[place].byte);
  CsvReader reader(known.table, source, known.places[place]);
  reader.skip(first - place * kRowsPerPlace);
  RawTable rows = reader.rows(count);
  if (rows.columns.front().values.size() != count) {
    throw InputError(known.table.source +
                     ": the file has become shorter while it was read; wait until it is whole");
  }
  chunk = assemble_chunk(std::move(rows), &head);
  chunk.path = head.path;
  return chunk;
}

}  // namespace slipstack::workbench
