// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace slipstack::workbench {

// The text without spaces and tabs at both ends.
std::string_view trimmed(std::string_view text);

// The text with the capitals of ASCII as small letters.
std::string lower_case(std::string_view text);

// A copy that is safe in a terminal, a report and JSON: control characters become blanks, bytes that are not
// UTF-8 become '?'. With `limit` > 0, cut after that many bytes and closed with "...".
std::string printable(std::string_view text, std::size_t limit = 0);

// printable() in single quotes, cut to a length that fits into one line of an error message.
std::string in_quotes(std::string_view text);

// "a, b, c".
std::string joined(const std::vector<std::string>& names);

// `line` cut at every comma, each field trimmed. An empty line gives one empty field.
std::vector<std::string_view> split_fields(std::string_view line);

// Reads a decimal number at `begin`, where a plus sign is allowed. Returns the first character behind it, or
// nullptr when there is none or it is beyond the range of a double. "nan" and "inf" are read as such: the
// caller decides whether it accepts them. Locale-independent. O(length).
const char* parse_double(const char* begin, const char* end, double& value);

// Why a field is not a usable number: "'abc' is not a number", "is empty", ...; empty when it is one.
std::string number_fault(std::string_view field);

}  // namespace slipstack::workbench
