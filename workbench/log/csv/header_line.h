// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace slipstack::workbench {

/// A line `# key: value` above the rows.
struct HeaderLine {
  std::string key;    ///< not empty
  std::string value;  ///< what follows the first colon
};

/// Parses such a line, given without its '#'; empty where it is a comment: without a colon, or without a key.
/// Both sides lose the blanks around them, and unprintable characters are escaped.
std::optional<HeaderLine> parse_header_line(std::string_view text);

}  // namespace slipstack::workbench
