// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/row_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace slipstack::workbench {
namespace {

// The two stages in tiles of columns against the one FIR that they are, for every number of columns that
// makes other tiles, groups of one to many samples, and chunks that end anywhere.
TEST(RowCollector, FiltersEachColumnByTheTaps) {
  std::mt19937_64 random(20);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (const double bandwidth_Hz : {170.0, 40.0, 5.0}) {
    const RowFilter filter(bandwidth_Hz, 1000.0);
    const std::vector<double>& taps = filter.taps();
    const std::size_t half = taps.size() / 2;
    const std::size_t samples = 2 * taps.size() + 3001;
    std::vector<std::size_t> rows;
    const std::size_t first = (half / filter.group() + 2) * filter.group();
    for (std::size_t row = first; row + half + filter.group() < samples; row += 3 * filter.group())
      rows.push_back(row);
    for (const std::size_t columns : {1, 2, 3, 4, 5, 8, 11, 16, 20, 32, 41, 70}) {
      std::vector<double> values(samples * columns);
      for (double& value : values) value = uniform(random);
      RowCollector collector(filter, rows, columns);
      for (std::size_t done = 0; done < samples; done += collector.chunk()) {
        const std::size_t count = std::min(collector.chunk(), samples - done);
        std::copy_n(values.data() + done * columns, count * columns, collector.space());
        collector.commit(count);
      }
      const Eigen::MatrixXd is = collector.take();
      ASSERT_GT(rows.size(), 10U);
      for (std::size_t r = 0; r < rows.size(); r += 7) {
        for (std::size_t c = 0; c < columns; ++c) {
          double should = 0.0;
          for (std::size_t k = 0; k < taps.size(); ++k)
            should += taps[k] * values[(rows[r] + k - half) * columns + c];
          EXPECT_NEAR(is(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)), should, 1e-13)
              << bandwidth_Hz << ' ' << columns << ' ' << r << ' ' << c;
        }
      }
    }
  }
}

}  // namespace
}  // namespace slipstack::workbench
