// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/expression/to_cpp.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "workbench/base/text.h"
#include "workbench/model/expression/expression.h"

namespace slipstack::workbench {
namespace {

/// Products that a whole power is written out to.
constexpr int kLargestPower = 8;
constexpr int kDeepest = 100;

struct Function {
  const char* name;
  std::size_t arguments;
  const char* form;  ///< {} for each argument
};

/// What the controller computes. Those that are missing have no fixed sequence of multiplications in
/// approx.h.
constexpr std::array<Function, 13> kFunctions{{
    {"exp", 1, "approx::exp({})"},
    {"ln", 1, "(approx::log2({}) * Real(0.69314718055994531))"},
    {"log", 1, "(approx::log2({}) * Real(0.69314718055994531))"},
    {"log2", 1, "approx::log2({})"},
    {"log10", 1, "(approx::log2({}) * Real(0.30102999566398120))"},
    {"sqrt", 1, "approx::square_root({})"},
    {"abs", 1, "approx::absolute({})"},
    {"sin", 1, "approx::sin_cos_of_cycles(({}) * Real(0.15915494309189535)).sin"},
    {"cos", 1, "approx::sin_cos_of_cycles(({}) * Real(0.15915494309189535)).cos"},
    {"sign", 1, "sign({})"},
    {"tanh", 1, "tanh({})"},
    {"min", 2, "smaller({}, {})"},
    {"max", 2, "larger({}, {})"},
}};

/// A recursive descent over an expression that muparser has taken: what is left to find out is only which
/// functions there are.
class Translator {
 public:
  explicit Translator(const Definition& definition) : definition_(definition), text_(definition.expression) {}

  std::string translate() {
    std::string result = choice();
    blanks();
    if (at_ != text_.size()) fail("has no form for the controller");
    return result;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { fail_at(at_, what); }
  [[noreturn]] void fail_at(std::size_t at, const std::string& what) const {
    throw DefinitionError(what, definition_.text, definition_.expression_at + at);
  }

  void blanks() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  bool take(std::string_view token) {
    blanks();
    if (text_.substr(at_, token.size()) != token) return false;
    at_ += token.size();
    return true;
  }
  void want(std::string_view token) {
    if (!take(token)) fail("has no form for the controller");
  }

  std::string choice() {
    if (++depth_ > kDeepest) fail("is nested too deeply");
    std::string condition = any();
    if (take("?")) {
      const std::string yes = choice();
      want(":");
      const std::string no = choice();
      condition = fmt::format("({} != Real(0) ? {} : {})", condition, yes, no);
    }
    --depth_;
    return condition;
  }

  std::string any() {
    std::string left = all();
    while (take("||")) left = fmt::format("Real({} != Real(0) || {} != Real(0))", left, all());
    return left;
  }

  std::string all() {
    std::string left = comparison();
    while (take("&&")) left = fmt::format("Real({} != Real(0) && {} != Real(0))", left, comparison());
    return left;
  }

  std::string comparison() {
    std::string left = sum();
    while (true) {
      const char* sign = nullptr;
      for (const char* candidate : {"<=", ">=", "==", "!=", "<", ">"}) {
        if (take(candidate)) {
          sign = candidate;
          break;
        }
      }
      if (sign == nullptr) return left;
      left = fmt::format("Real({} {} {})", left, sign, sum());
    }
  }

  std::string sum() {
    std::string left = product();
    while (true) {
      if (take("+")) {
        left = fmt::format("({} + {})", left, product());
      } else if (take("-")) {
        left = fmt::format("({} - {})", left, product());
      } else {
        return left;
      }
    }
  }

  std::string product() {
    std::string left = signed_power();
    while (true) {
      if (take("*")) {
        left = fmt::format("({} * {})", left, signed_power());
      } else if (take("/")) {
        left = fmt::format("({} / {})", left, signed_power());
      } else {
        return left;
      }
    }
  }

  /// The sign binds less than the power: -x^2 is -(x^2).
  std::string signed_power() {
    if (++depth_ > kDeepest) fail("is nested too deeply");
    std::string result;
    if (take("-")) {
      result = fmt::format("(-{})", signed_power());
    } else if (take("+")) {
      result = signed_power();
    } else {
      result = power();
    }
    --depth_;
    return result;
  }

  /// To the right: x^y^z is x^(y^z).
  std::string power() {
    std::string base = operand();
    if (!take("^")) return base;
    blanks();
    const std::size_t start = at_;
    const std::string exponent = signed_power();
    double value = 0.0;
    const std::string_view written = trimmed(text_.substr(start, at_ - start));
    const char* const end = written.data() + written.size();
    const bool whole = parse_double(written.data(), end, value) == end && value == std::floor(value) &&
                       value >= 1.0 && value <= kLargestPower;
    if (!whole) return fmt::format("approx::power({}, {})", base, exponent);
    return fmt::format("whole_power<{}>({})", static_cast<int>(value), base);
  }

  std::string operand() {
    blanks();
    if (take("(")) {
      std::string inside = choice();
      want(")");
      return inside;
    }
    if (at_ < text_.size() &&
        (std::isdigit(static_cast<unsigned char>(text_[at_])) != 0 || text_[at_] == '.')) {
      double value = 0.0;
      const char* const begin = text_.data() + at_;
      const char* const end = parse_double(begin, text_.data() + text_.size(), value);
      if (end == nullptr) fail("has no form for the controller");
      at_ += static_cast<std::size_t>(end - begin);
      return fmt::format("Real({:.17g})", value);
    }
    return name();
  }

  std::string name() {
    const std::size_t start = at_;
    while (at_ < text_.size() &&
           (std::isalnum(static_cast<unsigned char>(text_[at_])) != 0 || text_[at_] == '_')) {
      ++at_;
    }
    const std::string word(text_.substr(start, at_ - start));
    if (word.empty()) fail("has no form for the controller");
    if (take("(")) return call(word, start);
    if (word == "pi" || word == "_pi") return "Real(3.1415926535897931)";
    if (word == "_e") return "Real(2.7182818284590451)";
    // Names of the user's own end in _, so that no key word of the language meets them.
    const bool variable =
        std::find(std::begin(kVariables), std::end(kVariables), word) != std::end(kVariables);
    return variable ? word : word + "_";
  }

  std::string call(const std::string& word, std::size_t start) {
    std::vector<std::string> arguments;
    do {
      arguments.push_back(choice());
    } while (take(","));
    want(")");
    const auto function = std::find_if(kFunctions.begin(), kFunctions.end(),
                                       [&](const Function& one) { return word == one.name; });
    if (function == kFunctions.end()) {
      fail_at(start,
              fmt::format("the controller has no '{}'; it has exp, ln, log2, log10, sqrt, abs, sin, cos, "
                          "sign, tanh, min and max",
                          word));
    }
    if (function->arguments == 1) return fmt::format(fmt::runtime(function->form), arguments.at(0));
    std::string result = arguments.at(0);
    for (std::size_t i = 1; i < arguments.size(); ++i) {
      result = fmt::format(fmt::runtime(function->form), result, arguments[i]);
    }
    return result;
  }

  const Definition& definition_;
  std::string_view text_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

/// snag_here -> SnagHere.
std::string class_name(const std::string& name) {
  std::string result;
  bool upper = true;
  for (const char c : name) {
    if (c == '_') {
      upper = true;
      continue;
    }
    result += upper ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    upper = false;
  }
  return result.empty() || std::isdigit(static_cast<unsigned char>(result[0])) != 0 ? "Own" + result : result;
}

std::string number(const std::optional<DeclaredParameter::Bounds>& bounds, bool lower) {
  if (!bounds) return lower ? "-kUnbounded" : "kUnbounded";
  return fmt::format("static_cast<float>({:.9g})", lower ? bounds->lower : bounds->upper);
}

std::string literal(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) result += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return result + "\"";
}

std::string parameters_of(const Definition& definition, const std::vector<std::size_t>& which, bool gains) {
  std::string rows;
  for (const std::size_t p : which) {
    const DeclaredParameter& own = definition.parameters[p];
    rows += fmt::format("      {{{}, {}, {}, {}, {}}},\n", literal(own.name), literal(own.unit),
                        number(own.bounds, true), number(own.bounds, false),
                        gains ? "1, Acts::force" : "ShapeKind::user_defined");
  }
  return rows;
}

constexpr const char* kHeader = R"(// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/approx.h"
#include "firmware/effects/effect.h"

// Made by `slipstack effects --header` of
//   {definition}
namespace slipstack {{

template <class Real>
class {class_name} {{
 public:
  static constexpr EffectText text{{
      .id = {id},
      .title = {title},
      .formula = {formula},
      .source = "given by the user",
      .residual = {residual},
      .evidence = {residual},
      .cause = "what the one who wrote the expression had in mind",
      .confirm = "record again where the expression says that the force is large, and beside it"}};
  static constexpr std::array<GainGroup, {gain_count}> gains{{{{
{gains}  }}}};
  static constexpr std::array<ShapeSpec, {shape_count}> shapes{{{{
{shapes}  }}}};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = {shape_count};

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>&) {{
    static_cast<void>(shape);
{prepare}  }}
  void reset(const Sample<Real>&) {{}}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {{
{basis}  }}

 private:
  static constexpr Real sign(Real y) {{ return Real(y > Real(0)) - Real(y < Real(0)); }}
  static constexpr Real smaller(Real a, Real b) {{ return a < b ? a : b; }}
  static constexpr Real larger(Real a, Real b) {{ return a > b ? a : b; }}
  static constexpr Real tanh(Real y) {{
    const Real bounded = approx::clamp(y, Real(-20), Real(20));
    const Real e = approx::exp_minus_one(bounded + bounded);
    return e / (e + Real(2));
  }}
  template <int kPower>
  static constexpr Real whole_power(Real y) {{
    Real product = y;
    for (int i = 1; i < kPower; ++i) product *= y;
    return product;
  }}

  /// The expression.
  constexpr Real force(const Sample<Real>& sample{arguments}) const {{
    [[maybe_unused]] const Real t = sample.time_s;
    [[maybe_unused]] const Real x = sample.position_m;
    [[maybe_unused]] const Real v = sample.velocity_mps;
    [[maybe_unused]] const Real a = sample.acceleration_mps2;
    return {expression};
  }}
{members}}};

}}  // namespace slipstack
)";

}  // namespace

std::string to_cpp(const Definition& definition) {
  return Translator(definition).translate();
}

std::string to_effect_header(const Definition& definition, const ParameterRoles& roles) {
  std::string prepare, basis, arguments, members;
  for (std::size_t i = 0; i < roles.shapes.size(); ++i) {
    const std::string& name = definition.parameters[roles.shapes[i]].name;
    prepare += fmt::format("    {}_ = shape[{}];\n", name, i);
    members += fmt::format("{}  Real {}_{{}};\n", i == 0 ? "\n" : "", name);
  }
  for (std::size_t g = 0; g < roles.gains.size(); ++g) {
    arguments += fmt::format(", Real {}_", definition.parameters[roles.gains[g]].name);
    std::string ones;
    for (std::size_t k = 0; k < roles.gains.size(); ++k) ones += k == g ? ", Real(1)" : ", Real(0)";
    basis += fmt::format("    out[{}] = force(sample{});\n", g, ones);
  }
  return fmt::format(fmt::runtime(kHeader), fmt::arg("definition", definition.text),
                     fmt::arg("class_name", class_name(definition.name)),
                     fmt::arg("id", literal(definition.name)),
                     fmt::arg("title", literal(definition.name + " (own effect)")),
                     fmt::arg("formula", literal("F = " + definition.expression)),
                     fmt::arg("residual", literal("follows " + definition.expression)),
                     fmt::arg("gain_count", roles.gains.size()), fmt::arg("shape_count", roles.shapes.size()),
                     fmt::arg("gains", parameters_of(definition, roles.gains, true)),
                     fmt::arg("shapes", parameters_of(definition, roles.shapes, false)),
                     fmt::arg("prepare", prepare), fmt::arg("basis", basis), fmt::arg("arguments", arguments),
                     fmt::arg("expression", to_cpp(definition)), fmt::arg("members", members));
}

}  // namespace slipstack::workbench
