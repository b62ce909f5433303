// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/repair.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "workbench/base/axis_words.h"
#include "workbench/base/quantity.h"
#include "workbench/base/statistics.h"
#include "workbench/base/text.h"
#include "workbench/cleaning/impacts.h"
#include "workbench/cleaning/interpolate.h"
#include "workbench/cleaning/momentum.h"
#include "workbench/cleaning/outliers.h"
#include "workbench/cleaning/recorder_faults.h"
#include "workbench/signal/noise_estimate.h"

namespace slipstack::workbench {
namespace {

std::string time_of(const Log& log, std::size_t sample) {
  return fmt::format("{:.3f} s", log.start_time_s + static_cast<double>(sample) / log.sample_rate_Hz);
}

double share_of(const Log& log, std::size_t samples) {
  return static_cast<double>(samples) / static_cast<double>(log.position_m.size());
}

/// Difference at sample `i` between the cubic through two samples on either side of a gap and the straight
/// line through one on either side.
double cubic_part(const std::vector<double>& values, const Interval& gap, std::size_t i) {
  const auto width = static_cast<double>(gap.size() + 1);
  const double u = static_cast<double>(i - gap.first + 1);
  const double slope = (values[gap.end] - values[gap.first - 1]) / width;
  // The cubic u·(width − u)·(p + q·u) that passes through the second samples on either side.
  const double before = (values[gap.first - 1] - values[gap.first - 2] - slope) / (width + 1.0);
  const double behind = (slope - values[gap.end + 1] + values[gap.end]) / (width + 1.0);
  const double q = (behind - before) / (width + 2.0);
  return u * (width - u) * (before + q * (u + 1.0));
}

void interpolate_force(Log& log, const std::vector<Interval>& gaps) {
  for (const Interval& gap : gaps) interpolate(log.force_N, gap);
}

/// Interpolates positions by a cubic, because a mass accelerates, and rounds them to the encoder's grid. The
/// straight line is used where another of the `gaps` (ascending) lies within the samples of the cubic.
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
    std::vector<double> cubic_parts(gap.size(), 0.0);
    for (std::size_t i = gap.first; alone && i < gap.end; ++i)
      cubic_parts[i - gap.first] = cubic_part(x, gap, i);
    for (std::size_t i = gap.first; i < gap.end; ++i) {
      x[i] += cubic_parts[i - gap.first];
      if (step_m > 0.0) x[i] = x[gap.first - 1] + step_m * std::round((x[i] - x[gap.first - 1]) / step_m);
    }
  }
}

/// The intervals in ascending order; those with at most `apart` samples between them are joined.
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

void cut(const Log& log, const std::vector<Interval>& intervals, const std::string& why, Repairs& repairs) {
  if (intervals.empty()) return;
  repairs.notes.push_back(fmt::format("{:.3g} s left out in {} {}, the first at {}: {}",
                                      static_cast<double>(samples_in(intervals)) / log.sample_rate_Hz,
                                      intervals.size(), intervals.size() == 1 ? "place" : "places",
                                      time_of(log, intervals.front().first), why));
  repairs.cut.insert(repairs.cut.end(), intervals.begin(), intervals.end());
}

/// The intervals that keep a distance of kHalfWindow samples from everything that is cut.
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

/// A log of which more than this share would be interpolated is refused. Chosen.
constexpr double kMostRepaired = 0.02;

/// The largest outliers hide smaller ones near them, so the search is repeated up to this number of times.
constexpr int kPasses = 4;

/// A signal of the log whose outliers are repaired.
struct Signal {
  const std::vector<double>& values;
  const char* name;
  double noise;
  double least;                  ///< of an outlier
  double least_share_of_spikes;  ///< of the samples
  void (*interpolate)(Log&, const std::vector<Interval>&);
  /// Of what looks like outliers, those that are none of the axis.
  std::vector<Interval> (*faults_among)(const Log&, std::vector<Interval>, Repairs&);
};

/// Interpolates the outliers of one signal of the log, except near what is cut.
void repair_outliers(Log& log, const Signal& signal, Repairs& repairs) {
  if (signal.noise <= 0.0) return;
  std::vector<Interval> repaired;
  const auto repair_those = [&](std::vector<Interval> found) {
    found = signal.faults_among(log, beside_cuts(std::move(found), repairs), repairs);
    if (found.empty()) return false;
    // All are interpolated again, because outliers next to them are repaired now. Intervals with a single
    // good sample between them are joined.
    found.insert(found.end(), repaired.begin(), repaired.end());
    repaired = joined(std::move(found), 1);
    signal.interpolate(log, repaired);
    return true;
  };
  for (int pass = 0; pass < kPasses && repair_those(outliers(signal.values, signal.noise, signal.least));
       ++pass) {
  }
  repair_those(spikes(signal.values, signal.noise, signal.least_share_of_spikes));
  if (repaired.empty()) return;
  const std::size_t samples = samples_in(repaired);
  const std::size_t first = repaired.front().first;
  if (share_of(log, samples) > kMostRepaired) {
    throw InputError(fmt::format(
        "{}: {} of {} samples of the {} are outliers, the first at {}; check the cable and the shield "
        "and record again",
        printable(log.path), samples, signal.values.size(), signal.name, time_of(log, first)));
  }
  repairs.notes.push_back(fmt::format("{} {} of the {} interpolated, the first at {}", samples,
                                      samples == 1 ? "outlier" : "outliers", signal.name,
                                      time_of(log, first)));
}

/// An outlier of the position departs by at least this share of the travel. Chosen.
constexpr double kLeastTravel = 1e-4;

void repair_position(Log& log, Repairs& repairs) {
  const double noise_m = std::max(log.encoder_resolution_m.value_or(0.0), white_noise(log.position_m));
  const auto [low, high] = std::minmax_element(log.position_m.begin(), log.position_m.end());
  repair_outliers(log,
                  {.values = log.position_m,
                   .name = "position",
                   .noise = noise_m,
                   .least = kLeastTravel * (*high - *low),
                   .least_share_of_spikes = 0.0,
                   .interpolate = interpolate_positions,
                   .faults_among = [](const Log&, std::vector<Interval> found, Repairs&) { return found; }},
                  repairs);
}

/// An outlier of the force departs by at least this share of its rms. Chosen.
constexpr double kLeastForce = 0.05;
/// A smaller share of spikes in the force is left alone: reversals of a stiff axis look like spikes and do no
/// harm, and a bad cable gives more. The position of a mass has no such peaks.
constexpr double kLeastShareOfForceSpikes = 1.5e-3;

/// Of pulses of the force those that the axis neither follows nor causes.
std::vector<Interval> faults_of_force_sensor(const Log& log, std::vector<Interval> pulses, Repairs& repairs) {
  std::vector<Interval> faults = without_true_pulses(log, std::move(pulses));
  if (!are_impacts(log, faults)) return faults;
  if (faults.size() > repairs.impacts.size()) repairs.impacts = std::move(faults);
  return {};
}

void repair_force(Log& log, double noise_N, Repairs& repairs) {
  // A digital force changes by at least its resolution.
  const double least_noise_N = noise_N > 0.0 ? std::max(noise_N, smallest_step(log.force_N)) : 0.0;
  repair_outliers(log,
                  {.values = log.force_N,
                   .name = force_word(),
                   .noise = least_noise_N,
                   .least = kLeastForce * rms(log.force_N),
                   .least_share_of_spikes = kLeastShareOfForceSpikes,
                   .interpolate = interpolate_force,
                   .faults_among = faults_of_force_sensor},
                  repairs);
}

/// A log of which more than this share would be cut is refused. Chosen.
constexpr double kMostCut = 0.4;

/// Joins cuts that touch each other.
void join_cuts(const Log& log, Repairs& repairs) {
  repairs.cut = joined(std::move(repairs.cut), 0);
  const double share = share_of(log, samples_in(repairs.cut));
  if (share > kMostCut) {
    throw InputError(fmt::format("{}: {:.0f} % of the log cannot be used: {}; record again",
                                 printable(log.path), 100.0 * share, fmt::join(repairs.notes, "; ")));
  }
}

/// Finds the jumps of the encoder; corrects them in a whole log.
void repair_jumps(Log& log, RepairScope scope, Repairs& repairs) {
  repairs.jumps = encoder_jumps(log);
  if (repairs.jumps.empty() || scope == RepairScope::chunk) return;
  const EncoderJump first = repairs.jumps.front();
  remove_jumps(repairs.jumps, log);
  repairs.notes.push_back(fmt::format("{} {} of the encoder corrected, the first at {}: {}",
                                      repairs.jumps.size(), repairs.jumps.size() == 1 ? "jump" : "jumps",
                                      time_of(log, first.sample), quantity(first.jump_m, "m")));
}

/// Equal neighbours are a fault only where the noise is this many times the resolution of the force. Chosen.
constexpr double kNoiseOverStep = 3.0;

/// Of a force that is recorded at a lower rate than the position: refuses it where that is so low that the
/// values in between would be invented, else notes by how much it is late.
void note_held_force(const Log& log, Repairs& repairs) {
  constexpr std::size_t kMostHeld = 7;  // a constant force of more samples counts as frozen
  const std::size_t held = held_samples(log.force_N);
  if (held < 2) return;
  const double rate_Hz = log.sample_rate_Hz / static_cast<double>(held);
  if (held > kMostHeld) {
    throw InputError(fmt::format(
        "{}: the {} changes only every {} samples, it is recorded at {:.4g} Hz and the position at "
        "{:.4g} Hz; record both at one rate, or write only every {}th row",
        printable(log.path), force_word(), held, rate_Hz, log.sample_rate_Hz, held));
  }
  repairs.notes.push_back(fmt::format(
      "the {} changes only every {} samples ({:.4g} Hz): in the mean it is late by {}", force_word(), held,
      rate_Hz, quantity(0.5 * static_cast<double>(held - 1) / log.sample_rate_Hz, "s")));
}

Repairs repair_in_place(Log& log, RepairScope scope) {
  Repairs repairs;
  note_held_force(log, repairs);
  // A force that is at its limit for half of a log has a median change of zero.
  const double noise_N = white_noise(log.force_N, force_at_limit(log.force_N));
  if (noise_N > kNoiseOverStep * smallest_step(log.force_N)) {
    const ConstantForce constant = constant_force(log, noise_N);
    cut(log, constant.at_limit, fmt::format("the {} is at its limit", force_word()), repairs);
    // A command is constant at constant velocity; a sensor has noise there.
    if (!log.commanded_current)
      cut(log, constant.frozen, fmt::format("the {} is frozen", force_word()), repairs);
    if (!log.commanded_current && constant.noise_at_standstill) repair_repeats(log, noise_N, repairs);
  }
  repair_position(log, repairs);
  repair_jumps(log, scope, repairs);
  cut(log, stuck_encoder(log), "the position stands still and then jumps (encoder stuck)", repairs);
  if (const auto last = stuck_to_the_end(log)) {
    cut(log, {*last}, "the position stands still to the end of the log, the axis does not (encoder stuck)",
        repairs);
  }
  cut(log, forceless_motion(log, noise_N),
      fmt::format("the axis moves without any {} (drive off)", force_word()), repairs);
  repair_force(log, noise_N, repairs);
  join_cuts(log, repairs);
  return repairs;
}

}  // namespace

Repairs repair(Log& log, RepairScope scope) {
  if (scope == RepairScope::whole_log) return repair_in_place(log, scope);
  Log original = log;
  try {
    return repair_in_place(log, scope);
  } catch (const InputError&) {
    log = std::move(original);
    return {.cut = {{0, log.position_m.size()}}, .jumps = {}, .impacts = {}, .notes = {}};
  }
}

}  // namespace slipstack::workbench
