// SPDX-License-Identifier: Apache-2.0
#include "workbench/identify/row_filter.h"

#include <algorithm>
#include <cstring>

#include "workbench/identify/zero_phase.h"

namespace slipstack::workbench {
namespace {

/// Samples of a chunk, about: fits the first-level cache with the effect's state.
constexpr std::size_t kChunk = 2048;

/// A mean over this part of a period of the bandwidth droops by 5 % there, alike for all.
constexpr double kMeansPerCycle = 6.0;

}  // namespace

RowFilter::RowFilter(double bandwidth_Hz, double rate_Hz) {
  const auto largest = static_cast<std::size_t>(rate_Hz / (kMeansPerCycle * bandwidth_Hz));
  group_ = std::max<std::size_t>(1, largest - (largest % 2 == 0 ? 1 : 0));
  if (largest == 0) group_ = 1;
  stage_ = low_pass_taps(bandwidth_Hz, rate_Hz / static_cast<double>(group_));
  for (double& tap : stage_) tap /= static_cast<double>(group_);
  for (const double tap : stage_) taps_.insert(taps_.end(), group_, tap);
}

RowCollector::RowCollector(const RowFilter& filter, const std::vector<std::size_t>& row_samples,
                           std::size_t columns)
    : filter_(filter),
      row_samples_(row_samples),
      chunk_(kChunk / filter.group() * filter.group()),
      raw_(columns, std::vector<double>(chunk_)),
      means_(columns, std::vector<double>(filter.stage().size() + chunk_ / filter.group())),
      rows_(static_cast<Eigen::Index>(row_samples.size()), static_cast<Eigen::Index>(columns)) {}

void RowCollector::commit(std::size_t count) {
  const std::size_t group = filter_.group();
  const std::size_t groups = count / group;
  for (std::size_t c = 0; c < raw_.size(); ++c) {
    const double* from = raw_[c].data();
    double* to = means_[c].data() + held_;
    for (std::size_t g = 0; g < groups; ++g, from += group) {
      double sum = 0.0;
      for (std::size_t i = 0; i < group; ++i) sum += from[i];
      to[g] = sum;
    }
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
