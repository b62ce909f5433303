// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/sweep_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "workbench/console/output.h"
#include "workbench/papers/stop.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "slipstack sweep 1";
constexpr std::size_t kNumbersPerPoint = 7;

json point_json(const sim::SinePoint& point) {
  return {point.frequency_Hz, point.amplitude_m,         point.phase_rad,       point.mean_m,
          point.periods,      point.settled ? 1.0 : 0.0, point.jump ? 1.0 : 0.0};
}

sim::SinePoint point_of(const json& value) {
  const auto numbers = value.get<std::vector<double>>();
  if (numbers.size() != kNumbersPerPoint) throw std::runtime_error("a point has other numbers");
  return {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5] != 0.0, numbers[6] != 0.0};
}

json chain_json(const sim::SweepChain& chain) {
  json sweeps = json::array();
  for (const sim::Sweep& sweep : chain.sweeps) {
    json points = json::array();
    for (const sim::SinePoint& point : sweep.points) points.push_back(point_json(point));
    sweeps.push_back({{"up", sweep.up}, {"repeat", sweep.repeat}, {"points", std::move(points)}});
  }
  return {
      {"force_N", chain.force_N}, {"complete", chain.complete}, {"state", chain.state}, {"sweeps", sweeps}};
}

sim::SweepChain chain_of(const json& value) {
  sim::SweepChain chain;
  chain.force_N = value.at("force_N").get<double>();
  chain.complete = value.at("complete").get<bool>();
  chain.state = value.at("state").get<std::vector<double>>();
  for (const json& entry : value.at("sweeps")) {
    sim::Sweep sweep{chain.force_N, entry.at("up").get<bool>(), entry.at("repeat").get<std::size_t>(), {}};
    for (const json& point : entry.at("points")) sweep.points.push_back(point_of(point));
    chain.sweeps.push_back(std::move(sweep));
  }
  return chain;
}

std::size_t count_points(const std::vector<sim::SweepChain>& chains) {
  std::size_t points = 0;
  for (const sim::SweepChain& chain : chains) {
    for (const sim::Sweep& sweep : chain.sweeps) points += sweep.points.size();
  }
  return points;
}

}  // namespace

std::vector<sim::SweepChain> SweepFile::read() const {
  std::error_code error;
  if (path_.empty() || !std::filesystem::exists(path_, error)) return {};
  std::ifstream file(path_);
  const json content = json::parse(file, nullptr, false);
  if (!content.is_object() || content.value("format", "") != kFormat) {
    throw UsageError(fmt::format("{}: not a sweep that slipstack kept; name another file", path_));
  }
  if (content.value("request", "") != request_) {
    throw UsageError(fmt::format(
        "{}: belongs to a sweep with another set-up or other options; give those, or another file", path_));
  }
  try {
    std::vector<sim::SweepChain> chains;
    for (const json& chain : content.at("chains")) chains.push_back(chain_of(chain));
    return chains;
  } catch (const std::exception&) {
    throw UsageError(fmt::format("{}: damaged; remove it and start again", path_));
  }
}

void SweepFile::write(const std::vector<sim::SweepChain>& chains) const {
  if (path_.empty()) return;
  json kept = json::array();
  for (const sim::SweepChain& chain : chains) kept.push_back(chain_json(chain));
  const std::string text =
      json{{"format", kFormat}, {"request", request_}, {"chains", std::move(kept)}}.dump() + "\n";
  const std::string part = path_ + ".part";
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(part, path_, error);
  if (!file || error) {
    std::filesystem::remove(part, error);
    throw UsageError(
        fmt::format("{}: the sweep could not be kept there; name a place that can be written", path_));
  }
}

void SweepFile::remove() const {
  std::error_code error;
  if (!path_.empty()) std::filesystem::remove(path_, error);
}

std::string SweepFile::stopped_text(const std::vector<sim::SweepChain>& chains, std::size_t points) const {
  const std::string done = fmt::format("stopped after {} of {} points", count_points(chains), points);
  if (path_.empty()) return done + "; nothing was kept: with --resume FILE it would go on from here";
  return fmt::format("{}; kept in {}: the same command goes on from there", done, path_);
}

std::string request_text(const sim::ExperimentSetup& setup, const sim::SteppedSineRequest& request) {
  return fmt::format(
      "forces {} frequencies {} up {} down {} repeats {} tolerance {} settled {} most {} sensors {} seed "
      "{}\n{}",
      fmt::join(request.forces_N, ","), fmt::join(request.frequencies_Hz, ","), request.up, request.down,
      request.repeats, request.tolerance, request.settled, request.most_periods, request.sensors,
      request.seed, setup.text);
}

std::vector<sim::SweepChain> run_kept_sweep(const std::string& path, const sim::ExperimentSetup& setup,
                                            const sim::SteppedSineRequest& request, const RunControl& control,
                                            bool one_of_many) {
  const SweepFile file(path, request_text(setup, request));
  std::vector<sim::SweepChain> chains = file.read();
  RunControl stoppable = control;
  const StopSignal signal;
  stoppable.stop = &StopSignal::flag();
  run_sweeps(setup, request, chains, stoppable);
  const bool complete =
      std::all_of(chains.begin(), chains.end(), [](const auto& chain) { return chain.complete; });
  if (complete) {
    if (one_of_many) {
      file.write(chains);
    } else {
      file.remove();
    }
    return chains;
  }
  file.write(chains);
  throw Stopped(file.stopped_text(chains, request.forces_N.size() * sim::points_per_level(request)));
}

}  // namespace slipstack::workbench
