// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "workbench/log/byte_source.h"
#include "workbench/log/csv/line_reader.h"
#include "workbench/log/csv/raw_table.h"

namespace slipstack::workbench {

// What a file must hold: an example of its header row for messages, and the check of names, units and header
// values, made before any row is read. It throws InputError.
struct CsvColumns {
  const char* example;
  void (*check)(const RawTable& table);
};

// The columns of a log (columns.h).
extern const CsvColumns kLogColumns;

// Reads `# key: value` lines, one header row and rows of finite numbers, separated by commas; blank lines,
// spaces around fields and comments anywhere are allowed, quotes are not. The columns are checked when the
// header row is read, rows while they are read. `name` stands for the source in error messages. Throws
// InputError. Cost: linear in the bytes read; nothing is parsed after the first fault.
class CsvReader {
 public:
  CsvReader(const std::string& name, ByteSource& source, const CsvColumns& columns = kLogColumns);
  // Continues at a row: `table` comes from a reader of the same file, `source` starts at
  // `place`.
  CsvReader(const RawTable& table, ByteSource& source, LineReader::Place place);

  // The header and up to `maximum` further rows; fewer only at the end of the text.
  RawTable rows(std::size_t maximum);
  // Skips rows.
  void skip(std::size_t count);
  // Where the next row, or a comment before it, begins.
  LineReader::Place place() const { return lines_.place(); }

  // Header and column names only.
  static RawTable without_rows(const RawTable& table);

 private:
  std::string here() const { return table_.where_line(lines_.line_number()); }
  bool next_line();
  void read_header();
  void take_comment(std::string_view text);
  void take_names(std::string_view text);
  void take_row();
  void note_line();
  [[noreturn]] void refuse_row() const;
  void note_oddities();

  CsvColumns columns_ = kLogColumns;
  LineReader lines_;
  std::string_view line_;
  RawTable table_;
  std::size_t rows_ = 0;  // in table_
  std::size_t repeated_keys_ = 0;
  std::size_t comments_among_rows_ = 0;
};

// The whole text at once. More than 50 million rows are refused.
RawTable read_csv(const std::string& name, ByteSource& source, const CsvColumns& columns = kLogColumns);

}  // namespace slipstack::workbench
