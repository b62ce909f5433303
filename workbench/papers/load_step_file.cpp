// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/load_step_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/log/csv/csv.h"
#include "workbench/log/input_file.h"

namespace slipstack::workbench {
namespace {

/// A calibration has dozens of rows; a file with more than this is refused.
constexpr std::size_t kMostSteps = 100000;

/// The column of one of these names; nullptr without one. Throws InputError where two have it.
const RawTable::Column* find_column(const RawTable& table, std::string_view name,
                                    std::string_view other_name = {}) {
  const RawTable::Column* found = nullptr;
  for (const RawTable::Column& column : table.columns) {
    if (column.name != name && (other_name.empty() || column.name != other_name)) continue;
    if (found != nullptr)
      throw InputError(table.where_names() + ": a quantity has two columns; keep one of them");
    found = &column;
  }
  return found;
}

struct StepColumns {
  const RawTable::Column* time = nullptr;
  const RawTable::Column* load = nullptr;
  const RawTable::Column* signal = nullptr;
};

StepColumns columns_of(const RawTable& table) {
  const StepColumns found{find_column(table, "time_s"), find_column(table, "load_N", "load_kN"),
                          find_column(table, "signal_mV_per_V")};
  for (const auto& [column, name] :
       {std::pair(found.time, "time_s"), std::pair(found.load, "load_N or load_kN"),
        std::pair(found.signal, "signal_mV_per_V")}) {
    if (column == nullptr) {
      throw InputError(fmt::format("{}: the header row has no column {}; add it", table.where_names(), name));
    }
  }
  return found;
}

const CsvColumns kStepColumns{"time_s,load_N,signal_mV_per_V",
                              [](const RawTable& table) { columns_of(table); }};

}  // namespace

std::vector<sim::LoadStep> read_load_steps(const std::string& path) {
  const std::string name = printable(path);
  const InputFile file(name, path);
  FileSource source(file, 0);
  const RawTable table = CsvReader(name, source, kStepColumns).rows(kMostSteps + 1);
  const StepColumns columns = columns_of(table);
  const std::size_t count = columns.time->values.size();
  if (count > kMostSteps) {
    throw InputError(table.where_row(kMostSteps) + ": too many rows; write one for each settled reading");
  }
  if (count == 0) {
    throw InputError(
        fmt::format("{}: no load steps; write below the header row one row for each reading", name));
  }
  const double load_to_N = columns.load->name == "load_kN" ? 1000.0 : 1.0;
  std::vector<sim::LoadStep> steps;
  for (std::size_t i = 0; i < count; ++i) {
    steps.push_back(
        {columns.time->values[i], load_to_N * columns.load->values[i], columns.signal->values[i]});
  }
  return steps;
}

std::string load_steps_text(const std::string& comment, const std::vector<sim::LoadStep>& steps) {
  std::string text = fmt::format("# {}\ntime_s,load_N,signal_mV_per_V\n", comment);
  for (const sim::LoadStep& step : steps) {
    text += fmt::format("{:.3f},{:.3f},{:.9f}\n", step.time_s, step.load_N, step.signal_mV_per_V);
  }
  return text;
}

}  // namespace slipstack::workbench
