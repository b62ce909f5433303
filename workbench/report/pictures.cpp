// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "workbench/base/axis_units.h"
#include "workbench/base/quantity.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/report/json_values.h"
#include "workbench/report/measurement_notes.h"
#include "workbench/signal/spectrum.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// Bins of a profile, and the rows that a bin of a short log has on average: with fewer, most bins would have
/// none to draw.
constexpr int kMostBins = 80;
constexpr int kFewestBins = 8;
constexpr Eigen::Index kRowsPerBin = 8;
constexpr double kLargestLoop_m = 4e-4;
constexpr std::size_t kMostLoops = 4;

json array_of(const Eigen::VectorXd& values) {
  json array = json::array();
  for (const double value : values) array.push_back(number_json(value));
  return array;
}

/// Times of the rows as the log counts them.
Eigen::VectorXd recorded_times(const Measurement& measurement) {
  return row_times(measurement).array() + measurement.log().start_time_s;
}

/// Intervals in which the axis reverses within a few tenths of a millimetre: pre-sliding loops.
std::vector<RowRange> find_loops(const Measurement& measurement, const Eigen::VectorXd& position_m) {
  const auto window = static_cast<Eigen::Index>(std::max(8.0, 0.5 * measurement.row_rate_Hz()));
  std::vector<RowRange> loops;
  for (Eigen::Index first = 0; first + window <= position_m.size(); first += window) {
    const auto part = position_m.segment(first, window);
    const double range = part.maxCoeff() - part.minCoeff();
    if (range > axis_length(kLargestLoop_m) || range < 4.0 * measurement.encoder_resolution_m()) continue;
    const bool joins =
        !loops.empty() && loops.back().first + loops.back().count == first &&
        std::abs(position_m(first) - position_m(loops.back().first)) < axis_length(kLargestLoop_m);
    if (joins) {
      loops.back().count += window;
    } else {
      loops.push_back({first, window});
    }
  }
  std::erase_if(loops, [window](const RowRange& loop) { return loop.count < 2 * window; });
  std::sort(loops.begin(), loops.end(), [](const auto& a, const auto& b) { return a.count > b.count; });
  if (loops.size() > kMostLoops) loops.resize(kMostLoops);
  std::sort(loops.begin(), loops.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return loops;
}

/// Rows hold all that the filter passes, so that a loop is drawn as smooth as the samples are: between two
/// rows stand up to kFiner points, the position as it was sampled there and the forces interpolated by a sinc
/// of kReach rows to either side under a Kaiser window. Rows that are scarcer than kLeastRate of the
/// bandwidth are drawn as they are.
constexpr std::size_t kFiner = 8;
constexpr Eigen::Index kReach = 8;
constexpr double kKaiser = 6.0;
constexpr double kLeastRate = 2.0;
/// A point is left out where all curves stay within this share of the chart of the chord without it, a third
/// of a pixel of the page, over at most kLongestChord points.
constexpr double kLoopTolerance = 1e-3;
constexpr std::size_t kLongestChord = 24;

/// Weights of the rows from kReach - 1 before a row to kReach behind it, for a value this share of the way to
/// the next row; their sum is one.
Eigen::VectorXd weights_between_rows(double share) {
  Eigen::VectorXd weights(2 * kReach);
  for (Eigen::Index k = 0; k < weights.size(); ++k) {
    const double distance = share - static_cast<double>(k + 1 - kReach);
    const double phase = std::numbers::pi * distance;
    const double edge = std::max(0.0, 1.0 - (distance / kReach) * (distance / kReach));
    weights(k) =
        std::cyl_bessel_i(0.0, kKaiser * std::sqrt(edge)) * (phase == 0.0 ? 1.0 : std::sin(phase) / phase);
  }
  return weights / weights.sum();
}

/// Curves of force over one displacement, and the row that is nearest to each point.
struct LoopCurves {
  std::vector<double> displacement_m;
  std::vector<std::vector<double>> forces_N;
  std::vector<Eigen::Index> rows;
};

LoopCurves curves_of(const Measurement& measurement, const RowRange& loop, double centre_m,
                     const std::vector<const Eigen::VectorXd*>& forces_N) {
  const std::size_t stride = measurement.row_stride();
  const bool enough = measurement.row_rate_Hz() >= kLeastRate * measurement.bandwidth_Hz();
  const std::size_t steps = enough ? std::min(kFiner, stride) : 1;
  std::vector<Eigen::VectorXd> weights;
  for (std::size_t step = 0; step < steps; ++step) {
    const std::size_t offset = step * stride / steps;
    weights.push_back(weights_between_rows(static_cast<double>(offset) / static_cast<double>(stride)));
  }
  LoopCurves curves;
  curves.forces_N.resize(forces_N.size());
  for (Eigen::Index row = loop.first; row < loop.first + loop.count; ++row) {
    const std::size_t sample = measurement.row_samples()[static_cast<std::size_t>(row)];
    const LogPart& part = measurement.parts()[measurement.part_at(sample)];
    const auto first = static_cast<Eigen::Index>(part.first_row);
    const Eigen::Index last = first + static_cast<Eigen::Index>(part.row_count) - 1;
    const bool more = row < last && row + 1 < loop.first + loop.count;
    for (std::size_t step = 0; step < (more ? steps : 1); ++step) {
      curves.displacement_m.push_back(measurement.position_m()[sample + step * stride / steps] - centre_m);
      curves.rows.push_back(2 * step < steps ? row : row + 1);
      for (std::size_t f = 0; f < forces_N.size(); ++f) {
        double force_N = step == 0 ? (*forces_N[f])(row) : 0.0;
        for (Eigen::Index k = 0; step > 0 && k < 2 * kReach; ++k)
          force_N += weights[step](k) * (*forces_N[f])(std::clamp(row + k + 1 - kReach, first, last));
        curves.forces_N[f].push_back(force_N);
      }
    }
  }
  return curves;
}

double range_of(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return std::max(*high - *low, 1e-300);
}

/// The points without which the curves would look different.
std::vector<std::size_t> points_of_shape(const LoopCurves& curves) {
  const std::vector<double>& x = curves.displacement_m;
  const double x_range = range_of(x);
  const double y_range = range_of(curves.forces_N.front());
  const auto is_on_chord = [&](std::size_t from, std::size_t to) {
    for (const std::vector<double>& y : curves.forces_N) {
      const double dx = (x[to] - x[from]) / x_range;
      const double dy = (y[to] - y[from]) / y_range;
      const double length2 = std::max(dx * dx + dy * dy, 1e-300);
      for (std::size_t i = from + 1; i < to; ++i) {
        const double px = (x[i] - x[from]) / x_range;
        const double py = (y[i] - y[from]) / y_range;
        const double along = std::clamp((px * dx + py * dy) / length2, 0.0, 1.0);
        if (std::hypot(px - along * dx, py - along * dy) > kLoopTolerance) return false;
      }
    }
    return true;
  };
  std::vector<std::size_t> kept{0};
  while (kept.back() + 1 < x.size()) {
    const std::size_t from = kept.back();
    std::size_t to = from + 1;
    while (to + 1 < x.size() && to + 1 - from <= kLongestChord && is_on_chord(from, to + 1)) ++to;
    kept.push_back(to);
  }
  return kept;
}

template <class T>
json picked(const std::vector<T>& values, const std::vector<std::size_t>& points) {
  json array = json::array();
  for (const std::size_t point : points) {
    if constexpr (std::is_floating_point_v<T>) {
      array.push_back(number_json(values[point]));
    } else {
      array.push_back(values[point]);
    }
  }
  return array;
}

json loops_json(const Measurement& measurement, const ForceRows& before, const ForceRows* after) {
  const Eigen::VectorXd position_m = at_rows(measurement, measurement.position_m());
  std::vector<const Eigen::VectorXd*> forces_N{&before.measured_N, &before.model_N};
  if (after != nullptr) forces_N.push_back(&after->model_N);
  json list = json::array();
  for (const RowRange& loop : find_loops(measurement, position_m)) {
    const Eigen::VectorXd part = position_m.segment(loop.first, loop.count);
    const double centre_m = 0.5 * (part.maxCoeff() + part.minCoeff());
    const LoopCurves curves = curves_of(measurement, loop, centre_m, forces_N);
    const std::vector<std::size_t> points = points_of_shape(curves);
    json entry{{"title", fmt::format("Pre-sliding loops at {}", quantity(centre_m, "m"))},
               {"row", picked(curves.rows, points)},
               {"displacement_m", picked(curves.displacement_m, points)},
               {"measured_N", picked(curves.forces_N[0], points)},
               {"model_N", picked(curves.forces_N[1], points)}};
    if (after != nullptr) entry["after_N"] = picked(curves.forces_N[2], points);
    list.push_back(std::move(entry));
  }
  return list;
}

/// Mean of `values` in bins of `coordinate`, null where a bin is empty.
class Bins {
 public:
  explicit Bins(const Eigen::VectorXd& coordinate)
      : coordinate_(coordinate),
        bin_count_(std::clamp(static_cast<int>(coordinate.size() / kRowsPerBin), kFewestBins, kMostBins)) {
    low_ = coordinate.minCoeff();
    width_ = std::max(coordinate.maxCoeff() - low_, 1e-300) / bin_count_;
  }

  json centres() const {
    json list = json::array();
    for (int bin = 0; bin < bin_count_; ++bin) list.push_back(low_ + (bin + 0.5) * width_);
    return list;
  }

  template <class Accept>
  std::pair<json, json> mean_and_spread(const Eigen::VectorXd& values, Accept&& accept) const {
    const auto bin_count = static_cast<std::size_t>(bin_count_);
    std::vector<double> sum(bin_count, 0.0), squares(bin_count, 0.0), count(bin_count, 0.0);
    for (Eigen::Index row = 0; row < values.size(); ++row) {
      if (!accept(row)) continue;
      const auto bin = static_cast<std::size_t>(
          std::clamp(static_cast<int>((coordinate_(row) - low_) / width_), 0, bin_count_ - 1));
      sum[bin] += values(row);
      squares[bin] += values(row) * values(row);
      count[bin] += 1.0;
    }
    json mean = json::array();
    json spread = json::array();
    for (std::size_t bin = 0; bin < bin_count; ++bin) {
      if (count[bin] < 3.0) {
        mean.push_back(nullptr);
        spread.push_back(nullptr);
        continue;
      }
      const double m = sum[bin] / count[bin];
      mean.push_back(m);
      spread.push_back(std::sqrt(std::max(0.0, squares[bin] / count[bin] - m * m)));
    }
    return {mean, spread};
  }

 private:
  const Eigen::VectorXd& coordinate_;
  int bin_count_;
  double low_ = 0.0;
  double width_ = 1.0;
};

json profile_json(const char* name, const char* unit, const Eigen::VectorXd& coordinate,
                  const Eigen::VectorXd& velocity_mps, const ForceRows& before, const ForceRows* after) {
  const Bins bins(coordinate);
  const auto all = [](Eigen::Index) { return true; };
  const Eigen::VectorXd residual = before.residual_N();
  const auto [mean, spread] = bins.mean_and_spread(residual, all);
  json profile{{"coordinate", name}, {"title", fmt::format("Residual against {}", name)},
               {"unit", unit},       {"x", bins.centres()},
               {"mean_N", mean},     {"spread_N", spread}};
  if (after != nullptr) profile["after_mean_N"] = bins.mean_and_spread(after->residual_N(), all).first;
  if (std::string_view(name) == "position") {
    const double slow = 0.01 * velocity_mps.cwiseAbs().maxCoeff();
    profile["forward_mean_N"] =
        bins.mean_and_spread(residual, [&](Eigen::Index row) { return velocity_mps(row) > slow; }).first;
    profile["backward_mean_N"] =
        bins.mean_and_spread(residual, [&](Eigen::Index row) { return velocity_mps(row) < -slow; }).first;
  }
  return profile;
}

constexpr std::array<std::pair<const char*, const char*>, 4> kProfiles{
    {{"position", "m"}, {"velocity", "m/s"}, {"acceleration", "m/s2"}, {"time", "s"}}};

/// The coordinates of the profiles, at the rows, in the order of kProfiles.
std::array<Eigen::VectorXd, 4> profile_coordinates(const Measurement& measurement) {
  return {at_rows(measurement, measurement.position_m()), at_rows(measurement, measurement.velocity_mps()),
          at_rows(measurement, measurement.acceleration_mps2()), recorded_times(measurement)};
}

json amplitude_density(const Eigen::VectorXd& residual, double rate_Hz, double bandwidth_Hz,
                       json* frequency) {
  const std::span<const double> rows(residual.data(), static_cast<std::size_t>(residual.size()));
  std::size_t segment = 1024;
  while (segment > 64 && segment * 4 > rows.size()) segment /= 2;
  const Spectrum spectrum = power_spectrum(rows, rate_Hz, segment);
  json density = json::array();
  for (std::size_t k = 1; k < spectrum.density.size() && spectrum.frequency_Hz[k] <= bandwidth_Hz; ++k) {
    density.push_back(std::sqrt(spectrum.density[k]));
    if (frequency != nullptr) frequency->push_back(spectrum.frequency_Hz[k]);
  }
  return density;
}

json spectrum_json(const Measurement& measurement, const ForceRows& before, const ForceRows* after) {
  const double rate_Hz = measurement.row_rate_Hz();
  json frequency = json::array();
  json spectrum{
      {"residual_N", amplitude_density(before.residual_N(), rate_Hz, measurement.bandwidth_Hz(), &frequency)},
      {"floor_N", measurement.force_noise_N() * std::sqrt(2.0 / measurement.sample_rate_Hz())}};
  spectrum["frequency_Hz"] = frequency;
  if (after != nullptr) {
    spectrum["after_N"] =
        amplitude_density(after->residual_N(), rate_Hz, measurement.bandwidth_Hz(), nullptr);
  }
  return spectrum;
}

}  // namespace

ForceRows rows_of(const FittedModel& fitted) {
  return {fitted.linearisation->measured_N(), fitted.linearisation->force_N()};
}

void add_pictures(json& data, const Measurement& measurement, const ForceRows& before,
                  const ForceRows* after) {
  const Eigen::VectorXd time_s = recorded_times(measurement);
  const Eigen::VectorXd position_m = at_rows(measurement, measurement.position_m());
  const Eigen::VectorXd velocity_mps = at_rows(measurement, measurement.velocity_mps());
  const Eigen::VectorXd acceleration_mps2 = at_rows(measurement, measurement.acceleration_mps2());
  data["samples"] = measurement.whole_sample_count();
  data["duration_s"] = measurement.duration_s();
  data["sample_rate_Hz"] = measurement.sample_rate_Hz();
  json header = json::object();
  const Log& log = measurement.log();
  if (log.mass_kg) header["mass_kg"] = *log.mass_kg;
  if (log.magnet_pitch_m) header["magnet_pitch_m"] = *log.magnet_pitch_m;
  if (log.encoder_resolution_m) header["encoder_resolution_m"] = *log.encoder_resolution_m;
  data["header"] = header;
  data["series"] = {{"time_s", array_of(time_s)},
                    {"position_m", array_of(position_m)},
                    {"velocity_mps", array_of(velocity_mps)},
                    {"acceleration_mps2", array_of(acceleration_mps2)},
                    {"measured_N", array_of(before.measured_N)},
                    {"model_N", array_of(before.model_N)},
                    {"residual_N", array_of(before.residual_N())}};
  if (after != nullptr) data["series"]["after_N"] = array_of(after->residual_N());
  add_residual_charts(data, measurement, before, after);
  data["notes"] = method_notes(measurement);
}

void add_residual_charts(json& data, const Measurement& measurement, const ForceRows& before,
                         const ForceRows* after) {
  const Eigen::VectorXd velocity_mps = at_rows(measurement, measurement.velocity_mps());
  data["loops"] = loops_json(measurement, before, after);
  data["profiles"] = json::array();
  const std::array<Eigen::VectorXd, 4> coordinates = profile_coordinates(measurement);
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    data["profiles"].push_back(
        profile_json(kProfiles[i].first, kProfiles[i].second, coordinates[i], velocity_mps, before, after));
  }
  data["spectrum"] = spectrum_json(measurement, before, after);
}

json expected_means(const Measurement& measurement, const Eigen::VectorXd& expected_N) {
  const auto all = [](Eigen::Index) { return true; };
  json means = json::array();
  for (const Eigen::VectorXd& coordinate : profile_coordinates(measurement)) {
    means.push_back(Bins(coordinate).mean_and_spread(expected_N, all).first);
  }
  return means;
}

void add_expected(json& data, const Measurement& measurement, const std::string& name,
                  const Eigen::VectorXd& expected_N) {
  json means = expected_means(measurement, expected_N);
  for (std::size_t i = 0; i < means.size(); ++i) {
    data["profiles"][i]["expected_mean_N"] = std::move(means[i]);
    data["profiles"][i]["expected_name"] = name;
  }
}

}  // namespace slipstack::workbench
