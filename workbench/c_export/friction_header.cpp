// SPDX-License-Identifier: Apache-2.0
#include "workbench/c_export/friction_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "firmware/friction/packed_maxwell_slip.h"
#include "workbench/base/axis_units.h"
#include "workbench/base/axis_words.h"
#include "workbench/base/errors.h"
#include "workbench/c_export/c_functions.h"
#include "workbench/c_export/record_model.h"

namespace slipstack::workbench {
namespace {

/// Longer expressions get a name of their own.
constexpr std::size_t kLongestInline = 72;

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

/// Text that may stand within a comment.
std::string in_comment(std::string text) {
  replace_all(text, "*/", "* /");
  return text;
}

/// The formula of an effect, for a comment; velocities in it have the unit of the axis.
std::string formula_in_comment(const EffectText& text) {
  std::string formula = text.formula;
  replace_all(formula, " m/s", " " + axis_unit("m/s"));
  return in_comment(std::move(formula));
}

/// All of this file writes the names of a linear axis; here each identifier that ends with a unit gets that
/// of the axis: position_m becomes position_rad, force_N torque_Nm. Before the user's own prefix is in it.
std::string with_axis_names(const std::string& text) {
  const auto is_part = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    std::size_t end = at;
    while (end < text.size() && is_part(text[end])) ++end;
    if (end == at) {
      out += text[at++];
      continue;
    }
    out += axis_key(std::string_view(text).substr(at, end - at));
    at = end;
  }
  return out;
}

/// Writes values as C statements, each once, after those that it needs.
class Statements {
 public:
  Statements(const RecordedModel& model, const std::set<ValueId>& used)
      : values_(model.recording->values()), used_(used) {
    for (const ValueId id : used) {
      for (const ValueId operand : values_[id].operands) ++uses_[operand];
    }
    ++uses_[model.force_N];
    for (const RecordedModel::Effect& effect : model.effects) {
      if (effect.force_N) named_.emplace(*effect.force_N, fmt::format("{}_N", effect.text.id));
    }
    for (const RecordedModel::Memory& memory : model.memory) ++uses_[memory.next];
  }

  /// Of the values that `id` depends on, those that are used.
  void write_used(ValueId id) {
    if (used_.contains(id)) {
      if (!values_[id].is_leaf() && !names_.contains(id)) write(id, expression(id));
      return;
    }
    for (const ValueId operand : values_[id].operands) write_used(operand);
  }

  /// An expression for the value. `binding`: of the operator that it is an operand of; looser ones get
  /// parentheses.
  std::string text_of(ValueId id, int binding = 0) {
    if (const auto known = names_.find(id); known != names_.end()) return known->second;
    const ComputationRecord::Value& value = values_[id];
    if (value.is_leaf()) return value.form;
    const std::string text = expression(id);
    const bool is_own_line = uses_[id] > 1 || value.type == "@pair" || named_.contains(id);
    if (is_own_line || text.size() > kLongestInline) return write(id, text);
    return binding_of(value) < binding ? "(" + text + ")" : text;
  }

  const std::string& text() const { return text_; }
  void add(const std::string& line) { text_ += line; }

 private:
  static constexpr int kSum = 2, kProduct = 3, kTightest = 4;

  /// How tightly the outermost operator of a form binds.
  static int binding_of(const ComputationRecord::Value& value) {
    if (!value.compound) return kTightest;
    if (value.form == "{} + {}" || value.form == "{} - {}") return kSum;
    if (value.form == "{} * {}" || value.form == "{} / {}") return kProduct;
    return 1;
  }

  std::string expression(ValueId id) {
    const ComputationRecord::Value& value = values_[id];
    const int binding = binding_of(value);
    const bool is_arithmetic = binding == kSum || binding == kProduct;
    std::string text;
    std::size_t operand = 0;
    for (std::size_t at = 0; at < value.form.size(); ++at) {
      if (value.form.compare(at, 2, "{}") != 0) {
        text += value.form[at];
        continue;
      }
      // Operators bind from the left. Within brackets of a call nothing needs parentheses.
      const bool is_enclosed = !value.compound && at != 0 && at + 2 != value.form.size();
      const int needed = is_enclosed ? 0 : !is_arithmetic ? kTightest : operand == 0 ? binding : binding + 1;
      text += text_of(value.operands[operand++], needed);
      ++at;
    }
    return text;
  }

  std::string write(ValueId id, const std::string& expression) {
    const auto named = named_.find(id);
    std::string name = named != named_.end() ? named->second : fmt::format("t{}", ++temporaries_);
    text_ += fmt::format("  const {} {} = {};\n", values_[id].type, name, expression);
    names_[id] = name;
    return name;
  }

  const std::vector<ComputationRecord::Value>& values_;
  const std::set<ValueId>& used_;
  std::map<ValueId, int> uses_;
  std::map<ValueId, std::string> named_;  ///< the forces of the effects
  std::map<ValueId, std::string> names_;  ///< of what is written
  std::string text_;
  int temporaries_ = 0;
};

std::set<ValueId> used_values(const RecordedModel& model) {
  std::set<ValueId> used;
  model.recording->add_used(model.force_N, used);
  for (const RecordedModel::Memory& memory : model.memory) model.recording->add_used(memory.next, used);
  return used;
}

std::string step_function(const RecordedModel& model) {
  const std::set<ValueId> used = used_values(model);
  Statements statements(model, used);
  for (const RecordedModel::Effect& effect : model.effects) {
    if (!effect.force_N) continue;
    statements.add(
        fmt::format("  /* {}: {} */\n", in_comment(effect.text.title), formula_in_comment(effect.text)));
    statements.write_used(*effect.force_N);
  }
  // The new state after all that reads the old one.
  const std::string force = statements.text_of(model.force_N);
  std::vector<std::string> next;
  for (const RecordedModel::Memory& memory : model.memory) {
    next.push_back(statements.text_of(memory.next));
  }
  std::string text = fmt::format(
      "/* One tick: the {} in {} that friction and inertia take, positive towards {}. The motion is that at "
      "this\n"
      "   tick. */\n"
      "static inline REAL @step(@state *state, const @motion *motion) {{\n",
      force_word(), axis_unit("N"), axis_is_rotary() ? "positive angles" : "+x");
  if (statements.text().find("motion") == std::string::npos && force.find("motion") == std::string::npos) {
    text += "  (void)motion;\n";
  }
  text += statements.text();
  text += fmt::format("  const REAL force_N = {};\n", force);
  for (std::size_t i = 0; i < next.size(); ++i) {
    text += fmt::format("  const REAL next_{} = {};\n", i, next[i]);
  }
  for (std::size_t i = 0; i < next.size(); ++i) text += fmt::format("  state->memory[{0}] = next_{0};\n", i);
  return text + "  state->force_N = force_N;\n  return force_N;\n}\n";
}

std::string init_function(const RecordedModel& model, bool has_hysteresis, const std::string& position) {
  std::set<ValueId> used;
  for (const RecordedModel::Memory& memory : model.memory) model.recording->add_used(memory.first, used);
  Statements statements(model, used);
  std::vector<std::string> first;
  for (const RecordedModel::Memory& memory : model.memory) {
    first.push_back(statements.text_of(memory.first));
  }
  std::string text =
      "/* Begins at this motion: nothing is remembered, the hysteresis is unloaded. Not for the tick. */\n"
      "static inline void @init(@state *state, const @motion *motion) {\n";
  text += statements.text();
  for (std::size_t i = 0; i < first.size(); ++i) {
    text += fmt::format("  state->memory[{}] = {};\n", i, first[i]);
  }
  if (has_hysteresis) text += fmt::format("  @unload(state, motion->{});\n", position);
  return text + "  (void)motion;\n  state->force_N = (REAL)0;\n}\n";
}

std::string list(const std::vector<std::string>& values) {
  return fmt::format("{}", fmt::join(values, ", "));
}

std::string hysteresis_functions(const ComputationRecord::Hysteresis& elements, bool is_float) {
  const std::size_t count = elements.stiffness.size();
  if (is_float) {
    return fmt::format(R"(static const int32_t @slip_steps[{0}] = {{{1}}};
static const int32_t @stiffness[{0}] = {{{2}}};
static inline void @unload(@state *state, int32_t position_steps) {{
  int i;
  for (i = 0; i < {0}; ++i) state->stretch_steps[i] = 0;
  state->position_steps = position_steps;
}}
/* Stop operators: springs that slip at a distance of their own. Whole numbers: nothing is lost, nothing drifts; the
   counter may wrap. */
static inline float @hysteresis(@state *state, int32_t position_steps) {{
  const int32_t moved = (int32_t)((uint32_t)position_steps - (uint32_t)state->position_steps);
  const int32_t below = moved > 32767 ? 32767 : moved;
  const int32_t travel = below < -32768 ? -32768 : below;
  int32_t sum = 0;
  int i;
  for (i = 0; i < {0}; ++i) {{
    const int32_t slip = @slip_steps[i];
    const int32_t stretched = state->stretch_steps[i] + travel;
    const int32_t limited = stretched > slip ? slip : stretched;
    const int32_t stretch = limited < -slip ? -slip : limited;
    state->stretch_steps[i] = stretch;
    sum += @stiffness[i] * stretch;
  }}
  state->position_steps = position_steps;
  return (float)sum * {3};
}}
)",
                       count, list(elements.slip_distance), list(elements.stiffness), elements.scale);
  }
  return fmt::format(R"(static const double @slip_m[{0}] = {{{1}}};
static const double @stiffness[{0}] = {{{2}}};
static inline void @unload(@state *state, double position_m) {{
  int i;
  for (i = 0; i < {0}; ++i) state->anchor_m[i] = position_m;
}}
/* Stop operators: springs that drag their anchor along once they are stretched by their slip distance. */
static inline double @hysteresis(@state *state, double position_m) {{
  double sum = 0.0;
  int i;
  for (i = 0; i < {0}; ++i) {{
    const double slip = @slip_m[i];
    const double stretched = position_m - state->anchor_m[i];
    const double limited = stretched > slip ? slip : stretched;
    const double stretch = limited < -slip ? -slip : limited;
    if (stretch != stretched) state->anchor_m[i] = position_m - stretch;
    sum += @stiffness[i] * (position_m - state->anchor_m[i]);
  }}
  return sum;
}}
)",
                     count, list(elements.slip_distance), list(elements.stiffness));
}

/// The tables that a text mentions.
std::string tables_of(const ComputationRecord& recording, const std::string& text) {
  std::string tables;
  for (const ComputationRecord::Table& table : recording.tables()) {
    const std::size_t at = text.find(table.name);
    if (at == std::string::npos) continue;
    tables +=
        fmt::format("static const {} {}{} = {{\n{}}};\n", table.type, table.name, table.extents, table.rows);
  }
  return tables;
}

/// The functions that a text mentions, and what they need.
std::string functions_of(bool is_float, const std::string& text) {
  const std::vector<CFunction> all = c_functions(is_float);
  std::string needed;
  for (auto function = all.rbegin(); function != all.rend(); ++function) {
    const bool is_used = std::any_of(function->names.begin(), function->names.end(), [&](const auto& name) {
      return text.find(name) != std::string::npos || needed.find(name) != std::string::npos;
    });
    if (is_used) needed = function->text + needed;
  }
  return needed;
}

const Term* hysteresis_of(const Model& model) {
  return find_role(model.target_terms, Role::hysteresis);
}

/// Slip distances of elements that have a stiffness.
std::vector<double> slip_distances(const Term& hysteresis) {
  std::vector<double> slip_m;
  for (std::size_t i = 0; i < hysteresis.shapes.size() && i < hysteresis.gains.size(); ++i) {
    if (hysteresis.gains[i] > 0.0 && hysteresis.shapes[i] > 0.0) slip_m.push_back(hysteresis.shapes[i]);
  }
  return slip_m;
}

/// 1, 2 or 5 times a power of ten, not below `least`.
double round_step(double least) {
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= least) return factor * decade;
  }
  return 10.0 * decade;
}

double step_of(const Model& model, const FrictionHeaderOptions& options) {
  constexpr double kMostSteps = PackedMaxwellSlip<2>::kLargestSlipDistance;
  const double usual_step_m = axis_length(1e-7);
  const Term* const hysteresis = hysteresis_of(model);
  const std::vector<double> slip_m =
      hysteresis != nullptr ? slip_distances(*hysteresis) : std::vector<double>{};
  if (slip_m.empty()) return options.step_m.value_or(usual_step_m);
  const auto [least, most] = std::minmax_element(slip_m.begin(), slip_m.end());
  if (!options.step_m) return round_step(*most / (kMostSteps - 1.0));
  if (*most / *options.step_m >= kMostSteps) {
    throw InputError(fmt::format(
        "--step {:g}: the largest slip distance, {:g} {}, has more than {:.0f} steps; give {:g} or more",
        *options.step_m, *most, axis_unit("m"), kMostSteps, *most / (kMostSteps - 1.0)));
  }
  if (*least < *options.step_m) {
    throw InputError(
        fmt::format("--step {:g}: the smallest slip distance, {:g} {}, is less than one step; give a part "
                    "of the encoder's step, {:g} or less, and count in it",
                    *options.step_m, *least, axis_unit("m"), *least));
  }
  return *options.step_m;
}

RecordedModel record(const Model& model, bool is_float, const ExportScales& scales) {
  try {
    return is_float ? record_float(model.target_terms, scales) : record_double(model.target_terms, scales);
  } catch (const NotRecordable& error) {
    throw InputError(fmt::format("{}; this effect has no C form", error.what()));
  }
}

RecordedModel recorded_at_rate(const Model& model, const FrictionHeaderOptions& options, double step_m) {
  ExportScales scales{options.is_float ? step_m : 1.0, {}};
  if (!options.rate_Hz) {
    RecordedModel recorded = record(model, options.is_float, scales);
    if (!recorded.depends_on_tick) return recorded;
    throw InputError(
        "an effect of this model goes on from tick to tick; give --rate, the calls of step() per second");
  }
  scales.tick_s = 1.0 / *options.rate_Hz;
  return record(model, options.is_float, scales);
}

std::string motion_type(bool is_float, double step_m) {
  std::string text =
      "/* The motion at one tick, in SI units. */\ntypedef struct {\n  REAL time_s; /* since the axis runs "
      "*/\n";
  if (is_float) {
    text += fmt::format(
        "  int32_t position_steps; /* in steps of {:g} {}, absolute, from anywhere; may wrap */\n"
        "  REAL position_m; /* {}, from where the model's map begins */\n",
        step_m, axis_unit("m"), axis_is_rotary() ? "the angle" : "on the rail");
  } else {
    text += "  REAL position_m;\n";
  }
  return text + "  REAL velocity_mps;\n  REAL acceleration_mps2;\n} @motion;\n";
}

std::string state_type(const RecordedModel& model, bool is_float) {
  std::string text =
      "/* What the model remembers. */\ntypedef struct {\n  REAL force_N; /* of the last step */\n";
  if (!model.memory.empty()) text += fmt::format("  REAL memory[{}];\n", model.memory.size());
  if (const std::size_t count = model.recording->hysteresis.stiffness.size(); count > 0) {
    text += is_float ? fmt::format("  int32_t position_steps;\n  int32_t stretch_steps[{}];\n", count)
                     : fmt::format("  REAL anchor_m[{}];\n", count);
  }
  return text + "} @state;\n";
}

/// Effects that add no force are left to the caller, with what they say.
std::string parameters_without_force(const Model& model) {
  std::string text;
  for (const Term& term : model.target_terms) {
    if (term.effect->gain_count > 0) continue;
    text += fmt::format("/* {}: adds no {}, is left to the caller. {} */\n", term.id(), force_word(),
                        formula_in_comment(term.effect->text));
    for (std::size_t i = 0; i < term.shapes.size(); ++i) {
      std::string name = term.id() + "_" + term.effect->shapes[i].name;
      std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::toupper(c); });
      text +=
          fmt::format("#define @MACRO_{} {} /* {} */\n", name, c_literal(static_cast<float>(term.shapes[i])),
                      axis_unit(term.effect->shapes[i].unit));
    }
  }
  return text;
}

std::string heading(const Model& model, const FrictionHeaderOptions& options) {
  std::string effects;
  for (const Term& term : model.target_terms) effects += (effects.empty() ? "" : ", ") + term.id();
  return fmt::format(
      "/* SPDX-License-Identifier: Apache-2.0 */\n"
      "/* clang-format off */\n"
      "/* NOLINTBEGIN */\n"
      "/* Friction model {:08x} in C99, written by slipstack; {}.\n"
      "   Effects: {}.\n"
      "   @init() once, @step() each tick; a @state for each axis. No heap, no library but memcpy.\n"
      "   The {} is that of {} bit for bit where the compiler does not contract into fused products\n"
      "   (-ffp-contract=off), to rounding where it does. */\n",
      target_hash(model), axis_is_rotary() ? "a rotary axis: rad, N m, kg m2" : "SI units", effects,
      force_word(), options.is_float ? "the slipstack firmware" : "the workbench in double precision");
}

}  // namespace

std::string friction_header(const Model& model, const FrictionHeaderOptions& options) {
  const double step_m = step_of(model, options);
  RecordedModel recorded = recorded_at_rate(model, options, step_m);
  const bool has_hysteresis = !recorded.recording->hysteresis.stiffness.empty();
  const std::string position = options.is_float ? "position_steps" : "position_m";
  const std::string functions =
      (has_hysteresis ? hysteresis_functions(recorded.recording->hysteresis, options.is_float) : "") + "\n" +
      init_function(recorded, has_hysteresis, position) + "\n" + step_function(recorded);
  std::string text = heading(model, options);
  text += "#ifndef @GUARD\n#define @GUARD\n\n#include <stdint.h>\n#include <string.h>\n\n";
  text += fmt::format("#define @MODEL_HASH 0x{:08x}U\n", target_hash(model));
  if (options.is_float && has_hysteresis)
    text += fmt::format("#define @STEP_M {}\n", c_literal(static_cast<float>(step_m)));
  text += parameters_without_force(model);
  if (options.rate_Hz) text += fmt::format("#define @RATE_HZ {:g}\n", *options.rate_Hz);
  text += "\n" + motion_type(options.is_float, step_m) + "\n" + state_type(recorded, options.is_float) + "\n";
  text += functions_of(options.is_float, functions) + tables_of(*recorded.recording, functions) + functions;
  text += "\n#endif\n/* NOLINTEND */\n";
  text = with_axis_names(text);
  for (std::size_t i = 0; i < recorded.memory.size(); ++i) {
    replace_all(text, recorded.recording->values()[recorded.memory[i].now].form,
                fmt::format("state->memory[{}]", i));
  }
  std::string upper = options.name;
  std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return std::toupper(c); });
  replace_all(text, "@MACRO_", upper + "_");
  for (const char* const macro : {"GUARD", "MODEL_HASH", "STEP_M", "RATE_HZ"}) {
    const std::string name = std::string_view(macro) == "GUARD"                        ? "H"
                             : std::string_view(macro) == "STEP_M" && axis_is_rotary() ? "STEP_RAD"
                                                                                       : macro;
    replace_all(text, std::string("@") + macro, upper + "_" + name);
  }
  replace_all(text, "REAL", options.is_float ? "float" : "double");
  replace_all(text, "@", options.name + "_");
  return text;
}

}  // namespace slipstack::workbench
