// SPDX-License-Identifier: Apache-2.0
#include "workbench/identify/mend.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "workbench/identify/white_noise.h"
#include "workbench/log/median.h"
#include "workbench/log/text.h"

namespace slipstack::workbench {
namespace {

/// A median over seven samples leaves steps and slopes as they are and takes out what is at most three wide.
constexpr std::size_t kHalfWindow = 3;
/// A wild sample stands this many standard deviations of the noise out of its neighbours' median, and this
/// many times as far as samples around it do, or as they step: ringing stands out everywhere, and a median
/// cuts the tip of every peak.
constexpr double kWild = 12.0;
constexpr double kWildAmongOthers = 8.0;
/// Of the wildest within the window.
constexpr double kShareOfWildest = 0.2;
/// Nor is the tip of a short peak wild, which rises and falls by steps on either side.
constexpr double kWildAmongNeighbours = 5.0;
/// Nor is a sample wild that stands out by less than this share of the force's rms, or of the travel.
constexpr double kLeastForce = 0.05;
constexpr double kLeastTravel = 1e-4;
/// Wild samples next to each other, and in a chain of samples so near to each other: more are a burst. Of
/// wild samples that have nothing to do with each other, one in a hundred, every fifth is as near to the
/// next, and one chain in ten thousand is longer.
constexpr std::size_t kWidest = 3;
constexpr std::size_t kApart = 24;
constexpr std::size_t kLongestChain = 6;

/// One sample alone is wild by less, where what its neighbours say of it, a cubic, is known so well: this
/// many standard deviations of the noise, and times what nine in ten samples around differ by from theirs.
constexpr double kSpike = 9.0;
constexpr double kSpikeAmongOthers = 4.0;
/// It makes its neighbours differ by two thirds of that, the other way. A corner makes them differ by half of
/// that, a step by all of it on one side.
constexpr double kLeastEcho = 0.52;
constexpr double kMostEcho = 0.9;
/// Fewer spikes of the force are reversals of a stiff axis, which look alike and spoil nothing; a bad cable
/// gives more. The position of a mass has none.
constexpr double kLeastShareOfForceSpikes = 1.5e-3;

/// Equal neighbours are a fault only where noise is this many times the smallest step of the force.
constexpr double kNoiseOverStep = 3.0;
/// So many equal forces in a row do not happen by chance then: each has a chance of 0.1 at most.
constexpr std::size_t kFrozen = 8;
/// Where the force is constant during so much of the time that the axis rests, it is no sensor's but a
/// current that a controller commands, which has no noise while nothing moves.
constexpr double kRestsWithoutNoise = 0.5;
constexpr std::size_t kRest = 50;  ///< samples within an encoder step
/// Chance repeats, of which so many times as many must be seen.
constexpr double kBeyondChance = 5.0;
constexpr double kFewestRepeats = 10.0;

/// An encoder that stood for so many samples and makes up for them in one step was stuck.
constexpr std::size_t kStuck = 20;
constexpr double kJump = 20.0;  ///< encoder steps, and times the steps that follow

/// One that stood to the end had moved at so many steps a sample, or the force has so many times the range
/// that it has elsewhere while the position stands.
constexpr double kSpeed = 5.0;
constexpr double kForceStands = 2.0;

/// Motion without force lasts at least so long, [s].
constexpr double kForceless_s = 0.25;
constexpr double kForcelessNoise = 1.5;    ///< rms over the noise
constexpr double kForceSeen = 10.0;        ///< rms of the whole log over the noise
constexpr double kForcelessTravel = 50.0;  ///< encoder steps

/// More than this share of a log must not be mended or cut.
constexpr double kMostMended = 0.02;
constexpr double kMostCut = 0.4;
/// What is this share of the log is its nature, not a fault of it.
constexpr double kNature = 0.2;

double median_of_seven(const std::vector<double>& values, std::size_t i) {
  std::array<double, 2 * kHalfWindow + 1> window{};
  std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(i - kHalfWindow), window.size(), window.begin());
  std::nth_element(window.begin(), window.begin() + kHalfWindow, window.end());
  return window[kHalfWindow];
}

/// Of the five samples on either side, those next to the stretch and other wild ones left out.
double largest_step_beside(const std::vector<double>& values, const Stretch& one,
                           const std::vector<std::size_t>& wild) {
  constexpr std::size_t kBeside = 6;
  double largest = 0.0;
  const auto step_to = [&](std::size_t i) {
    const auto next = std::lower_bound(wild.begin(), wild.end(), i - 1);
    if (next == wild.end() || *next > i) largest = std::max(largest, std::abs(values[i] - values[i - 1]));
  };
  for (std::size_t k = 2; k <= kBeside; ++k) {
    if (one.first >= k) step_to(one.first - k + 1);
    if (one.end + k <= values.size()) step_to(one.end + k - 1);
  }
  return largest;
}

/// Neighbours together, chains that are bursts left out.
std::vector<Stretch> apart_from_bursts(const std::vector<std::size_t>& wild) {
  std::vector<Stretch> stretches;
  for (std::size_t first = 0, end = 0; first < wild.size(); first = end) {
    end = first + 1;
    while (end < wild.size() && wild[end] - wild[end - 1] <= kApart) ++end;
    if (end - first > kLongestChain) continue;
    std::vector<Stretch> chain;
    for (std::size_t i = first; i < end; ++i) {
      if (!chain.empty() && wild[i] - chain.back().end < kWidest) {
        chain.back().end = wild[i] + 1;
      } else {
        chain.push_back({wild[i], wild[i] + 1});
      }
    }
    const bool single = std::all_of(chain.begin(), chain.end(),
                                    [](const Stretch& one) { return one.end - one.first <= kWidest; });
    if (single) stretches.insert(stretches.end(), chain.begin(), chain.end());
  }
  return stretches;
}

/// Wild samples of one signal, as stretches of up to three.
std::vector<Stretch> wild_samples(const std::vector<double>& values, double noise, double least) {
  std::vector<std::size_t> wild;
  std::vector<double> departures(values.size(), 0.0);
  for (std::size_t i = kHalfWindow; i + kHalfWindow < values.size(); ++i) {
    departures[i] = std::abs(values[i] - median_of_seven(values, i));
  }
  const double least_departure = std::max(kWild * noise, least);
  for (std::size_t i = kHalfWindow; i + kHalfWindow < values.size(); ++i) {
    if (departures[i] <= least_departure) continue;
    // One wild sample moves the medians of its neighbours by a step of the signal: they are not wild.
    const auto around = departures.begin() + static_cast<std::ptrdiff_t>(i - kHalfWindow);
    const double most = *std::max_element(around, around + 2 * kHalfWindow + 1);
    if (departures[i] > kShareOfWildest * most) wild.push_back(i);
  }
  std::vector<Stretch> clusters = apart_from_bursts(wild);
  std::erase_if(clusters, [&](const Stretch& one) {
    const double own = *std::max_element(departures.begin() + static_cast<std::ptrdiff_t>(one.first),
                                         departures.begin() + static_cast<std::ptrdiff_t>(one.end));
    const std::size_t from = one.first > 4 * kApart ? one.first - 4 * kApart : 0;
    const std::size_t to = std::min(values.size(), one.end + 4 * kApart);
    std::vector<double> others, steps;
    others.reserve(to - from);
    steps.reserve(to - from);
    for (std::size_t i = from + 1; i < to; ++i) {
      if (i < one.first || i >= one.end) others.push_back(departures[i]);
      steps.push_back(std::abs(values[i] - values[i - 1]));
    }
    const auto usual = others.begin() + static_cast<std::ptrdiff_t>(others.size() * 9 / 10);
    std::nth_element(others.begin(), usual, others.end());
    if (own < kWildAmongOthers * std::max(*usual, median(std::move(steps)))) return true;
    return own < kWildAmongNeighbours * largest_step_beside(values, one, wild);
  });
  return clusters;
}

/// What each sample differs by from the cubic through two neighbours on either side.
std::vector<double> departures_from_cubic(const std::vector<double>& values) {
  std::vector<double> departures(values.size(), 0.0);
  for (std::size_t i = 2; i + 2 < values.size(); ++i) {
    departures[i] = values[i] - (4.0 * (values[i - 1] + values[i + 1]) - values[i - 2] - values[i + 2]) / 6.0;
  }
  return departures;
}

/// Wild samples that stand alone: spikes of a cable, which would vanish in the motion of the signal but not
/// in its noise. None where they are a smaller share of the samples than `least_share`.
std::vector<Stretch> spikes(const std::vector<double>& values, double noise, double least_share) {
  const std::vector<double> departures = departures_from_cubic(values);
  std::vector<std::size_t> found;
  for (std::size_t i = 3; i + 3 < values.size(); ++i) {
    const double own = std::abs(departures[i]);
    if (own <= kSpike * noise) continue;
    const double before = -departures[i - 1] / departures[i];
    const double behind = -departures[i + 1] / departures[i];
    if (std::min(before, behind) < kLeastEcho || std::max(before, behind) > kMostEcho) continue;
    const std::size_t from = i > 4 * kApart ? i - 4 * kApart : 0;
    const std::size_t to = std::min(values.size(), i + 4 * kApart);
    std::vector<double> others;
    others.reserve(to - from);
    for (std::size_t k = from; k < to; ++k) others.push_back(std::abs(departures[k]));
    const auto usual = others.begin() + static_cast<std::ptrdiff_t>(others.size() * 9 / 10);
    std::nth_element(others.begin(), usual, others.end());
    if (own > kSpikeAmongOthers * *usual) found.push_back(i);
  }
  const double share = static_cast<double>(found.size()) / static_cast<double>(values.size());
  return share < least_share ? std::vector<Stretch>{} : apart_from_bursts(found);
}

/// Straight from the sample before to the sample behind.
void interpolate(std::vector<double>& values, const Stretch& gap) {
  if (gap.first == 0 || gap.end >= values.size()) return;
  const double from = values[gap.first - 1];
  const double to = values[gap.end];
  const auto steps = static_cast<double>(gap.end - gap.first + 1);
  for (std::size_t i = gap.first; i < gap.end; ++i) {
    values[i] = std::lerp(from, to, static_cast<double>(i - gap.first + 1) / steps);
  }
}

/// The smallest difference between neighbours that differ: the step of a digital force.
double smallest_step(const std::vector<double>& values) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double step = std::abs(values[i] - values[i - 1]);
    if (step > 0.0) smallest = std::min(smallest, step);
  }
  return smallest;
}

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

class Mender {
 public:
  explicit Mender(Log& log)
      : log_(log),
        count_(log.position_m.size()),
        noise_N_(white_noise(log.force_N)),
        step_m_(log.encoder_resolution_m.value_or(0.0)) {}

  Mending run() {
    const bool noise_shows = noise_N_ > kNoiseOverStep * smallest_step(log_.force_N);
    if (noise_shows) cut_frozen_force();
    if (noise_shows && noise_at_rest_) mend_repeats();
    const double position_noise_m = std::max(step_m_, white_noise(log_.position_m));
    const auto [low, high] = std::minmax_element(log_.position_m.begin(), log_.position_m.end());
    mend_wild(log_.position_m, position_noise_m, kLeastTravel * (*high - *low), 0.0, "position");
    cut_stuck_encoder();
    cut_forceless_motion();
    // A digital force flickers by its step.
    const double force_noise_N = std::max(noise_N_, smallest_step(log_.force_N));
    mend_wild(log_.force_N, noise_N_ > 0.0 ? force_noise_N : 0.0, kLeastForce * rms(log_.force_N),
              kLeastShareOfForceSpikes, "force");
    join_cuts();
    return std::move(mending_);
  }

 private:
  std::string at(std::size_t sample) const {
    return fmt::format("{:.3f} s", log_.start_time_s + static_cast<double>(sample) / log_.sample_rate_Hz);
  }
  double share(std::size_t samples) const {
    return static_cast<double>(samples) / static_cast<double>(count_);
  }
  void note(std::string text) { mending_.notes.push_back(std::move(text)); }

  void mend_wild(std::vector<double>& values, double noise, double least, double least_share_of_spikes,
                 const char* what) {
    if (noise <= 0.0) return;
    std::size_t samples = 0;
    std::size_t first = count_;
    const auto mend_those = [&](std::vector<Stretch> wild) {
      std::erase_if(wild, [&](const Stretch& one) { return is_cut(one); });
      for (const Stretch& one : wild) {
        interpolate(values, one);
        samples += one.end - one.first;
        first = std::min(first, one.first);
      }
    };
    mend_those(wild_samples(values, noise, least));
    mend_those(spikes(values, noise, least_share_of_spikes));
    if (samples == 0) return;
    if (share(samples) > kMostMended) {
      throw InputError(fmt::format(
          "{}: {} of {} samples of the {} are wild, the first at {}; check the cable and the shield and "
          "record again",
          printable(log_.path), samples, count_, what, at(first)));
    }
    note(fmt::format("{} wild {} of the {} interpolated, the first at {}", samples,
                     samples == 1 ? "sample" : "samples", what, at(first)));
  }

  bool is_cut(const Stretch& one) const {
    return std::any_of(mending_.cut.begin(), mending_.cut.end(), [&](const Stretch& cut) {
      return one.first < cut.end + kHalfWindow && one.end + kHalfWindow > cut.first;
    });
  }

  /// Both force and position as the sample before: lost by the recorder, which wrote the last one again.
  void mend_repeats() {
    std::vector<Stretch> repeats;
    std::size_t samples = 0;
    for (std::size_t i = 1; i < count_; ++i) {
      if (log_.force_N[i] != log_.force_N[i - 1] || log_.position_m[i] != log_.position_m[i - 1]) continue;
      Stretch run{i, i + 1};
      while (run.end < count_ && log_.force_N[run.end] == log_.force_N[i] &&
             log_.position_m[run.end] == log_.position_m[i])
        ++run.end;
      if (run.end - run.first + 1 < kFrozen && !is_cut(run)) {
        samples += run.end - run.first;
        repeats.push_back(run);
      }
      i = run.end;
    }
    // Neighbours agree by chance now and then: density of their difference at zero, times the step.
    const double chance = 0.2821 * smallest_step(log_.force_N) / noise_N_ * static_cast<double>(count_);
    if (static_cast<double>(samples) < kFewestRepeats + kBeyondChance * chance || share(samples) > kNature)
      return;
    for (const Stretch& run : repeats) {
      interpolate(log_.force_N, run);
      interpolate(log_.position_m, run);
      if (step_m_ <= 0.0) continue;
      for (std::size_t i = run.first; i < run.end; ++i) {
        log_.position_m[i] = step_m_ * std::round(log_.position_m[i] / step_m_);
      }
    }
    note(fmt::format("{} samples repeat the one before and were interpolated, the first at {}", samples,
                     at(repeats.front().first)));
  }

  /// Whether the force is constant in these stretches as it is nearly always while the axis rests.
  bool rests_without_noise(const std::vector<Stretch>& constant) const {
    std::size_t rest = 0;
    for (std::size_t i = 0; i < count_;) {
      std::size_t end = i + 1;
      while (end < count_ && std::abs(log_.position_m[end] - log_.position_m[i]) <= 1.5 * step_m_) ++end;
      if (end - i >= kRest) rest += end - i;
      i = end;
    }
    std::size_t samples = 0;
    for (const Stretch& one : constant) samples += one.end - one.first;
    return constant.size() > 1 &&
           static_cast<double>(samples) > kRestsWithoutNoise * static_cast<double>(rest);
  }

  void cut_frozen_force() {
    const auto [low, high] = std::minmax_element(log_.force_N.begin(), log_.force_N.end());
    const double lowest = *low;
    const double highest = *high;
    std::vector<Stretch> limited, frozen, at_rest;
    for (std::size_t i = 0; i < count_;) {
      std::size_t end = i + 1;
      while (end < count_ && log_.force_N[end] == log_.force_N[i]) ++end;
      if (end - i >= kFrozen) {
        const bool at_limit = log_.force_N[i] == lowest || log_.force_N[i] == highest;
        const auto from = log_.position_m.begin() + static_cast<std::ptrdiff_t>(i);
        const bool rests = std::all_of(from, from + static_cast<std::ptrdiff_t>(end - i),
                                       [&](double x) { return std::abs(x - *from) <= 1.5 * step_m_; });
        (rests ? at_rest : at_limit ? limited : frozen).push_back({i, end});
      }
      i = end;
    }
    noise_at_rest_ = !rests_without_noise(at_rest);
    if (noise_at_rest_) frozen.insert(frozen.end(), at_rest.begin(), at_rest.end());
    cut(limited, "the force is at its limit");
    cut(frozen, "the force is frozen");
  }

  void cut_stuck_encoder() {
    const std::vector<double>& x = log_.position_m;
    std::vector<Stretch> stuck;
    for (std::size_t i = 0; i < count_;) {
      std::size_t end = i + 1;
      while (end < count_ && x[end] == x[i]) ++end;
      if (end - i >= kStuck && end + kStuck < count_) {
        const double jump_m = std::abs(x[end] - x[end - 1]);
        std::vector<double> next;
        next.reserve(kStuck);
        for (std::size_t k = end + 1; k <= end + kStuck; ++k) next.push_back(std::abs(x[k] - x[k - 1]));
        if (jump_m > kJump * std::max(step_m_, median(std::move(next))) && jump_m > 0.0) {
          stuck.push_back({i, end + 1});
        }
      }
      i = end;
    }
    cut(stuck, "the position stands still and then jumps (encoder stuck)");
    if (const auto last = stuck_to_the_end()) {
      cut({*last}, "the position stands still to the end of the log, the axis does not (encoder stuck)");
    }
  }

  /// The last stretch of one position, where the axis cannot have stood: it came in at speed and stopped
  /// within a sample, or the force does there what it does nowhere else while the position stands.
  std::optional<Stretch> stuck_to_the_end() const {
    const std::vector<double>& x = log_.position_m;
    std::size_t first = count_ - 1;
    while (first > 0 && x[first - 1] == x[first]) --first;
    if (count_ - first < kStuck || first < 2 * kStuck) return {};
    std::vector<double> before;
    before.reserve(kStuck);
    for (std::size_t k = first - kStuck; k < first; ++k) before.push_back(std::abs(x[k] - x[k - 1]));
    const double slowest_m = *std::min_element(before.end() - 4, before.end());
    const bool at_speed =
        slowest_m > kSpeed * std::max(step_m_, 1e-12) && slowest_m > 0.5 * median(std::move(before));
    if (at_speed || force_range_N(first, count_) > kForceStands * largest_standing_range_N(first)) {
      return Stretch{first, count_};
    }
    return {};
  }

  /// Between the twentieth parts at either end of the values, so that noise and single samples do not count.
  double force_range_N(std::size_t first, std::size_t end) const {
    std::vector<double> values(log_.force_N.begin() + static_cast<std::ptrdiff_t>(first),
                               log_.force_N.begin() + static_cast<std::ptrdiff_t>(end));
    std::sort(values.begin(), values.end());
    return values[values.size() - 1 - values.size() / 20] - values[values.size() / 20];
  }

  /// The largest range of the force in any earlier stretch of one position, or a quarter of that of the whole
  /// log.
  double largest_standing_range_N(std::size_t before) const {
    const std::vector<double>& x = log_.position_m;
    double largest = 0.25 * force_range_N(0, count_);
    for (std::size_t i = 0; i < before;) {
      std::size_t end = i + 1;
      while (end < before && x[end] == x[i]) ++end;
      if (end - i >= kStuck) largest = std::max(largest, force_range_N(i, end));
      i = end;
    }
    return largest;
  }

  void cut_forceless_motion() {
    const auto window = static_cast<std::size_t>(std::max(50.0, kForceless_s * log_.sample_rate_Hz));
    if (noise_N_ <= 0.0 || rms(log_.force_N) < kForceSeen * noise_N_) return;
    std::vector<Stretch> idle;
    std::size_t samples = 0;
    for (std::size_t first = 0; first + window <= count_; first += window / 2) {
      double sum = 0.0;
      double lowest = log_.position_m[first];
      double highest = lowest;
      for (std::size_t i = first; i < first + window; ++i) {
        sum += log_.force_N[i] * log_.force_N[i];
        lowest = std::min(lowest, log_.position_m[i]);
        highest = std::max(highest, log_.position_m[i]);
      }
      const double most = kForcelessNoise * noise_N_;
      const double travel_m = std::max(kForcelessTravel * step_m_, 1e-4);
      if (sum > most * most * static_cast<double>(window) || highest - lowest < travel_m) continue;
      if (!idle.empty() && first <= idle.back().end) {
        idle.back().end = first + window;
      } else {
        idle.push_back({first, first + window});
      }
    }
    for (const Stretch& one : idle) samples += one.end - one.first;
    if (share(samples) > kNature) return;
    // A window at the edge held still some force: half of one more goes.
    for (Stretch& one : idle) {
      one.first = one.first > window / 2 ? one.first - window / 2 : 0;
      one.end = std::min(count_, one.end + window / 2);
    }
    cut(idle, "the axis moves without any force (drive off)");
  }

  void cut(const std::vector<Stretch>& stretches, const char* why) {
    if (stretches.empty()) return;
    std::size_t samples = 0;
    for (const Stretch& one : stretches) samples += one.end - one.first;
    note(fmt::format("{:.3g} s left out in {} {}, the first at {}: {}",
                     static_cast<double>(samples) / log_.sample_rate_Hz, stretches.size(),
                     stretches.size() == 1 ? "place" : "places", at(stretches.front().first), why));
    mending_.cut.insert(mending_.cut.end(), stretches.begin(), stretches.end());
  }

  void join_cuts() {
    std::vector<Stretch>& cuts = mending_.cut;
    std::sort(cuts.begin(), cuts.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<Stretch> joined;
    std::size_t samples = 0;
    for (const Stretch& one : cuts) {
      if (!joined.empty() && one.first <= joined.back().end) {
        joined.back().end = std::max(joined.back().end, one.end);
      } else {
        joined.push_back(one);
      }
    }
    for (const Stretch& one : joined) samples += one.end - one.first;
    if (share(samples) > kMostCut) {
      throw InputError(fmt::format("{}: {:.0f} % of the log cannot be used: {}; record again",
                                   printable(log_.path), 100.0 * share(samples),
                                   mending_.notes.empty() ? "" : mending_.notes.back()));
    }
    cuts = std::move(joined);
  }

  Log& log_;
  std::size_t count_;
  double noise_N_;
  double step_m_;
  bool noise_at_rest_ = true;  ///< or a force that is constant while the axis rests
  Mending mending_;
};

}  // namespace

Mending mend(Log& log, Mended what) {
  if (what == Mended::whole_log) return Mender(log).run();
  Log as_it_was = log;
  try {
    return Mender(log).run();
  } catch (const InputError&) {
    log = std::move(as_it_was);
    return {{{0, log.position_m.size()}}, {}};
  }
}

}  // namespace slipstack::workbench
