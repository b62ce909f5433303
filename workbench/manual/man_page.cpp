// SPDX-License-Identifier: Apache-2.0
#include "workbench/manual/man_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

namespace slipstack::workbench {
namespace {

/// A text in the language of troff: what it would read as a control line, a hyphen or a quotation mark is
/// said as the character itself.
std::string escaped(std::string_view text) {
  std::string out;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) out += "\\&";
    line_begins = c == '\n';
    switch (c) {
      case '\\':
        out += "\\e";
        break;
      case '-':
        out += "\\-";
        break;
      case '\'':
        out += "\\(aq";
        break;
      case '`':
        out += "\\(ga";
        break;
      case '^':
        out += "\\(ha";
        break;
      case '~':
        out += "\\(ti";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string bold(std::string_view text) {
  return "\\fB" + escaped(text) + "\\fR";
}

std::string names_of(const OptionText& option) {
  std::string out;
  for (const std::string& name : option.names) out += (out.empty() ? "" : ", ") + bold(name);
  return out;
}

/// One section of options or of positional arguments; nothing where there are none.
std::string option_section(const CommandText& command, const char* title, bool positional) {
  std::string out;
  for (const OptionText& option : command.options) {
    if (option.is_positional != positional) continue;
    if (out.empty()) out = fmt::format(".SH {}\n", title);
    out +=
        fmt::format(".TP\n{}{}\n{}\n", names_of(option), escaped(option.value), escaped(option.description));
  }
  return out;
}

std::string command_section(const CommandText& command) {
  if (command.commands.empty()) return "";
  std::string out = ".SH COMMANDS\n";
  for (const CommandText& below : command.commands) {
    out += fmt::format(".TP\n{}\n{}; see {}(1)\n", bold(below.path.back()), escaped(below.description),
                       bold(below.name("-")));
  }
  return out;
}

/// Paragraphs; lines that begin with two spaces are a list, kept line by line.
std::string note_section(const std::string& footer) {
  if (footer.empty()) return "";
  std::string out = ".SH NOTES\n";
  bool in_list = false;
  for (std::size_t begin = 0; begin < footer.size();) {
    const std::size_t end = std::min(footer.find('\n', begin), footer.size());
    const std::string_view line = std::string_view(footer).substr(begin, end - begin);
    begin = end + 1;
    const bool of_list = line.substr(0, 2) == "  ";
    if (of_list != in_list) out += of_list ? ".PP\n.nf\n" : ".fi\n.PP\n";
    in_list = of_list;
    out += line.empty() ? ".PP\n" : escaped(line) + "\n";
  }
  return out + (in_list ? ".fi\n" : "");
}

std::string see_also(const CommandText& command) {
  std::string out;
  const auto add = [&](const std::string& name) {
    out += fmt::format("{}{}(1)", out.empty() ? ".SH SEE ALSO\n" : ",\n", bold(name));
  };
  std::string above;
  for (std::size_t i = 0; i + 1 < command.path.size(); ++i) {
    above += (i == 0 ? "" : "-") + command.path[i];
    add(above);
  }
  for (const CommandText& below : command.commands) add(below.name("-"));
  return out.empty() ? "" : out + "\n";
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

void collect_pages(const CommandText& command, const std::string& version,
                   std::vector<std::pair<std::string, std::string>>& pages) {
  pages.emplace_back(command.name("-") + ".1", man_page(command, version));
  for (const CommandText& below : command.commands) collect_pages(below, version, pages);
}

}  // namespace

std::string man_page(const CommandText& command, const std::string& version) {
  const std::string name = command.name("-");
  std::string what = command.description;
  if (const std::string title = name + ": "; what.rfind(title, 0) == 0) what.erase(0, title.size());
  // The synopsis: the command in bold, its arguments plain.
  const std::string typed = command.name(" ");
  std::string out =
      fmt::format(".TH \"{}\" 1 \"\" \"{}\" \"User Commands\"\n", escaped(upper(name)), escaped(version));
  out += fmt::format(".SH NAME\n{} \\- {}\n", escaped(name), escaped(what));
  out += fmt::format(".SH SYNOPSIS\n{}{}\n", bold(typed), escaped(command.usage.substr(typed.size())));
  out += fmt::format(".SH DESCRIPTION\n{}.\n", escaped(what));
  out += option_section(command, "ARGUMENTS", true);
  out += option_section(command, "OPTIONS", false);
  return out + command_section(command) + note_section(command.footer) + see_also(command);
}

std::vector<std::pair<std::string, std::string>> man_pages(const CommandText& command,
                                                           const std::string& version) {
  std::vector<std::pair<std::string, std::string>> pages;
  collect_pages(command, version, pages);
  return pages;
}

}  // namespace slipstack::workbench
