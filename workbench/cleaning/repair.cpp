// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "workbench/base/statistics.h"
#include "workbench/base/text.h"
#include "workbench/cleaning/outliers.h"
#include "workbench/cleaning/recorder_faults.h"
#include "workbench/signal/white_noise.h"

namespace slipstack::workbench {
namespace {

std::string time_of(const Log& log, std::size_t sample) {
  return fmt::format("{:.3f} s", log.start_time_s + static_cast<double>(sample) / log.sample_rate_Hz);
}

double share_of(const Log& log, std::size_t samples) {
  return static_cast<double>(samples) / static_cast<double>(log.position_m.size());
}

/// Straight from the sample before to the sample behind.
void interpolate(std::vector<double>& values, const Interval& gap) {
  if (gap.first == 0 || gap.end >= values.size()) return;
  const double from = values[gap.first - 1];
  const double to = values[gap.end];
  const auto steps = static_cast<double>(gap.size() + 1);
  for (std::size_t i = gap.first; i < gap.end; ++i) {
    values[i] = std::lerp(from, to, static_cast<double>(i - gap.first + 1) / steps);
  }
}

/// What the cubic through two samples on either side of a gap says more than the straight line, at sample
/// `i`.
double bend(const std::vector<double>& values, const Interval& gap, std::size_t i) {
  const auto width = static_cast<double>(gap.size() + 1);
  const double u = static_cast<double>(i - gap.first + 1);
  const double slope = (values[gap.end] - values[gap.first - 1]) / width;
  // Cubic u·(width − u)·(p + q·u) that meets the samples one further on either side.
  const double before = (values[gap.first - 1] - values[gap.first - 2] - slope) / (width + 1.0);
  const double behind = (slope - values[gap.end + 1] + values[gap.end]) / (width + 1.0);
  const double q = (behind - before) / (width + 2.0);
  return u * (width - u) * (before + q * (u + 1.0));
}

void interpolate_force(Log& log, const std::vector<Interval>& gaps) {
  for (const Interval& gap : gaps) interpolate(log.force_N, gap);
}

/// The positions of a mass bend, and lie on the encoder's grid. The cubic is taken where no other of the
/// `gaps` (ascending) is within its samples.
void interpolate_positions(Log& log, const std::vector<Interval>& gaps) {
  std::vector<double>& x = log.position_m;
  const double step_m = log.encoder_resolution_m.value_or(0.0);
  for (std::size_t g = 0; g < gaps.size(); ++g) {
    const Interval& gap = gaps[g];
    if (gap.first == 0 || gap.end >= x.size()) continue;
    interpolate(x, gap);
    const bool alone = gap.first >= 2 && gap.end + 1 < x.size() &&
                       (g == 0 || gaps[g - 1].end + 1 < gap.first) &&
                       (g + 1 == gaps.size() || gap.end + 1 < gaps[g + 1].first);
    std::vector<double> bends(gap.size(), 0.0);
    for (std::size_t i = gap.first; alone && i < gap.end; ++i) bends[i - gap.first] = bend(x, gap, i);
    for (std::size_t i = gap.first; i < gap.end; ++i) {
      x[i] += bends[i - gap.first];
      if (step_m > 0.0) x[i] = x[gap.first - 1] + step_m * std::round((x[i] - x[gap.first - 1]) / step_m);
    }
  }
}

/// Ascending; those that no more than `apart` samples part become one.
std::vector<Interval> joined(std::vector<Interval> intervals, std::size_t apart) {
  std::sort(intervals.begin(), intervals.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Interval> all;
  for (const Interval& one : intervals) {
    if (!all.empty() && one.first <= all.back().end + apart) {
      all.back().end = std::max(all.back().end, one.end);
    } else {
      all.push_back(one);
    }
  }
  return all;
}

void cut(const Log& log, const std::vector<Interval>& intervals, const char* why, Repairs& repairs) {
  if (intervals.empty()) return;
  repairs.notes.push_back(fmt::format("{:.3g} s left out in {} {}, the first at {}: {}",
                                      static_cast<double>(samples_in(intervals)) / log.sample_rate_Hz,
                                      intervals.size(), intervals.size() == 1 ? "place" : "places",
                                      time_of(log, intervals.front().first), why));
  repairs.cut.insert(repairs.cut.end(), intervals.begin(), intervals.end());
}

/// Those that do not touch what is cut.
std::vector<Interval> beside_cuts(std::vector<Interval> intervals, const Repairs& repairs) {
  std::erase_if(intervals, [&](const Interval& one) {
    return std::any_of(repairs.cut.begin(), repairs.cut.end(), [&](const Interval& cut) {
      return one.first < cut.end + kHalfWindow && one.end + kHalfWindow > cut.first;
    });
  });
  return intervals;
}

void repair_repeats(Log& log, double noise_N, Repairs& repairs) {
  const std::vector<Interval> repeats = beside_cuts(repeated_samples(log, noise_N), repairs);
  const std::size_t samples = samples_in(repeats);
  if (repeat_by_chance(log, noise_N, samples)) return;
  interpolate_force(log, repeats);
  interpolate_positions(log, repeats);
  repairs.notes.push_back(
      fmt::format("{} samples repeat the one before and were interpolated, the first at {}", samples,
                  time_of(log, repeats.front().first)));
}

/// More than this share of a log must not be mended.
constexpr double kMostRepaired = 0.02;

/// The wildest samples hide the others near them: so often one looks again.
constexpr int kLooks = 4;

/// Mends wild samples of one signal of the log, beside what is cut; spikes only where they are not rarer than
/// `least_share_of_spikes`.
void repair_outliers(Log& log, const std::vector<double>& values, double noise, double least,
                     double least_share_of_spikes, const char* what,
                     void (*interpolate_gaps)(Log&, const std::vector<Interval>&), Repairs& repairs) {
  if (noise <= 0.0) return;
  std::vector<Interval> wild;
  const auto repair_those = [&](std::vector<Interval> found) {
    found = beside_cuts(std::move(found), repairs);
    if (found.empty()) return false;
    // All of them again: what was wild beside them is mended now. What a single good sample parts is one.
    found.insert(found.end(), wild.begin(), wild.end());
    wild = joined(std::move(found), 1);
    interpolate_gaps(log, wild);
    return true;
  };
  for (int look = 0; look < kLooks && repair_those(outliers(values, noise, least)); ++look) {
  }
  repair_those(spikes(values, noise, least_share_of_spikes));
  if (wild.empty()) return;
  const std::size_t samples = samples_in(wild);
  const std::size_t first = wild.front().first;
  if (share_of(log, samples) > kMostRepaired) {
    throw InputError(fmt::format(
        "{}: {} of {} samples of the {} are wild, the first at {}; check the cable and the shield "
        "and record again",
        printable(log.path), samples, values.size(), what, time_of(log, first)));
  }
  repairs.notes.push_back(fmt::format("{} wild {} of the {} interpolated, the first at {}", samples,
                                      samples == 1 ? "sample" : "samples", what, time_of(log, first)));
}

/// No sample of the position is wild that stands out by less than this share of the travel.
constexpr double kLeastTravel = 1e-4;

void repair_position(Log& log, Repairs& repairs) {
  const double noise_m = std::max(log.encoder_resolution_m.value_or(0.0), white_noise(log.position_m));
  const auto [low, high] = std::minmax_element(log.position_m.begin(), log.position_m.end());
  repair_outliers(log, log.position_m, noise_m, kLeastTravel * (*high - *low), 0.0, "position",
                  interpolate_positions, repairs);
}

/// Nor one of the force by less than this share of its rms.
constexpr double kLeastForce = 0.05;
/// Fewer spikes of the force are reversals of a stiff axis, which look alike and spoil nothing; a bad cable
/// gives more. The position of a mass has none.
constexpr double kLeastShareOfForceSpikes = 1.5e-3;

void repair_force(Log& log, double noise_N, Repairs& repairs) {
  // A digital force flickers by its step.
  const double least_noise_N = noise_N > 0.0 ? std::max(noise_N, smallest_step(log.force_N)) : 0.0;
  repair_outliers(log, log.force_N, least_noise_N, kLeastForce * rms(log.force_N), kLeastShareOfForceSpikes,
                  "force", interpolate_force, repairs);
}

/// More than this share of a log must not be cut.
constexpr double kMostCut = 0.4;

/// Cuts that touch become one.
void join_cuts(const Log& log, Repairs& repairs) {
  repairs.cut = joined(std::move(repairs.cut), 0);
  const double share = share_of(log, samples_in(repairs.cut));
  if (share > kMostCut) {
    throw InputError(fmt::format("{}: {:.0f} % of the log cannot be used: {}; record again",
                                 printable(log.path), 100.0 * share,
                                 repairs.notes.empty() ? "" : repairs.notes.back()));
  }
}

/// Finds the encoder's jumps; takes them back where all of the log is there.
void repair_jumps(Log& log, RepairScope what, Repairs& repairs) {
  repairs.jumps = encoder_jumps(log);
  if (repairs.jumps.empty() || what == RepairScope::piece) return;
  const EncoderJump first = repairs.jumps.front();
  take_back(repairs.jumps, log);
  repairs.notes.push_back(fmt::format("{} {} of the encoder taken back, the first at {}: {:.3g} um",
                                      repairs.jumps.size(), repairs.jumps.size() == 1 ? "jump" : "jumps",
                                      time_of(log, first.sample), 1e6 * first.jump_m));
}

/// Equal neighbours are a fault only where noise is this many times the smallest step of the force.
constexpr double kNoiseOverStep = 3.0;

Repairs repair_in_place(Log& log, RepairScope what) {
  Repairs repairs;
  const double noise_N = white_noise(log.force_N);
  if (noise_N > kNoiseOverStep * smallest_step(log.force_N)) {
    const ConstantForce constant = constant_force(log, noise_N);
    cut(log, constant.at_limit, "the force is at its limit", repairs);
    cut(log, constant.frozen, "the force is frozen", repairs);
    if (constant.noise_at_rest) repair_repeats(log, noise_N, repairs);
  }
  repair_position(log, repairs);
  repair_jumps(log, what, repairs);
  cut(log, stuck_encoder(log), "the position stands still and then jumps (encoder stuck)", repairs);
  if (const auto last = stuck_to_the_end(log)) {
    cut(log, {*last}, "the position stands still to the end of the log, the axis does not (encoder stuck)",
        repairs);
  }
  cut(log, forceless_motion(log, noise_N), "the axis moves without any force (drive off)", repairs);
  repair_force(log, noise_N, repairs);
  join_cuts(log, repairs);
  return repairs;
}

}  // namespace

Repairs repair(Log& log, RepairScope what) {
  if (what == RepairScope::whole_log) return repair_in_place(log, what);
  Log as_it_was = log;
  try {
    return repair_in_place(log, what);
  } catch (const InputError&) {
    log = std::move(as_it_was);
    return {{{0, log.position_m.size()}}, {}, {}};
  }
}

}  // namespace slipstack::workbench
