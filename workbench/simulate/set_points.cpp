// SPDX-License-Identifier: Apache-2.0
#include "workbench/simulate/set_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/simulate/model_stepper.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kFewest = 10;
constexpr std::uintmax_t kLargestFile = std::uintmax_t{1} << 30;
/// Largest deviation of a time stamp from the uniform grid, relative to the step.
constexpr double kUniform = 0.02;

std::vector<double> differences(const std::vector<double>& values, double rate_Hz) {
  std::vector<double> slope(values.size(), 0.0);
  for (std::size_t i = 1; i + 1 < values.size(); ++i) {
    slope[i] = 0.5 * rate_Hz * (values[i + 1] - values[i - 1]);
  }
  // One-sided differences at the ends: the file may begin and end during a movement.
  slope.front() = rate_Hz * (values[1] - values[0]);
  slope.back() = rate_Hz * (values[values.size() - 1] - values[values.size() - 2]);
  return slope;
}

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path) {}

  SetPoints read() {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path_, error)) {
      throw InputError(
          printable(fmt::format("{}: no such file; `slipstack experiment plan` writes one", path_.string())));
    }
    if (std::filesystem::file_size(path_, error) > kLargestFile) {
      throw InputError(
          printable(fmt::format("{}: larger than a GiB; give a shorter motion", path_.string())));
    }
    std::ifstream file(path_, std::ios::binary);
    std::string line;
    while (std::getline(file, line)) {
      ++line_;
      if (!line.empty() && line.back() == '\r') line.pop_back();
      if (line.empty() || line[0] == '#') continue;
      if (columns_.empty()) {
        read_header(line);
      } else {
        read_row(line);
      }
    }
    return assemble();
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(printable(fmt::format("{}:{}: {}", path_.string(), line_, what)));
  }

  void read_header(std::string_view line) {
    for (const std::string_view name : split_fields(line)) {
      columns_.push_back(std::string(name));
      values_[columns_.back()];
    }
    for (const char* wanted : {"time_s", "position_m"}) {
      if (!values_.contains(wanted)) {
        fail(fmt::format("no column {}; set points have time_s and position_m", wanted));
      }
    }
  }

  void read_row(std::string_view line) {
    const std::vector<std::string_view> fields = split_fields(line);
    if (fields.size() != columns_.size()) {
      fail(fmt::format("{} fields where the header has {}", fields.size(), columns_.size()));
    }
    for (std::size_t i = 0; i < fields.size(); ++i) {
      double value = 0.0;
      const std::string fault = number_fault(fields[i]);
      if (!fault.empty()) fail(fmt::format("column {}: {}", columns_[i], fault));
      parse_double(fields[i].data(), fields[i].data() + fields[i].size(), value);
      if (!std::isfinite(value)) fail(fmt::format("column {}: not a finite number", columns_[i]));
      values_[columns_[i]].push_back(value);
    }
  }

  SetPoints assemble() {
    const std::vector<double>& time_s = values_["time_s"];
    if (time_s.size() < kFewest) {
      throw InputError(
          printable(fmt::format("{}: {} set points, fewer than {}", path_.string(), time_s.size(), kFewest)));
    }
    const double step_s = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
    for (std::size_t i = 0; i < time_s.size(); ++i) {
      const double place_s = time_s.front() + static_cast<double>(i) * step_s;
      if (!(step_s > 0.0) || std::abs(time_s[i] - place_s) > kUniform * step_s) {
        throw InputError(printable(
            fmt::format("{}: set point {}: time {:g} s is not on a uniform grid; write one with equal steps",
                        path_.string(), i + 1, time_s[i])));
      }
    }
    SetPoints points;
    points.rate_Hz = 1.0 / step_s;
    points.position_m = values_["position_m"];
    points.velocity_mps = values_.contains("velocity_mps") ? values_["velocity_mps"]
                                                           : differences(points.position_m, points.rate_Hz);
    points.acceleration_mps2 = values_.contains("acceleration_mps2")
                                   ? values_["acceleration_mps2"]
                                   : differences(points.velocity_mps, points.rate_Hz);
    return points;
  }

  std::filesystem::path path_;
  std::size_t line_ = 0;
  std::vector<std::string> columns_;
  std::map<std::string, std::vector<double>> values_;
};

}  // namespace

std::string to_csv(const SetPoints& points, const std::vector<std::string>& header) {
  std::string text;
  for (const std::string& line : header) text += "# " + printable(line) + "\n";
  text += "time_s,position_m,velocity_mps,acceleration_mps2\n";
  for (std::size_t i = 0; i < points.size(); ++i) {
    fmt::format_to(std::back_inserter(text), "{:.9g},{:.12f},{:.9g},{:.9g}\n",
                   static_cast<double>(i) / points.rate_Hz, points.position_m[i], points.velocity_mps[i],
                   points.acceleration_mps2[i]);
  }
  return text;
}

SetPoints read_set_points(const std::filesystem::path& path) {
  return Reader(path).read();
}

std::vector<double> force_along(const SetPoints& points, const Terms& terms) {
  ModelStepper model(terms, 1.0 / points.rate_Hz);
  std::vector<double> force_N(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Sample<double> sample{.time_s = static_cast<double>(i) / points.rate_Hz,
                                .displacement = points.position_m[i],
                                .position_m = points.position_m[i],
                                .velocity_mps = points.velocity_mps[i],
                                .acceleration_mps2 = points.acceleration_mps2[i]};
    if (i == 0) model.reset(sample);
    const ModelStepper::Forces forces = model.step(sample);
    force_N[i] = (model.mass_kg() * points.acceleration_mps2[i] + forces.friction_N) * forces.factor;
  }
  return force_N;
}

}  // namespace slipstack::workbench
