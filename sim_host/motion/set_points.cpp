// SPDX-License-Identifier: Apache-2.0
#include "sim_host/motion/set_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <string_view>

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

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

std::size_t column(const std::vector<std::string_view>& names, std::string_view wanted,
                   const std::string& where) {
  const auto found = std::find(names.begin(), names.end(), wanted);
  if (found == names.end()) throw std::runtime_error(fmt::format("{}: no column {}", where, wanted));
  return static_cast<std::size_t>(found - names.begin());
}

double number(std::string_view field, const std::string& where) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(value)) {
    throw std::runtime_error(fmt::format("{}: not a number", where));
  }
  return value;
}

}  // namespace

std::unique_ptr<Segment> make_sampled(std::vector<double> position_m, double rate_Hz) {
  if (position_m.size() < 3 || !(rate_Hz > 0.0)) {
    throw std::invalid_argument("set points: at least three, at a positive rate");
  }
  return std::make_unique<Sampled>(std::move(position_m), rate_Hz);
}

SetPointFile read_set_points(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  SetPointFile points;
  std::vector<double> time_s;
  std::size_t time_column = 0;
  std::size_t position_column = 0;
  std::size_t columns = 0;
  std::string line;
  for (std::size_t row = 1; std::getline(file, line); ++row) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line[0] == '#') continue;
    const std::string where = fmt::format("{}:{}", path, row);
    const std::vector<std::string_view> fields = fields_of(line);
    if (columns == 0) {
      columns = fields.size();
      time_column = column(fields, "time_s", where);
      position_column = column(fields, "position_m", where);
      continue;
    }
    if (fields.size() != columns)
      throw std::runtime_error(where + ": another number of fields than the header");
    time_s.push_back(number(fields[time_column], where));
    points.position_m.push_back(number(fields[position_column], where));
  }
  if (time_s.size() < 3) throw std::runtime_error(path + ": fewer than three set points");
  const double step_s = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    if (!(std::fabs(time_s[i] - time_s.front() - static_cast<double>(i) * step_s) <= 0.02 * step_s)) {
      throw std::runtime_error(
          fmt::format("{}: set point {}: the times are not on a uniform grid", path, i + 1));
    }
  }
  points.rate_Hz = 1.0 / step_s;
  return points;
}

}  // namespace slipstack::sim
