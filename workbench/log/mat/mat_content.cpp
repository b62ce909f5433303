// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/mat/mat_content.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/log/csv/columns.h"

namespace slipstack::workbench {
namespace {

void require_finite(const std::string& source, const RawTable::Column& column) {
  const auto& values = column.values;
  const auto bad = std::find_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); });
  if (bad == values.end()) return;
  throw InputError(fmt::format("{}: {}({}) is {}; remove or correct the sample", source,
                               printable(column.name), bad - values.begin() + 1, *bad));
}

void require_equal_lengths(const RawTable& table) {
  plan_columns(table, read_header_values(table));
  const auto& first = table.columns.front();
  for (const auto& column : table.columns) {
    if (column.values.size() == first.values.size()) continue;
    throw InputError(fmt::format("{}: {} has {} samples, {} has {}; save vectors of one length", table.source,
                                 column.name, column.values.size(), first.name, first.values.size()));
  }
}

}  // namespace

void MatContent::add_numbers(bool in_record, const std::string& name, std::vector<double> values,
                             double relative_precision) {
  if (values.size() == 1) {
    part(in_record).texts.try_emplace(printable(name), fmt::format("{}", values.front()));
    return;
  }
  part(in_record).columns.push_back({name, std::move(values), relative_precision});
}

void MatContent::add_text(bool in_record, const std::string& name, const std::string& value) {
  part(in_record).texts.try_emplace(printable(name), printable(trimmed(value)));
}

void MatContent::leave_out(const std::string& name) {
  left_out_.push_back(printable(name));
}

void MatContent::begin_record(const std::string& name) {
  if (!record_name_.empty()) {
    throw InputError(source_ + ": structs " + in_quotes(record_name_) + " and " + in_quotes(name) +
                     " both hold a log; save one of them alone");
  }
  record_name_ = name.empty() ? "?" : name;
}

RawTable MatContent::finish() {
  const auto is_time = [](const RawTable::Column& column) { return column.name == "time_s"; };
  const bool in_record =
      !record_name_.empty() && std::none_of(variables_.columns.begin(), variables_.columns.end(), is_time);
  for (const auto& column : part(!in_record).columns) leave_out(column.name);
  Part& log = part(in_record);
  if (in_record) log.texts.merge(variables_.texts);
  RawTable table;
  table.source = source_;
  table.columns = std::move(log.columns);
  for (const auto& [key, value] : log.texts) table.header.try_emplace(key, RawTable::HeaderEntry{value, 0});
  for (const RawTable::Column& column : table.columns) require_finite(source_, column);
  if (!left_out_.empty()) {
    table.notes.push_back("left out, neither vector, number nor text: " + joined(left_out_));
  }
  require_equal_lengths(table);
  return table;
}

}  // namespace slipstack::workbench
