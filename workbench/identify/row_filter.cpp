// SPDX-License-Identifier: Apache-2.0
#include "workbench/identify/row_filter.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "workbench/identify/zero_phase.h"

namespace slipstack::workbench {
namespace {

/// Samples of a chunk, about: fits the first-level cache with the effect's state.
constexpr std::size_t kChunk = 2048;

/// Triangular means of this part of a period of the bandwidth on either side: they droop by 9 % there, alike
/// for all. What lies above half the rate of the means folds into the band; the triangle leaves 4 % of it.
/// Plain means leave a fifth, and that of the force is not that of an acceleration which was band-limited
/// before.
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
      chunk_(kChunk / filter.group() * filter.group()),
      raw_(columns, std::vector<double>(chunk_)),
      means_(columns, std::vector<double>(filter.stage().size() + chunk_ / filter.group())),
      rising_(columns, 0.0),
      rows_(static_cast<Eigen::Index>(row_samples.size()), static_cast<Eigen::Index>(columns)) {}

void RowCollector::commit(std::size_t count) {
  const std::size_t group = filter_.group();
  const std::size_t groups = count / group;
  for (std::size_t c = 0; c < raw_.size(); ++c) {
    const double* from = raw_[c].data();
    double* to = means_[c].data() + held_;
    double before = rising_[c];
    for (std::size_t g = 0; g < groups; ++g, from += group) {
      double sum = 0.0;
      double rising = 0.0;
      for (std::size_t i = 0; i < group; ++i) {
        sum += from[i];
        rising += static_cast<double>(i) * from[i];
      }
      rising /= static_cast<double>(group);
      to[g] = before + sum - rising;
      before = rising;
    }
    rising_[c] = before;
  }
  held_ += groups;

  const std::size_t length = filter_.stage().size();
  const std::size_t half = length / 2;
  const Eigen::Map<const Eigen::VectorXd> stage(filter_.stage().data(), static_cast<Eigen::Index>(length));
  for (; next_row_ < row_samples_.size(); ++next_row_) {
    const std::size_t centre = row_samples_[next_row_] / group;
    if (centre + half >= first_group_ + held_) break;
    const std::size_t offset = centre - half - first_group_;
    for (std::size_t c = 0; c < means_.size(); ++c) {
      rows_(static_cast<Eigen::Index>(next_row_), static_cast<Eigen::Index>(c)) =
          stage.dot(Eigen::Map<const Eigen::VectorXd>(means_[c].data() + offset, stage.size()));
    }
  }
  const std::size_t keep = std::min(held_, length);
  const std::size_t drop = held_ - keep;
  for (auto& column : means_) std::memmove(column.data(), column.data() + drop, keep * sizeof(double));
  first_group_ += drop;
  held_ = keep;
}

}  // namespace slipstack::workbench
