// SPDX-License-Identifier: Apache-2.0
#include "workbench/manual/command_text.h"

#include <array>
#include <utility>

#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

std::string put_together(const std::vector<std::string>& words, const std::string& separator) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : separator) + word;
  return out;
}

/// The words of a closed choice, which the parser's check names as "{float,double}".
std::vector<std::string> choices_of(const std::string& type) {
  const std::size_t begin = type.rfind('{');
  if (begin == std::string::npos || type.back() != '}') return {};
  std::vector<std::string> choices;
  for (const std::string_view word :
       split_fields(std::string_view(type).substr(begin + 1, type.size() - begin - 2))) {
    choices.emplace_back(word);
  }
  return choices;
}

ValueKind kind_of_value(const std::string& name) {
  // By the names of values that the commands use.
  static constexpr std::array kKinds{
      std::pair{"FILE", ValueKind::file},      std::pair{"FILE...", ValueKind::file},
      std::pair{"LOG", ValueKind::file},       std::pair{"LOG...", ValueKind::file},
      std::pair{"MODEL", ValueKind::file},     std::pair{"IMAGE", ValueKind::file},
      std::pair{"READINGS", ValueKind::file},  std::pair{"NAME|FILE", ValueKind::file},
      std::pair{"FOLDER", ValueKind::folder},  std::pair{"DIR", ValueKind::folder},
      std::pair{"A,B,..", ValueKind::effects}, std::pair{"ID", ValueKind::effect},
  };
  for (const auto& [known, kind] : kKinds) {
    if (name == known) return kind;
  }
  return ValueKind::any;
}

OptionText option_text(const CLI::Option& option) {
  OptionText text;
  text.is_positional = option.get_positional() && !option.nonpositional();
  if (text.is_positional) {
    text.names.push_back(option.get_name(true));
  } else {
    for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
  }
  text.is_repeated = option.get_items_expected_max() >= CLI::detail::expected_max_vector_size;
  text.value = CLI::Formatter().make_option_opts(&option);
  text.description = option.get_description();
  if (option.get_items_expected_max() == 0) {
    text.kind = ValueKind::none;
    return text;
  }
  const std::string type = option.get_type_name();
  text.value_name = type.substr(0, type.find(':'));
  text.choices = choices_of(type);
  text.kind = text.choices.empty() ? kind_of_value(text.value_name) : ValueKind::choice;
  return text;
}

CommandText described(const CLI::App& app, std::vector<std::string> path) {
  CommandText text;
  text.path = std::move(path);
  text.description = app.get_description();
  text.footer = app.get_footer();
  const std::string usage = CLI::Formatter().make_usage(&app, text.name(" "));
  const std::string label = "Usage:";
  text.usage = std::string(trimmed(usage.substr(usage.find(label) + label.size())));
  while (!text.usage.empty() && text.usage.back() == '\n') text.usage.pop_back();
  for (const CLI::Option* option : app.get_options()) text.options.push_back(option_text(*option));
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    std::vector<std::string> below = text.path;
    below.push_back(command->get_name());
    text.commands.push_back(described(*command, std::move(below)));
  }
  return text;
}

}  // namespace

std::string CommandText::name(const std::string& separator) const {
  return put_together(path, separator);
}

std::string with_blanks(const std::vector<std::string>& words) {
  return put_together(words, " ");
}

CommandText command_text(const CLI::App& app, const std::string& name) {
  return described(app, {name});
}

}  // namespace slipstack::workbench
