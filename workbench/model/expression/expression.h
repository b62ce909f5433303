// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "workbench/model/expression/definition.h"

namespace slipstack::workbench {

/// A name in an expression, and its position.
struct NameInText {
  std::string name;
  std::size_t at = 0;
  bool called = false;  ///< followed by an opening parenthesis
};
std::vector<NameInText> names_in(std::string_view expression);

/// Whether `name` is a function or a constant that expressions know.
bool is_known_name(std::string_view name);

/// Values of the variables at one instant.
struct Instant {
  double t = 0.0;
  double x = 0.0;
  double v = 0.0;
  double a = 0.0;
};

/// The expression of a definition, compiled by muparser. Not thread-safe: one for each thread.
class Expression {
 public:
  /// Throws DefinitionError where the expression is wrong: an unknown name, a parenthesis that is missing or
  /// too many, an operator without operand.
  explicit Expression(const Definition& definition);
  ~Expression();
  Expression(Expression&&) noexcept;
  Expression& operator=(Expression&&) = delete;
  Expression(const Expression&) = delete;
  Expression& operator=(const Expression&) = delete;

  std::size_t parameter_count() const;
  void set(std::size_t parameter, double value);
  /// The value; not finite where the expression is undefined. Some 100 ns.
  double at(const Instant& instant) const;

 private:
  struct Compiled;
  std::unique_ptr<Compiled> compiled_;
};

}  // namespace slipstack::workbench
