// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/views/trace.h"

#include <algorithm>
#include <cmath>

#include "workbench/base/cancel.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kChunk = 262144;  // samples read at a time; a multiple of the finest point

const std::vector<double>& column(const Log& log, Trace::Signal signal) {
  return signal == Trace::Signal::position ? log.position_m : log.force_N;
}

Extremes joined(const Extremes* points, std::size_t count) {
  Extremes all = points[0];
  for (std::size_t i = 1; i < count; ++i) {
    all.low = std::min(all.low, points[i].low);
    all.high = std::max(all.high, points[i].high);
  }
  return all;
}

/// Of values [first, end).
Extremes extremes_of(const std::vector<double>& values, std::size_t first, std::size_t end) {
  const auto [low, high] = std::minmax_element(values.begin() + static_cast<std::ptrdiff_t>(first),
                                               values.begin() + static_cast<std::ptrdiff_t>(end));
  return {static_cast<float>(*low), static_cast<float>(*high)};
}

}  // namespace

Trace::Trace(const LongLog& log)
    : log_(log),
      samples_(log.sample_count()),
      rate_Hz_(log.head().sample_rate_Hz),
      start_s_(log.head().start_time_s) {
  for (auto& levels : levels_) levels.resize(1);
  for (std::size_t first = 0; first < samples_; first += kChunk) {
    throw_if_cancelled();
    take(log.chunk(first, std::min(kChunk, samples_ - first)));
  }
  build_levels();
}

void Trace::take(const Log& chunk) {
  for (std::size_t s = 0; s < kSignals; ++s) {
    const std::vector<double>& values = column(chunk, static_cast<Signal>(s));
    for (std::size_t first = 0; first < values.size(); first += kFinest) {
      levels_[s][0].push_back(extremes_of(values, first, std::min(first + kFinest, values.size())));
    }
  }
}

void Trace::build_levels() {
  for (auto& levels : levels_) {
    while (levels.back().size() > 512) {
      const std::vector<Extremes>& finer = levels.back();
      std::vector<Extremes> coarser;
      coarser.reserve(finer.size() / kRatio + 1);
      for (std::size_t i = 0; i < finer.size(); i += kRatio) {
        coarser.push_back(joined(&finer[i], std::min(kRatio, finer.size() - i)));
      }
      levels.push_back(std::move(coarser));
    }
  }
}

Trace::Picture Trace::from_samples(Signal signal, std::size_t first, std::size_t end,
                                   std::size_t per_point) const {
  // Whole points, the same wherever the picture begins.
  first -= first % per_point;
  end = std::min((end + per_point - 1) / per_point * per_point, samples_);
  const Log part = log_.chunk(first, end - first);
  const std::vector<double>& values = column(part, signal);
  Picture picture{
      static_cast<double>(first) / rate_Hz_, static_cast<double>(per_point) / rate_Hz_, per_point, {}};
  picture.points.reserve(values.size() / per_point + 1);
  for (std::size_t i = 0; i < values.size(); i += per_point) {
    picture.points.push_back(extremes_of(values, i, std::min(i + per_point, values.size())));
  }
  return picture;
}

Trace::Picture Trace::picture(Signal signal, double from_s, double to_s, std::size_t points) const {
  const double last = static_cast<double>(samples_);
  const double from = std::clamp(std::floor(from_s * rate_Hz_), 0.0, last - 1.0);
  const double to = std::clamp(std::ceil(to_s * rate_Hz_) + 1.0, from + 1.0, last);
  const auto first = static_cast<std::size_t>(from);
  const auto end = static_cast<std::size_t>(to);
  const std::size_t per_point = (end - first + points - 1) / std::max<std::size_t>(points, 1);
  if (per_point < kFinest) return from_samples(signal, first, end, per_point);
  // The coarsest level that has as many points as are asked for.
  const auto& levels = levels_[static_cast<std::size_t>(signal)];
  std::size_t level = 0;
  std::size_t size = kFinest;
  while (level + 1 < levels.size() && size * kRatio <= per_point) {
    ++level;
    size *= kRatio;
  }
  const std::size_t begin = first / size;
  const std::size_t stop = std::min((end + size - 1) / size, levels[level].size());
  const std::size_t join = std::max<std::size_t>(1, (stop - begin + points - 1) / points);
  Picture picture{static_cast<double>(begin * size) / rate_Hz_,
                  static_cast<double>(size * join) / rate_Hz_,
                  size * join,
                  {}};
  for (std::size_t i = begin; i < stop; i += join) {
    picture.points.push_back(joined(&levels[level][i], std::min(join, levels[level].size() - i)));
  }
  return picture;
}

}  // namespace slipstack::workbench
