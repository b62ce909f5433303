// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/import/import_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <system_error>
#include <utility>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/log/foreign_format.h"
#include "workbench/log/import/table_guess.h"
#include "workbench/log/import/table_text.h"
#include "workbench/log/import/text_encoding.h"
#include "workbench/log/mat/mat.h"
#include "workbench/log/sampling/sampling.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kLookedAt = std::size_t{1} << 16;  // bytes of which the guess is made
constexpr std::size_t kShownRows = 8;
constexpr std::string_view kEndMark = "EOF";  // the last line of an export of TwinCAT Scope
// From here on a time counts from an epoch, not from the start of the log: eleven days.
constexpr double kEpoch_s = 1e6;

/// Of a time without a unit the factor to seconds, where it can only be the time since 1970: in seconds it
/// has ten digits for centuries, in ms, us and ns three, six and nine more.
double factor_of_epoch(double value) {
  constexpr std::array<std::array<double, 3>, 3> kDigits{
      {{1e11, 1e14, 1e-3}, {1e14, 1e17, 1e-6}, {1e17, 1e20, 1e-9}}};
  for (const auto& [from, to, factor] : kDigits) {
    if (value >= from && value < to) return factor;
  }
  return 1.0;
}

bool names_row_expected(const ImportProfile& profile) {
  return profile.columns.empty() || profile.columns[0].source != "column 1";
}

/// Why a file cannot be converted as a profile says, and what to add to the command line.
struct Fault {
  std::string what;
  std::string advice;
};

std::string names_of(const ImportProfile& profile) {
  constexpr std::size_t kMost = 12;
  std::string names;
  for (std::size_t i = 0; i < std::min(profile.columns.size(), kMost); ++i) {
    names += fmt::format("{}'{}'", i == 0 ? "" : ", ", printable(profile.columns[i].source, 40));
  }
  return profile.columns.size() > kMost ? names + ", ..." : names;
}

std::optional<Fault> fault_of(const ImportProfile& profile) {
  const auto has = [&](std::initializer_list<const char*> begins) {
    return std::any_of(profile.columns.begin(), profile.columns.end(), [&](const ImportColumn& column) {
      return std::any_of(begins.begin(), begins.end(),
                         [&](const char* begin) { return column.target.rfind(begin, 0) == 0; });
    });
  };
  const auto assign = [&](const char* target) {
    return fmt::format("assign one with --columns 'NAME={}*FACTOR', of {}", target, names_of(profile));
  };
  if (!has({"time_"}) && !(profile.sample_rate_Hz > 0.0)) {
    return Fault{"no column is the time, and no sample rate is given",
                 assign("time_s") + ", or give --header sample_rate_Hz=RATE"};
  }
  if (!has({"position_"})) return Fault{"no column is the position", assign("position_mm")};
  if (!has({"force_", "torque_", "current_"})) {
    return Fault{"no column is the force, the torque or the current", assign("force_N")};
  }
  if (has({"current_"}) && !has({"force_", "torque_"}) &&
      profile.header.count("motor_constant_N_per_A") == 0 &&
      profile.header.count("motor_constant_Nm_per_A") == 0) {
    return Fault{"a current needs the motor constant", "give --header motor_constant_N_per_A=VALUE"};
  }
  return {};
}

/// "# key: value" lines that stand above the table: what a log of ours, or of somebody who knows it, says of
/// itself.
void keep_header(std::string_view text, ImportProfile& profile) {
  std::string_view line;
  for (Lines lines(text); lines.next(line) && lines.number() <= profile.skip_lines;) {
    const std::size_t colon = line.find(": ");
    if (line.empty() || line[0] != '#' || colon == std::string_view::npos) continue;
    profile.header.emplace(printable(trimmed(line.substr(1, colon - 1))),
                           printable(trimmed(line.substr(colon + 2))));
  }
}

/// Writes one row after another; knows where it is for messages.
class Converter {
 public:
  Converter(const std::string& name, const ImportProfile& profile) : name_(name), profile_(profile) {
    for (std::size_t i = 0; i < profile.columns.size(); ++i) {
      if (!profile.columns[i].target.empty()) used_.push_back(i);
      if (profile.columns[i].target == "time_s") time_column_ = i;
    }
    choose_times();
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
    if (after_end_of_group(fields, line)) return;
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
      put(profile_.columns[i], fields[i == time_column_ ? time_field_ : i], line, out);
    }
    require_same_time(fields, line);
    out += '\n';
    ++rows_;
  }

  /// The times of the rows, where the file has them.
  const std::vector<double>& time_s() const { return time_s_; }

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
  /// Where the file has several columns of times, each is that of the channels behind it. The time of the log
  /// is that of the first channel that is used; those of the other channels in use have to agree with it.
  void choose_times() {
    if (!time_column_) return;
    time_field_ = *time_column_;
    std::vector<std::size_t> times;
    for (std::size_t i = 0; i < profile_.columns.size(); ++i) {
      if (i == *time_column_ || profile_.columns[i].same_time) times.push_back(i);
    }
    if (times.size() < 2) return;
    for (const std::size_t i : used_) {
      if (i == *time_column_) continue;
      const auto behind = std::upper_bound(times.begin(), times.end(), i);
      group_times_.push_back(behind == times.begin() ? times.front() : *std::prev(behind));
    }
    if (!group_times_.empty()) time_field_ = group_times_.front();
  }
  /// Channels that were sampled more slowly, or stopped sooner, have no values in the last rows of a file.
  bool after_end_of_group(const std::vector<std::string_view>& fields, std::size_t line) {
    if (group_times_.empty()) return false;
    const bool here = time_field_ < fields.size() && !trimmed(fields[time_field_]).empty();
    if (here && ended_) fail(line, "these channels have values again after rows without; remove the rows");
    ended_ = !here;
    return ended_;
  }
  bool same_number(std::string_view one, std::string_view other) const {
    if (one == other) return true;
    std::array<double, 2> values{};
    std::array<std::string, 2> room;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::string_view pointed = with_point(i == 0 ? one : other, profile_.decimal, room[i]);
      if (parse_double(pointed.data(), pointed.data() + pointed.size(), values[i]) == nullptr) return false;
    }
    return values[0] == values[1];
  }
  /// A row is one instant only where its channels were sampled together.
  void require_same_time(const std::vector<std::string_view>& fields, std::size_t line) const {
    for (const std::size_t i : group_times_) {
      if (i >= fields.size() || same_number(fields[i], fields[time_field_])) continue;
      fail(line,
           fmt::format(
               "{} is {}, that of the first channel in use {}: these channels were not sampled together; "
               "record them with one sample time, or export with one time line",
               profile_.columns[i].source, in_quotes(fields[i]), in_quotes(fields[time_field_])));
    }
  }
  /// A time since an epoch counts from the first row: its digits would not fit into a number.
  void put_epoch(const ImportColumn& column, std::string_view pointed, std::string& out) {
    std::int64_t ticks = 0;
    const auto [end, error] = std::from_chars(pointed.data(), pointed.data() + pointed.size(), ticks);
    const bool whole = error == std::errc() && end == pointed.data() + pointed.size();
    double value = 0.0;
    parse_double(pointed.data(), pointed.data() + pointed.size(), value);
    if (rows_ == 0) {
      first_ticks_ = ticks;
      first_value_ = value;
    }
    const double since = whole ? static_cast<double>(ticks - first_ticks_) : value - first_value_;
    time_s_.push_back(since * column.factor);
    fmt::format_to(std::back_inserter(out), "{:.15g}", time_s_.back());
  }
  void put(const ImportColumn& column, std::string_view field, std::size_t line, std::string& out) {
    if (column.iso_time) {
      const auto seconds = iso_seconds(field);
      if (!seconds)
        fail(line, fmt::format("column {}: {} is no date and time", column.source, in_quotes(field)));
      if (rows_ == 0) start_s_ = *seconds;
      time_s_.push_back(*seconds - start_s_);
      fmt::format_to(std::back_inserter(out), "{:.9f}", time_s_.back());
      return;
    }
    const std::string_view pointed = with_point(field, profile_.decimal, room_);
    if (const std::string fault = number_fault(pointed); !fault.empty()) {
      fail(line, fmt::format("column {}: {}", printable(column.source), fault));
    }
    double value = 0.0;
    parse_double(pointed.data(), pointed.data() + pointed.size(), value);
    if (column.target == "time_s") {
      if (rows_ == 0) is_epoch_ = std::fabs(value * column.factor) >= kEpoch_s;
      if (is_epoch_) return put_epoch(column, pointed, out);
      time_s_.push_back(value * column.factor);
    }
    if (column.factor == 1.0) {
      out += pointed;
      return;
    }
    fmt::format_to(std::back_inserter(out), "{:.15g}", value * column.factor);
  }

  const std::string& name_;
  const ImportProfile& profile_;
  std::vector<std::size_t> used_;
  std::optional<std::size_t> time_column_;
  std::size_t time_field_ = 0;            // where the time is read
  std::vector<std::size_t> group_times_;  // the times of the channels in use; empty: the file has one time
  bool ended_ = false;
  std::vector<double> time_s_;
  std::size_t rows_ = 0;
  double start_s_ = 0.0;
  bool is_epoch_ = false;
  std::int64_t first_ticks_ = 0;
  double first_value_ = 0.0;
  std::string room_;
};

/// Where time stamps grow, and no more can be said against them than that they are uneven: what a user should
/// know of it.
std::optional<std::string> jitter_note(const std::vector<double>& time_s) {
  if (time_s.size() < 3) return {};
  const WhereRow nowhere = [](std::size_t) { return std::string(); };
  try {
    require_growing_time(time_s, nowhere);
  } catch (const InputError&) {
    return {};  // the reader of the log says where
  }
  try {
    static_cast<void>(uniform_sampling(time_s, 0.0, nowhere));
    return {};
  } catch (const InputError&) {
    std::vector<double> steps_s(time_s.size() - 1);
    for (std::size_t i = 0; i + 1 < time_s.size(); ++i) steps_s[i] = time_s[i + 1] - time_s[i];
    const auto [least, most] = std::minmax_element(steps_s.begin(), steps_s.end());
    return fmt::format(
        "time stamps are uneven, {:.4g} to {:.4g} ms apart: the log says `sampling: irregular` and is "
        "interpolated to its median step when it is read",
        1e3 * *least, 1e3 * *most);
  }
}

}  // namespace

ImportPreview guess_import(const std::string& name, std::string_view bytes) {
  if (const std::string format = foreign_format(bytes.substr(0, kLookedAt)); !format.empty()) {
    throw InputError(fmt::format("{}: is {}", name, format));
  }
  if (looks_like_mat(bytes.substr(0, kMatHeaderSize))) {
    throw InputError(name + ": is a MAT file, which every command reads as it is; nothing is to be imported");
  }
  const std::string encoding = encoding_of(bytes.substr(0, kLookedAt));
  std::string text = decoded(bytes.substr(0, kLookedAt), encoding);
  if (bytes.size() > kLookedAt) text.erase(std::min(text.size(), text.find_last_of("\r\n") + 1));
  std::optional<ImportProfile> profile = guess_table(text);
  if (!profile) {
    throw InputError(name + ": no table of numbers was found; a log is text with one row for each sample");
  }
  profile->encoding = encoding;
  keep_header(text, *profile);
  ImportPreview preview = preview_import(name, bytes, *profile);
  for (std::size_t i = 0; i < preview.profile.columns.size() && !preview.rows.empty(); ++i) {
    if (i >= preview.rows[0].size()) break;
    ImportColumn& column = preview.profile.columns[i];
    if (iso_seconds(preview.rows[0][i])) {
      column = {column.source, "time_s", 1.0, true, false};
    } else if (column.target == "time_s" && column.factor == 1.0) {
      std::string room;
      const std::string_view first = with_point(preview.rows[0][i], profile->decimal, room);
      double value = 0.0;
      if (parse_double(first.data(), first.data() + first.size(), value) != nullptr)
        column.factor = factor_of_epoch(value);
    }
  }
  preview.fault = fault_of(preview.profile).value_or(Fault{}).what;
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
  preview.fault = fault_of(profile).value_or(Fault{}).what;
  return preview;
}

ImportedLog import_log(const std::string& name, std::string_view bytes, const ImportProfile& profile) {
  if (const auto fault = fault_of(profile)) {
    throw InputError(fmt::format("{}: {}; {}", name, fault->what, fault->advice));
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
    if (trimmed(line) == kEndMark) break;
    split_row(line, profile.separator, fields);
    converter.row(fields, lines.number(), out);
  }
  if (converter.rows() == 0) throw InputError(name + ": no row of numbers follows the names");
  ImportedLog log{std::move(out), {}};
  if (profile.header.count("sampling") == 0) {
    if (const auto note = jitter_note(converter.time_s())) {
      log.notes.push_back(*note);
      log.text.insert(0, "# sampling: irregular\n");
    }
  }
  return log;
}

}  // namespace slipstack::workbench
