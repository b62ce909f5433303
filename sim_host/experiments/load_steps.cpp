// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/load_steps.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim_host/experiments/quasi_static.h"
#include "sim_host/rng.h"

namespace slipstack::sim {
namespace {

constexpr std::size_t kLeastSteps = 5;
/// Loads within this share of full scale are the same: machines do not return to the last digit.
constexpr double kSameLoad = 1e-3;

[[noreturn]] void refuse(std::size_t step, const std::string& what) {
  throw std::invalid_argument("step " + std::to_string(step + 1) + ": " + what);
}

}  // namespace

StepRecord step_record(std::vector<LoadStep> steps) {
  StepRecord record;
  record.steps = std::move(steps);
  const std::vector<LoadStep>& all = record.steps;
  if (all.empty()) throw std::invalid_argument("no load steps; write one row for each settled reading");
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool finite = std::isfinite(all[i].time_s + all[i].load_N + all[i].signal_mV_per_V);
    if (!finite) refuse(i, "a number is not finite; remove the row");
    if (i > 0 && !(all[i].time_s > all[i - 1].time_s)) refuse(i, "time does not rise; sort the rows by time");
    if (all[i].load_N < 0.0) refuse(i, "the load is negative; calibrate in one direction of load");
    record.full_scale_N = std::max(record.full_scale_N, all[i].load_N);
  }
  const double zero_N = kSameLoad * record.full_scale_N;
  const auto is_zero = [&](std::size_t i) { return all[i].load_N <= zero_N; };
  const auto is_full = [&](std::size_t i) { return all[i].load_N >= record.full_scale_N - zero_N; };
  if (!is_zero(0)) refuse(0, "the record must begin at zero load");
  if (!is_zero(all.size() - 1)) refuse(all.size() - 1, "the cycle must end at zero load");
  // Preloads go straight up: the cycle begins at the last zero before the first step in between.
  std::size_t between = 0;
  while (between < all.size() && (is_zero(between) || is_full(between))) ++between;
  if (between == all.size()) throw std::invalid_argument("there are no steps between zero and full scale");
  for (std::size_t i = 0; i < between; ++i) {
    if (is_zero(i)) record.cycle = i;
    if (is_full(i) && (i == 0 || !is_full(i - 1))) ++record.preloads;
  }
  record.top = record.cycle;
  while (record.top < all.size() && !is_full(record.top)) ++record.top;
  if (record.top == all.size()) throw std::invalid_argument("the cycle does not reach full scale");
  std::size_t rising = 0;
  double highest_N = 0.0;
  for (std::size_t i = record.cycle; i <= record.top; ++i) {
    if (all[i].load_N <= highest_N + zero_N) continue;
    highest_N = all[i].load_N;
    ++rising;
  }
  if (rising < kLeastSteps) {
    refuse(record.top, "fewer than five steps up to full scale; ISO 376 asks for eight, evenly spaced");
  }
  return record;
}

Reversibility reversibility(const StepRecord& record) {
  const std::vector<LoadStep>& steps = record.steps;
  const LoadStep& start = steps[record.cycle];
  const LoadStep& top = steps[record.top];
  const LoadStep& end = steps.back();
  Reversibility found;
  found.sensitivity = (top.signal_mV_per_V - start.signal_mV_per_V) / (top.load_N - start.load_N);
  if (!(found.sensitivity > 0.0))
    throw std::invalid_argument("the signal does not grow with the load; check its sign");
  const auto off_line = [&](const LoadStep& step) {
    return step.signal_mV_per_V - start.signal_mV_per_V - found.sensitivity * (step.load_N - start.load_N);
  };
  found.zero_drift = off_line(end);
  const double grid_N = kSameLoad * record.full_scale_N;
  std::map<long, std::pair<double, double>> up;  // level → load, deviation
  std::map<long, double> down;
  double highest_N = 0.0;
  double lowest_N = 0.0;
  for (std::size_t i = record.cycle; i < steps.size(); ++i) {
    const double share = (steps[i].time_s - start.time_s) / (end.time_s - start.time_s);
    const double deviation = off_line(steps[i]) - found.zero_drift * share;
    found.deviation.push_back(deviation);
    // Inside a loop the load comes to places where it has been: only new ones are on the main branch.
    const double load_N = steps[i].load_N;
    const long level = std::lround(load_N / (2.0 * grid_N));
    if (i <= record.top && (up.empty() || load_N > highest_N + grid_N)) {
      up.emplace(level, std::pair(load_N, deviation));
      highest_N = load_N;
    }
    if (i >= record.top && (down.empty() || load_N < lowest_N - grid_N)) {
      down.emplace(level, deviation);
      lowest_N = load_N;
    }
  }
  for (const auto& [level, rising] : up) {
    const auto falling = down.find(level);
    if (falling == down.end()) continue;
    found.load_N.push_back(rising.first);
    found.rise.push_back(rising.second);
    found.linearity.push_back(0.5 * (rising.second + falling->second));
    found.hysteresis.push_back(0.5 * (rising.second - falling->second));
    found.largest_hysteresis = std::max(found.largest_hysteresis, std::fabs(found.hysteresis.back()));
  }
  if (found.load_N.size() < kLeastSteps) {
    throw std::invalid_argument("fewer than five loads were read both ways; use the same steps up and down");
  }
  return found;
}

namespace {

/// Takes a load after a wait and reads the transducer.
using Reader = std::function<LoadStep(double load_N, double wait_s)>;

/// Preloads, then up and down with a loop between 22 and 8 % of full scale on either way.
std::vector<LoadStep> cycle_with_loops(const TransducerSetup& setup, const Reader& read) {
  const double full_N = setup.full_scale_N;
  const auto level = [&](std::size_t i) {
    return full_N * static_cast<double>(i) / static_cast<double>(setup.steps);
  };
  std::vector<LoadStep> record;
  record.push_back(read(0.0, setup.preload_s));
  for (std::size_t i = 0; i < setup.preloads; ++i) {
    record.push_back(read(full_N, setup.preload_s));
    record.push_back(read(0.0, setup.preload_s));
  }
  // Down from 22 % to 8 % and up again, or the other way round, in steps of 2 %.
  const auto way = [&](int from_percent, int to_percent) {
    const int by = from_percent < to_percent ? 2 : -2;
    for (int p = from_percent + by; p != to_percent + by; p += by) {
      record.push_back(read(0.01 * p * full_N, setup.step_s));
    }
  };
  for (std::size_t i = 1; i <= setup.steps; ++i) {
    if (level(i - 1) < 0.22 * full_N && level(i) >= 0.22 * full_N) {
      record.push_back(read(0.22 * full_N, setup.step_s));
      way(22, 8);
      way(8, 22);
    }
    if (level(i) > 1.001 * record.back().load_N) record.push_back(read(level(i), setup.step_s));
  }
  for (std::size_t i = setup.steps; i-- > 0;) {
    if (level(i) < 0.08 * full_N && level(i + 1) >= 0.08 * full_N) {
      if (level(i + 1) > 0.081 * full_N) record.push_back(read(0.08 * full_N, setup.step_s));
      way(8, 22);
      way(22, 8);
    }
    record.push_back(read(level(i), setup.step_s));
  }
  return record;
}

}  // namespace

SimulatedCalibration simulate_calibration(const TransducerSetup& setup, std::uint64_t seed) {
  const double full_N = setup.full_scale_N;
  // Between a power law and an exponential: no sum of ten straight lines.
  const VirginCurve shape({{CurveKind::kStretched, 1.0, setup.hysteresis_length_N, 0.85}});
  // d_h of a cycle after preloads, halfway, is y(FS/4) + y(FS/4) − y(FS/2).
  const double middle = 2.0 * shape.force_N(0.25 * full_N) - shape.force_N(0.5 * full_N);
  const VirginCurve curve(
      {{CurveKind::kStretched, setup.hysteresis_mV_per_V / middle, setup.hysteresis_length_N, 0.85}});
  ElementBank bank = elements_between(curve, 0.06 * full_N, full_N);
  Rng noise(seed, "transducer");
  double time_s = 0.0;
  const auto read = [&](double load_N, double wait_s) {
    bank.move_to(load_N);
    time_s += wait_s;
    const double u = load_N / full_N;
    const double straight = setup.sensitivity_mV_per_V * u + setup.quadratic_mV_per_V * u * (1.0 - u) +
                            setup.cubic_mV_per_V * u * (1.0 - u) * (1.0 - 2.0 * u);
    return LoadStep{time_s, load_N,
                    straight + bank.force_N() + setup.zero_drift_mV_per_V_per_s * time_s +
                        setup.noise_mV_per_V * noise.normal()};
  };
  SimulatedCalibration result;
  const auto level = [&](std::size_t i) {
    return full_N * static_cast<double>(i) / static_cast<double>(setup.steps);
  };
  for (std::size_t i = 0; i <= setup.steps; ++i) result.virgin.push_back(read(level(i), setup.step_s));
  for (std::size_t i = setup.steps; i-- > 0;) result.virgin.push_back(read(level(i), setup.step_s));

  result.loops = cycle_with_loops(setup, read);
  result.repeat = cycle_with_loops(setup, read);
  return result;
}

}  // namespace slipstack::sim
