// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace slipstack::workbench {

/// Position of the axis during some samples: first value, minimum and maximum. A hundredth of the size of the
/// samples.
struct EnvelopePoint {
  float first_m = 0.0F;
  float low_m = 0.0F;
  float high_m = 0.0F;
};

/// Initial number of samples of a point, and largest number of points: together 1.3e8 samples.
inline constexpr std::size_t kEnvelopeSamples = 128;
inline constexpr std::size_t kMostEnvelopePoints = std::size_t{1} << 20;

/// Envelope of positions that are added in portions of any size. Where the points become more than `most`,
/// pairs of them are joined, so that the memory is limited to 12 bytes x `most` for any length of the log.
class Envelope {
 public:
  explicit Envelope(std::size_t most = kMostEnvelopePoints) : most_(most / 2 * 2) {}
  /// Points that another process has found, each of so many samples.
  Envelope(std::vector<EnvelopePoint> all, std::size_t samples) : all_(std::move(all)), samples_(samples) {}

  void take(const std::vector<double>& position_m);

  /// Samples of each point: kEnvelopeSamples times a power of two.
  std::size_t samples() const { return samples_; }
  const std::vector<EnvelopePoint>& all() const { return all_; }
  std::size_t size() const { return all_.size(); }
  const EnvelopePoint& operator[](std::size_t index) const { return all_[index]; }

 private:
  void join_pairs();

  std::vector<EnvelopePoint> all_;
  std::size_t samples_ = kEnvelopeSamples;
  std::size_t most_ = kMostEnvelopePoints;
  std::size_t in_last_ = kEnvelopeSamples;  ///< samples in the last point; samples_: it is complete
};

}  // namespace slipstack::workbench
