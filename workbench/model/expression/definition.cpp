// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/expression/definition.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "workbench/base/text.h"
#include "workbench/model/expression/expression.h"
#include "workbench/model/expression/units.h"

namespace slipstack::workbench {
namespace {

/// A longer text is a file given by mistake.
constexpr std::size_t kLongestText = 4000;
constexpr std::size_t kLongestIdentifier = 40;
constexpr std::size_t kMostParameters = 16;

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

/// A part of the text, with its position.
struct TextRange {
  std::string_view text;
  std::size_t at = 0;

  TextRange from(std::size_t offset) const { return {text.substr(offset), at + offset}; }
  TextRange until(std::size_t offset) const { return {text.substr(0, offset), at}; }
  TextRange trimmed() const {
    std::size_t first = 0;
    std::size_t last = text.size();
    while (first < last && is_blank(text[first])) ++first;
    while (last > first && is_blank(text[last - 1])) --last;
    return {text.substr(first, last - first), at + first};
  }
  std::size_t end() const { return at + text.size(); }
};

/// Position of the '=' that ends the name: not part of ==, <=, >= or !=.
std::size_t find_equals(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    const bool comparison = (i > 0 && std::string_view("<>!=").find(text[i - 1]) != std::string_view::npos) ||
                            (i + 1 < text.size() && text[i + 1] == '=');
    if (!comparison) return i;
  }
  return std::string_view::npos;
}

class DefinitionReader {
 public:
  explicit DefinitionReader(const std::string& text) : text_(text) {}

  Definition read() const {
    if (text_.size() > kLongestText) {
      throw DefinitionError(
          fmt::format("the definition has {} characters, more than {}", text_.size(), kLongestText),
          text_.substr(0, 60), 0);
    }
    for (std::size_t i = 0; i < text_.size(); ++i) {
      const auto c = static_cast<unsigned char>(text_[i]);
      if (c < 0x20 ? c != '\t' : c >= 0x7f) fail(i, "only plain ASCII characters are understood here");
    }
    Definition definition;
    definition.text = text_;
    std::size_t start = 0;
    for (bool first = true; start <= text_.size(); first = false) {
      const std::size_t end = std::min(text_.find(';', start), text_.size());
      const TextRange range = TextRange{std::string_view(text_).substr(start, end - start), start}.trimmed();
      if (first) {
        read_head(range, definition);
      } else if (!range.text.empty()) {
        read_parameter(range, definition);
      }
      start = end + 1;
    }
    check_used(definition);
    return definition;
  }

 private:
  [[noreturn]] void fail(std::size_t at, const std::string& what) const {
    throw DefinitionError(what, text_, at);
  }

  void check_name(const TextRange& name, std::string_view what) const {
    if (name.text.empty()) fail(name.at, fmt::format("{} is missing", what));
    for (std::size_t i = 0; i < name.text.size(); ++i) {
      const auto c = static_cast<unsigned char>(name.text[i]);
      const bool good = std::isalpha(c) != 0 || c == '_' || (i > 0 && std::isdigit(c) != 0);
      if (!good) {
        fail(name.at + i, fmt::format("{} {} must be made of letters, digits and _, a letter first", what,
                                      in_quotes(name.text)));
      }
    }
    if (name.text.size() > kLongestIdentifier) {
      fail(name.at, fmt::format("{} is longer than {} characters", what, kLongestIdentifier));
    }
  }

  void read_head(const TextRange& range, Definition& definition) const {
    const std::size_t equals = find_equals(range.text);
    if (equals == std::string_view::npos) {
      fail(range.at, "no '='; write 'name = expression; parameter: unit; ...'");
    }
    const TextRange name = range.until(equals).trimmed();
    check_name(name, "the name of the effect");
    definition.name = name.text;
    const TextRange expression = range.from(equals + 1).trimmed();
    if (expression.text.empty()) fail(expression.at, "the expression is missing");
    definition.expression = expression.text;
    definition.expression_at = expression.at;
  }

  void read_parameter(const TextRange& range, Definition& definition) const {
    const std::size_t colon = range.text.find(':');
    const TextRange name = range.until(std::min(colon, range.text.size())).trimmed();
    if (colon == std::string_view::npos) {
      fail(range.end(), fmt::format("the unit of {} is missing; write '{}: unit', 1 for a number",
                                    in_quotes(name.text), printable(name.text, kLongestIdentifier)));
    }
    check_name(name, "the name of a parameter");
    if (std::find(std::begin(kVariables), std::end(kVariables), name.text) != std::end(kVariables)) {
      fail(name.at, fmt::format("{} is a variable; call the parameter otherwise", in_quotes(name.text)));
    }
    if (is_known_name(name.text)) {
      fail(name.at,
           fmt::format("{} is a function or a constant; call the parameter otherwise", in_quotes(name.text)));
    }
    for (const DeclaredParameter& other : definition.parameters) {
      if (other.name == name.text) fail(name.at, fmt::format("{} is declared twice", in_quotes(name.text)));
    }
    if (definition.parameters.size() == kMostParameters) {
      fail(name.at, fmt::format("more than {} parameters", kMostParameters));
    }
    DeclaredParameter parameter;
    parameter.name = name.text;
    parameter.at = name.at;
    read_unit_and_bounds(range.from(colon + 1).trimmed(), parameter);
    definition.parameters.push_back(std::move(parameter));
  }

  void read_unit_and_bounds(const TextRange& range, DeclaredParameter& parameter) const {
    std::size_t in = range.text.find(" in ");
    if (in == std::string_view::npos) in = range.text.find(" in[");
    const TextRange unit = range.until(std::min(in, range.text.size())).trimmed();
    if (unit.text.empty() || unit.text.starts_with("in ") || unit.text == "in" || unit.text[0] == '[') {
      fail(range.at, fmt::format("the unit of '{}' is missing; 1 for a number", parameter.name));
    }
    if (const std::string fault = unit_fault(unit.text); !fault.empty()) fail(unit.at, fault);
    parameter.unit = unit.text;
    if (in != std::string_view::npos) read_bounds(range.from(in + 3).trimmed(), parameter);
  }

  void read_bounds(const TextRange& range, DeclaredParameter& parameter) const {
    const std::size_t comma = range.text.find(',');
    const bool brackets = range.text.size() > 1 && range.text.front() == '[' && range.text.back() == ']';
    if (!brackets || comma == std::string_view::npos) {
      const bool open = !range.text.empty() && range.text.front() == '[';
      fail(open ? range.end() : range.at, "bounds are written [low, high]");
    }
    const TextRange low = range.until(comma).from(1).trimmed();
    const TextRange high = range.until(range.text.size() - 1).from(comma + 1).trimmed();
    DeclaredParameter::Bounds bounds{number(low), number(high)};
    if (bounds.lower >= bounds.upper) {
      fail(low.at, fmt::format("the bounds of '{}' are reversed or equal; write the lower one first",
                               parameter.name));
    }
    parameter.bounds = bounds;
  }

  double number(const TextRange& range) const {
    constexpr double kLargest = 1e12;
    double value = 0.0;
    const char* const end = range.text.data() + range.text.size();
    if (range.text.empty() || parse_double(range.text.data(), end, value) != end || !std::isfinite(value)) {
      fail(range.at, fmt::format("a bound {}", range.text.empty() ? "is missing" : "is not a number"));
    }
    if (std::abs(value) > kLargest) fail(range.at, fmt::format("a bound is beyond {:g}", kLargest));
    return value;
  }

  void check_used(const Definition& definition) const {
    const std::vector<NameInText> names = names_in(definition.expression);
    for (const DeclaredParameter& parameter : definition.parameters) {
      const bool used = std::any_of(names.begin(), names.end(),
                                    [&](const NameInText& name) { return name.name == parameter.name; });
      if (!used) {
        fail(parameter.at,
             fmt::format("'{}' is declared, but the expression does not use it", parameter.name));
      }
    }
  }

  const std::string& text_;
};

}  // namespace

DefinitionError::DefinitionError(const std::string& what, std::string_view text, std::size_t at)
    : std::runtime_error(what), text_(printable(text)), column_(std::min(at, text_.size())) {}

std::string DefinitionError::picture() const {
  // A long definition is shortened to the surroundings of the error.
  constexpr std::size_t kBefore = 60;
  constexpr std::size_t kWidth = 100;
  const std::size_t from = column_ > kBefore && text_.size() > kWidth ? column_ - kBefore : 0;
  return fmt::format("  {}\n  {}^\n", text_.substr(from, kWidth), std::string(column_ - from, ' '));
}

Definition parse_definition(const std::string& text) {
  return DefinitionReader(text).read();
}

}  // namespace slipstack::workbench
