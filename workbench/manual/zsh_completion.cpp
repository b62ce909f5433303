// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <string_view>

#include "workbench/manual/completion.h"

namespace slipstack::workbench {
namespace {

/// In single quotes of a shell.
std::string in_shell_quotes(std::string_view text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

/// A text within a specification of `_arguments`, where brackets and colons have a meaning.
std::string plain(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out;
}

std::string zsh_action(const OptionText& option, const std::vector<std::string>& effects) {
  switch (option.kind) {
    case ValueKind::file:
      return "_files";
    case ValueKind::folder:
      return "_files -/";
    case ValueKind::effect:
      return "(" + with_blanks(effects) + ")";
    case ValueKind::effects:
      return "_values -s , effect " + with_blanks(effects);
    case ValueKind::choice:
      return "(" + with_blanks(option.choices) + ")";
    case ValueKind::none:
    case ValueKind::any:
      break;
  }
  return " ";
}

/// The specifications of one option or argument, each on a line of its own.
std::string specifications(const OptionText& option, const std::vector<std::string>& effects) {
  const std::string value =
      fmt::format(":{}:{}", plain(option.value_name.empty() ? option.names.front() : option.value_name),
                  zsh_action(option, effects));
  if (option.is_positional)
    return fmt::format(" \\\n    {}", in_shell_quotes((option.is_repeated ? "*" : "") + value));
  std::string out;
  for (const std::string& name : option.names) {
    out += fmt::format(
        " \\\n    {}",
        in_shell_quotes(fmt::format("{}{}[{}]{}", option.is_repeated ? "*" : "", name,
                                    plain(option.description), option.kind == ValueKind::none ? "" : value)));
  }
  return out;
}

void put_function(const CommandText& command, const std::vector<std::string>& effects, std::string& out) {
  for (const CommandText& below : command.commands) put_function(below, effects, out);
  std::string body = "  _arguments -S";
  if (!command.commands.empty()) body = "  local state line\n  local -a words_below\n  _arguments -C";
  for (const OptionText& option : command.options) {
    if (command.commands.empty() || !option.is_positional) body += specifications(option, effects);
  }
  if (!command.commands.empty()) {
    body +=
        " \\\n    '1: :->command' \\\n    '*:: :->rest'\n  case $state in\n    command)\n      words_below=(";
    for (const CommandText& below : command.commands)
      body += "\n        " + in_shell_quotes(below.path.back() + ":" + plain(below.description));
    body += ")\n      _describe command words_below ;;\n    rest)\n      case $line[1] in\n";
    for (const CommandText& below : command.commands)
      body += fmt::format("        {}) _{} ;;\n", below.path.back(), below.name("_"));
    body += "      esac ;;\n  esac";
  }
  out += fmt::format("_{}() {{\n{}\n}}\n", command.name("_"), body);
}

}  // namespace

std::string zsh_completion(const CommandText& program, const std::vector<std::string>& effects) {
  const std::string name = program.name("-");
  std::string out = fmt::format("#compdef {}\n# Completion of {} for zsh, made by slipstack.\n", name, name);
  put_function(program, effects, out);
  // Autoloaded the file is the body of the function: then it completes; sourced it only tells what completes.
  return out +
         fmt::format("if [ \"${{funcstack[1]}}\" = _{0} ]; then _{0} \"$@\"; else compdef _{0} {1}; fi\n",
                     program.name("_"), name);
}

}  // namespace slipstack::workbench
