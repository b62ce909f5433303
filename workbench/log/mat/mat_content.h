// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "workbench/log/csv/raw_table.h"

namespace slipstack::workbench {

/// Collects what a MAT-file of any version holds, and makes the table of a log of it. The log is either in
/// the variables or in the fields of the one struct that has a field time_s.
class MatContent {
 public:
  /// `source`: stands for the file in messages.
  explicit MatContent(std::string source) : source_(std::move(source)) {}

  /// A vector becomes a column, or, of one value, a header entry. `in_record`: it is a field of the struct.
  /// `relative_precision` of the stored numbers, 0: those of doubles.
  void add_numbers(bool in_record, const std::string& name, std::vector<double> values,
                   double relative_precision);
  /// Text becomes a header entry.
  void add_text(bool in_record, const std::string& name, const std::string& value);
  /// What is neither vector, number nor text.
  void leave_out(const std::string& name);
  /// The struct that holds the log. Throws InputError for a second one.
  void begin_record(const std::string& name);

  /// Vectors beside a struct with the log are left out, scalars and text beside it still count as header
  /// entries. Throws InputError where the columns are not those of a log, are not finite or not of one
  /// length.
  RawTable finish();

 private:
  struct Part {
    std::vector<RawTable::Column> columns;
    std::map<std::string, std::string> texts;
  };

  Part& part(bool in_record) { return in_record ? record_ : variables_; }

  std::string source_;
  Part variables_;
  Part record_;
  std::string record_name_;
  std::vector<std::string> left_out_;
};

}  // namespace slipstack::workbench
