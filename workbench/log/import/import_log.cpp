// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/import/import_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/log/utf8.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kLookedAt = std::size_t{1} << 16;  // bytes of which the guess is made
constexpr std::size_t kShownRows = 8;
constexpr std::size_t kMostColumns = 256;

std::string from_utf16(std::string_view bytes, bool little) {
  const auto unit = [&](std::size_t i) {
    const auto first = static_cast<std::uint8_t>(bytes[i]);
    const auto second = static_cast<std::uint8_t>(bytes[i + 1]);
    return static_cast<std::uint32_t>(little ? first | (second << 8U) : (first << 8U) | second);
  };
  std::string out;
  out.reserve(bytes.size() / 2);
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    std::uint32_t code = unit(i);
    if (code >= 0xD800 && code < 0xDC00 && i + 3 < bytes.size()) {
      code = 0x10000 + ((code - 0xD800) << 10U) + (unit(i + 2) - 0xDC00);
      i += 2;
    }
    if (code != 0xFEFF) append_utf8(out, code);
  }
  return out;
}

bool is_utf8(std::string_view bytes) {
  return printable(bytes).find('?') == std::string::npos || bytes.find('?') != std::string_view::npos;
}

std::string encoding_of(std::string_view bytes) {
  if (bytes.substr(0, 2) == "\xFF\xFE") return "utf-16le";
  if (bytes.substr(0, 2) == "\xFE\xFF") return "utf-16be";
  const std::string_view head = bytes.substr(0, 512);
  const auto zeros = [&](std::size_t from) {
    std::size_t count = 0;
    for (std::size_t i = from; i < head.size(); i += 2) count += head[i] == '\0' ? 1 : 0;
    return count;
  };
  if (head.size() >= 8 && zeros(1) > head.size() / 4) return "utf-16le";
  if (head.size() >= 8 && zeros(0) > head.size() / 4) return "utf-16be";
  return is_utf8(bytes) ? "utf-8" : "latin-1";
}

/// The text as UTF-8, without a byte-order mark.
std::string decoded(std::string_view bytes, const std::string& encoding) {
  if (encoding == "utf-16le") return from_utf16(bytes, true);
  if (encoding == "utf-16be") return from_utf16(bytes, false);
  if (encoding == "latin-1") {
    std::string out;
    out.reserve(bytes.size());
    for (const char c : bytes) append_utf8(out, static_cast<std::uint8_t>(c));
    return out;
  }
  if (bytes.substr(0, 3) == "\xEF\xBB\xBF") bytes.remove_prefix(3);
  return std::string(bytes);
}

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
void split(std::string_view line, char separator, std::vector<std::string_view>& fields) {
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

/// The field with a decimal point.
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

/// Digits of "2026-03-04T10:15:00.123456Z": seconds since 1970, of a proleptic Gregorian calendar. The day
/// number after Hinnant, "chrono-compatible low-level date algorithms" (2013).
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
  year -= month <= 2 ? 1 : 0;
  const int era = year / 400;
  const int of_era = year - era * 400;
  const int of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  const int days = era * 146097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719468;
  return 86400.0 * days + 3600.0 * hour + 60.0 * minute + second;
}

/// Separator and decimal mark by which most of the first lines have equally many numbers, more than one.
struct Form {
  char separator = ',';
  char decimal = '.';
  std::size_t columns = 0;
  std::size_t rows = 0;
};

Form guess_form(std::string_view text) {
  constexpr std::array kForms{std::pair{',', '.'},  std::pair{';', '.'},  std::pair{';', ','},
                              std::pair{'\t', '.'}, std::pair{'\t', ','}, std::pair{' ', '.'},
                              std::pair{' ', ','}};
  Form best;
  for (const auto& [separator, decimal] : kForms) {
    Form form{separator, decimal, 0, 0};
    std::vector<std::string_view> fields;
    std::string_view line;
    for (Lines lines(text); lines.next(line);) {
      split(line, separator, fields);
      const char mark = decimal;
      const auto value = [mark](std::string_view field) {
        return is_number(field, mark) || iso_seconds(field).has_value();
      };
      const bool numbers = fields.size() >= 2 && std::all_of(fields.begin(), fields.end(), value);
      if (!numbers) continue;
      if (fields.size() == form.columns) {
        ++form.rows;
      } else if (form.rows == 0) {
        form.columns = fields.size();
        form.rows = 1;
      }
    }
    if (form.rows > best.rows) best = form;
  }
  return best;
}

/// The row of names is the last line before the numbers that has as many fields, or the one above its units.
void find_names(std::string_view text, ImportProfile& profile, std::size_t columns) {
  std::vector<std::string> above;
  std::string_view line;
  std::vector<std::string_view> fields;
  for (Lines lines(text); lines.next(line);) {
    split(line, profile.separator, fields);
    const bool value = !fields.empty() && (is_number(fields[0], profile.decimal) || iso_seconds(fields[0]));
    if (value && fields.size() == columns) break;
    above.emplace_back(line);
  }
  const auto fits = [&](std::size_t index) {
    split(above[index], profile.separator, fields);
    return fields.size() == columns;
  };
  std::size_t names = above.size();
  while (names > 0 && !fits(names - 1)) --names;
  if (names == 0) {
    profile.skip_lines = above.size();
    for (std::size_t i = 0; i < columns; ++i)
      profile.columns.push_back({fmt::format("column {}", i + 1), "", 1.0, false});
    return;
  }
  std::vector<std::string> units;
  if (names >= 2 && fits(names - 2)) {  // two rows: names, then units, where the second is short words
    split(above[names - 1], profile.separator, fields);
    const bool short_words =
        std::all_of(fields.begin(), fields.end(), [](std::string_view field) { return field.size() <= 8; });
    if (short_words) {
      for (const std::string_view field : fields) {
        units.emplace_back(field.substr(
            field.find_first_not_of("[(") == std::string_view::npos ? 0 : field.find_first_not_of("[(")));
        while (!units.back().empty() && std::string("])").find(units.back().back()) != std::string::npos)
          units.back().pop_back();
      }
      profile.units_row = true;
      --names;
    }
  }
  profile.skip_lines = names - 1;
  split(above[names - 1], profile.separator, fields);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    std::string name(fields[i]);
    if (i == 0 && !name.empty() && name[0] == '#')
      name = std::string(trimmed(std::string_view(name).substr(1)));
    profile.columns.push_back(guess_column(name, i < units.size() ? units[i] : ""));
  }
}

/// Each target once: the first that claims it.
void keep_first_of_each(ImportProfile& profile) {
  std::vector<std::string> taken;
  for (ImportColumn& column : profile.columns) {
    const std::string kind = column.target.substr(0, column.target.rfind('_'));
    if (kind.empty()) continue;
    if (std::find(taken.begin(), taken.end(), kind) != taken.end()) {
      column.target.clear();
    } else {
      taken.push_back(kind);
    }
  }
}

bool names_row_expected(const ImportProfile& profile) {
  return profile.columns.empty() || profile.columns[0].source != "column 1";
}

std::string fault_of(const ImportProfile& profile) {
  const auto has = [&](std::initializer_list<const char*> begins) {
    return std::any_of(profile.columns.begin(), profile.columns.end(), [&](const ImportColumn& column) {
      return std::any_of(begins.begin(), begins.end(),
                         [&](const char* begin) { return column.target.rfind(begin, 0) == 0; });
    });
  };
  if (!has({"time_"}) && !(profile.sample_rate_Hz > 0.0))
    return "no column is the time, and no sample rate is given";
  if (!has({"position_"})) return "no column is the position";
  if (!has({"force_", "torque_", "current_"})) return "no column is the force, the torque or the current";
  if (has({"current_"}) && !has({"force_", "torque_"}) &&
      profile.header.count("motor_constant_N_per_A") == 0 &&
      profile.header.count("motor_constant_Nm_per_A") == 0) {
    return "a current needs the motor constant";
  }
  return "";
}

/// Writes one row after another; knows where it is for messages.
class Converter {
 public:
  Converter(const std::string& name, const ImportProfile& profile) : name_(name), profile_(profile) {
    for (std::size_t i = 0; i < profile.columns.size(); ++i) {
      if (!profile.columns[i].target.empty()) used_.push_back(i);
    }
  }

  std::string head() const {
    std::string out;
    for (const auto& [key, value] : profile_.header) out += "# " + key + ": " + value + "\n";
    bool first = true;
    if (makes_time()) {
      out += "time_s";
      first = false;
    }
    for (const std::size_t i : used_) {
      if (!first) out += ',';
      first = false;
      out += profile_.columns[i].target;
    }
    return out + "\n";
  }

  void row(const std::vector<std::string_view>& fields, std::size_t line, std::string& out) {
    bool first = true;
    if (makes_time()) {
      fmt::format_to(std::back_inserter(out), "{:.9f}", static_cast<double>(rows_) / profile_.sample_rate_Hz);
      first = false;
    }
    for (const std::size_t i : used_) {
      if (!first) out += ',';
      first = false;
      if (i >= fields.size())
        fail(line, fmt::format("{} fields; the row ends before {}", fields.size(),
                               in_quotes(profile_.columns[i].source)));
      put(profile_.columns[i], fields[i], line, out);
    }
    out += '\n';
    ++rows_;
  }

  std::size_t rows() const { return rows_; }

 private:
  bool makes_time() const {
    if (!(profile_.sample_rate_Hz > 0.0)) return false;
    return std::none_of(profile_.columns.begin(), profile_.columns.end(),
                        [](const ImportColumn& column) { return column.target == "time_s"; });
  }
  [[noreturn]] void fail(std::size_t line, const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", name_, line, what));
  }
  void put(const ImportColumn& column, std::string_view field, std::size_t line, std::string& out) {
    if (column.iso_time) {
      const auto seconds = iso_seconds(field);
      if (!seconds)
        fail(line, fmt::format("column {}: {} is no date and time", column.source, in_quotes(field)));
      if (rows_ == 0) start_s_ = *seconds;
      fmt::format_to(std::back_inserter(out), "{:.9f}", *seconds - start_s_);
      return;
    }
    const std::string_view pointed = with_point(field, profile_.decimal, room_);
    if (const std::string fault = number_fault(pointed); !fault.empty()) {
      fail(line, fmt::format("column {}: {}", printable(column.source), fault));
    }
    if (column.factor == 1.0) {
      out += pointed;
      return;
    }
    double value = 0.0;
    parse_double(pointed.data(), pointed.data() + pointed.size(), value);
    fmt::format_to(std::back_inserter(out), "{:.15g}", value * column.factor);
  }

  const std::string& name_;
  const ImportProfile& profile_;
  std::vector<std::size_t> used_;
  std::size_t rows_ = 0;
  double start_s_ = 0.0;
  std::string room_;
};

}  // namespace

ImportPreview guess_import(const std::string& name, std::string_view bytes) {
  ImportProfile profile;
  profile.encoding = encoding_of(bytes.substr(0, kLookedAt));
  std::string text = decoded(bytes.substr(0, kLookedAt), profile.encoding);
  if (bytes.size() > kLookedAt) text.erase(std::min(text.size(), text.find_last_of("\r\n") + 1));
  const Form form = guess_form(text);
  if (form.rows < 2 || form.columns > kMostColumns) {
    throw InputError(name + ": no table of numbers was found; a log is text with one row for each sample");
  }
  profile.separator = form.separator;
  profile.decimal = form.decimal;
  find_names(text, profile, form.columns);
  keep_first_of_each(profile);
  ImportPreview preview = preview_import(name, bytes, profile);
  for (std::size_t i = 0; i < preview.profile.columns.size() && !preview.rows.empty(); ++i) {
    if (i >= preview.rows[0].size()) break;
    if (!iso_seconds(preview.rows[0][i])) continue;
    ImportColumn& column = preview.profile.columns[i];
    column = {column.source, "time_s", 1.0, true};
  }
  preview.fault = fault_of(preview.profile);
  return preview;
}

ImportPreview preview_import(const std::string& name, std::string_view bytes, const ImportProfile& profile) {
  ImportPreview preview{profile, {}, ""};
  const std::string text = decoded(bytes.substr(0, kLookedAt), profile.encoding);
  const std::size_t before =
      profile.skip_lines + (names_row_expected(profile) ? 1U : 0U) + (profile.units_row ? 1U : 0U);
  std::string_view line;
  std::vector<std::string_view> fields;
  for (Lines lines(text); lines.next(line) && preview.rows.size() < kShownRows;) {
    if (lines.number() <= before || trimmed(line).empty()) continue;
    split(line, profile.separator, fields);
    preview.rows.emplace_back();
    for (const std::string_view field : fields) preview.rows.back().push_back(printable(field, 40));
  }
  if (preview.rows.empty()) throw InputError(name + ": no row of numbers follows the names");
  preview.fault = fault_of(profile);
  return preview;
}

std::string import_log(const std::string& name, std::string_view bytes, const ImportProfile& profile) {
  if (const std::string fault = fault_of(profile); !fault.empty()) {
    throw InputError(name + ": " + fault + "; assign the columns");
  }
  const std::string text = decoded(bytes, profile.encoding);
  Converter converter(name, profile);
  std::string out = converter.head();
  out.reserve(text.size());
  const std::size_t before =
      profile.skip_lines + (names_row_expected(profile) ? 1U : 0U) + (profile.units_row ? 1U : 0U);
  std::string_view line;
  std::vector<std::string_view> fields;
  for (Lines lines(text); lines.next(line);) {
    if (lines.number() <= before || trimmed(line).empty()) continue;
    split(line, profile.separator, fields);
    converter.row(fields, lines.number(), out);
  }
  if (converter.rows() == 0) throw InputError(name + ": no row of numbers follows the names");
  return out;
}

}  // namespace slipstack::workbench
