// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/import/table_guess.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "workbench/base/text.h"
#include "workbench/log/import/column_guess.h"
#include "workbench/log/import/scope_header.h"
#include "workbench/log/import/table_text.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kMostColumns = 256;

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
      split_row(line, separator, fields);
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
    split_row(line, profile.separator, fields);
    const bool value = !fields.empty() && (is_number(fields[0], profile.decimal) || iso_seconds(fields[0]));
    if (value && fields.size() == columns) break;
    above.emplace_back(line);
  }
  std::vector<std::vector<std::string_view>> rows_above(above.size());
  for (std::size_t i = 0; i < above.size(); ++i) split_row(above[i], profile.separator, rows_above[i]);
  if (auto scope = scope_columns(rows_above, columns)) {
    profile.columns = std::move(*scope);
    profile.skip_lines = above.size() - 1;  // the last of its rows counts as that of the names
    return;
  }
  const auto fits = [&](std::size_t index) {
    split_row(above[index], profile.separator, fields);
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
    split_row(above[names - 1], profile.separator, fields);
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
  split_row(above[names - 1], profile.separator, fields);
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

}  // namespace

std::optional<ImportProfile> guess_table(std::string_view text) {
  const Form form = guess_form(text);
  if (form.rows < 2 || form.columns > kMostColumns) return {};
  ImportProfile profile;
  profile.separator = form.separator;
  profile.decimal = form.decimal;
  find_names(text, profile, form.columns);
  keep_first_of_each(profile);
  return profile;
}

}  // namespace slipstack::workbench
