// SPDX-License-Identifier: Apache-2.0
// Surveys as bytes, for processes that do not read the file themselves.
#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "workbench/long_logs/survey.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

json optional_json(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}

std::optional<double> optional_of(const json& value) {
  return value.is_null() ? std::nullopt : std::optional(value.get<double>());
}

/// The bytes of the numbers in memory: all processes of a group run on the same kind of machine.
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
                                                             {"envelope_samples", survey.envelope.samples()},
                                                             {"envelope", binary_json(survey.envelope.all())},
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
  survey.envelope = {vector_of<EnvelopePoint>(value.at("envelope")),
                     value.at("envelope_samples").get<std::size_t>()};
  survey.places = vector_of<LineReader::Place>(value.at("places"));
  return survey;
}

}  // namespace slipstack::workbench
