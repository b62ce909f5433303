// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace slipstack::workbench {

/// Where the axis was during some samples: enough to tell how it moved, at a hundredth of the size.
struct EnvelopePoint {
  float first_m = 0.0F;
  float low_m = 0.0F;
  float high_m = 0.0F;
};

/// Samples of one glance at first, and so many glances at most: 1.3e8 samples.
inline constexpr std::size_t kEnvelopeSamples = 128;
inline constexpr std::size_t kMostEnvelopePoints = std::size_t{1} << 20;

/// Envelope of positions that come in any number at a time, the last for what is left. Where they become too
/// many, two become one, so that memory ends at 12 bytes x `most` however long the log.
class Envelope {
 public:
  explicit Envelope(std::size_t most = kMostEnvelopePoints) : most_(most / 2 * 2) {}
  /// As they were found elsewhere, each of so many samples.
  Envelope(std::vector<EnvelopePoint> all, std::size_t samples) : all_(std::move(all)), samples_(samples) {}

  void take(const std::vector<double>& position_m);

  /// Samples of each: kGlanceSamples times a power of two.
  std::size_t samples() const { return samples_; }
  const std::vector<EnvelopePoint>& all() const { return all_; }
  std::size_t size() const { return all_.size(); }
  const EnvelopePoint& operator[](std::size_t index) const { return all_[index]; }

 private:
  void join_pairs();

  std::vector<EnvelopePoint> all_;
  std::size_t samples_ = kEnvelopeSamples;
  std::size_t most_ = kMostEnvelopePoints;
  std::size_t in_last_ = kEnvelopeSamples;  ///< samples of the last; none yet where it is full
};

}  // namespace slipstack::workbench
