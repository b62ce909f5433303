// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/csv/header_line.h"

#include <cstddef>

#include "workbench/base/text.h"

namespace slipstack::workbench {

std::optional<HeaderLine> parse_header_line(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return std::nullopt;
  HeaderLine line{printable(trimmed(text.substr(0, colon))), printable(trimmed(text.substr(colon + 1)))};
  if (line.key.empty()) return std::nullopt;
  return line;
}

}  // namespace slipstack::workbench
