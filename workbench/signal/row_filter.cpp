// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/row_filter.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "workbench/signal/zero_phase.h"

namespace slipstack::workbench {
namespace {

/// Samples of a chunk, rounded down to whole groups: 16 KiB a column, which stays in a first-level cache of
/// 32 KiB together with an effect's state.
constexpr std::size_t kRowChunk = 2048;

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
      chunk_(kRowChunk / filter.group() * filter.group()),
      raw_(chunk_ * columns),
      means_((filter.stage().size() + chunk_ / filter.group()) * columns),
      rising_(columns, 0.0),
      rows_(static_cast<Eigen::Index>(row_samples.size()), static_cast<Eigen::Index>(columns)) {}

// kColumns: the number of columns at compile time, or 0 for columns_. One column is the common case and then
// needs no inner loop.
template <std::size_t kColumns>
void RowCollector::take_means(std::size_t groups) {
  const std::size_t columns = kColumns == 0 ? columns_ : kColumns;
  const std::size_t group = filter_.group();
  const double share = 1.0 / static_cast<double>(group);
  const double* from = raw_.data();
  double* mean = means_.data() + held_ * columns;
  double* next = rising_.data();
  for (std::size_t g = 0; g < groups; ++g, mean += columns) {
    for (std::size_t c = 0; c < columns; ++c) mean[c] = std::exchange(next[c], 0.0);
    for (std::size_t i = 0; i < group; ++i, from += columns) {
      const double up = share * static_cast<double>(i);
      const double down = 1.0 - up;
      for (std::size_t c = 0; c < columns; ++c) {
        mean[c] += down * from[c];
        next[c] += up * from[c];
      }
    }
  }
  held_ += groups;
}

void RowCollector::filter_rows() {
  const std::size_t half = filter_.stage().size() / 2;
  const auto length = static_cast<Eigen::Index>(filter_.stage().size());
  const auto columns = static_cast<Eigen::Index>(columns_);
  const Eigen::Map<const Eigen::VectorXd> stage(filter_.stage().data(), length);
  Eigen::VectorXd row(columns);
  for (; next_row_ < row_samples_.size(); ++next_row_) {
    const std::size_t centre = row_samples_[next_row_] / filter_.group();
    if (centre + half >= first_group_ + held_) break;
    const double* means = means_.data() + (centre - half - first_group_) * columns_;
    if (columns_ == 1) {
      row(0) = stage.dot(Eigen::Map<const Eigen::VectorXd>(means, length));
    } else {
      row.noalias() = Eigen::Map<const Eigen::MatrixXd>(means, columns, length) * stage;
    }
    rows_.row(static_cast<Eigen::Index>(next_row_)) = row.transpose();
  }
}

void RowCollector::commit(std::size_t count) {
  const std::size_t groups = count / filter_.group();
  columns_ == 1 ? take_means<1>(groups) : take_means<0>(groups);
  filter_rows();
  const std::size_t keep = std::min(held_, filter_.stage().size());
  const std::size_t drop = held_ - keep;
  std::memmove(means_.data(), means_.data() + drop * columns_, keep * columns_ * sizeof(double));
  first_group_ += drop;
  held_ = keep;
}

}  // namespace slipstack::workbench
