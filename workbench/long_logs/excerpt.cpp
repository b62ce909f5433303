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

/// What a stretch shows, as counts of glances by kind.
constexpr std::size_t kPlaces = 16;
constexpr std::size_t kSpeeds = 24;  ///< by octaves, either way
constexpr std::size_t kAccelerations = 12;
constexpr std::size_t kTimes = 8;
constexpr std::size_t kKinds = kPlaces + kSpeeds + kAccelerations + kTimes + 2;
using Shown = std::array<std::uint16_t, kKinds>;

/// Samples of the shortest stretch and of the longest; stretches that are fewer are longer.
constexpr std::size_t kShortest = 64 * kGlanceSamples;
constexpr std::size_t kFewest = 6;
constexpr std::size_t kLongest = kExcerptSamples / kGlanceSamples / kFewest * kGlanceSamples;
/// Of one log so many stretches at most are looked at, evenly spread: 1.3e8 samples of the shortest.
constexpr std::size_t kMostStretches = 16384;
/// A state that was left so long ago is not looked for, [samples].
constexpr std::size_t kLongestLead = kExcerptSamples / 4;
/// Sweeps of the pre-sliding travel that a stretch should hold.
constexpr std::size_t kSweeps = 6;

struct Extent {
  float low = std::numeric_limits<float>::infinity();
  float high = -std::numeric_limits<float>::infinity();
  void take(const Glance& glance) {
    low = std::min(low, glance.low_m);
    high = std::max(high, glance.high_m);
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
      const Glances& glances = log.glances();
      for (const Glance& glance : glances.all()) stroke_.take(glance);
      for (std::size_t i = 1; i < glances.size(); ++i) {
        const float step = std::abs(glances[i].first_m - glances[i - 1].first_m);
        fastest_ = std::max(fastest_, per_shortest(glances) * step);
      }
    }
  }

  std::vector<LogStretch> run() {
    choose_length();
    for (std::size_t log = 0; log < logs_.size(); ++log) cut(log);
    std::vector<bool> chosen(stretches_.size(), false);
    for (std::size_t log = 0; log < logs_.size(); ++log) {
      choose_best(chosen, [&](std::size_t i) { return stretches_[i].log == log; });
    }
    while (samples_ < kExcerptSamples && choose_best(chosen, [](std::size_t) { return true; })) {
    }
    std::vector<LogStretch> result;
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      if (chosen[i]) result.push_back(stretches_[i]);
    }
    return joined(std::move(result), {});
  }

 private:
  /// The time that the axis takes to sweep its pre-sliding travel, some times over: of all moments the median
  /// moment's, since of a move and a dwell the move holds many sweeps and the dwell most of the time.
  void choose_length() {
    const auto sweep = static_cast<float>(swept_before_known_m(static_cast<double>(stroke_.length())));
    std::map<std::size_t, std::size_t> sweeps;  // how many took so many samples: few lengths, however many
    for (const LongLog& log : logs_) {
      const Glances& glances = log.glances();
      Extent swept;
      std::size_t since = 0;
      for (std::size_t i = 0; i < glances.size(); ++i) {
        swept.take(glances[i]);
        if (swept.length() < sweep) continue;
        ++sweeps[(i - since + 1) * glances.samples()];
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
    const std::size_t glances = logs_[log].glances().size();
    const std::size_t samples = logs_[log].glances().samples();
    const std::size_t count = std::clamp<std::size_t>(glances * samples / length_, 1, glances);
    const std::size_t step = 1 + (count - 1) / kMostStretches;
    for (std::size_t i = 0; i < count; i += step) {
      const std::size_t from = glances * i / count;
      const std::size_t to = glances * (i + 1) / count;
      const std::size_t first = lead_in(logs_[log], from * samples, kLongestLead);
      const std::size_t end = std::min(to * samples, logs_[log].sample_count());
      stretches_.push_back({log, first, end - first});
      shown_.push_back(shown(logs_[log].glances(), from, to));
    }
  }

  /// What makes a way from glance to glance one within the shortest: of longer glances the mean speed.
  static float per_shortest(const Glances& glances) {
    return static_cast<float>(kGlanceSamples) / static_cast<float>(glances.samples());
  }

  Shown shown(const Glances& glances, std::size_t from, std::size_t to) const {
    const float per = per_shortest(glances);
    Shown kinds{};
    for (std::size_t i = std::max<std::size_t>(from, 1); i + 1 < to; ++i) {
      const float way = (glances[i].first_m - stroke_.low) / stroke_.length();
      std::size_t at = 0;
      ++kinds[at + std::min(kPlaces - 1, static_cast<std::size_t>(way * static_cast<float>(kPlaces)))];
      at += kPlaces;
      const float step = per * (glances[i + 1].first_m - glances[i].first_m);
      const float before = per * (glances[i].first_m - glances[i - 1].first_m);
      const std::size_t speed = octave(std::abs(step), fastest_, kSpeeds / 2);
      ++kinds[at + (step < 0.0F ? kSpeeds / 2 : 0) + speed];
      at += kSpeeds;
      ++kinds[at + octave(std::abs(step - before), fastest_, kAccelerations)];
      at += kAccelerations;
      ++kinds[at + kTimes * i / glances.size()];
      at += kTimes;
      if (step * before < 0.0F) ++kinds[at];
      if (glances[i].high_m > glances[i].low_m) ++kinds[at + 1];  // not at rest
    }
    return kinds;
  }

  template <class Allowed>
  bool choose_best(std::vector<bool>& chosen, Allowed&& allowed) {
    std::size_t best = stretches_.size();
    float most = -1.0F;
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
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
    if (best == stretches_.size()) return false;
    chosen[best] = true;
    for (std::size_t k = 0; k < kKinds; ++k) so_far_[k] += static_cast<float>(shown_[best][k]);
    samples_ += stretches_[best].count;
    return true;
  }

  const std::vector<LongLog>& logs_;
  Extent stroke_;
  float fastest_ = 0.0F;           ///< way from glance to glance
  std::size_t length_ = kLongest;  ///< of a stretch, in samples
  std::vector<LogStretch> stretches_;
  std::vector<Shown> shown_;
  std::array<float, kKinds> so_far_{};
  std::size_t samples_ = 0;  ///< chosen
};

}  // namespace

std::size_t lead_in(const LongLog& log, std::size_t sample, std::size_t most) {
  const auto needed_m = static_cast<float>(swept_before_known_m(log.travel_m()));
  Extent swept;
  const Glances& glances = log.glances();
  std::size_t glance = sample / glances.samples();
  const std::size_t settling = settling_samples(log.head().sample_rate_Hz);
  const std::size_t settled = (sample > settling ? sample - settling : 0) / glances.samples();
  const std::size_t earliest = (sample > most ? sample - most : 0) / glances.samples();
  while (glance > earliest && (glance > settled || !(swept.length() > needed_m)))
    swept.take(glances[--glance]);
  return std::min(sample, glance * glances.samples());
}

std::vector<LogStretch> searched_stretches(const std::vector<LongLog>& logs) {
  std::size_t samples = 0;
  std::vector<LogStretch> all;
  for (const LongLog& log : logs) {
    all.push_back({all.size(), 0, log.sample_count()});
    samples += log.sample_count();
  }
  return samples > kSearchedWhole ? choose_stretches(logs) : all;
}

std::vector<LogStretch> choose_stretches(const std::vector<LongLog>& logs) {
  return Chooser(logs).run();
}

std::vector<LogStretch> joined(std::vector<LogStretch> stretches, const std::vector<LogStretch>& more) {
  stretches.insert(stretches.end(), more.begin(), more.end());
  std::sort(stretches.begin(), stretches.end(), [](const LogStretch& a, const LogStretch& b) {
    return std::tuple(a.log, a.first) < std::tuple(b.log, b.first);
  });
  std::vector<LogStretch> result;
  for (const LogStretch& one : stretches) {
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

std::vector<LogPiece> pieces_of(const std::vector<LongLog>& logs, const std::vector<LogStretch>& stretches) {
  std::vector<LogPiece> pieces;
  pieces.reserve(stretches.size());
  for (const LogStretch& one : stretches) {
    const LongLog& log = logs[one.log];
    LogPiece piece{log.piece(one.first, one.count), one.log, one.first, log.sample_count(), log.travel_m()};
    piece.log.notes = log.head().notes;
    piece.log.header = log.head().header;
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

}  // namespace slipstack::workbench
