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

/// Largest whole power that is written as a product; larger ones use approx::power().
constexpr int kLargestPower = 8;
constexpr int kDeepest = 100;

struct Function {
  const char* name;
  std::size_t arguments;
  const char* form;  ///< {} for each argument
};

/// The functions that the controller has. approx.h has no implementation of fixed cost for the others.
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

/// Translates by recursive descent. muparser has accepted the expression before, so only functions that the
/// controller does not have must be detected.
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
      condition = fmt::format("approx::select({} != Real(0), {}, {})", condition, yes, no);
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

  /// The sign binds weaker than the power: -x^2 is -(x^2).
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

  /// Right-associative: x^y^z is x^(y^z).
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
    // The user's names get a trailing _, so that they cannot be keywords of C++.
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

}  // namespace

std::string to_cpp(const Definition& definition) {
  return Translator(definition).translate();
}

}  // namespace slipstack::workbench
