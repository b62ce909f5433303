// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/recorder_faults.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "workbench/base/axis_units.h"
#include "workbench/base/statistics.h"
#include "workbench/signal/noise_estimate.h"

namespace slipstack::workbench {
namespace {

/// The end of the run of equal values that starts at `first`; at most `end`.
std::size_t end_of_run(const std::vector<double>& values, std::size_t first, std::size_t end) {
  std::size_t i = first + 1;
  while (i < end && values[i] == values[first]) ++i;
  return i;
}

/// The start of the run of equal values whose last sample is `end` - 1.
std::size_t start_of_run(const std::vector<double>& values, std::size_t end) {
  std::size_t first = end - 1;
  while (first > 0 && values[first - 1] == values[first]) --first;
  return first;
}

double encoder_step_m(const Log& log) {
  return log.encoder_resolution_m.value_or(0.0);
}

/// Where the force is constant during more than this share of all standstills, it is not measured by a
/// sensor: it is a current commanded by a controller, which has no noise at standstill. Chosen.
constexpr double kStandstillsWithoutNoise = 0.5;
constexpr std::size_t kStandstill = 50;  ///< samples within one encoder step; chosen

/// Whether these intervals of constant force make up most of the standstills.
bool standstills_without_noise(const Log& log, const std::vector<Interval>& constant) {
  const std::vector<double>& x = log.position_m;
  std::size_t still = 0;
  for (std::size_t i = 0; i < x.size();) {
    std::size_t end = i + 1;
    while (end < x.size() && std::abs(x[end] - x[i]) <= 1.5 * encoder_step_m(log)) ++end;
    if (end - i >= kStandstill) still += end - i;
    i = end;
  }
  return constant.size() > 1 &&
         static_cast<double>(samples_in(constant)) > kStandstillsWithoutNoise * static_cast<double>(still);
}

/// So many equal forces in a row do not occur by chance where there is noise: two neighbours are equal with a
/// probability of 0.1 at most.
constexpr std::size_t kFrozen = 8;

/// The runs of at least so many equal forces.
std::vector<Interval> runs_of_constant(const std::vector<double>& force_N) {
  std::vector<Interval> runs;
  for (std::size_t i = 0; i < force_N.size();) {
    const std::size_t end = end_of_run(force_N, i, force_N.size());
    if (end - i >= kFrozen) runs.push_back({i, end});
    i = end;
  }
  return runs;
}

/// The force has no noise next to an interval where all of kFaultMargin steps on either side are smaller than
/// this share of the noise; white noise looks like that at one sample in 10^4.
constexpr std::size_t kFaultMargin = 4;
constexpr double kNoiseless = 0.5;

/// Whether the force has no noise on either side of the interval, as a command at standstill.
bool noiseless_beside(const Log& log, double noise_N, const Interval& interval) {
  const std::vector<double>& force_N = log.force_N;
  const std::size_t from = interval.first > kFaultMargin ? interval.first - kFaultMargin : 1;
  const std::size_t to = std::min(interval.end + kFaultMargin, force_N.size());
  for (std::size_t i = from; i < to; ++i) {
    if (std::abs(force_N[i] - force_N[i - 1]) > kNoiseless * noise_N) return false;
  }
  return true;
}

}  // namespace

double smallest_step(const std::vector<double>& values) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double step = std::abs(values[i] - values[i - 1]);
    if (step > 0.0) smallest = std::min(smallest, step);
  }
  return smallest;
}

std::size_t held_samples(const std::vector<double>& force_N) {
  constexpr double kNearlyAll = 0.8;  // of the changes; chosen
  std::vector<double> lengths;
  for (std::size_t i = 0; i < force_N.size();) {
    const std::size_t end = end_of_run(force_N, i, force_N.size());
    lengths.push_back(static_cast<double>(end - i));
    i = end;
  }
  constexpr std::size_t kFewest = 50;  // changes; of fewer nothing follows
  if (lengths.size() < kFewest) return 1;
  const double usual = median(lengths);
  const auto alike = static_cast<double>(std::count(lengths.begin(), lengths.end(), usual));
  return alike >= kNearlyAll * static_cast<double>(lengths.size()) ? static_cast<std::size_t>(usual) : 1;
}

std::vector<Interval> force_at_limit(const std::vector<double>& force_N) {
  std::vector<Interval> constant = runs_of_constant(force_N);
  if (constant.empty()) return constant;
  const double lowest_N = *std::min_element(force_N.begin(), force_N.end());
  const double highest_N = *std::max_element(force_N.begin(), force_N.end());
  std::erase_if(constant, [&](const Interval& one) {
    return force_N[one.first] != lowest_N && force_N[one.first] != highest_N;
  });
  return constant;
}

ConstantForce constant_force(const Log& log, double noise_N) {
  const std::vector<double>& force_N = log.force_N;
  const auto [lowest, highest] = std::minmax_element(force_N.begin(), force_N.end());
  ConstantForce found;
  std::vector<Interval> at_standstill;
  for (const Interval& run : runs_of_constant(force_N)) {
    const bool at_limit = force_N[run.first] == *lowest || force_N[run.first] == *highest;
    const auto from = log.position_m.begin() + static_cast<std::ptrdiff_t>(run.first);
    const bool still = std::all_of(from, from + static_cast<std::ptrdiff_t>(run.size()), [&](double x) {
      return std::abs(x - *from) <= 1.5 * encoder_step_m(log);
    });
    (still ? at_standstill : at_limit ? found.at_limit : found.frozen).push_back(run);
  }
  found.noise_at_standstill = !standstills_without_noise(log, at_standstill);
  // A slowly changing command repeats its last digits now and then, without noise around; a sensor that
  // freezes had noise before.
  std::erase_if(at_standstill, [&](const Interval& one) { return noiseless_beside(log, noise_N, one); });
  if (found.noise_at_standstill) {
    found.frozen.insert(found.frozen.end(), at_standstill.begin(), at_standstill.end());
  }
  return found;
}

std::vector<Interval> repeated_samples(const Log& log, double noise_N) {
  const std::vector<double>& force_N = log.force_N;
  std::vector<Interval> repeats;
  for (std::size_t i = 0; i < force_N.size();) {
    const std::size_t end = end_of_run(log.position_m, i, end_of_run(force_N, i, force_N.size()));
    const Interval repeat{i + 1, end};
    if (end - i > 1 && end - i < kFrozen && !noiseless_beside(log, noise_N, repeat))
      repeats.push_back(repeat);
    i = end;
  }
  return repeats;
}

/// Repeats are a fault where they are at least so many times as frequent as expected by chance, and at least
/// so many. Chosen.
constexpr double kBeyondChance = 5.0;
constexpr double kFewestRepeats = 10.0;
/// What occurs in a larger share of the log than this is a property of the log, not a fault. Chosen.
constexpr double kLargestShare = 0.2;

bool repeat_by_chance(const Log& log, double noise_N, std::size_t repeats) {
  const auto count = static_cast<double>(log.force_N.size());
  // Neighbours are equal by chance with the density of their difference at zero, 1 / (2 sqrt(pi) noise),
  // times the step of the force.
  const double chance = 0.2821 * smallest_step(log.force_N) / noise_N * count;
  return static_cast<double>(repeats) < kFewestRepeats + kBeyondChance * chance ||
         static_cast<double>(repeats) / count > kLargestShare;
}

namespace {

/// An encoder was stuck where it reads the same for so many samples and then makes up the motion in one step.
/// Chosen.
constexpr std::size_t kStuck = 20;

/// Magnitudes of `count` steps from sample to sample, the first of them to sample `first`.
std::vector<double> steps_m(const std::vector<double>& x, std::size_t first, std::size_t count) {
  std::vector<double> steps(count);
  for (std::size_t i = 0; i < count; ++i) steps[i] = std::abs(x[first + i] - x[first + i - 1]);
  return steps;
}

double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

/// From the 5 % quantile to the 95 % quantile of the force, so that noise and single samples do not count.
double force_range_N(const Log& log, std::size_t first, std::size_t end) {
  std::vector<double> values(log.force_N.begin() + static_cast<std::ptrdiff_t>(first),
                             log.force_N.begin() + static_cast<std::ptrdiff_t>(end));
  const std::size_t part = values.size() / 20;
  return value_at_rank(values, values.size() - 1 - part) - value_at_rank(values, part);
}

constexpr double kJump = 20.0;  ///< encoder steps, and multiples of the steps that follow; chosen

/// Whether the standstill that ends before `end` ends by a jump of the position in one step.
bool ends_by_jump(const Log& log, std::size_t end) {
  const std::vector<double>& x = log.position_m;
  if (end + kStuck >= x.size()) return false;
  const double jump_m = std::abs(x[end] - x[end - 1]);
  // A move of a few samples begins with a jump too, but continues with larger steps.
  const double next_m = std::max(encoder_step_m(log), largest(steps_m(x, end + 1, kStuck)));
  return jump_m > kJump * next_m && jump_m > 0.0;
}

/// The largest range of the force in any earlier standstill, at least a quarter of the range in the whole
/// log. Standstills that end by a jump are left out: there the encoder may have been stuck.
double largest_standstill_range_N(const Log& log, std::size_t before) {
  double widest_N = 0.25 * force_range_N(log, 0, log.force_N.size());
  for (std::size_t i = 0; i < before;) {
    const std::size_t end = end_of_run(log.position_m, i, before);
    if (end - i >= kStuck && !ends_by_jump(log, end))
      widest_N = std::max(widest_N, force_range_N(log, i, end));
    i = end;
  }
  return widest_N;
}

}  // namespace

/// The axis moves at speed where it makes so many encoder steps a sample, and at least this share of the
/// largest speed in the samples before. Chosen.
constexpr double kSpeed = 5.0;
constexpr double kSteady = 0.5;

bool stopped_dead(const Log& log, std::size_t sample) {
  const std::vector<double>& x = log.position_m;
  const std::size_t first = start_of_run(x, sample);
  if (first < 2 * kStuck) return false;
  const std::vector<double> before = steps_m(x, first - kStuck, kStuck);
  const double slowest_m = *std::min_element(before.end() - 4, before.end());
  return slowest_m > kSpeed * std::max(encoder_step_m(log), 1e-12) && slowest_m > kSteady * largest(before);
}

std::vector<Interval> stuck_encoder(const Log& log) {
  const std::vector<double>& x = log.position_m;
  std::vector<Interval> stuck;
  for (std::size_t i = 0; i < x.size();) {
    const std::size_t end = end_of_run(x, i, x.size());
    if (end - i >= kStuck && ends_by_jump(log, end)) stuck.push_back({i, end + 1});
    i = end;
  }
  return stuck;
}

/// The force shows motion where its range during a standstill of the position is so many times the range in
/// other standstills. Chosen.
constexpr double kBeyondStandstill = 2.0;

std::optional<Interval> stuck_to_the_end(const Log& log) {
  const std::vector<double>& x = log.position_m;
  const std::size_t first = start_of_run(x, x.size());
  if (x.size() - first < kStuck || first < 2 * kStuck) return {};
  if (stopped_dead(log, x.size()) || force_shows_motion(log, x.size())) return Interval{first, x.size()};
  return {};
}

bool force_shows_motion(const Log& log, std::size_t sample) {
  const std::size_t first = start_of_run(log.position_m, sample);
  return force_range_N(log, first, sample) > kBeyondStandstill * largest_standstill_range_N(log, first);
}

/// Motion without force lasts at least so long [s]; all four chosen.
constexpr double kForceless_s = 0.25;
constexpr double kForcelessNoise = 1.5;    ///< rms over the noise
constexpr double kClearForce = 10.0;       ///< rms of the whole log over the noise
constexpr double kForcelessTravel = 50.0;  ///< encoder steps

namespace {

/// Blocks of a window, and what chi-squared of their means is at most where these are of white noise: five
/// standard deviations above its expectation.
constexpr std::size_t kBlocks = 8;
const double kMostChiSquared = static_cast<double>(kBlocks) + 5.0 * std::sqrt(2.0 * kBlocks);

/// Whether the force within the window is white noise about zero, by the means of its blocks in units of
/// their standard error. A force that is only small has a mean or follows the motion: on a joint of little
/// friction the force of a move passes zero for long.
bool is_noise_about_zero(const Log& log, const Interval& window) {
  const std::size_t length = window.size() / kBlocks;
  double squares = 0.0;
  double squared_means = 0.0;
  for (std::size_t block = 0; block < kBlocks; ++block) {
    double sum = 0.0;
    for (std::size_t i = 0; i < length; ++i) {
      const double force_N = log.force_N[window.first + block * length + i];
      sum += force_N;
      squares += force_N * force_N;
    }
    squared_means += squared(sum / static_cast<double>(length));
  }
  const double variance = squares / static_cast<double>(kBlocks * length);
  return static_cast<double>(length) * squared_means <= kMostChiSquared * variance;
}

/// Less is not seen to be motion.
double least_forceless_travel_m(const Log& log) {
  return std::max(kForcelessTravel * encoder_step_m(log), axis_length(1e-4));
}

/// Whether the axis moves while the force is no more than noise.
bool moves_without_force(const Log& log, double noise_N, const Interval& window) {
  double sum = 0.0;
  double lowest = log.position_m[window.first];
  double highest = lowest;
  for (std::size_t i = window.first; i < window.end; ++i) {
    sum += log.force_N[i] * log.force_N[i];
    lowest = std::min(lowest, log.position_m[i]);
    highest = std::max(highest, log.position_m[i]);
  }
  const double most = kForcelessNoise * noise_N;
  return sum <= most * most * static_cast<double>(window.size()) &&
         highest - lowest >= least_forceless_travel_m(log) && is_noise_about_zero(log, window);
}

/// A drive is switched within so long [s]; the force then passes from noise to so many standard deviations of
/// it. Both chosen.
constexpr double kSwitching_s = 0.02;
constexpr double kSwitchedNoise = 10.0;
constexpr double kBeyondNoise = 5.0;  ///< standard deviations that noise does not exceed
/// A rest before motion lasts so long [s]. Chosen.
constexpr double kRest_s = 0.1;

/// Whether the drive is switched at the end of an idle interval towards `step` (-1: its start, +1: its end)
/// while the axis moves on: the force passes from noise to far more at once. A force that inertia and
/// friction make together passes zero evenly, or changes at once where the axis turns round.
bool is_switched(const Log& log, double noise_N, const Interval& idle, std::ptrdiff_t step) {
  const auto count = static_cast<std::ptrdiff_t>(log.force_N.size());
  const auto force_N = [&](std::ptrdiff_t i) { return std::abs(log.force_N[static_cast<std::size_t>(i)]); };
  const auto x = [&](std::ptrdiff_t i) { return log.position_m[static_cast<std::size_t>(i)]; };
  auto edge = static_cast<std::ptrdiff_t>((idle.first + idle.end) / 2);
  while (edge > 0 && edge + 1 < count && force_N(edge) <= kBeyondNoise * noise_N) edge += step;
  const auto within = static_cast<std::ptrdiff_t>(std::max(2.0, kSwitching_s * log.sample_rate_Hz));
  if (edge < 2 * within || edge + 2 * within >= count) return false;
  const bool clear = force_N(edge + step * within) > kSwitchedNoise * noise_N &&
                     force_N(edge + step * 2 * within) > kSwitchedNoise * noise_N;
  const double before_m = x(edge - within) - x(edge - 2 * within);
  const double after_m = x(edge + 2 * within) - x(edge + within);
  return clear && before_m * after_m > 0.0 &&
         std::min(std::abs(before_m), std::abs(after_m)) > encoder_step_m(log);
}

/// Whether the axis is as fast at the end of an idle interval as at its start: without a drive, friction
/// slows it down. Where a constant force balances the friction, a drive moves it evenly without any force.
bool keeps_its_speed(const Log& log, const Interval& idle) {
  constexpr double kSame = 0.9;  // of the faster of both; chosen
  const std::size_t part = idle.size() / 3;
  const auto travel_m = [&](std::size_t first) {
    return std::abs(log.position_m[first + part] - log.position_m[first]);
  };
  const auto [slow, fast] = std::minmax(travel_m(idle.first), travel_m(idle.end - part - 1));
  return slow > kSame * fast;
}

/// Whether the axis starts from rest in an idle interval, which nothing but the drive or a hand makes it do.
bool starts_from_rest(const Log& log, const Interval& idle) {
  const auto rest = static_cast<std::size_t>(std::max(2.0, kRest_s * log.sample_rate_Hz));
  const double travel_m = least_forceless_travel_m(log);
  std::size_t still = 0;
  double held_m = log.position_m[idle.first];
  for (std::size_t i = idle.first; i < idle.end; ++i) {
    const double moved_m = std::abs(log.position_m[i] - held_m);
    if (still >= rest && moved_m >= travel_m) return true;
    if (still >= rest || moved_m <= 1.5 * encoder_step_m(log)) {
      still += 1;
    } else {
      still = 0;
      held_m = log.position_m[i];
    }
  }
  return false;
}

}  // namespace

std::vector<Interval> forceless_motion(const Log& log, double noise_N) {
  const std::size_t count = log.force_N.size();
  const auto window = static_cast<std::size_t>(std::max(50.0, kForceless_s * log.sample_rate_Hz));
  if (noise_N <= 0.0 || rms(log.force_N) < kClearForce * noise_N) return {};
  // In coarse steps, no force is any force of less than half a step.
  if (coarse_step(log.force_N) > 0.0) return {};
  std::vector<Interval> idle;
  for (std::size_t first = 0; first + window <= count; first += window / 2) {
    if (!moves_without_force(log, noise_N, {first, first + window})) continue;
    if (!idle.empty() && first <= idle.back().end) {
      idle.back().end = first + window;
    } else {
      idle.push_back({first, first + window});
    }
  }
  if (static_cast<double>(samples_in(idle)) / static_cast<double>(count) > kLargestShare) return {};
  std::vector<Interval> off;
  for (Interval one : idle) {
    const bool even = keeps_its_speed(log, one);
    // The windows at either edge still contained some force: half a window more is cut.
    one.first = one.first > window / 2 ? one.first - window / 2 : 0;
    one.end = std::min(count, one.end + window / 2);
    const bool switched = is_switched(log, noise_N, one, -1) || is_switched(log, noise_N, one, 1);
    if ((switched && !even) || starts_from_rest(log, one)) off.push_back(one);
  }
  return off;
}

}  // namespace slipstack::workbench
