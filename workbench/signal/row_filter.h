// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace slipstack::workbench {

/// The zero-phase low-pass between samples and rows, in two stages to save time: a triangular mean for each
/// group of neighbouring samples, then a symmetric FIR over the means. Together they are one symmetric FIR,
/// taps(), evaluated at the rows only; force and regressors pass exactly the same filter.
class RowFilter {
 public:
  RowFilter() = default;
  RowFilter(double bandwidth_Hz, double rate_Hz);

  /// Samples in one group: the weights of a mean fall to zero this far on either side of the group's first
  /// sample. Rows must lie on first samples of groups: sample % group() == 0.
  std::size_t group() const { return group_; }
  /// FIR over the means.
  const std::vector<double>& stage() const { return stage_; }
  /// Both stages as one FIR over samples.
  const std::vector<double>& taps() const { return taps_; }

 private:
  std::size_t group_ = 1;
  std::vector<double> stage_;
  std::vector<double> taps_;
};

/// Filters columns of samples to rows while the samples are produced; keeps no more than one filter length.
class RowCollector {
 public:
  RowCollector(const RowFilter& filter, const std::vector<std::size_t>& row_samples, std::size_t columns);

  /// Samples of one chunk.
  std::size_t chunk() const { return chunk_; }
  /// Room for the next `chunk()` samples: space()[sample * columns + column].
  double* space() { return raw_.data(); }
  /// Processes `count` samples in the space: chunk() of them, fewer only at the end.
  void commit(std::size_t count);
  /// rows x columns.
  Eigen::MatrixXd take() { return std::move(rows_); }

 private:
  void take_means(std::size_t groups);
  void filter_rows();

  const RowFilter& filter_;
  const std::vector<std::size_t>& row_samples_;
  std::size_t columns_;
  std::size_t stride_;  ///< of means_: whole vectors of four columns, or one column
  std::size_t chunk_;
  std::vector<double> raw_;      ///< [sample][column], and as much as a vector reaches beyond the last
  std::vector<double> means_;    ///< triangular sums around the groups' first samples, [group][stride]
  std::vector<double> rising_;   ///< contribution of the last group to the next mean, [column]
  std::size_t first_group_ = 0;  ///< index of the first group in means_
  std::size_t held_ = 0;         ///< groups in means_
  std::size_t next_row_ = 0;
  Eigen::MatrixXd rows_;
};

}  // namespace slipstack::workbench
