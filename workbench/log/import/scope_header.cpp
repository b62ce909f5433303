// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/import/scope_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "workbench/log/import/column_guess.h"

namespace slipstack::workbench {
namespace {

// Of each channel: its path in the controller, or its name in the scope; older files have the name alone.
constexpr std::string_view kName = "Name";
constexpr std::string_view kUnit = "Unit";
constexpr double kScopeTime_s = 1e-3;  // times are in ms (TwinCAT 3 Scope, "Export to CSV")

using Row = std::vector<std::string_view>;

/// The row with this key over all columns of times, which are those of `names`; nullptr where there is none.
const Row* row_of(const std::vector<Row>& rows, std::string_view key, const std::vector<std::size_t>& times) {
  for (const Row& row : rows) {
    const bool all = std::all_of(times.begin(), times.end(),
                                 [&](std::size_t at) { return at < row.size() && row[at] == key; });
    if (all) return &row;
  }
  return nullptr;
}

}  // namespace

std::optional<std::vector<ImportColumn>> scope_columns(const std::vector<std::vector<std::string_view>>& rows,
                                                       std::size_t columns) {
  const auto names = std::find_if(rows.begin(), rows.end(), [&](const Row& row) {
    return row.size() == columns && row.size() >= 2 && row[0] == kName && row[1] != kName;
  });
  if (names == rows.end()) return {};
  std::vector<std::size_t> times;
  for (std::size_t i = 0; i < columns; ++i) {
    if ((*names)[i] == kName) times.push_back(i);
  }
  // A table of another program may have a column "Name"; a row for each sample time it has not.
  const Row* sampled = row_of(rows, "SampleTime[ms]", times);
  if (sampled == nullptr && times.size() < 2) return {};
  const Row* units = row_of(rows, kUnit, times);
  std::vector<ImportColumn> found;
  for (std::size_t i = 0; i < columns; ++i) {
    if ((*names)[i] == kName) {
      ImportColumn time{fmt::format("time {}", found.size() + 1), "", kScopeTime_s, false, i != 0};
      if (i == 0) time.target = "time_s";
      found.push_back(std::move(time));
      continue;
    }
    const std::string unit(units != nullptr && i < units->size() ? (*units)[i] : std::string_view());
    found.push_back(guess_column(std::string((*names)[i]), unit == "(None)" ? "" : unit));
  }
  return found;
}

}  // namespace slipstack::workbench
