// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "workbench/log/byte_source.h"

namespace slipstack::workbench {

// Splits bytes into lines with a buffer of fixed size, so that neither a sparse file of gigabytes nor one
// without a newline exhausts memory. Accepts LF and CRLF, a missing newline at the end, and a UTF-8
// byte-order mark.
class LineReader {
 public:
  static constexpr std::size_t kLongestLine = 65536;

  // Where a line begins: byte offset within the source, and number of lines before it.
  struct Place {
    std::size_t byte = 0;
    std::size_t lines = 0;
  };

  // `name` stands for the source in error messages; `source` must outlive the reader. A source that starts at
  // a `place` found earlier is read from there.
  LineReader(std::string name, ByteSource& source) : LineReader(std::move(name), source, {}) {}
  LineReader(std::string name, ByteSource& source, Place place);

  // Puts the next line, without its end, into `line`; false at the end of the text. The view stays valid
  // until the next call. Throws InputError for a NUL byte, a line above kLongestLine, and text in UTF-16.
  bool next(std::string_view& line);

  // Number of the line that next() returned last, counted from 1.
  std::size_t line_number() const { return line_number_; }
  // Where the next line begins.
  Place place() const { return {begin_byte_ + begin_, line_number_}; }

 private:
  void refill();
  void check_beginning();
  void refuse_nul(std::string_view line) const;
  void refuse_lone_returns(std::string_view line) const;

  std::string name_;
  ByteSource& source_;
  std::unique_ptr<char[]> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::size_t begin_byte_ = 0;  // of the buffer within the source
  std::size_t line_number_ = 0;
  bool exhausted_ = false;
  bool started_ = false;
};

}  // namespace slipstack::workbench
