// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "workbench/log/assemble.h"
#include "workbench/log/csv/columns.h"
#include "workbench/log/csv/csv.h"
#include "workbench/log/mat/mat.h"
#include "workbench/log/sampling/sampling.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// Rates of two stretches of a log agree better than this, or samples are missing.
constexpr double kSameRate = 1e-3;

struct Extremes {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void take(const std::vector<double>& values) {
    for (const double value : values) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
};

std::string name_of(const RawTable& table, const ColumnPlan& plan, Quantity quantity) {
  return table.source + ": column " + table.columns[plan[quantity]->column].name;
}

}  // namespace

bool reads_in_chunks(const std::string& name, const InputFile& file) {
  std::array<char, kMatHeaderSize> head{};
  if (looks_like_mat({head.data(), file.read_at(0, head.data(), head.size())})) return false;
  FileSource source(file, 0);
  return !read_header_values(CsvReader(name, source).rows(0)).irregular_sampling;
}

Survey survey(const std::string& name, const InputFile& file) {
  Survey found;
  found.bytes = file.size();
  FileSource source(file, 0);
  CsvReader reader(name, source);
  Extremes position_m, force_N;
  double last_s = 0.0;
  for (;;) {
    const LineReader::Place place = reader.place();
    RawTable rows = reader.rows(kRowsPerPlace);
    const std::size_t count = rows.columns.front().values.size();
    if (count == 0) break;
    const bool first = found.samples == 0;
    const std::string where = rows.where_row(0);
    if (first) found.table = CsvReader::without_rows(rows);
    // What is left at the end may be too short to tell its rate.
    const bool tells = count >= Log::kMinimumSamples;
    const Log piece = assemble_chunk(std::move(rows), tells ? nullptr : &found.head);
    if (first) {
      found.head = piece;
      for (const auto column : kSampleColumns) std::vector<double>().swap(found.head.*column);
    }
    const double step_s = 1.0 / found.head.sample_rate_Hz;
    const double gap_s = piece.start_time_s - last_s;
    if (!first && (gap_s < kShortestStep * step_s || gap_s > kLongestStep * step_s)) {
      throw InputError(
          fmt::format("{}: column time_s: a step of {:.6g} s where the others are {:.6g} s; cut the "
                      "log there",
                      where, gap_s, step_s));
    }
    if (std::abs(piece.sample_rate_Hz - found.head.sample_rate_Hz) > kSameRate * found.head.sample_rate_Hz) {
      throw InputError(
          fmt::format("{}: sampled at {:.6g} Hz from here on, at {:.6g} Hz before; cut the log there", where,
                      piece.sample_rate_Hz, found.head.sample_rate_Hz));
    }
    if (piece.encoder_resolution_m) {
      found.head.encoder_resolution_m = std::min(
          *piece.encoder_resolution_m, found.head.encoder_resolution_m.value_or(*piece.encoder_resolution_m));
    }
    last_s = piece.start_time_s + static_cast<double>(count - 1) * step_s;
    position_m.take(piece.position_m);
    force_N.take(piece.force_N);
    found.envelope.take(piece.position_m);
    found.places.push_back(place);
    found.samples += count;
  }
  found.head.notes = reader.rows(0).notes;
  if (found.table.header.find("encoder_resolution_m") == found.table.header.end() &&
      found.head.encoder_resolution_m) {
    found.head.notes.push_back(
        fmt::format("encoder_resolution_m is not in the header; the positions move in steps of {:.6g} m",
                    *found.head.encoder_resolution_m));
  }
  const ColumnPlan plan = plan_columns(found.table, read_header_values(found.table));
  require_motion(name_of(found.table, plan, Quantity::kPosition), position_m.low, position_m.high,
                 found.head.encoder_resolution_m);
  require_force(name_of(found.table, plan, plan[Quantity::kForce] ? Quantity::kForce : Quantity::kCurrent),
                force_N.low, force_N.high);
  found.travel_m = position_m.high - position_m.low;
  return found;
}

namespace {

json optional_json(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}

std::optional<double> optional_of(const json& value) {
  return value.is_null() ? std::nullopt : std::optional(value.get<double>());
}

/// Numbers as they lie in memory.
template <class T>
json binary_json(const std::vector<T>& values) {
  std::vector<std::uint8_t> bytes(values.size() * sizeof(T));
  if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return json::binary(std::move(bytes));
}

template <class T>
std::vector<T> vector_of(const json& value) {
  const auto& bytes = value.get_binary();
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

json head_json(const Log& head) {
  return {{"rate_Hz", head.sample_rate_Hz},
          {"start_s", head.start_time_s},
          {"mass_kg", optional_json(head.mass_kg)},
          {"motor_constant", optional_json(head.motor_constant_N_per_A)},
          {"magnet_pitch_m", optional_json(head.magnet_pitch_m)},
          {"resolution_m", optional_json(head.encoder_resolution_m)},
          {"header", head.header},
          {"notes", head.notes}};
}

Log head_of(const json& value) {
  Log head;
  head.sample_rate_Hz = value.at("rate_Hz").get<double>();
  head.start_time_s = value.at("start_s").get<double>();
  head.mass_kg = optional_of(value.at("mass_kg"));
  head.motor_constant_N_per_A = optional_of(value.at("motor_constant"));
  head.magnet_pitch_m = optional_of(value.at("magnet_pitch_m"));
  head.encoder_resolution_m = optional_of(value.at("resolution_m"));
  head.header = value.at("header").get<std::map<std::string, std::string>>();
  head.notes = value.at("notes").get<std::vector<std::string>>();
  return head;
}

json table_json(const RawTable& table) {
  json entries = json::array();
  for (const auto& [key, entry] : table.header) entries.push_back({key, entry.value, entry.line});
  json columns = json::array();
  for (const RawTable::Column& column : table.columns) {
    columns.push_back({column.name, column.relative_precision});
  }
  return {{"source", table.source}, {"line", table.names_line}, {"header", entries}, {"columns", columns}};
}

RawTable table_of(const json& value) {
  RawTable table;
  table.source = value.at("source").get<std::string>();
  table.names_line = value.at("line").get<std::size_t>();
  for (const json& entry : value.at("header")) {
    table.header[entry[0].get<std::string>()] = {entry[1].get<std::string>(), entry[2].get<std::size_t>()};
  }
  for (const json& column : value.at("columns")) {
    table.columns.push_back({column[0].get<std::string>(), {}, column[1].get<double>()});
  }
  return table;
}

}  // namespace

std::string to_bytes(const Survey& survey) {
  const std::vector<std::uint8_t> bytes = json::to_cbor(json{{"head", head_json(survey.head)},
                                                             {"table", table_json(survey.table)},
                                                             {"samples", survey.samples},
                                                             {"travel_m", survey.travel_m},
                                                             {"bytes", survey.bytes},
                                                             {"glance_samples", survey.envelope.samples()},
                                                             {"glances", binary_json(survey.envelope.all())},
                                                             {"places", binary_json(survey.places)}});
  return {bytes.begin(), bytes.end()};
}

Survey survey_of(const std::string& bytes) {
  const json value = json::from_cbor(bytes.begin(), bytes.end());
  Survey survey;
  survey.head = head_of(value.at("head"));
  survey.table = table_of(value.at("table"));
  survey.samples = value.at("samples").get<std::size_t>();
  survey.travel_m = value.at("travel_m").get<double>();
  survey.bytes = value.at("bytes").get<std::size_t>();
  survey.envelope = {vector_of<EnvelopePoint>(value.at("glances")),
                     value.at("glance_samples").get<std::size_t>()};
  survey.places = vector_of<LineReader::Place>(value.at("places"));
  return survey;
}

}  // namespace slipstack::workbench
