// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/csv/raw_table.h"

#include <algorithm>

namespace slipstack::workbench {

std::string RawTable::where_line(std::size_t line) const {
  return line == 0 ? source : source + ":" + std::to_string(line);
}

std::string RawTable::where_row(std::size_t row) const {
  if (anchors.empty()) return source + ": sample " + std::to_string(row + 1);
  const auto behind = std::upper_bound(anchors.begin(), anchors.end(), row,
                                       [](std::size_t r, const Anchor& a) { return r < a.row; });
  if (behind == anchors.begin()) return source;
  const Anchor& anchor = *(behind - 1);
  return where_line(anchor.line + (row - anchor.row));
}

}  // namespace slipstack::workbench
