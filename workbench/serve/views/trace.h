// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "workbench/long_logs/long_log.h"

namespace slipstack::workbench {

/// Lowest and highest value of some consecutive samples.
struct Extremes {
  float low = 0.0F;
  float high = 0.0F;
};

/// The signals of a whole log as they were recorded, for drawing at any magnification: the extremes of 16,
/// 64, 256, ... samples (a min/max pyramid). Below 16 samples a point the samples are read again.
/// Memory: 2/3 byte for each sample of a signal. Cost of a picture: its points, whatever the log's length.
class Trace {
 public:
  enum class Signal : std::uint8_t { position, force };
  static constexpr std::size_t kSignals = 2;

  /// Reads the log once more, in chunks. Throws InputError.
  explicit Trace(const LongLog& log);

  std::size_t samples() const { return samples_; }
  double rate_Hz() const { return rate_Hz_; }
  double start_s() const { return start_s_; }

  /// What is drawn of [from_s, to_s], times counted from the start of the log: at most `points` + 2 points,
  /// each the extremes of as many samples; the samples themselves where there are no more of them.
  /// Throws InputError where the file is gone.
  struct Picture {
    double first_s = 0.0;  ///< of the first point
    double step_s = 0.0;
    std::size_t samples_per_point = 1;
    std::vector<Extremes> points;
  };
  Picture picture(Signal signal, double from_s, double to_s, std::size_t points) const;

 private:
  static constexpr std::size_t kFinest = 16;  ///< samples of a point of the lowest level
  static constexpr std::size_t kRatio = 4;    ///< points joined to one of the next level

  void take(const Log& chunk);
  void build_levels();
  Picture from_samples(Signal signal, std::size_t first, std::size_t end, std::size_t per_point) const;

  LongLog log_;
  std::size_t samples_ = 0;
  double rate_Hz_ = 0.0;
  double start_s_ = 0.0;
  std::vector<std::vector<Extremes>> levels_[kSignals];
};

}  // namespace slipstack::workbench
