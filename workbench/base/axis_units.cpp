// SPDX-License-Identifier: Apache-2.0
#include "workbench/base/axis_units.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <mutex>
#include <vector>

#include "workbench/base/errors.h"

namespace slipstack::workbench {
namespace {

struct InUse {
  std::mutex lock;
  AxisUnits units;
  std::string source;  ///< the first input; empty before it
};

InUse& in_use() {
  static InUse one;
  return one;
}

bool is_letter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

bool is_exponent(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '^' || c == '-';
}

/// One symbol of a unit, with its exponent and what stands before it.
struct Factor {
  std::string before;  ///< separators, and what is no symbol: "/", " ", "1"
  std::string symbol;
  std::string exponent;  ///< as written
  int power = 1;         ///< negative behind a '/'
};

/// The factors of a product such as "N s2/m2"; a last one without a symbol holds what stands behind.
std::vector<Factor> factors_of(std::string_view unit) {
  std::vector<Factor> factors(1);
  for (std::size_t at = 0; at < unit.size();) {
    Factor& factor = factors.back();
    if (!is_letter(unit[at])) {
      factor.before += unit[at++];
      continue;
    }
    while (at < unit.size() && is_letter(unit[at])) factor.symbol += unit[at++];
    while (at < unit.size() && is_exponent(unit[at])) factor.exponent += unit[at++];
    const std::size_t digits = factor.exponent.find_first_not_of('^');
    if (digits != std::string::npos) factor.power = std::atoi(factor.exponent.c_str() + digits);
    if (factor.before.find('/') != std::string::npos) factor.power = -factor.power;
    factors.emplace_back();
  }
  return factors;
}

int power_of(const std::vector<Factor>& factors, std::string_view symbol) {
  int power = 0;
  for (const Factor& factor : factors) {
    if (factor.symbol == symbol) power += factor.power;
  }
  return power;
}

/// Whether a unit is one of a rotary axis: it has an angle, or the lengths of its torques (N m) and moments
/// of inertia (kg m2).
bool is_rotary_unit(const std::vector<Factor>& factors) {
  if (power_of(factors, "rad") != 0) return true;
  const int length = power_of(factors, "m");
  return length != 0 && length == power_of(factors, "N") + 2 * power_of(factors, "kg");
}

/// How the unit separates its factors: "N*s/m", "N·s/m" or "N s/m".
std::string separator_of(std::string_view unit) {
  if (unit.find('*') != std::string_view::npos) return "*";
  return unit.find("·") != std::string_view::npos ? "·" : " ";
}

/// The ends of names that are units, longest first, and what a rotary axis has in their place.
struct KeyUnit {
  std::string_view linear;
  std::string_view rotary;
};
constexpr std::array<KeyUnit, 9> kKeyUnits{{{"mass_kg", "inertia_kg_m2"},
                                            {"_N_per_m", "_Nm_per_rad"},
                                            {"_N_per_A", "_Nm_per_A"},
                                            {"_mps3", "_radps3"},
                                            {"_mps2", "_radps2"},
                                            {"_mps", "_radps"},
                                            {"_kg", "_kg_m2"},
                                            {"_N", "_Nm"},
                                            {"_m", "_rad"}}};

/// What is a torque on a rotary axis.
constexpr std::string_view kForceWord = "force";

}  // namespace

AxisUnits axis_units() {
  InUse& now = in_use();
  const std::lock_guard guard(now.lock);
  return now.units;
}

bool axis_is_rotary() {
  return axis_units().kind == AxisKind::rotary;
}

void use_axis(const AxisUnits& units, const std::string& source) {
  InUse& now = in_use();
  const std::lock_guard guard(now.lock);
  if (now.source.empty()) {
    now.units = units;
    now.source = source;
    return;
  }
  if (now.units.kind != units.kind) {
    const auto name = [](AxisKind kind) { return kind == AxisKind::rotary ? "rotary" : "linear"; };
    throw InputError(source + ": is of a " + name(units.kind) + " axis, but " + now.source + " of a " +
                     name(now.units.kind) + " one; give files of one axis");
  }
  if (units.shown != AngleUnit::radian) now.units.shown = units.shown;
}

void forget_axis() {
  InUse& now = in_use();
  const std::lock_guard guard(now.lock);
  now.units = {};
  now.source.clear();
}

std::string axis_unit(std::string_view unit) {
  return axis_unit(unit, axis_units().kind);
}

std::string axis_unit(std::string_view unit, AxisKind kind) {
  const std::vector<Factor> factors = factors_of(unit);
  if (kind == AxisKind::linear || is_rotary_unit(factors)) return std::string(unit);
  const std::string separator = separator_of(unit);
  std::string text;
  for (const Factor& factor : factors) {
    const std::string between = factor.power < 0 ? "/" : separator;
    text += factor.before + (factor.symbol == "m" ? "rad" : factor.symbol) + factor.exponent;
    if (factor.symbol == "N") text += between + "m" + factor.exponent;
    if (factor.symbol == "kg") text += between + "m2";
  }
  return text;
}

std::string linear_unit(std::string_view unit) {
  const std::vector<Factor> factors = factors_of(unit);
  if (!axis_is_rotary() || !is_rotary_unit(factors)) return std::string(unit);
  std::string text;
  for (const Factor& factor : factors) {
    if (factor.symbol == "m") continue;  // of a torque or a moment of inertia
    text += factor.before + (factor.symbol == "rad" ? "m" : factor.symbol) + factor.exponent;
  }
  return text;
}

std::string axis_key(std::string_view key) {
  return axis_key(key, axis_units().kind);
}

std::string axis_key(std::string_view key, AxisKind kind) {
  if (kind == AxisKind::linear) return std::string(key);
  const auto end = std::find_if(kKeyUnits.begin(), kKeyUnits.end(),
                                [&](const KeyUnit& one) { return key.ends_with(one.linear); });
  if (end == kKeyUnits.end()) return std::string(key);
  std::string text(key.substr(0, key.size() - end->linear.size()));
  const std::size_t word = text.find(kForceWord);
  if (word == 0 || (word != std::string::npos && text[word - 1] == '_')) {
    text.replace(word, kForceWord.size(), "torque");
  }
  return text.append(end->rotary);
}

int power_of_length(std::string_view unit) {
  return power_of(factors_of(unit), "m");
}

double axis_length(double metres) {
  return axis_is_rotary() ? metres / kReferenceRadius_m : metres;
}

}  // namespace slipstack::workbench
