// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "workbench/manual/completion.h"

namespace slipstack::workbench {
namespace {

/// What a kind of value is completed with; empty: with nothing.
std::string bash_action(const OptionText& option, const std::string& function) {
  switch (option.kind) {
    case ValueKind::file:
      return function + "_files";
    case ValueKind::folder:
      return function + "_folders";
    case ValueKind::effect:
      return function + "_words \"$effects\"";
    case ValueKind::effects:
      return function + "_list \"$effects\"";
    case ValueKind::choice:
      return fmt::format("{}_words '{}'", function, with_blanks(option.choices));
    case ValueKind::none:
    case ValueKind::any:
      break;
  }
  return "";
}

/// The branches of the two `case`: what follows an option, and what else can be typed in a command.
struct Branches {
  std::string paths;
  std::string values;
  std::string rest;
};

void collect_branches(const CommandText& command, const std::string& function, Branches& branches) {
  const std::string path = command.name(" ");
  if (command.path.size() > 1)
    branches.paths += fmt::format("{}'{}'", branches.paths.empty() ? "" : " | ", path);
  std::vector<std::string> options;
  std::string positional;
  for (const OptionText& option : command.options) {
    if (option.is_positional) {
      if (positional.empty()) positional = bash_action(option, function);
      continue;
    }
    options.insert(options.end(), option.names.begin(), option.names.end());
    if (option.kind == ValueKind::none) continue;
    std::string pattern;
    for (const std::string& name : option.names)
      pattern += fmt::format("{}'{} {}'", pattern.empty() ? "" : " | ", path, name);
    const std::string act = bash_action(option, function);
    branches.values += fmt::format("    {}) {}{}return ;;\n", pattern, act, act.empty() ? "" : "; ");
  }
  std::vector<std::string> commands;
  for (const CommandText& below : command.commands) commands.push_back(below.path.back());
  if (!commands.empty()) positional = fmt::format("{}_words '{}'", function, with_blanks(commands));
  branches.rest +=
      fmt::format("    '{}')\n      if [[ $current == -* ]]; then {}_words '{}'; else {}; fi ;;\n", path,
                  function, with_blanks(options), positional.empty() ? ":" : positional);
  for (const CommandText& below : command.commands) collect_branches(below, function, branches);
}

// @: the name of the function.
constexpr std::string_view kHelpers =
    R"(@_words() { mapfile -t COMPREPLY < <(compgen -W "$1" -- "$current"); }
@_files() { compopt -o filenames 2> /dev/null; mapfile -t COMPREPLY < <(compgen -f -- "$current"); }
@_folders() { compopt -o filenames 2> /dev/null; mapfile -t COMPREPLY < <(compgen -d -- "$current"); }
# The last word of a list with commas.
@_list() {
  local before=''
  [[ $current != *,* ]] || before=${current%,*},
  compopt -o nospace 2> /dev/null
  mapfile -t COMPREPLY < <(compgen -P "$before" -W "$1" -- "${current##*,}")
}
@() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} i
)";

std::string with_function(std::string_view text, const std::string& function) {
  std::string out;
  for (const char c : text) out += c == '@' ? function : std::string(1, c);
  return out;
}

}  // namespace

std::string bash_completion(const CommandText& program, const std::vector<std::string>& effects) {
  const std::string name = program.name("-");
  std::string function = "_" + name;
  std::replace(function.begin(), function.end(), '-', '_');
  Branches branches;
  collect_branches(program, function, branches);
  std::string out =
      fmt::format("# shellcheck shell=bash\n# Completion of {} for bash, made by slipstack.\n", name);
  out += with_function(kHelpers, function);
  out += fmt::format("  local path='{}' effects='{}'\n  COMPREPLY=()\n", name, with_blanks(effects));
  if (!branches.paths.empty()) {
    out += "  for ((i = 1; i < COMP_CWORD; ++i)); do\n    case \"$path ${COMP_WORDS[i]}\" in\n      ";
    out += branches.paths + ") path+=\" ${COMP_WORDS[i]}\" ;;\n    esac\n  done\n";
  }
  out += "  case \"$path $previous\" in\n" + branches.values + "  esac\n";
  out += "  case \"$path\" in\n" + branches.rest + "  esac\n}\n";
  return out + fmt::format("complete -F {} {}\n", function, name);
}

}  // namespace slipstack::workbench
