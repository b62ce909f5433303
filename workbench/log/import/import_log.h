// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "workbench/log/import/import_profile.h"

namespace slipstack::workbench {

/// How a foreign file would be read, for a person to confirm.
struct ImportPreview {
  ImportProfile profile;
  std::vector<std::vector<std::string>> rows;  ///< the first of them, as they stand in the file
  std::string fault;                           ///< why it cannot be converted so; empty: it can
};

/// Guesses encoding, separator, decimal mark, row of names, units and columns from the beginning of a file.
/// Throws InputError for what is no table of text.
ImportPreview guess_import(const std::string& name, std::string_view bytes);

/// The same with a profile that is given.
ImportPreview preview_import(const std::string& name, std::string_view bytes, const ImportProfile& profile);

struct ImportedLog {
  std::string text;                ///< the log as a CSV file
  std::vector<std::string> notes;  ///< what a user should know of it, each a sentence
};

/// The file as a log of the documented format: header lines, then the assigned columns. Numbers that keep
/// their unit keep their digits. Where the time stamps grow but not uniformly, the log says `sampling:
/// irregular` and a note tells how far they are off. Throws InputError, one line with file and line. Cost:
/// linear in the bytes.
ImportedLog import_log(const std::string& name, std::string_view bytes, const ImportProfile& profile);

}  // namespace slipstack::workbench
