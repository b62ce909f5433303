// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/c_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <span>
#include <string_view>

#include "workbench/base/axis_units.h"

namespace slipstack::workbench {
namespace {

std::string macro_name(const std::string& effect, std::string_view parameter) {
  std::string name = "SLIPSTACK_" + effect + "_" + std::string(parameter);
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) {
    return std::isalnum(c) != 0 ? static_cast<char>(std::toupper(c)) : '_';
  });
  return name;
}

/// A float literal that reads back as the same float; always with a point or an exponent.
std::string literal(double value) {
  std::string text = fmt::format("{:.9g}", static_cast<double>(static_cast<float>(value)));
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text + "F";
}

std::string constant(const std::string& effect, std::string_view name, const char* unit,
                     std::span<const double> values) {
  std::string text = fmt::format("/* {} */\n", axis_unit(unit));
  if (values.size() == 1) {
    return text + fmt::format("static const float {} = {};\n", macro_name(effect, name), literal(values[0]));
  }
  text += fmt::format("static const float {}[{}] = {{\n", macro_name(effect, name), values.size());
  for (const double value : values) text += fmt::format("  {},\n", literal(value));
  return text + "};\n";
}

std::string term_text(const Term& term) {
  std::string text = fmt::format("\n/* {} */\n", term.effect->text.title);
  const std::vector<ShapeSpec>& specs = term.effect->shapes;
  for (std::size_t i = 0; i < term.shapes.size();) {
    std::size_t end = i + 1;
    while (end < term.shapes.size() && std::string_view(specs[end].name) == specs[i].name) ++end;
    text += constant(term.id(), specs[i].name, specs[i].unit, std::span(term.shapes).subspan(i, end - i));
    i = end;
  }
  std::size_t first = 0;
  for (const GainGroup& group : term.effect->gain_groups) {
    const auto count = std::min(static_cast<std::size_t>(group.count), term.gains.size() - first);
    text += constant(term.id(), group.name, group.unit, std::span(term.gains).subspan(first, count));
    first += count;
  }
  return text;
}

}  // namespace

std::string to_c_header(const Model& model) {
  std::string text = fmt::format(
      "/* Friction model for the controller, hash {:08x}; written by slipstack. SI units. */\n"
      "#ifndef SLIPSTACK_MODEL_H\n#define SLIPSTACK_MODEL_H\n",
      target_hash(model));
  for (const Term& term : model.target_terms) text += term_text(term);
  return text + "\n#endif\n";
}

}  // namespace slipstack::workbench
