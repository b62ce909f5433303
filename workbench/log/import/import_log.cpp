// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/import/import_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/log/import/table_guess.h"
#include "workbench/log/import/table_text.h"
#include "workbench/log/import/text_encoding.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kLookedAt = std::size_t{1} << 16;  // bytes of which the guess is made
constexpr std::size_t kShownRows = 8;

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
  const std::string encoding = encoding_of(bytes.substr(0, kLookedAt));
  std::string text = decoded(bytes.substr(0, kLookedAt), encoding);
  if (bytes.size() > kLookedAt) text.erase(std::min(text.size(), text.find_last_of("\r\n") + 1));
  std::optional<ImportProfile> profile = guess_table(text);
  if (!profile) {
    throw InputError(name + ": no table of numbers was found; a log is text with one row for each sample");
  }
  profile->encoding = encoding;
  ImportPreview preview = preview_import(name, bytes, *profile);
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
    split_row(line, profile.separator, fields);
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
    split_row(line, profile.separator, fields);
    converter.row(fields, lines.number(), out);
  }
  if (converter.rows() == 0) throw InputError(name + ": no row of numbers follows the names");
  return out;
}

}  // namespace slipstack::workbench
