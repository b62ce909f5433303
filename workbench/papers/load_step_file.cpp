// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/load_step_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <fstream>
#include <system_error>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

/// A calibration has dozens of rows; a file with more than this is refused.
constexpr std::size_t kMostSteps = 100000;
constexpr std::size_t kLongestLine = 10000;

/// The column of each quantity, and the factor of the load to SI.
struct Layout {
  std::size_t time = std::string::npos;
  std::size_t load = std::string::npos;
  std::size_t signal = std::string::npos;
  std::size_t columns = 0;
  double load_to_N = 1.0;
};

[[noreturn]] void refuse(const std::string& path, std::size_t line, const std::string& what) {
  throw InputError(fmt::format("{}:{}: {}", printable(path), line, what));
}

Layout layout_of(const std::string& path, std::size_t line, std::string_view header) {
  Layout layout;
  const std::vector<std::string_view> names = split_fields(header);
  layout.columns = names.size();
  const auto place = [&](std::size_t& where, std::size_t column) {
    if (where != std::string::npos) refuse(path, line, "a quantity has two columns; keep one of them");
    where = column;
  };
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == "time_s") place(layout.time, i);
    if (names[i] == "load_N" || names[i] == "load_kN") place(layout.load, i);
    if (names[i] == "load_kN") layout.load_to_N = 1000.0;
    if (names[i] == "signal_mV_per_V") place(layout.signal, i);
  }
  for (const auto& [where, name] :
       {std::pair(layout.time, "time_s"), std::pair(layout.load, "load_N or load_kN"),
        std::pair(layout.signal, "signal_mV_per_V")}) {
    if (where == std::string::npos)
      refuse(path, line, fmt::format("the header row has no column {}; add it", name));
  }
  return layout;
}

double number_at(const std::string& path, std::size_t line, const std::vector<std::string_view>& fields,
                 std::size_t column, const char* name) {
  if (const std::string fault = number_fault(fields[column]); !fault.empty()) {
    refuse(path, line, fmt::format("column {} {}; write a number or remove the row", name, fault));
  }
  double value = 0.0;
  parse_double(fields[column].data(), fields[column].data() + fields[column].size(), value);
  return value;
}

}  // namespace

std::vector<sim::LoadStep> read_load_steps(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    throw InputError(fmt::format("{}: cannot be read: {}; name a file of load steps", printable(path),
                                 std::generic_category().message(errno)));
  }
  std::vector<sim::LoadStep> steps;
  Layout layout;
  std::string text;
  for (std::size_t line = 1; std::getline(file, text); ++line) {
    if (text.size() > kLongestLine) refuse(path, line, "the line is too long for a list of load steps");
    if (!text.empty() && text.back() == '\r') text.pop_back();
    const std::string_view content = trimmed(text);
    if (content.empty() || content.front() == '#') continue;
    if (layout.columns == 0) {
      layout = layout_of(path, line, content);
      continue;
    }
    const std::vector<std::string_view> fields = split_fields(content);
    if (fields.size() != layout.columns) {
      refuse(path, line, fmt::format("{} fields where the header row has {}", fields.size(), layout.columns));
    }
    if (steps.size() == kMostSteps) refuse(path, line, "too many rows; write one for each settled reading");
    steps.push_back({number_at(path, line, fields, layout.time, "time_s"),
                     layout.load_to_N * number_at(path, line, fields, layout.load, "load"),
                     number_at(path, line, fields, layout.signal, "signal_mV_per_V")});
  }
  if (file.bad()) throw InputError(fmt::format("{}: cannot be read to its end", printable(path)));
  if (steps.empty()) {
    throw InputError(fmt::format(
        "{}: no load steps; write a header row time_s,load_N,signal_mV_per_V and one row for each reading",
        printable(path)));
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
