// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace slipstack::workbench {

/// What is wrong with the definition of an effect, and where in its text: what() is one line.
class DefinitionError : public std::runtime_error {
 public:
  DefinitionError(const std::string& what, std::string_view text, std::size_t at);
  /// The definition, safe for a terminal.
  const std::string& text() const { return text_; }
  /// Column of the wrong place in text(), from 0.
  std::size_t column() const { return column_; }
  /// Two lines: the text, and a caret under the wrong place.
  std::string picture() const;

 private:
  std::string text_;
  std::size_t column_;
};

/// One parameter of an effect as its definition declares it; SI units.
struct DeclaredParameter {
  struct Bounds {
    double lower;
    double upper;
  };
  std::string name;
  std::string unit;
  std::size_t at = 0;  ///< of the declaration in the text
  std::optional<Bounds> bounds;
};

/// An effect of the user's own, as text: 'name = expression; parameter: unit [in [low, high]]; ...'.
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

/// Names and declarations of a definition. Throws DefinitionError: no name, a name that is taken, a missing
/// or unknown unit, a bound that is no number, reversed bounds, a parameter that is declared twice or not
/// used. The expression itself is read by Expression.
Definition parse_definition(const std::string& text);

}  // namespace slipstack::workbench
