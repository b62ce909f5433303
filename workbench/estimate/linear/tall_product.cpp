// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/linear/tall_product.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

#include "workbench/base/wide_vectors.h"

namespace slipstack::workbench {
namespace {

using Eigen::Index;

/// Columns of either side that are multiplied with each other at once, so that each value that is loaded
/// serves four products.
constexpr Index kTallTile = 4;

/// Products of up to four columns of either side: sums[l][r].
template <Index kLeft, Index kRight>
[[gnu::always_inline]] inline void tile_product(const double* left, Index left_stride, const double* right,
                                                Index right_stride, Index rows, double* out,
                                                Index out_stride) {
  FourDoubles partial[kLeft][kRight] = {};
  Index row = 0;
  for (; row + 4 <= rows; row += 4) {
    FourDoubles own[kRight];
    for (Index r = 0; r < kRight; ++r) load(own[r], right + r * right_stride + row);
    for (Index l = 0; l < kLeft; ++l) {
      FourDoubles value;
      load(value, left + l * left_stride + row);
      for (Index r = 0; r < kRight; ++r) partial[l][r] += value * own[r];
    }
  }
  for (Index l = 0; l < kLeft; ++l) {
    for (Index r = 0; r < kRight; ++r) {
      const FourDoubles four = partial[l][r];
      double sum = (four[0] + four[1]) + (four[2] + four[3]);
      for (Index k = row; k < rows; ++k) sum += left[l * left_stride + k] * right[r * right_stride + k];
      out[l + r * out_stride] = sum;
    }
  }
}

/// Products of left columns [0, count) with the right ones from `r` on.
template <Index kRight>
[[gnu::always_inline]] inline void product_with(const Eigen::Ref<const Eigen::MatrixXd>& left, Index count,
                                                const Eigen::Ref<const Eigen::MatrixXd>& right, Index r,
                                                Eigen::MatrixXd& product) {
  const double* const own = right.data() + r * right.outerStride();
  Index l = 0;
  for (; l + kTallTile <= count; l += kTallTile) {
    tile_product<kTallTile, kRight>(left.data() + l * left.outerStride(), left.outerStride(), own,
                                    right.outerStride(), left.rows(), &product(l, r), product.outerStride());
  }
  for (; l < count; ++l) {
    tile_product<1, kRight>(left.data() + l * left.outerStride(), left.outerStride(), own,
                            right.outerStride(), left.rows(), &product(l, r), product.outerStride());
  }
}

/// `lower`: only the columns of `left` up to the end of each tile of `right` are wanted.
Eigen::MatrixXd product_of(const Eigen::Ref<const Eigen::MatrixXd>& left,
                           const Eigen::Ref<const Eigen::MatrixXd>& right, bool lower) {
  Eigen::MatrixXd product(left.cols(), right.cols());
  const auto wanted = [&](Index end) { return lower ? end : left.cols(); };
  run_wide([&] {
    Index r = 0;
    for (; r + 2 <= right.cols(); r += 2) product_with<2>(left, wanted(r + 2), right, r, product);
    for (; r < right.cols(); ++r) product_with<1>(left, wanted(r + 1), right, r, product);
  });
  return product;
}

/// Rows whose sums stay in the first-level cache while all columns are added.
constexpr Index kRowTile = 1024;

/// sums[row] += the factors x the values of kColumns columns.
template <std::size_t kColumns>
[[gnu::always_inline]] inline void add_columns(const double* const* columns, const double* factors,
                                               Index rows, double* sums) {
  Index row = 0;
  for (; row + 4 <= rows; row += 4) {
    FourDoubles sum;
    load(sum, sums + row);
    for (std::size_t c = 0; c < kColumns; ++c) {
      FourDoubles value;
      load(value, columns[c] + row);
      sum += factors[c] * value;
    }
    std::memcpy(sums + row, &sum, sizeof(sum));
  }
  for (; row < rows; ++row) {
    for (std::size_t c = 0; c < kColumns; ++c) sums[row] += factors[c] * columns[c][row];
  }
}

}  // namespace

Eigen::VectorXd tall_combination(const Eigen::Ref<const Eigen::MatrixXd>& matrix,
                                 const Eigen::Ref<const Eigen::VectorXd>& factors) {
  std::vector<const double*> columns;
  std::vector<double> own;
  for (Index c = 0; c < matrix.cols(); ++c) {
    if (factors(c) == 0.0) continue;
    columns.push_back(matrix.data() + c * matrix.outerStride());
    own.push_back(factors(c));
  }
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(matrix.rows());
  constexpr std::size_t kAtOnce = 8;
  run_wide([&] {
    for (Index first = 0; first < matrix.rows(); first += kRowTile) {
      const Index rows = std::min(kRowTile, matrix.rows() - first);
      double* const out = sums.data() + first;
      std::size_t c = 0;
      for (; c + kAtOnce <= own.size(); c += kAtOnce) {
        const double* from[kAtOnce];
        for (std::size_t k = 0; k < kAtOnce; ++k) from[k] = columns[c + k] + first;
        add_columns<kAtOnce>(from, own.data() + c, rows, out);
      }
      for (; c < own.size(); ++c) {
        const double* const from = columns[c] + first;
        add_columns<1>(&from, own.data() + c, rows, out);
      }
    }
  });
  return sums;
}

Eigen::MatrixXd tall_product(const Eigen::Ref<const Eigen::MatrixXd>& left,
                             const Eigen::Ref<const Eigen::MatrixXd>& right) {
  return product_of(left, right, false);
}

Eigen::MatrixXd weighted_gram(const Eigen::Ref<const Eigen::MatrixXd>& matrix,
                              const Eigen::Ref<const Eigen::VectorXd>& weights) {
  const Eigen::MatrixXd weighted = weights.asDiagonal() * matrix;
  Eigen::MatrixXd gram = product_of(weighted, matrix, true);
  gram.triangularView<Eigen::StrictlyLower>() = gram.transpose();
  return gram;
}

}  // namespace slipstack::workbench
