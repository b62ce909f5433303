// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/csv/csv.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/log/csv/columns.h"
#include "workbench/log/csv/header_line.h"
#include "workbench/log/csv/line_reader.h"

namespace slipstack::workbench {
namespace {

// 50 million rows of three columns take 1.2 GB; longer logs are refused before the memory of the machine is
// exhausted.
constexpr std::size_t kMaximumRows = 50'000'000;

// A first row with more fields than this is not the header row of a log; chosen.
constexpr std::size_t kMaximumColumns = 64;

void refuse_what_is_no_header_row(const std::string& here, std::string_view text,
                                  const std::vector<std::string_view>& fields, const char* example) {
  if (text.find('"') != std::string_view::npos) {
    throw InputError(here + ": quotes are not supported; write the column names without them");
  }
  if (fields.size() == 1 && text.find_first_of(";\t ") != std::string_view::npos) {
    throw InputError(here + ": found no comma in the header row " + in_quotes(text) +
                     "; separate columns by commas and write decimal points, or use `slipstack import`, "
                     "which reads other separators and decimal commas");
  }
  const bool numbers = std::all_of(fields.begin(), fields.end(),
                                   [](std::string_view field) { return number_fault(field).empty(); });
  if (numbers) {
    throw InputError(here +
                     ": numbers where the header row should be; write the column names above them, "
                     "without '#', e.g. " +
                     example);
  }
  if (fields.size() > kMaximumColumns) {
    throw InputError(here + ": " + std::to_string(fields.size()) +
                     " columns; keep only those that a log may have");
  }
}

const char* skip_blanks(const char* position, const char* end) {
  while (position != end && (*position == ' ' || *position == '\t')) ++position;
  return position;
}

}  // namespace

const CsvColumns kLogColumns{"time_s,position_m,force_N",
                             [](const RawTable& table) { plan_columns(table, read_header_values(table)); }};

CsvReader::CsvReader(const std::string& name, ByteSource& source, const CsvColumns& columns)
    : columns_(columns), lines_(name, source) {
  table_.source = name;
  read_header();
}

CsvReader::CsvReader(const RawTable& table, ByteSource& source, LineReader::Place place)
    : lines_(table.source, source, place), table_(without_rows(table)) {}

bool CsvReader::next_line() {
  while (lines_.next(line_)) {
    const std::string_view text = trimmed(line_);
    if (text.empty()) continue;
    if (text.front() != '#') return true;
    take_comment(trimmed(text.substr(1)));
  }
  return false;
}

void CsvReader::read_header() {
  if (next_line()) {
    take_names(trimmed(line_));
    return;
  }
  if (lines_.line_number() == 0) {
    throw InputError(table_.source + ": the file is empty; record a log into it");
  }
  throw InputError(here() +
                   ": the text ends without a header row; write the column names and the samples, "
                   "e.g. " +
                   columns_.example);
}

void CsvReader::skip(std::size_t count) {
  while (count > 0 && next_line()) --count;
}

RawTable CsvReader::without_rows(const RawTable& table) {
  RawTable header;
  header.source = table.source;
  header.header = table.header;
  header.names_line = table.names_line;
  for (const RawTable::Column& column : table.columns) {
    header.columns.push_back({column.name, {}, column.relative_precision});
  }
  return header;
}

RawTable CsvReader::rows(std::size_t maximum) {
  rows_ = 0;
  if (maximum < kMaximumRows) {  // else the number of rows is not known beforehand
    for (RawTable::Column& column : table_.columns) column.values.reserve(maximum);
  }
  while (rows_ < maximum && next_line()) take_row();
  note_oddities();
  RawTable table = without_rows(table_);
  std::swap(table, table_);
  return table;
}

void CsvReader::take_comment(std::string_view text) {
  if (!table_.columns.empty()) {
    ++comments_among_rows_;
    return;
  }
  const std::optional<HeaderLine> line = parse_header_line(text);
  if (!line) return;
  const auto [entry, is_new] =
      table_.header.try_emplace(line->key, RawTable::HeaderEntry{line->value, lines_.line_number()});
  if (is_new) return;
  if (entry->second.value != line->value) {
    throw InputError(here() + ": header key " + in_quotes(line->key) + " has another value than on line " +
                     std::to_string(entry->second.line) + "; keep one of them");
  }
  ++repeated_keys_;
}

void CsvReader::take_names(std::string_view text) {
  table_.names_line = lines_.line_number();
  const std::vector<std::string_view> fields = split_fields(text);
  refuse_what_is_no_header_row(here(), text, fields, columns_.example);
  for (const std::string_view field : fields) {
    if (field.empty()) {
      throw InputError(here() + ": column " + std::to_string(table_.columns.size() + 1) +
                       " has no name; name it or remove the comma");
    }
    table_.columns.push_back({std::string(field), {}, 0.0});
  }
  columns_.check(table_);
}

void CsvReader::take_row() {
  note_line();
  const char* position = line_.data();
  const char* const end = position + line_.size();
  for (std::size_t i = 0; i < table_.columns.size(); ++i) {
    position = skip_blanks(position, end);
    double value = 0.0;
    position = parse_double(position, end, value);
    if (position == nullptr || !std::isfinite(value)) refuse_row();
    position = skip_blanks(position, end);
    const bool last = i + 1 == table_.columns.size();
    if (last ? position != end : (position == end || *position != ',')) refuse_row();
    if (!last) ++position;
    table_.columns[i].values.push_back(value);
  }
  ++rows_;
}

// Records the line of the row; rows on consecutive lines share one anchor.
void CsvReader::note_line() {
  const std::size_t line = lines_.line_number();
  if (table_.anchors.empty() || table_.anchors.back().line + (rows_ - table_.anchors.back().row) != line) {
    table_.anchors.push_back({rows_, line});
  }
}

// Reads the row again field by field, to name the fault.
void CsvReader::refuse_row() const {
  const std::vector<std::string_view> fields = split_fields(line_);
  const std::size_t expected = table_.columns.size();
  if (fields.size() != expected) {
    std::vector<std::string> names;
    for (const auto& column : table_.columns) names.push_back(column.name);
    throw InputError(here() + ": " + std::to_string(fields.size()) +
                     (fields.size() == 1 ? " field" : " fields") + " where the header row names " +
                     std::to_string(expected) + " (" + joined(names) +
                     "); complete or remove the row, write decimal points, not commas");
  }
  for (std::size_t i = 0; i < expected; ++i) {
    const std::string fault = number_fault(fields[i]);
    if (fault.empty()) continue;
    throw InputError(here() + ": column " + table_.columns[i].name + ": " + fault +
                     "; write a decimal number or remove the row");
  }
  throw InputError(here() + ": the row cannot be read; remove it");
}

void CsvReader::note_oddities() {
  if (repeated_keys_ > 0) {
    table_.notes.push_back(std::to_string(repeated_keys_) + " repeated header " +
                           (repeated_keys_ == 1 ? "key" : "keys") + " ignored");
  }
  if (comments_among_rows_ > 0) {
    table_.notes.push_back(std::to_string(comments_among_rows_) + " comment " +
                           (comments_among_rows_ == 1 ? "line" : "lines") + " among the samples ignored");
  }
}

RawTable read_csv(const std::string& name, ByteSource& source, const CsvColumns& columns) {
  CsvReader reader(name, source, columns);
  RawTable table = reader.rows(kMaximumRows);
  const RawTable more = reader.rows(1);
  if (!more.anchors.empty()) {
    throw InputError(more.where_row(0) + ": more than " + std::to_string(kMaximumRows) +
                     " samples; split it into shorter logs or decimate it");
  }
  return table;
}

}  // namespace slipstack::workbench
