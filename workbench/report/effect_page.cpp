// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/effect_page.h"

#include <fmt/format.h>

#include <cmath>

#include "workbench/base/axis_words.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {
namespace {

const char* kGenerated =
    "<!-- Written by `slipstack effects --pages docs/effects`; change the effect's header. -->\n";

std::string unit_text(std::string_view unit) {
  return unit == "1" ? "–" : std::string(unit);
}

std::string bound(double value) {
  return std::abs(value) >= static_cast<double>(kUnbounded) ? (value < 0.0 ? "−∞" : "∞")
                                                            : fmt::format("{:.4g}", value);
}

std::string parameter_row(const std::string& name, std::string_view unit, double lower, double upper,
                          const std::string& role) {
  return fmt::format("| `{}` | {} | {} … {} | {} |\n", name, unit_text(unit), bound(lower), bound(upper),
                     role);
}

const char* role_of(Acts acts) {
  switch (acts) {
    case Acts::force:
      return "gain: adds to the force";
    case Acts::dry:
      return "gain: dry friction, which preload and velocity weakening modulate";
    case Acts::dry_scale:
      return "gain: share by which the dry friction changes";
    case Acts::total_scale:
      return "gain: share by which the whole force changes";
  }
  return "";
}

/// Shapes of one name (slip distances, places of a map) are one row.
std::string shape_rows(const EffectDescription& effect) {
  std::string text;
  for (std::size_t i = 0; i < effect.shapes.size();) {
    std::size_t end = i + 1;
    while (end < effect.shapes.size() && std::string_view(effect.shapes[end].name) == effect.shapes[i].name)
      ++end;
    const ShapeSpec& shape = effect.shapes[i];
    const std::size_t count = end - i;
    text += parameter_row(shape.name, shape.unit, static_cast<double>(shape.lower),
                          static_cast<double>(shape.upper),
                          count > 1 ? fmt::format("shape, {} values", count) : "shape");
    i = end;
  }
  return text;
}

/// How the controller evaluates the effect.
std::string deployment(const EffectDescription& effect) {
  if (effect.has_role(Role::measurement_delay)) {
    return "A lag adds no force: the controller shifts the reference that the compensator sees by delay and "
           "filter together, which is how late a low pass is for what changes slowly against it.";
  }
  return "The controller evaluates the same `basis()` in every tick, from the gains and shapes of the model "
         "file.";
}

}  // namespace

std::string effect_description(const EffectDescription& effect) {
  const EffectText& words = effect.text;
  std::string text = fmt::format("# {}: `{}`\n\n", words.title, words.id);
  text += fmt::format("**Formula.** `{}`\n\n**Source.** {}\n\n", words.formula, sentence(words.source));
  if (effect.gain_count > 0 || !effect.shapes.empty()) {
    text += "| parameter | unit | bounds | role |\n|---|---|---|---|\n";
    for (const GainGroup& group : effect.gain_groups) {
      text += parameter_row(group.name, group.unit, static_cast<double>(group.lower),
                            static_cast<double>(group.upper),
                            group.count > 1 ? fmt::format("{}; {} values", role_of(group.acts), group.count)
                                            : role_of(group.acts));
    }
    text += shape_rows(effect) + "\n";
  }
  text += fmt::format("**What a model without it leaves.** {}\n\n", sentence(words.residual));
  text += fmt::format("**Usual cause.** {}\n\n", sentence(text_of_any_axis(words.cause)));
  text += fmt::format("**Experiment that confirms it.** {}\n\n", sentence(text_of_any_axis(words.confirm)));
  text += fmt::format("**On the controller.** {}\n\n", deployment(effect));
  text += fmt::format("Code: `firmware/effects/{}.h`.\n", words.id);
  return text;
}

std::string effect_page(const EffectDescription& effect) {
  return kGenerated + effect_description(effect);
}

std::string effect_lines(const std::string& indent) {
  std::string text;
  for (const EffectDescription& effect : catalogue()) {
    text += fmt::format("{}{:<31} {}\n", indent, effect.text.id, effect.text.title);
  }
  return text;
}

std::string effect_index() {
  std::string text = fmt::format(
      "{}# The catalogue of effects\n\n| effect | formula | where its residual shows |\n|---|---|---|\n",
      kGenerated);
  for (const EffectDescription& effect : catalogue()) {
    text += fmt::format("| [{}]({}.md) `{}` | `{}` | {} |\n", effect.text.title, effect.text.id,
                        effect.text.id, effect.text.formula, effect.text.residual);
  }
  return text;
}

}  // namespace slipstack::workbench
