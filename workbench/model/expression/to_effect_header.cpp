// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cctype>
#include <optional>
#include <string>
#include <vector>

#include "workbench/model/expression/to_cpp.h"

namespace slipstack::workbench {
namespace {

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
  return result.empty() || std::isdigit(static_cast<unsigned char>(result[0])) != 0 ? "User" + result
                                                                                    : result;
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
    const DeclaredParameter& parameter = definition.parameters[p];
    rows += fmt::format("      {{{}, {}, {}, {}, {}}},\n", literal(parameter.name), literal(parameter.unit),
                        number(parameter.bounds, true), number(parameter.bounds, false),
                        gains ? "1, Acts::force" : "ShapeKind::user_defined");
  }
  return rows;
}

constexpr const char* kHeader = R"(// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/numerics/approx.h"
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
      .cause = "what the author of the expression had in mind",
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
  static constexpr Real smaller(Real a, Real b) {{ return approx::select(a < b, a, b); }}
  static constexpr Real larger(Real a, Real b) {{ return approx::select(a > b, a, b); }}
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
                     fmt::arg("title", literal(definition.name + " (user-defined effect)")),
                     fmt::arg("formula", literal("F = " + definition.expression)),
                     fmt::arg("residual", literal("follows " + definition.expression)),
                     fmt::arg("gain_count", roles.gains.size()), fmt::arg("shape_count", roles.shapes.size()),
                     fmt::arg("gains", parameters_of(definition, roles.gains, true)),
                     fmt::arg("shapes", parameters_of(definition, roles.shapes, false)),
                     fmt::arg("prepare", prepare), fmt::arg("basis", basis), fmt::arg("arguments", arguments),
                     fmt::arg("expression", to_cpp(definition)), fmt::arg("members", members));
}

}  // namespace slipstack::workbench
