// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace slipstack::workbench {

// The content of a file before names and units are interpreted: header entries and columns of finite numbers
// of equal length. Both file formats are read into it, so that all further processing is shared.
struct RawTable {
  struct HeaderEntry {
    std::string value;
    std::size_t line = 0;  // 0: the format has no lines
  };
  struct Column {
    std::string name;
    std::vector<double> values;
    double relative_precision = 0.0;  // of the stored numbers, where it is lower than a double's: 2⁻²⁴
  };
  // From row `row` on, row r is on line `line` + (r − row); after comments and blank lines a new anchor
  // follows.
  struct Anchor {
    std::size_t row = 0;
    std::size_t line = 0;
  };

  std::string source;  // the file's name, as error messages show it
  std::map<std::string, HeaderEntry> header;
  std::vector<Column> columns;
  std::size_t names_line = 0;  // line of the header row; 0: no lines
  std::vector<Anchor> anchors;
  std::vector<std::string> notes;

  // "run.csv:17" or, without lines, "run.mat: sample 17" (counted from 1).
  std::string where_row(std::size_t row) const;
  std::string where_names() const { return where_line(names_line); }
  std::string where_line(std::size_t line) const;
};

}  // namespace slipstack::workbench
