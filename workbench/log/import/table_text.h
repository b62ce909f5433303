// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slipstack::workbench {

/// Lines of a text; LF, CRLF or CR.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}
  bool next(std::string_view& line) {
    if (begin_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find_first_of("\r\n", begin_), text_.size());
    line = text_.substr(begin_, end - begin_);
    begin_ = end + 1;
    if (end + 1 < text_.size() && text_[end] == '\r' && text_[end + 1] == '\n') ++begin_;
    ++number_;
    return true;
  }
  std::size_t number() const { return number_; }

 private:
  std::string_view text_;
  std::size_t begin_ = 0;
  std::size_t number_ = 0;
};

/// Fields of a line, trimmed, without the quotes around them. Several blanks are one separator.
void split_row(std::string_view line, char separator, std::vector<std::string_view>& fields);

/// The field with a decimal point; `room` holds it where a mark was replaced.
std::string_view with_point(std::string_view field, char decimal, std::string& room);

bool is_number(std::string_view field, char decimal);

/// Seconds since 1970 of "2026-03-04T10:15:00.123456Z", of a proleptic Gregorian calendar; empty for any
/// other text.
std::optional<double> iso_seconds(std::string_view text);

}  // namespace slipstack::workbench
