// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/load_steps.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

namespace slipstack::workbench {
namespace {

constexpr std::size_t kLeastSteps = 5;
/// Loads within this share of full scale count as the same: a machine repeats a load only approximately.
constexpr double kSameLoad = 1e-3;

[[noreturn]] void refuse(std::size_t step, const std::string& what) {
  throw std::invalid_argument("step " + std::to_string(step + 1) + ": " + what);
}

}  // namespace

StepRecord step_record(std::vector<sim::LoadStep> steps) {
  StepRecord record;
  record.steps = std::move(steps);
  const std::vector<sim::LoadStep>& all = record.steps;
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
  const std::vector<sim::LoadStep>& steps = record.steps;
  const sim::LoadStep& start = steps[record.cycle];
  const sim::LoadStep& top = steps[record.top];
  const sim::LoadStep& end = steps.back();
  Reversibility found;
  found.sensitivity = (top.signal_mV_per_V - start.signal_mV_per_V) / (top.load_N - start.load_N);
  if (!(found.sensitivity > 0.0))
    throw std::invalid_argument("the signal does not grow with the load; check its sign");
  const auto off_line = [&](const sim::LoadStep& step) {
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
    // Inside a loop the load repeats earlier values: only new extremes lie on the main branch.
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

}  // namespace slipstack::workbench
