// SPDX-License-Identifier: Apache-2.0
#include "workbench/console/wrap.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>

namespace slipstack::workbench {
namespace {

/// Terminals narrower than this many columns break the lines themselves; chosen.
constexpr std::size_t kNarrowest = 40;

std::size_t length_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

/// Column at which continuation lines start: behind the last gap of two spaces or more in the first two
/// thirds of the width, where the text of the line begins.
std::size_t indent_of(std::string_view line, std::size_t width) {
  std::size_t indent = 0;
  for (std::size_t at = line.find("  "); at != std::string_view::npos; at = line.find("  ", at)) {
    const std::size_t end = line.find_first_not_of(' ', at);
    if (end == std::string_view::npos || 3 * end > 2 * width) break;
    indent = end;
    at = end;
  }
  return indent;
}

void append_wrapped(std::string& out, std::string_view line, std::size_t width) {
  const std::string margin(indent_of(line, width), ' ');
  std::size_t column = 0;
  std::size_t begin = 0;
  while (begin < line.size()) {  // word by word, each with the spaces before it
    const std::size_t word = std::min(line.find_first_not_of(' ', begin), line.size());
    const std::size_t end = std::min(line.find(' ', word), line.size());
    const std::size_t long_with_spaces = length_of(line.substr(begin, end - begin));
    if (column > margin.size() && column + long_with_spaces > width) {
      out += '\n' + margin;
      out += line.substr(word, end - word);
      column = margin.size() + length_of(line.substr(word, end - word));
    } else {
      out += line.substr(begin, end - begin);
      column += long_with_spaces;
    }
    begin = end;
  }
}

}  // namespace

std::string wrapped(std::string_view text, std::size_t width) {
  if (width < kNarrowest) return std::string(text);
  std::string out;
  out.reserve(text.size() + text.size() / 16);
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    if (line.starts_with("  ") || length_of(line) <= width) {
      out += line;
    } else {
      append_wrapped(out, line, width);
    }
    if (end < text.size()) out += '\n';
    begin = end + 1;
  }
  return out;
}

std::size_t terminal_width() {
  if (::isatty(STDOUT_FILENO) == 0) return 0;
  struct winsize size {};
  return ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

}  // namespace slipstack::workbench
