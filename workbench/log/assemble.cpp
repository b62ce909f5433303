// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/assemble.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "workbench/base/axis_units.h"
#include "workbench/base/axis_words.h"
#include "workbench/base/text.h"
#include "workbench/log/csv/columns.h"
#include "workbench/log/sampling/encoder_step.h"
#include "workbench/log/sampling/sampling.h"

namespace slipstack::workbench {
namespace {

constexpr double kMoreThanOneStep = 1.5;  // in encoder steps: half-way between one step and two
constexpr double kOnGrid = 0.05;          // of an encoder step: rounding of the written decimals; chosen
constexpr double kMostOnGrid = 0.99;      // share of the readings that must lie on the grid; chosen

double largest_magnitude(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

double storage_error(const RawTable::Column& column, double largest) {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  return 2.0 * std::max(column.relative_precision, kEpsilon) * largest;
}

/// Continues a position that is counted modulo a period; returns how often it jumps. It is one where all
/// values lie within one period, and a step from sample to sample is less than a quarter of it, or more than
/// three quarters: between them no one could tell forward from backward.
std::size_t unwrap(std::vector<double>& position, double period) {
  if (position.empty()) return 0;
  const auto [lowest, highest] = std::minmax_element(position.begin(), position.end());
  constexpr double kRounding = 1e-3;
  if (*highest - *lowest > (1.0 + kRounding) * period) return 0;
  std::size_t wraps = 0;
  for (std::size_t i = 1; i < position.size(); ++i) {
    const double step = std::abs(position[i] - position[i - 1]) / period;
    if (step > 0.25 && step < 0.75) return 0;
    wraps += step >= 0.75 ? 1 : 0;
  }
  if (wraps == 0) return 0;
  double periods = 0.0;
  double before = position.front();
  for (double& value : position) {
    const double step = (value - before) / period;
    before = value;
    periods -= std::round(step);
    value += periods * period;
  }
  return wraps;
}

/// Whether the position jumps at this sample from one end of its range to the other while the axis moves on
/// in the opposite direction. A knock, an outlier or a lost reference does not.
bool wraps_at(const std::vector<double>& position, std::size_t sample, double range) {
  constexpr std::size_t kSide = 5;         // samples that show the motion before and after; chosen
  constexpr double kNearlyTheRange = 0.9;  // an axis does not pass so much of its travel within a sample
  constexpr double kMostMotion = 0.25;     // of the range, within kSide samples; chosen
  if (sample < kSide + 1 || sample + kSide >= position.size()) return false;
  const double jump = position[sample] - position[sample - 1];
  if (std::abs(jump) < kNearlyTheRange * range) return false;
  const double way = jump > 0.0 ? -1.0 : 1.0;
  const double before = way * (position[sample - 1] - position[sample - 1 - kSide]);
  const double after = way * (position[sample + kSide] - position[sample]);
  return before > 0.0 && after > 0.0 && std::max(before, after) < kMostMotion * range;
}

class Assembler {
 public:
  /// What the table holds: all rows of a log, or a chunk of them whose sampling is to be found or is known.
  enum class Rows { all, unknown_sampling, known_sampling };
  explicit Assembler(RawTable table, Rows rows = Rows::all, const Log* head = nullptr)
      : table_(std::move(table)),
        header_(read_header_values(table_)),
        plan_(plan_columns(table_, header_)),
        rows_(rows),
        head_(head) {
    use_axis(plan_.axis, table_.source);
  }

  Log assemble() {
    if (rows_ == Rows::all) require_enough_samples(table_.columns.front().values.size(), "");
    for (const auto& [key, entry] : table_.header) log_.header.emplace(key, entry.value);
    log_.notes = std::move(table_.notes);
    log_.mass_kg = header_.mass_kg;
    log_.motor_constant_N_per_A = header_.motor_constant_N_per_A;
    log_.magnet_pitch_m = header_.magnet_pitch_m;
    log_.commanded_current = header_.commanded_current;
    log_.encoder_resolution_m =
        rows_ == Rows::known_sampling ? head_->encoder_resolution_m : header_.encoder_resolution_m;
    take_time();
    take_position();
    take_force();
    log_.reference_position_m = take(Quantity::kReferencePosition);
    if (rows_ == Rows::all && axis_is_rotary()) unwrap(log_.reference_position_m, kTurn_rad);
    log_.reference_position_m = on_grid(std::move(log_.reference_position_m));
    log_.velocity_mps = on_grid(take(Quantity::kVelocity));
    log_.normal_force_N = on_grid(take(Quantity::kNormalForce));
    log_.temperature_C = on_grid(take(Quantity::kTemperature));
    return std::move(log_);
  }

 private:
  std::string where_column(Quantity quantity) const {
    return table_.source + ": column " + table_.columns[plan_[quantity]->column].name;
  }

  void require_enough_samples(std::size_t count, std::string_view when) const {
    if (count >= Log::kMinimumSamples) return;
    throw InputError(fmt::format("{}: {} samples{} are too few; record at least {}", table_.source, count,
                                 when, Log::kMinimumSamples));
  }

  // Moves a column out of the table, in SI units; empty when the table has no such column.
  std::vector<double> take(Quantity quantity) {
    const auto& source = plan_[quantity];
    if (!source) return {};
    std::vector<double> values = std::move(table_.columns[source->column].values);
    if (source->divisor != 1.0) {
      for (double& value : values) value /= source->divisor;
    }
    if (source->factor != 1.0) {
      for (double& value : values) value *= source->factor;
    }
    return values;
  }

  // Irregular samples are interpolated on the uniform grid; uniform ones are returned unchanged.
  std::vector<double> on_grid(std::vector<double> values) const {
    if (!header_.irregular_sampling || values.empty()) return values;
    return resampled(time_s_, values, grid_);
  }

  void take_time() {
    time_s_ = take(Quantity::kTime);
    if (rows_ == Rows::known_sampling) {
      log_.sample_rate_Hz = head_->sample_rate_Hz;
      log_.start_time_s = time_s_.front();
      return;
    }
    const WhereRow where = [this](std::size_t row) { return table_.where_row(row); };
    require_growing_time(time_s_, where);
    Sampling sampling;
    if (header_.irregular_sampling) {
      sampling = take_grid(where);
    } else {
      const RawTable::Column& column = table_.columns[plan_[Quantity::kTime]->column];
      const double largest_s = std::max(std::abs(time_s_.front()), std::abs(time_s_.back()));
      sampling = uniform_sampling(time_s_, storage_error(column, largest_s), where);
    }
    if (!std::isnormal(sampling.rate_Hz)) {
      throw InputError(where_column(Quantity::kTime) +
                       ": the sample rate is beyond the range of a number; write seconds");
    }
    log_.sample_rate_Hz = sampling.rate_Hz;
    log_.start_time_s = sampling.start_s;
  }

  // The uniform grid for irregular samples.
  Sampling take_grid(const WhereRow& where) {
    if (const auto even =
            evenly_sampled(time_s_, table_.columns[plan_[Quantity::kPosition]->column].values)) {
      grid_ = {even->sampling, even->places.back() + 1};
      for (std::size_t i = 0; i < time_s_.size(); ++i) {
        time_s_[i] = grid_.sampling.start_s + static_cast<double>(even->places[i]) / grid_.sampling.rate_Hz;
      }
      log_.notes.push_back(fmt::format(
          "irregular sampling: the time stamps deviate by up to {:.2g} s from a uniform {:.6g} Hz, but the "
          "positions show that the samples were taken evenly; they are read as uniform",
          even->jitter_s, grid_.sampling.rate_Hz));
      if (const std::size_t missing = grid_.count - time_s_.size(); missing > 0) {
        log_.notes.push_back(fmt::format("{} missing samples interpolated", missing));
      }
    } else {
      grid_ = resampling_grid(time_s_, where);
      log_.notes.push_back(fmt::format("irregular sampling: {} samples interpolated to {} at {:.6g} Hz",
                                       time_s_.size(), grid_.count, grid_.sampling.rate_Hz));
    }
    require_enough_samples(grid_.count, " on the median step");
    return grid_.sampling;
  }

  // Irregular positions interpolated on the uniform time grid; they are rounded to the encoder's grid where
  // the readings lie on one.
  std::vector<double> position_on_grid(const std::vector<double>& reading_m) const {
    std::vector<double> position_m = resampled_smoothly(time_s_, reading_m, grid_);
    const double step_m = log_.encoder_resolution_m.value_or(0.0);
    if (!(step_m > 0.0)) return position_m;
    const auto on_encoder_grid = [&](double x) {
      return reading_m.front() + step_m * std::round((x - reading_m.front()) / step_m);
    };
    const auto on_it = std::count_if(reading_m.begin(), reading_m.end(), [&](double x) {
      return std::abs(x - on_encoder_grid(x)) < kOnGrid * step_m;
    });
    if (static_cast<double>(on_it) < kMostOnGrid * static_cast<double>(reading_m.size())) return position_m;
    for (double& x : position_m) x = on_encoder_grid(x);
    return position_m;
  }

  void take_position() {
    const ColumnPlan::Source source = *plan_[Quantity::kPosition];
    log_.position_m = take(Quantity::kPosition);
    if (source.counts) {
      if (rows_ == Rows::all) unwrap_counts();
      for (double& value : log_.position_m) value *= *log_.encoder_resolution_m;
      require_finite(log_.position_m, Quantity::kPosition);
    }
    if (rows_ == Rows::all && axis_is_rotary()) unwrap_angle();
    if (rows_ == Rows::all) refuse_wraps();
    // Interpolated positions lie on no grid, so the encoder's step is estimated before the interpolation.
    if (!log_.encoder_resolution_m && rows_ != Rows::known_sampling)
      estimate_resolution(table_.columns[source.column]);
    if (header_.irregular_sampling) log_.position_m = position_on_grid(log_.position_m);
    if (rows_ != Rows::all) return;
    const auto [lowest, highest] = std::minmax_element(log_.position_m.begin(), log_.position_m.end());
    require_motion(where_column(Quantity::kPosition), *lowest, *highest, log_.encoder_resolution_m);
  }

  // An angle that is counted modulo one turn continues where it jumps from one end of the turn to the other.
  void unwrap_angle() { note_wraps("the angle", "one turn", unwrap(log_.position_m, kTurn_rad)); }

  // The same of a counter of 16, 24 or 32 bits: of the shortest that holds all values.
  void unwrap_counts() {
    const auto [lowest, highest] = std::minmax_element(log_.position_m.begin(), log_.position_m.end());
    for (const int bits : {16, 24, 32}) {
      const double period = std::ldexp(1.0, bits);
      if (*highest - *lowest >= period) continue;
      note_wraps("the count", fmt::format("2^{}", bits), unwrap(log_.position_m, period));
      return;
    }
  }

  void note_wraps(std::string_view what, std::string_view period, std::size_t wraps) {
    if (wraps == 0) return;
    log_.notes.push_back(fmt::format("{} jumps by {} {} {} and was continued (it is counted modulo {})", what,
                                     period, wraps, wraps == 1 ? "time" : "times", period));
  }

  // Of any other counter the period is not known to the last step, so that nothing can be continued.
  void refuse_wraps() const {
    const std::vector<double>& position_m = log_.position_m;
    const auto [lowest, highest] = std::minmax_element(position_m.begin(), position_m.end());
    for (std::size_t i = 1; i < position_m.size(); ++i) {
      if (!wraps_at(position_m, i, *highest - *lowest)) continue;
      throw InputError(fmt::format(
          "{}: column {}: the position jumps from {:.6g} to {:.6g} {}, one end of its range to the other, "
          "while the axis moves on, as a counter does that is full; write the position without such jumps",
          table_.where_row(i), table_.columns[plan_[Quantity::kPosition]->column].name, position_m[i - 1],
          position_m[i], axis_unit("m")));
    }
  }

  void estimate_resolution(const RawTable::Column& column) {
    const double error_m = storage_error(column, largest_magnitude(log_.position_m));
    log_.encoder_resolution_m = estimate_encoder_step(log_.position_m, error_m);
    if (log_.encoder_resolution_m) {
      log_.notes.push_back(estimated_resolution_note(*log_.encoder_resolution_m));
    } else {
      log_.notes.push_back(axis_key("encoder_resolution_m") +
                           " is not in the header, and the positions show no steps");
    }
  }

  void take_force() {
    const Quantity quantity = plan_[Quantity::kForce] ? Quantity::kForce : Quantity::kCurrent;
    log_.force_N = take(quantity);
    if (quantity == Quantity::kCurrent) {
      for (double& value : log_.force_N) value *= *log_.motor_constant_N_per_A;
      require_finite(log_.force_N, quantity);
    } else if (plan_[Quantity::kCurrent]) {
      log_.notes.emplace_back("column current_A ignored, the force is measured");
    }
    log_.force_N = on_grid(std::move(log_.force_N));
    if (rows_ != Rows::all) return;
    const auto [lowest, highest] = std::minmax_element(log_.force_N.begin(), log_.force_N.end());
    require_force(where_column(quantity), *lowest, *highest);
  }

  void require_finite(const std::vector<double>& values, Quantity quantity) const {
    const auto bad = std::find_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); });
    if (bad == values.end()) return;
    const auto row = static_cast<std::size_t>(bad - values.begin());
    throw InputError(table_.where_row(row) + ": column " + table_.columns[plan_[quantity]->column].name +
                     ": the value is beyond the range of a number; correct it or remove the row");
  }

  RawTable table_;
  HeaderValues header_;
  ColumnPlan plan_;
  Rows rows_;
  const Log* head_;
  Log log_;
  std::vector<double> time_s_;
  ResamplingGrid grid_;
};

/// No sensor reads more, in whatever unit; the squares of larger values, summed, exceed a number.
constexpr double kLargestValue = 1e40;

void require_possible(const std::string& where, const char* what, double lowest, double highest,
                      const std::string& unit) {
  const double largest = std::abs(lowest) > std::abs(highest) ? lowest : highest;
  if (std::abs(largest) <= kLargestValue) return;
  throw InputError(
      fmt::format("{}: the {} reaches {:.3g} {}, which no sensor reads; correct the unit or remove the row",
                  where, what, largest, unit));
}

}  // namespace

std::string estimated_resolution_note(double resolution_m) {
  return fmt::format("{} is not in the header; the positions move in steps of {:.6g} {}",
                     axis_key("encoder_resolution_m"), resolution_m, axis_unit("m"));
}

void require_motion(const std::string& where, double lowest_m, double highest_m,
                    const std::optional<double>& resolution_m) {
  if (lowest_m == highest_m) {
    throw InputError(fmt::format("{}: the position never moves (it is always {:.6g} {}); record a motion",
                                 where, lowest_m + 0.0, axis_unit("m")));
  }
  const double travel_m = highest_m - lowest_m;
  require_possible(where, "position", lowest_m, highest_m, axis_unit("m"));
  if (resolution_m && travel_m < kMoreThanOneStep * *resolution_m) {
    throw InputError(fmt::format(
        "{}: the position never moves by more than one encoder step ({:.6g} {}); record a motion or correct "
        "{}",
        where, *resolution_m, axis_unit("m"), axis_key("encoder_resolution_m")));
  }
}

void require_force(const std::string& where, double lowest_N, double highest_N) {
  if (lowest_N == highest_N) {
    throw InputError(
        fmt::format("{}: the {} never changes (it is always {:.6g} {}); check the sensor or the export",
                    where, force_word(), lowest_N, axis_unit("N")));
  }
  require_possible(where, force_word(), lowest_N, highest_N, axis_unit("N"));
}

Log assemble_log(RawTable table) {
  return Assembler(std::move(table)).assemble();
}

Log assemble_chunk(RawTable table, const Log* head) {
  using Rows = Assembler::Rows;
  const Rows rows = head == nullptr ? Rows::unknown_sampling : Rows::known_sampling;
  return Assembler(std::move(table), rows, head).assemble();
}

}  // namespace slipstack::workbench
