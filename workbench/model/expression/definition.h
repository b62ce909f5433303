// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace slipstack::workbench {

/// An error in the definition of an effect, and where in its text it is. what() is one line.
class DefinitionError : public std::runtime_error {
 public:
  DefinitionError(const std::string& what, std::string_view text, std::size_t at);
  /// The definition, safe for a terminal.
  const std::string& text() const { return text_; }
  /// Column of the error in text(), from 0.
  std::size_t column() const { return column_; }
  /// Two lines: the text, and a caret under the error.
  std::string picture() const;

 private:
  std::string text_;
  std::size_t column_;
};

/// One parameter of an effect, as declared; SI units.
struct DeclaredParameter {
  struct Bounds {
    double lower;
    double upper;
  };
  std::string name;
  std::string unit;
  std::size_t at = 0;  ///< position of the declaration in the text
  std::optional<Bounds> bounds;
};

/// A user-defined effect as text: 'name = expression; parameter: unit [in [low, high]]; ...'.
struct Definition {
  std::string text;
  std::string name;
  std::string expression;
  std::size_t expression_at = 0;
  std::vector<DeclaredParameter> parameters;
};

/// Variables that an expression may use, SI units: time since the start of the log, position, velocity,
/// acceleration.
inline constexpr std::string_view kVariables[] = {"t", "x", "v", "a"};

/// Parses the names and declarations of a definition. Throws DefinitionError for a missing or reserved name,
/// a missing or unknown unit, a bound that is no number, reversed bounds, a parameter that is declared twice
/// or not used. The expression itself is parsed by Expression.
Definition parse_definition(const std::string& text);

}  // namespace slipstack::workbench
