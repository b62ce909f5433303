// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/expression/expression.h"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <cctype>
#include <limits>

#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

bool starts_name(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
}

bool continues_name(char c) {
  return starts_name(c) || std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// A parser that knows the functions and constants of expressions, and no variables.
mu::Parser bare_parser() {
  mu::Parser parser;
  parser.DefineConst("pi", 3.141592653589793);
  parser.EnableOptimizer(true);
  return parser;
}

/// The matching of parentheses, told apart from muparser's: at the very place.
void check_parentheses(const Definition& definition) {
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < definition.expression.size(); ++i) {
    const std::size_t at = definition.expression_at + i;
    if (definition.expression[i] == '(') open.push_back(at);
    if (definition.expression[i] != ')') continue;
    if (open.empty()) throw DefinitionError("this parenthesis closes nothing", definition.text, at);
    open.pop_back();
  }
  if (!open.empty()) throw DefinitionError("this parenthesis is not closed", definition.text, open.back());
}

void check_names(const Definition& definition) {
  for (const NameInText& name : names_in(definition.expression)) {
    const auto& own = definition.parameters;
    const bool parameter =
        std::any_of(own.begin(), own.end(), [&](const auto& one) { return one.name == name.name; });
    const bool variable =
        std::find(std::begin(kVariables), std::end(kVariables), name.name) != std::end(kVariables);
    if (parameter || variable || is_known_name(name.name)) continue;
    const std::string help =
        name.called
            ? "no such function; there are sin, cos, tan, exp, ln, sqrt, abs, sign, tanh, min, max, ..."
            : fmt::format("declare it: '; {}: unit'; variables are t, x, v and a", name.name);
    throw DefinitionError(fmt::format("unknown name {}: {}", in_quotes(name.name), help), definition.text,
                          definition.expression_at + name.at);
  }
}

/// Expressions are values: nothing in them is assigned.
void check_assignments(const Definition& definition) {
  const std::string_view text = definition.expression;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    const bool pair = (i + 1 < text.size() && text[i + 1] == '=');
    const bool ends = i > 0 && std::string_view("<>!=").find(text[i - 1]) != std::string_view::npos;
    if (!pair && !ends) {
      throw DefinitionError("a second '='; equality is written ==", definition.text,
                            definition.expression_at + i);
    }
  }
}

std::string reason(const mu::ParserError& error) {
  switch (error.GetCode()) {
    case mu::ecUNEXPECTED_EOF:
      return "the expression ends too early";
    case mu::ecUNEXPECTED_OPERATOR:
      return fmt::format("operator {} is not expected here", in_quotes(error.GetToken()));
    case mu::ecUNEXPECTED_VAL:
      return "a number is not expected here; is an operator missing?";
    case mu::ecUNEXPECTED_VAR:
      return "a name is not expected here; is an operator missing?";
    case mu::ecUNEXPECTED_FUN:
      return "a function is not expected here; is an operator missing?";
    case mu::ecUNEXPECTED_ARG_SEP:
      return "a comma is not expected here";
    case mu::ecUNEXPECTED_PARENS:
      return "a parenthesis is not expected here; is an operator or an operand missing?";
    case mu::ecTOO_MANY_PARAMS:
      return "too many arguments";
    case mu::ecTOO_FEW_PARAMS:
      return "too few arguments";
    default:
      return printable(error.GetMsg(), 120);
  }
}

}  // namespace

std::vector<NameInText> names_in(std::string_view expression) {
  std::vector<NameInText> names;
  for (std::size_t i = 0; i < expression.size();) {
    if (std::isdigit(static_cast<unsigned char>(expression[i])) != 0 || expression[i] == '.') {
      // A number, whose exponent is no name.
      const char* const begin = expression.data() + i;
      double value = 0.0;
      const char* const end = parse_double(begin, expression.data() + expression.size(), value);
      i += end == nullptr ? 1 : static_cast<std::size_t>(end - begin);
      continue;
    }
    if (!starts_name(expression[i])) {
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < expression.size() && continues_name(expression[end])) ++end;
    std::size_t next = end;
    while (next < expression.size() && expression[next] == ' ') ++next;
    names.push_back(
        {std::string(expression.substr(i, end - i)), i, next < expression.size() && expression[next] == '('});
    i = end;
  }
  return names;
}

bool is_known_name(std::string_view name) {
  static const mu::Parser parser = bare_parser();
  const std::string own(name);
  return parser.GetFunDef().contains(own) || parser.GetConst().contains(own);
}

struct Expression::Compiled {
  mu::Parser parser = bare_parser();
  Instant instant;
  std::vector<double> parameters;
};

Expression::Expression(const Definition& definition) : compiled_(std::make_unique<Compiled>()) {
  check_parentheses(definition);
  check_assignments(definition);
  check_names(definition);
  mu::Parser& parser = compiled_->parser;
  compiled_->parameters.assign(definition.parameters.size(), 1.0);
  try {
    parser.DefineVar("t", &compiled_->instant.t);
    parser.DefineVar("x", &compiled_->instant.x);
    parser.DefineVar("v", &compiled_->instant.v);
    parser.DefineVar("a", &compiled_->instant.a);
    for (std::size_t i = 0; i < definition.parameters.size(); ++i) {
      parser.DefineVar(definition.parameters[i].name, &compiled_->parameters[i]);
    }
    parser.SetExpr(definition.expression);
    parser.Eval();
  } catch (const mu::ParserError& error) {
    // muparser counts from 0, past the end where the expression ends too early, and past some tokens.
    std::size_t at = error.GetPos() < 0 ? 0 : static_cast<std::size_t>(error.GetPos());
    at = std::min(at, definition.expression.size());
    throw DefinitionError(reason(error), definition.text, definition.expression_at + at);
  }
}

Expression::~Expression() = default;
Expression::Expression(Expression&&) noexcept = default;

std::size_t Expression::parameter_count() const {
  return compiled_->parameters.size();
}

void Expression::set(std::size_t parameter, double value) {
  compiled_->parameters[parameter] = value;
}

double Expression::at(const Instant& instant) const {
  compiled_->instant = instant;
  try {
    return compiled_->parser.Eval();
  } catch (const mu::ParserError&) {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace slipstack::workbench
