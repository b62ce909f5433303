// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/row_filter.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <type_traits>
#include <utility>

#include "workbench/base/wide_vectors.h"
#include "workbench/signal/zero_phase.h"

namespace slipstack::workbench {
namespace {

/// Samples of a chunk of one column, rounded down to whole groups: 16 KiB, which stays in a first-level cache
/// of 32 KiB together with an effect's state. Of many columns fewer samples, 64 KiB in all.
constexpr std::size_t kRowChunk = 2048;
constexpr std::size_t kRowValues = 8192;
/// Chunks whose means are held before those that are no longer needed are dropped.
constexpr std::size_t kHeldChunks = 8;

std::size_t chunk_of(std::size_t group, std::size_t columns) {
  const std::size_t samples = std::min(kRowChunk, kRowValues / std::max<std::size_t>(columns, 1));
  return std::max<std::size_t>(samples / group, 1) * group;
}

/// Sums of `length` taps x values, of 4 * kVectors columns: value k of column c at values[k * stride + c].
/// Eight partial sums in all, since each addition waits for the one before it.
template <std::size_t kVectors>
[[gnu::always_inline]] inline void weighted_sums(const double* taps, std::size_t length, const double* values,
                                                 std::size_t stride, double* sums) {
  constexpr std::size_t kPartial = 8 / kVectors;
  FourDoubles partial[kPartial][kVectors] = {};
  std::size_t k = 0;
  for (; k + kPartial <= length; k += kPartial) {
    for (std::size_t p = 0; p < kPartial; ++p) {
      for (std::size_t v = 0; v < kVectors; ++v) {
        FourDoubles value;
        load(value, values + (k + p) * stride + 4 * v);
        partial[p][v] += taps[k + p] * value;
      }
    }
  }
  for (; k < length; ++k) {
    for (std::size_t v = 0; v < kVectors; ++v) {
      FourDoubles value;
      load(value, values + k * stride + 4 * v);
      partial[0][v] += taps[k] * value;
    }
  }
  for (std::size_t v = 0; v < kVectors; ++v) {
    for (std::size_t p = 1; p < kPartial; ++p) partial[0][v] += partial[p][v];
    std::memcpy(sums + 4 * v, &partial[0][v], sizeof(FourDoubles));
  }
}

/// Triangular means of the groups of a chunk, of one column: half of each group falls to its own mean, the
/// rest, `rising`, to the next. kGroups groups at once, since each addition waits for the one before it; the
/// order of the sums is the same.
[[gnu::always_inline]] inline void triangular_means(const double* from, std::size_t groups, std::size_t group,
                                                    double* mean, double& rising) {
  const double share = 1.0 / static_cast<double>(group);
  constexpr std::size_t kGroups = 8;
  double next = rising;
  std::size_t g = 0;
  for (; g + kGroups <= groups; g += kGroups, from += kGroups * group) {
    double later[kGroups] = {};
    for (std::size_t i = 0; i < group; ++i) {
      const double up = share * static_cast<double>(i);
      for (std::size_t k = 0; k < kGroups; ++k) later[k] += up * from[k * group + i];
    }
    double own[kGroups];
    own[0] = std::exchange(next, later[kGroups - 1]);
    for (std::size_t k = 1; k < kGroups; ++k) own[k] = later[k - 1];
    for (std::size_t i = 0; i < group; ++i) {
      const double down = 1.0 - share * static_cast<double>(i);
      for (std::size_t k = 0; k < kGroups; ++k) own[k] += down * from[k * group + i];
    }
    std::memcpy(mean + g, own, sizeof(own));
  }
  for (; g < groups; ++g) {
    double own = std::exchange(next, 0.0);
    for (std::size_t i = 0; i < group; ++i, ++from) {
      const double up = share * static_cast<double>(i);
      own += (1.0 - up) * *from;
      next += up * *from;
    }
    mean[g] = own;
  }
  rising = next;
}

/// The same of 4 * kVectors columns of [sample][columns], into [group][stride]. What lies behind the last
/// column goes through it like a column of its own; nobody reads its means.
template <std::size_t kVectors>
[[gnu::always_inline]] inline void triangular_means(const double* from, std::size_t groups, std::size_t group,
                                                    std::size_t columns, double* mean, std::size_t stride,
                                                    double* rising) {
  const double share = 1.0 / static_cast<double>(group);
  FourDoubles next[kVectors];
  for (std::size_t v = 0; v < kVectors; ++v) load(next[v], rising + 4 * v);
  for (std::size_t g = 0; g < groups; ++g, mean += stride) {
    FourDoubles own[kVectors];
    for (std::size_t v = 0; v < kVectors; ++v) {
      own[v] = next[v];
      next[v] = FourDoubles{};
    }
    for (std::size_t i = 0; i < group; ++i, from += columns) {
      const double up = share * static_cast<double>(i);
      const double down = 1.0 - up;
      for (std::size_t v = 0; v < kVectors; ++v) {
        FourDoubles value;
        load(value, from + 4 * v);
        own[v] += down * value;
        next[v] += up * value;
      }
    }
    for (std::size_t v = 0; v < kVectors; ++v) std::memcpy(mean + 4 * v, &own[v], sizeof(FourDoubles));
  }
  for (std::size_t v = 0; v < kVectors; ++v) std::memcpy(rising + 4 * v, &next[v], sizeof(FourDoubles));
}

/// A triangular mean reaches this part of a period of the bandwidth to either side. Its gain at the bandwidth
/// is 9 % below one, for force and regressors alike. Components above half the rate of the means are aliased
/// into the band; the triangle attenuates them to 4 %. Plain means would leave a fifth, and the aliases of
/// the force would differ from those of an acceleration that was band-limited before.
constexpr double kMeansPerCycle = 6.0;

}  // namespace

RowFilter::RowFilter(double bandwidth_Hz, double rate_Hz) {
  group_ = std::max<std::size_t>(1, static_cast<std::size_t>(rate_Hz / (kMeansPerCycle * bandwidth_Hz)));
  const auto group = static_cast<std::ptrdiff_t>(group_);
  stage_ = low_pass_taps(bandwidth_Hz, rate_Hz / static_cast<double>(group_));
  for (double& tap : stage_) tap /= static_cast<double>(group_);
  taps_.assign((stage_.size() + 1) * group_ - 1, 0.0);
  for (std::size_t k = 0; k < stage_.size(); ++k) {
    for (std::ptrdiff_t i = 1 - group; i < group; ++i) {
      const double side = 1.0 - static_cast<double>(std::abs(i)) / static_cast<double>(group);
      taps_[static_cast<std::size_t>(static_cast<std::ptrdiff_t>((k + 1) * group_) - 1 + i)] +=
          stage_[k] * side;
    }
  }
}

RowCollector::RowCollector(const RowFilter& filter, const std::vector<std::size_t>& row_samples,
                           std::size_t columns)
    : filter_(filter),
      row_samples_(row_samples),
      columns_(columns),
      stride_(columns == 1 ? 1 : (columns + 3) / 4 * 4),
      chunk_(chunk_of(filter.group(), columns)),
      raw_(chunk_ * columns + stride_ - columns),
      means_((filter.stage().size() + kHeldChunks * chunk_ / filter.group()) * stride_),
      rising_(stride_, 0.0),
      rows_(static_cast<Eigen::Index>(row_samples.size()), static_cast<Eigen::Index>(columns)) {}

void RowCollector::take_means(std::size_t groups) {
  double* const means = means_.data() + held_ * stride_;
  run_wide([&] {
    if (columns_ == 1) {
      triangular_means(raw_.data(), groups, filter_.group(), means, rising_.front());
      return;
    }
    const auto tile = [&]<std::size_t kVectors>(std::integral_constant<std::size_t, kVectors>,
                                                std::size_t first) {
      triangular_means<kVectors>(raw_.data() + first, groups, filter_.group(), columns_, means + first,
                                 stride_, rising_.data() + first);
    };
    std::size_t first = 0;
    for (; first + 16 <= stride_; first += 16) tile(std::integral_constant<std::size_t, 4>{}, first);
    for (; first + 8 <= stride_; first += 8) tile(std::integral_constant<std::size_t, 2>{}, first);
    for (; first < stride_; first += 4) tile(std::integral_constant<std::size_t, 1>{}, first);
  });
  held_ += groups;
}

void RowCollector::filter_rows() {
  const double* const taps = filter_.stage().data();
  const std::size_t length = filter_.stage().size();
  const std::size_t half = length / 2;
  std::vector<double> row(stride_);
  run_wide([&] {
    for (; next_row_ < row_samples_.size(); ++next_row_) {
      const std::size_t centre = row_samples_[next_row_] / filter_.group();
      if (centre + half >= first_group_ + held_) break;
      const double* const means = means_.data() + (centre - half - first_group_) * stride_;
      if (columns_ == 1) {
        row[0] = dot_product(taps, means, length);
      } else {
        std::size_t first = 0;
        for (; first + 32 <= stride_; first += 32)
          weighted_sums<8>(taps, length, means + first, stride_, row.data() + first);
        for (; first + 8 <= stride_; first += 8)
          weighted_sums<2>(taps, length, means + first, stride_, row.data() + first);
        for (; first < stride_; first += 4)
          weighted_sums<1>(taps, length, means + first, stride_, row.data() + first);
      }
      for (std::size_t c = 0; c < columns_; ++c)
        rows_(static_cast<Eigen::Index>(next_row_), static_cast<Eigen::Index>(c)) = row[c];
    }
  });
}

void RowCollector::commit(std::size_t count) {
  const std::size_t groups = count / filter_.group();
  take_means(groups);
  filter_rows();
  // What later rows reach is moved to the front only where the next chunk has no room behind it.
  if ((held_ + chunk_ / filter_.group()) * stride_ <= means_.size()) return;
  const std::size_t keep = std::min(held_, filter_.stage().size());
  const std::size_t drop = held_ - keep;
  std::memmove(means_.data(), means_.data() + drop * stride_, keep * stride_ * sizeof(double));
  first_group_ += drop;
  held_ = keep;
}

}  // namespace slipstack::workbench
