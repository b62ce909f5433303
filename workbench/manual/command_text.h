// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace slipstack::workbench {

/// What a shell can offer as the value of an option.
enum class ValueKind { none, any, file, folder, effect, effects, choice };

/// One option of a command, or one of its positional arguments.
struct OptionText {
  std::vector<std::string> names;  ///< "-h", "--help"; of a positional argument its one name
  bool is_positional = false;
  bool is_repeated = false;         ///< takes any number of values
  std::string value;                ///< what --help prints behind the name, as " FILE REQUIRED"
  std::string value_name;           ///< the kind of value alone, as "FILE"
  ValueKind kind = ValueKind::any;  ///< none: a flag
  std::vector<std::string> choices;
  std::string description;
};

/// A command, its options and the commands below it, as the parser knows them. Man pages and completions are
/// written from this, so that they say what --help says.
struct CommandText {
  std::vector<std::string> path;  ///< {"slipstack", "experiment", "plan"}
  std::string description;
  std::string usage;   ///< of --help, as "slipstack compare [OPTIONS] LOG..."
  std::string footer;  ///< of --help
  std::vector<OptionText> options;
  std::vector<CommandText> commands;

  /// The words of the path with `separator` between them.
  std::string name(const std::string& separator) const;
};

/// The words with one blank between them.
std::string with_blanks(const std::vector<std::string>& words);

/// The command that `app` parses, called `name`, with all commands below it.
CommandText command_text(const CLI::App& app, const std::string& name);

}  // namespace slipstack::workbench
