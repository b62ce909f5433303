// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace slipstack::workbench {

/// What a column of a foreign file is in the log.
struct ImportColumn {
  std::string source;     ///< its name in the file, units included
  std::string target;     ///< column of the log (docs/log-format.md), as time_s; empty: left out
  double factor = 1.0;    ///< value in the log = factor x value in the file
  bool iso_time = false;  ///< date and time of ISO 8601; the log counts seconds from the first row
  bool same_time =
      false;  ///< the time of the channels behind it: left out, or taken for the time where they are used
};

/// How a foreign file of text is read.
struct ImportProfile {
  std::string encoding = "utf-8";  ///< utf-8, utf-16le, utf-16be or latin-1
  char separator = ',';
  char decimal = '.';
  std::size_t skip_lines = 0;   ///< before the row of names
  bool units_row = false;       ///< the row below the names holds units
  double sample_rate_Hz = 0.0;  ///< makes the time where the file has none
  std::vector<ImportColumn> columns;
  std::map<std::string, std::string> header;  ///< lines that the log gets, as mass_kg
};

/// "t=time_s, x=position_mm, F=force_N*0.001": assigns columns by the names in the file, or by their numbers
/// from 1; the others are left out, but for the time that was recognised, where neither a column nor
/// sample_rate_Hz gives one. Throws UsageError.
void assign_columns(ImportProfile& profile, const std::string& text);

/// The profile as TOML, and back. `name` stands for the text in messages. Throws InputError.
std::string to_toml(const ImportProfile& profile);
ImportProfile parse_profile(const std::string& name, std::string_view text);

}  // namespace slipstack::workbench
