// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/csv/line_reader.h"

#include <cstring>
#include <utility>

#include "workbench/base/errors.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 20;
static_assert(kBufferSize > 2 * LineReader::kLongestLine);

}  // namespace

LineReader::LineReader(std::string name, ByteSource& source, Place place)
    : name_(std::move(name)),
      source_(source),
      buffer_(std::make_unique_for_overwrite<char[]>(kBufferSize)),
      begin_byte_(place.byte),
      line_number_(place.lines),
      started_(place.byte > 0) {}

bool LineReader::next(std::string_view& line) {
  if (!started_) check_beginning();
  const char* newline = nullptr;
  for (std::size_t searched = 0;;) {
    const std::size_t available = end_ - begin_;
    const char* const from = buffer_.get() + begin_ + searched;
    newline = static_cast<const char*>(std::memchr(from, '\n', available - searched));
    if (newline != nullptr || exhausted_) break;
    if (available > kLongestLine) break;
    searched = available;
    refill();
  }
  if (newline == nullptr && begin_ == end_) return false;
  const char* const first = buffer_.get() + begin_;
  const char* last = newline != nullptr ? newline : buffer_.get() + end_;
  ++line_number_;
  const auto length = static_cast<std::size_t>(last - first);
  refuse_nul({first, length < kLongestLine ? length : kLongestLine});
  if (length > kLongestLine) {
    refuse_lone_returns({first, kLongestLine});
    throw InputError(name_ + ":" + std::to_string(line_number_) + ": the line is longer than " +
                     std::to_string(kLongestLine) + " bytes; write one sample to a line");
  }
  refuse_lone_returns({first, length});
  begin_ += length + (newline != nullptr ? 1 : 0);
  while (last != first && last[-1] == '\r') --last;  // files that were converted twice have two
  line = {first, static_cast<std::size_t>(last - first)};
  return true;
}

void LineReader::refill() {
  std::memmove(buffer_.get(), buffer_.get() + begin_, end_ - begin_);
  begin_byte_ += begin_;
  end_ -= begin_;
  begin_ = 0;
  const std::size_t count = source_.read(buffer_.get() + end_, kBufferSize - end_);
  if (count == 0) exhausted_ = true;
  end_ += count;
}

void LineReader::check_beginning() {
  started_ = true;
  while (end_ < 3 && !exhausted_) refill();
  const std::string_view head(buffer_.get(), end_);
  if (head.starts_with("\xEF\xBB\xBF")) {
    begin_ = 3;
  } else if (head.starts_with("\xFF\xFE") || head.starts_with("\xFE\xFF")) {
    throw InputError(name_ +
                     ": the text is UTF-16; save it as UTF-8, or use `slipstack import`, which reads it");
  }
}

void LineReader::refuse_lone_returns(std::string_view line) const {
  const std::size_t last = line.find_last_not_of('\r');
  if (last == std::string_view::npos || line.substr(0, last).find('\r') == std::string_view::npos) return;
  throw InputError(name_ + ":" + std::to_string(line_number_) +
                   ": lines end in a carriage return alone; save the file with LF or CRLF");
}

void LineReader::refuse_nul(std::string_view line) const {
  if (std::memchr(line.data(), '\0', line.size()) == nullptr) return;
  throw InputError(name_ + ":" + std::to_string(line_number_) +
                   ": NUL bytes where text should be: this is neither a CSV log nor a MAT file, or a damaged "
                   "copy; export it again");
}

}  // namespace slipstack::workbench
