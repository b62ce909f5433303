// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/excerpt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {
namespace {

/// Kinds of motion; an interval is described by the number of envelope points of each kind.
constexpr std::size_t kPlaces = 16;
constexpr std::size_t kSpeeds = 24;  ///< by octaves, either way
constexpr std::size_t kAccelerations = 12;
constexpr std::size_t kTimes = 8;
constexpr std::size_t kKinds = kPlaces + kSpeeds + kAccelerations + kTimes + 2;
using MotionCounts = std::array<std::uint16_t, kKinds>;

/// Samples of the shortest and of the longest interval; an excerpt has at least kFewest intervals. Chosen.
constexpr std::size_t kShortest = 64 * kEnvelopeSamples;
constexpr std::size_t kFewest = 6;
constexpr std::size_t kLongest = kExcerptSamples / kEnvelopeSamples / kFewest * kEnvelopeSamples;
/// At most so many intervals of one log are candidates, evenly spread: 1.3e8 samples of the shortest.
constexpr std::size_t kMostIntervals = 16384;
/// Longest burn-in of an interval [samples].
constexpr std::size_t kLongestExcerptBurnIn = kExcerptSamples / 4;
/// An interval should cover the pre-sliding travel so many times; chosen.
constexpr std::size_t kSweeps = 6;

struct Extent {
  float low = std::numeric_limits<float>::infinity();
  float high = -std::numeric_limits<float>::infinity();
  void take(const EnvelopePoint& point) {
    low = std::min(low, point.low_m);
    high = std::max(high, point.high_m);
  }
  float length() const { return high - low; }
};

/// Octave of a magnitude below the largest, as an index below `count`.
std::size_t octave(float magnitude, float largest, std::size_t count) {
  if (!(magnitude > 0.0F)) return count - 1;
  const float below = std::log2(largest / magnitude);
  return std::min(count - 1, static_cast<std::size_t>(std::max(0.0F, below)));
}

class Chooser {
 public:
  explicit Chooser(const std::vector<LongLog>& logs) : logs_(logs) {
    for (const LongLog& log : logs) {
      const Envelope& envelope = log.envelope();
      for (const EnvelopePoint& point : envelope.all()) range_.take(point);
      for (std::size_t i = 1; i < envelope.size(); ++i) {
        const float step = std::abs(envelope[i].first_m - envelope[i - 1].first_m);
        fastest_ = std::max(fastest_, per_shortest(envelope) * step);
      }
    }
  }

  std::vector<LogInterval> run() {
    choose_length();
    for (std::size_t log = 0; log < logs_.size(); ++log) cut(log);
    std::vector<bool> chosen(intervals_.size(), false);
    for (std::size_t log = 0; log < logs_.size(); ++log) {
      choose_best(chosen, [&](std::size_t i) { return intervals_[i].log == log; });
    }
    while (samples_ < kExcerptSamples && choose_best(chosen, [](std::size_t) { return true; })) {
    }
    std::vector<LogInterval> result;
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
      if (chosen[i]) result.push_back(intervals_[i]);
    }
    return joined(std::move(result), {});
  }

 private:
  /// kSweeps times the time that the axis takes to cover its pre-sliding travel. Of these times the median
  /// weighted by time is used: in a log of moves and dwells the moves contain most of the sweeps, the dwells
  /// most of the time.
  void choose_length() {
    const auto sweep = static_cast<float>(burn_in_travel_m(static_cast<double>(range_.length())));
    std::map<std::size_t, std::size_t> sweeps;  // number of sweeps by their samples: few different lengths
    for (const LongLog& log : logs_) {
      const Envelope& envelope = log.envelope();
      Extent swept;
      std::size_t since = 0;
      for (std::size_t i = 0; i < envelope.size(); ++i) {
        swept.take(envelope[i]);
        if (swept.length() < sweep) continue;
        ++sweeps[(i - since + 1) * envelope.samples()];
        since = i;
        swept = {};
      }
    }
    std::size_t all = 0;
    for (const auto& [samples, count] : sweeps) all += samples * count;
    std::size_t passed = 0;
    for (const auto& [samples, count] : sweeps) {
      passed += samples * count;
      if (2 * passed < all) continue;
      length_ = std::clamp(kSweeps * samples, kShortest, kLongest);
      return;
    }
    length_ = kLongest;
  }

  void cut(std::size_t log) {
    const std::size_t envelope = logs_[log].envelope().size();
    const std::size_t samples = logs_[log].envelope().samples();
    const std::size_t count = std::clamp<std::size_t>(envelope * samples / length_, 1, envelope);
    const std::size_t step = 1 + (count - 1) / kMostIntervals;
    for (std::size_t i = 0; i < count; i += step) {
      const std::size_t from = envelope * i / count;
      const std::size_t to = envelope * (i + 1) / count;
      const std::size_t first = burn_in_start(logs_[log], from * samples, kLongestExcerptBurnIn);
      const std::size_t end = std::min(to * samples, logs_[log].sample_count());
      intervals_.push_back({log, first, end - first});
      shown_.push_back(shown(logs_[log].envelope(), from, to));
    }
  }

  /// Converts a displacement from point to point into one within kEnvelopeSamples, at the mean speed.
  static float per_shortest(const Envelope& envelope) {
    return static_cast<float>(kEnvelopeSamples) / static_cast<float>(envelope.samples());
  }

  MotionCounts shown(const Envelope& envelope, std::size_t from, std::size_t to) const {
    const float per = per_shortest(envelope);
    MotionCounts kinds{};
    for (std::size_t i = std::max<std::size_t>(from, 1); i + 1 < to; ++i) {
      const float place = (envelope[i].first_m - range_.low) / range_.length();
      std::size_t at = 0;
      ++kinds[at + std::min(kPlaces - 1, static_cast<std::size_t>(place * static_cast<float>(kPlaces)))];
      at += kPlaces;
      const float step = per * (envelope[i + 1].first_m - envelope[i].first_m);
      const float before = per * (envelope[i].first_m - envelope[i - 1].first_m);
      const std::size_t speed = octave(std::abs(step), fastest_, kSpeeds / 2);
      ++kinds[at + (step < 0.0F ? kSpeeds / 2 : 0) + speed];
      at += kSpeeds;
      ++kinds[at + octave(std::abs(step - before), fastest_, kAccelerations)];
      at += kAccelerations;
      ++kinds[at + kTimes * i / envelope.size()];
      at += kTimes;
      if (step * before < 0.0F) ++kinds[at];
      if (envelope[i].high_m > envelope[i].low_m) ++kinds[at + 1];  // in motion
    }
    return kinds;
  }

  template <class Allowed>
  bool choose_best(std::vector<bool>& chosen, Allowed&& allowed) {
    std::size_t best = intervals_.size();
    float most = -1.0F;
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
      if (chosen[i] || !allowed(i)) continue;
      float gain = 0.0F;
      for (std::size_t k = 0; k < kKinds; ++k) {
        gain += std::sqrt(so_far_[k] + static_cast<float>(shown_[i][k])) - std::sqrt(so_far_[k]);
      }
      if (gain > most) {
        most = gain;
        best = i;
      }
    }
    if (best == intervals_.size()) return false;
    chosen[best] = true;
    for (std::size_t k = 0; k < kKinds; ++k) so_far_[k] += static_cast<float>(shown_[best][k]);
    samples_ += intervals_[best].count;
    return true;
  }

  const std::vector<LongLog>& logs_;
  Extent range_;
  float fastest_ = 0.0F;           ///< largest displacement within kEnvelopeSamples
  std::size_t length_ = kLongest;  ///< of an interval, in samples
  std::vector<LogInterval> intervals_;
  std::vector<MotionCounts> shown_;
  std::array<float, kKinds> so_far_{};
  std::size_t samples_ = 0;  ///< chosen
};

}  // namespace

std::size_t burn_in_start(const LongLog& log, std::size_t sample, std::size_t longest) {
  const auto needed_m = static_cast<float>(burn_in_travel_m(log.travel_m()));
  Extent swept;
  const Envelope& envelope = log.envelope();
  std::size_t point = sample / envelope.samples();
  const std::size_t settling = settling_samples(log.head().sample_rate_Hz);
  const std::size_t converged = (sample > settling ? sample - settling : 0) / envelope.samples();
  const std::size_t earliest = (sample > longest ? sample - longest : 0) / envelope.samples();
  while (point > earliest && (point > converged || !(swept.length() > needed_m)))
    swept.take(envelope[--point]);
  return std::min(sample, point * envelope.samples());
}

std::vector<LogInterval> searched_intervals(const std::vector<LongLog>& logs) {
  std::size_t samples = 0;
  std::vector<LogInterval> all;
  for (const LongLog& log : logs) {
    all.push_back({all.size(), 0, log.sample_count()});
    samples += log.sample_count();
  }
  return samples > kSearchedWhole ? choose_intervals(logs) : all;
}

std::vector<LogInterval> choose_intervals(const std::vector<LongLog>& logs) {
  return Chooser(logs).run();
}

std::vector<LogInterval> joined(std::vector<LogInterval> intervals, const std::vector<LogInterval>& more) {
  intervals.insert(intervals.end(), more.begin(), more.end());
  std::sort(intervals.begin(), intervals.end(), [](const LogInterval& a, const LogInterval& b) {
    return std::tuple(a.log, a.first) < std::tuple(b.log, b.first);
  });
  std::vector<LogInterval> result;
  for (const LogInterval& one : intervals) {
    const std::size_t end = one.first + one.count;
    if (!result.empty() && result.back().log == one.log &&
        result.back().first + result.back().count >= one.first) {
      result.back().count = std::max(result.back().first + result.back().count, end) - result.back().first;
    } else {
      result.push_back(one);
    }
  }
  return result;
}

std::vector<LogChunk> chunks_of(const std::vector<LongLog>& logs, const std::vector<LogInterval>& intervals) {
  std::vector<LogChunk> chunks;
  chunks.reserve(intervals.size());
  for (const LogInterval& one : intervals) {
    const LongLog& log = logs[one.log];
    LogChunk chunk{log.chunk(one.first, one.count), one.log, one.first, log.sample_count(), log.travel_m()};
    chunk.log.notes = log.head().notes;
    chunk.log.header = log.head().header;
    chunks.push_back(std::move(chunk));
  }
  return chunks;
}

}  // namespace slipstack::workbench
