// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/log_of_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "workbench/base/text.h"
#include "workbench/log/assemble.h"
#include "workbench/log/csv/columns.h"

namespace slipstack::workbench {

void require_equal_and_finite(const RawTable& table) {
  const RawTable::Column& first = table.columns.front();
  for (const RawTable::Column& column : table.columns) {
    const std::vector<double>& values = column.values;
    if (values.size() != first.values.size()) {
      throw InputError(fmt::format("{}: {} has {} samples, {} has {}; give columns of one length",
                                   printable(table.source), printable(column.name), values.size(),
                                   printable(first.name), first.values.size()));
    }
    const auto bad = std::find_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); });
    if (bad == values.end()) continue;
    const auto row = static_cast<std::size_t>(bad - values.begin());
    throw InputError(fmt::format("{}: column {} is {}; remove or correct the sample", table.where_row(row),
                                 printable(column.name), *bad));
  }
}

Log log_of_table(RawTable table) {
  const std::string path = table.source;
  table.source = printable(path);
  plan_columns(table, read_header_values(table));  // a wrong name is told before a wrong number
  require_equal_and_finite(table);
  Log log = assemble_log(std::move(table));
  log.path = path;
  return log;
}

}  // namespace slipstack::workbench
