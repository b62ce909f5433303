// SPDX-License-Identifier: Apache-2.0
#include "sim_host/motion/set_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

namespace slipstack::sim {
namespace {

class Sampled final : public Segment {
 public:
  Sampled(std::vector<double> position_m, double rate_Hz) : x_(std::move(position_m)), rate_Hz_(rate_Hz) {
    v_.assign(x_.size(), 0.0);
    a_.assign(x_.size(), 0.0);
    for (std::size_t i = 1; i + 1 < x_.size(); ++i) {
      v_[i] = 0.5 * (x_[i + 1] - x_[i - 1]);
      a_[i] = x_[i + 1] - 2.0 * x_[i] + x_[i - 1];
    }
  }

  double duration_s() const override { return static_cast<double>(x_.size() - 1) / rate_Hz_; }

  /// The quintic of Hermite on the interval, time in samples.
  MotionPoint at(double t_s) const override {
    const double place = std::clamp(t_s * rate_Hz_, 0.0, static_cast<double>(x_.size() - 1));
    const std::size_t i = std::min(static_cast<std::size_t>(place), x_.size() - 2);
    const double u = place - static_cast<double>(i);
    // The remainder after the parabola that fits the left end.
    const double d = x_[i + 1] - x_[i] - v_[i] - 0.5 * a_[i];
    const double e = v_[i + 1] - v_[i] - a_[i];
    const double f = a_[i + 1] - a_[i];
    const double c3 = 10.0 * d - 4.0 * e + 0.5 * f;
    const double c4 = -15.0 * d + 7.0 * e - f;
    const double c5 = 6.0 * d - 3.0 * e + 0.5 * f;
    return {x_[i] + u * (v_[i] + u * (0.5 * a_[i] + u * (c3 + u * (c4 + u * c5)))),
            rate_Hz_ * (v_[i] + u * (a_[i] + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))),
            rate_Hz_ * rate_Hz_ * (a_[i] + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5)))};
  }

 private:
  std::vector<double> x_;
  std::vector<double> v_;  // per sample
  std::vector<double> a_;  // per sample squared
  double rate_Hz_;
};

std::string_view trimmed(std::string_view field) {
  const std::size_t first = field.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return field.substr(first, field.find_last_not_of(" \t") - first + 1);
}

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

constexpr std::uintmax_t kLargestFile = std::uintmax_t{1} << 30;
constexpr std::size_t kFewest = 3;
// Largest deviation of a time from the uniform grid, relative to the step; chosen.
constexpr double kUniform = 0.02;

// Reads a file of set points line by line.
class SetPointReader {
 public:
  SetPointReader(const std::string& path, const SetPointColumns& columns) : path_(path), columns_(columns) {}

  SetPointFile read() {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path_, error)) {
      fail("no such file; `slipstack experiment plan` writes one");
    }
    if (std::filesystem::file_size(path_, error) > kLargestFile) {
      fail("larger than a GiB; give a shorter motion");
    }
    std::ifstream file(path_, std::ios::binary);
    std::string line;
    while (std::getline(file, line)) {
      ++line_;
      if (!line.empty() && line.back() == '\r') line.pop_back();
      if (line.empty() || line[0] == '#') continue;
      if (names_.empty()) {
        read_names(line);
      } else {
        read_row(line);
      }
    }
    return assemble();
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(line_ == 0 ? fmt::format("{}: {}", path_, what)
                                        : fmt::format("{}:{}: {}", path_, line_, what));
  }

  void read_names(std::string_view line) {
    for (const std::string_view name : fields_of(line)) names_.emplace_back(name);
    values_.resize(names_.size());
    for (const std::string& wanted : {std::string("time_s"), columns_.position}) {
      if (find(wanted) == nullptr) {
        fail(fmt::format("no column {}; set points have time_s and {}", wanted, columns_.position));
      }
    }
  }

  void read_row(std::string_view line) {
    const std::vector<std::string_view> fields = fields_of(line);
    if (fields.size() != names_.size()) {
      fail(fmt::format("{} fields where the header has {}", fields.size(), names_.size()));
    }
    for (std::size_t i = 0; i < fields.size(); ++i) values_[i].push_back(number(fields[i], names_[i]));
  }

  double number(std::string_view field, const std::string& name) const {
    double value = 0.0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(value)) {
      fail(fmt::format("column {}: '{}' is not a finite number", name, field));
    }
    return value;
  }

  const std::vector<double>* find(std::string_view name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    return found == names_.end() ? nullptr : &values_[static_cast<std::size_t>(found - names_.begin())];
  }

  SetPointFile assemble() {
    const std::vector<double>* const time = find("time_s");
    if (time == nullptr) return with_times(path_, {}, {});
    SetPointFile points{0.0, *find(columns_.position), {}, {}};
    if (const auto* velocity = find(columns_.velocity)) points.velocity_mps = *velocity;
    if (const auto* acceleration = find(columns_.acceleration)) points.acceleration_mps2 = *acceleration;
    return with_times(path_, *time, std::move(points));
  }

  const std::string& path_;
  const SetPointColumns& columns_;
  std::size_t line_ = 0;
  std::vector<std::string> names_;
  std::vector<std::vector<double>> values_;  // by column
};

}  // namespace

std::unique_ptr<Segment> make_sampled(std::vector<double> position_m, double rate_Hz) {
  if (position_m.size() < 3 || !(rate_Hz > 0.0)) {
    throw std::invalid_argument("set points: at least three, at a positive rate");
  }
  return std::make_unique<Sampled>(std::move(position_m), rate_Hz);
}

SetPointFile read_set_points(const std::string& path, const SetPointColumns& columns) {
  return SetPointReader(path, columns).read();
}

SetPointFile with_times(const std::string& name, const std::vector<double>& time_s, SetPointFile points) {
  if (time_s.size() < kFewest) {
    throw std::runtime_error(fmt::format("{}: fewer than {} set points", name, kFewest));
  }
  const double step_s = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    const double place_s = time_s.front() + static_cast<double>(i) * step_s;
    if (!(step_s > 0.0) || std::fabs(time_s[i] - place_s) > kUniform * step_s) {
      throw std::runtime_error(
          fmt::format("{}: set point {}: time {:g} s is not on a uniform grid; write one with equal steps",
                      name, i + 1, time_s[i]));
    }
  }
  points.rate_Hz = 1.0 / step_s;
  return points;
}

}  // namespace slipstack::sim
