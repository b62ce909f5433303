// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/report_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/signal/spectrum.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

constexpr int kBins = 80;
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

/// Stretches in which the axis moves to and fro within a few tenths of a millimetre: pre-sliding loops.
std::vector<RowRange> find_loops(const Measurement& measurement, const Eigen::VectorXd& position_m) {
  const double row_rate_Hz = measurement.sample_rate_Hz() / static_cast<double>(measurement.row_stride());
  const auto window = static_cast<Eigen::Index>(std::max(8.0, 0.5 * row_rate_Hz));
  std::vector<RowRange> loops;
  for (Eigen::Index first = 0; first + window <= position_m.size(); first += window) {
    const auto part = position_m.segment(first, window);
    const double range = part.maxCoeff() - part.minCoeff();
    if (range > kLargestLoop_m || range < 4.0 * measurement.encoder_resolution_m()) continue;
    const bool joins = !loops.empty() && loops.back().first + loops.back().count == first &&
                       std::abs(position_m(first) - position_m(loops.back().first)) < kLargestLoop_m;
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

json loops_json(const Measurement& measurement, const ForceRows& before, const ForceRows* after) {
  const Eigen::VectorXd position_m = at_rows(measurement, measurement.position_m());
  json list = json::array();
  for (const RowRange& loop : find_loops(measurement, position_m)) {
    const Eigen::VectorXd part = position_m.segment(loop.first, loop.count);
    const double centre_m = 0.5 * (part.maxCoeff() + part.minCoeff());
    json entry{{"title", fmt::format("Pre-sliding loops at {}", quantity(centre_m, "m"))},
               {"displacement_m", array_of((part.array() - centre_m).matrix())},
               {"measured_N", array_of(before.measured_N.segment(loop.first, loop.count))},
               {"model_N", array_of(before.model_N.segment(loop.first, loop.count))}};
    if (after != nullptr) entry["after_N"] = array_of(after->model_N.segment(loop.first, loop.count));
    list.push_back(std::move(entry));
  }
  return list;
}

/// Mean of `values` in bins of `coordinate`, null where a bin is empty.
class Bins {
 public:
  explicit Bins(const Eigen::VectorXd& coordinate) : coordinate_(coordinate) {
    low_ = coordinate.minCoeff();
    width_ = std::max(coordinate.maxCoeff() - low_, 1e-300) / kBins;
  }

  json centres() const {
    json list = json::array();
    for (int bin = 0; bin < kBins; ++bin) list.push_back(low_ + (bin + 0.5) * width_);
    return list;
  }

  template <class Accept>
  std::pair<json, json> mean_and_spread(const Eigen::VectorXd& values, Accept&& accept) const {
    std::vector<double> sum(kBins, 0.0), squares(kBins, 0.0), count(kBins, 0.0);
    for (Eigen::Index row = 0; row < values.size(); ++row) {
      if (!accept(row)) continue;
      const auto bin = static_cast<std::size_t>(
          std::clamp(static_cast<int>((coordinate_(row) - low_) / width_), 0, kBins - 1));
      sum[bin] += values(row);
      squares[bin] += values(row) * values(row);
      count[bin] += 1.0;
    }
    json mean = json::array();
    json spread = json::array();
    for (std::size_t bin = 0; bin < kBins; ++bin) {
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
  const double rate_Hz = measurement.sample_rate_Hz() / static_cast<double>(measurement.row_stride());
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

json notes_of(const Measurement& measurement) {
  json notes = json::array();
  notes.push_back(fmt::format(
      "Force and every regressor passed the same zero-phase low-pass of {:.0f} Hz and were compared at {} "
      "instants, {:.1f} ms apart.",
      measurement.bandwidth_Hz(), measurement.row_count(),
      1e3 * static_cast<double>(measurement.row_stride()) * measurement.tick_s()));
  if (measurement.burn_in_s() > 0.0) {
    notes.push_back(fmt::format("The first {} are left out: the state of the hysteresis is not known there.",
                                quantity(measurement.burn_in_s(), "s")));
  }
  notes.push_back(fmt::format(
      "Force noise before the filter: {} (from differences of sixth order). Held-out errors: {} contiguous "
      "blocks in {} folds, each judged by a fit to the others.",
      quantity(measurement.force_noise_N(), "N"), measurement.block_count(), measurement.fold_count()));
  if (measurement.log_count() > 1) {
    std::string logs;
    for (std::size_t log = 0; log < measurement.log_count(); ++log) {
      const LogPart& part = measurement.parts()[measurement.parts_of_log(log).first];
      logs += (logs.empty() ? "" : ", ") + printable(part.path);
    }
    notes.push_back(fmt::format("Logs, one after another: {}.", logs));
  }
  if (measurement.is_excerpt()) {
    notes.push_back(fmt::format(
        "Effects were searched, and the pictures drawn, in {} intervals, {} of {} samples; errors are those "
        "of all.",
        measurement.parts().size(), measurement.sample_count(), measurement.whole_sample_count()));
  }
  for (const std::string& note : measurement.log().notes) notes.push_back(note);
  return notes;
}

json parameter_json(const char* name, std::size_t index, bool numbered, double value, double error,
                    const char* unit, const std::string& note) {
  return {{"name", numbered ? fmt::format("{} {}", name, index + 1) : std::string(name)},
          {"value", number_json(value)},
          {"standard_error", error > 0.0 ? json(error) : json(nullptr)},
          {"unit", unit},
          {"note", note}};
}

std::string gain_note(const Term& term, std::size_t gain) {
  if (term.lower[gain] == term.upper[gain]) return "given";
  if (term.gains[gain] == term.lower[gain] || term.gains[gain] == term.upper[gain]) return "at its bound";
  return "";
}

json term_json(const Term& term) {
  json list = json::array();
  const bool elements = term.id() == "presliding_hysteresis";
  if (!elements) {
    for (std::size_t i = 0; i < term.shapes.size(); ++i) {
      const double error = term.shape_standard_error(i);
      list.push_back(parameter_json(term.effect->shapes[i].name, i, false, term.shapes[i], error,
                                    term.effect->shapes[i].unit, "shape"));
    }
  }
  for (std::size_t g = 0; g < term.gains.size(); ++g) {
    const std::size_t own = g % term.gains_per_set();
    const GainGroup& group = term.effect->group_of_gain(static_cast<int>(own));
    if (elements && term.gains[g] == 0.0) continue;
    const double error = term.gain_standard_error(g);
    const std::string note =
        elements ? fmt::format("slip distance {}", quantity(term.shapes[own], "m")) : gain_note(term, g);
    list.push_back(parameter_json(group.name, own, group.count > 1, term.gains[g], error, group.unit, note));
    if (term.gain_sets() > 1) list.back()["log"] = g / term.gains_per_set() + 1;
  }
  return {{"effect", term.id()},
          {"title", term.effect->text.title},
          {"formula", term.effect->text.formula},
          {"parameters", list}};
}

}  // namespace

json number_json(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
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
  data["loops"] = loops_json(measurement, before, after);
  data["profiles"] = {profile_json("position", "m", position_m, velocity_mps, before, after),
                      profile_json("velocity", "m/s", velocity_mps, velocity_mps, before, after),
                      profile_json("acceleration", "m/s2", acceleration_mps2, velocity_mps, before, after),
                      profile_json("time", "s", time_s, velocity_mps, before, after)};
  data["spectrum"] = spectrum_json(measurement, before, after);
  data["notes"] = notes_of(measurement);
}

void add_expected(json& data, const Measurement& measurement, const std::string& name,
                  const Eigen::VectorXd& expected_N) {
  const auto all = [](Eigen::Index) { return true; };
  const std::array<Eigen::VectorXd, 4> coordinates{
      at_rows(measurement, measurement.position_m()), at_rows(measurement, measurement.velocity_mps()),
      at_rows(measurement, measurement.acceleration_mps2()), recorded_times(measurement)};
  for (std::size_t i = 0; i < coordinates.size(); ++i) {  // in the order of add_pictures()
    data["profiles"][i]["expected_mean_N"] = Bins(coordinates[i]).mean_and_spread(expected_N, all).first;
    data["profiles"][i]["expected_name"] = name;
  }
}

json parameters_json(const Terms& terms) {
  json list = json::array();
  for (const Term& term : terms) list.push_back(term_json(term));
  return list;
}

json candidates_json(const Diagnosis& diagnosis) {
  json list = json::array();
  for (const Candidate& candidate : diagnosis.candidates) {
    const EffectText& text = candidate.term.effect->text;
    json entry{{"effect", text.id},
               {"title", text.title},
               {"holdout_rmse_N", number_json(candidate.holdout_rmse_N)},
               {"error_reduction", number_json(candidate.error_reduction)},
               {"error_reduction_se", number_json(candidate.error_reduction_se)},
               {"confounded_with", candidate.confounded_with},
               {"evidence", candidate.evidence},
               {"cause", text.cause},
               {"confirm_with", text.confirm}};
    if (candidate.term.effect->is_user_defined()) entry["definition"] = candidate.term.effect->definition;
    list.push_back(std::move(entry));
  }
  return list;
}

json steps_json(const Diagnosis& diagnosis) {
  json list = json::array();
  for (const Step& step : diagnosis.steps) {
    list.push_back({{"added", step.added}, {"holdout_rmse_N", number_json(step.holdout_rmse_N)}});
    if (!step.evidence.empty()) list.back()["evidence"] = step.evidence;
  }
  return list;
}

}  // namespace slipstack::workbench
