// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/import/table_text.h"

#include "workbench/base/text.h"

namespace slipstack::workbench {

void split_row(std::string_view line, char separator, std::vector<std::string_view>& fields) {
  fields.clear();
  std::size_t begin = 0;
  bool quoted = false;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    if (i < line.size() && line[i] == '"') quoted = !quoted;
    if (i < line.size() && (line[i] != separator || quoted)) continue;
    std::string_view field = trimmed(line.substr(begin, i - begin));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') {
      field = field.substr(1, field.size() - 2);
    }
    if (separator != ' ' || !field.empty()) fields.push_back(field);
    begin = i + 1;
  }
  while (separator != ' ' && !fields.empty() && fields.back().empty()) fields.pop_back();
}

std::string_view with_point(std::string_view field, char decimal, std::string& room) {
  if (decimal == '.') return field;
  room.assign(field);
  std::replace(room.begin(), room.end(), decimal, '.');
  return room;
}

bool is_number(std::string_view field, char decimal) {
  std::string room;
  return number_fault(with_point(field, decimal, room)).empty();
}

std::optional<double> iso_seconds(std::string_view text) {
  const auto digits = [&](std::size_t at, std::size_t count) -> int {
    int value = 0;
    for (std::size_t i = at; i < at + count; ++i) {
      if (i >= text.size() || text[i] < '0' || text[i] > '9') return -1;
      value = 10 * value + (text[i] - '0');
    }
    return value;
  };
  if (text.size() < 19 || text[4] != '-' || text[7] != '-' || (text[10] != 'T' && text[10] != ' ')) return {};
  int year = digits(0, 4);
  const int month = digits(5, 2), day = digits(8, 2), hour = digits(11, 2), minute = digits(14, 2);
  std::string_view seconds = text.substr(17);
  if (const std::size_t end = seconds.find_first_of("Z+-"); end != std::string_view::npos) {
    seconds = seconds.substr(0, end);
  }
  double second = 0.0;
  std::string room;
  const std::string_view pointed = with_point(seconds, ',', room);
  if (year < 0 || month < 1 || day < 1 || hour < 0 || minute < 0 ||
      parse_double(pointed.data(), pointed.data() + pointed.size(), second) !=
          pointed.data() + pointed.size()) {
    return {};
  }
  // The day number after Hinnant, "chrono-compatible low-level date algorithms" (2013).
  year -= month <= 2 ? 1 : 0;
  const int era = year / 400;
  const int of_era = year - era * 400;
  const int of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  const int days = era * 146097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719468;
  return 86400.0 * days + 3600.0 * hour + 60.0 * minute + second;
}

}  // namespace slipstack::workbench
