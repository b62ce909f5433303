// SPDX-License-Identifier: Apache-2.0
#include "workbench/base/quantity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <numbers>
#include <span>

#include "workbench/base/axis_units.h"

namespace slipstack::workbench {
namespace {

constexpr std::string_view kMinus = "\u2212";
constexpr std::string_view kThinSpace = "\u202f";  // no-break as well
constexpr std::string_view kNoBreakSpace = "\u00a0";

struct Prefix {
  double factor;
  std::string_view symbol;
};

/// Significant digits in plain text; an exponent only for magnitudes outside 1e-3 .. 1e5.
std::string plain_digits(double value, int significant) {
  const double magnitude = std::abs(value);
  if (magnitude == 0.0) return "0";
  if (magnitude >= 1e5 || magnitude < 1e-3) return fmt::format("{:.{}e}", value, significant - 1);
  const int decimals = std::max(0, significant - 1 - static_cast<int>(std::floor(std::log10(magnitude))));
  return fmt::format("{:.{}f}", value, decimals);
}

std::string printf_double(const char* format, int precision, double value) {
  std::array<char, 400> buffer{};
  const int length = std::snprintf(buffer.data(), buffer.size(), format, precision, value);
  return {buffer.data(), static_cast<std::size_t>(std::clamp(length, 0, 399))};
}

std::string superscript(int exponent) {
  static constexpr std::array<std::string_view, 10> kDigits = {"⁰", "¹", "²", "³", "⁴",
                                                               "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out = exponent < 0 ? "⁻" : "";
  for (const char digit : std::to_string(std::abs(exponent))) {
    out += kDigits[static_cast<std::size_t>(digit - '0')];
  }
  return out;
}

/// "-12345.6" → "−12 345.6" with thin no-break spaces.
std::string group_thousands(const std::string& plain) {
  const bool negative = plain.starts_with('-');
  const std::size_t first = negative ? 1 : 0;
  const std::size_t end = std::min(plain.find('.'), plain.size());
  std::string out{negative ? kMinus : ""};
  for (std::size_t i = first; i < plain.size(); ++i) {
    const bool group_starts = i > first && i < end && (end - i) % 3 == 0 && end - first > 4;
    if (group_starts) out += kThinSpace;
    out += plain[i];
  }
  return out;
}

/// One choice of display unit: used from `smallest` (in SI) upwards.
struct Step {
  double smallest;
  double per_si;
  std::string_view label;
};

constexpr Step kForce[] = {{1e4, 1e-3, "kN"}, {0.1, 1.0, "N"}, {1e-4, 1e3, "mN"}, {0.0, 1e6, "µN"}};
constexpr Step kLength[] = {{10.0, 1.0, "m"}, {1e-3, 1e3, "mm"}, {1e-6, 1e6, "µm"}, {0.0, 1e9, "nm"}};
constexpr Step kSpeed[] = {{10.0, 1.0, "m/s"}, {1e-3, 1e3, "mm/s"}, {0.0, 1e6, "µm/s"}};
constexpr Step kAcceleration[] = {{0.1, 1.0, "m/s²"}, {0.0, 1e3, "mm/s²"}};
constexpr Step kTime[] = {{1.0, 1.0, "s"}, {1e-3, 1e3, "ms"}, {0.0, 1e6, "µs"}};
constexpr Step kMass[] = {{0.1, 1.0, "kg"}, {0.0, 1e3, "g"}};
constexpr Step kStiffness[] = {{1e5, 1e-6, "N/µm"}, {100.0, 1e-3, "N/mm"}, {0.0, 1.0, "N/m"}};
constexpr Step kDamping[] = {{0.0, 1.0, "N·s/m"}};
constexpr Step kDensity[] = {{0.01, 1.0, "N/√Hz"}, {0.0, 1e3, "mN/√Hz"}};
constexpr Step kFrequency[] = {{1e5, 1e-3, "kHz"}, {0.0, 1.0, "Hz"}};

struct Family {
  std::string_view si_unit;
  std::span<const Step> steps;
};

// Effects, users and papers spell the same unit in several ways; the report shows one spelling.
constexpr Family kFamilies[] = {
    {"N", kForce},           {"m", kLength},          {"m/s", kSpeed},     {"m/s^2", kAcceleration},
    {"m/s²", kAcceleration}, {"m/s2", kAcceleration}, {"s", kTime},        {"kg", kMass},
    {"N/m", kStiffness},     {"N*s/m", kDamping},     {"N·s/m", kDamping}, {"Ns/m", kDamping},
    {"N s/m", kDamping},     {"N/(m/s)", kDamping},   {"Hz", kFrequency},  {"N/√Hz", kDensity},
};

constexpr Step kTorque[] = {{1e4, 1e-3, "kN·m"}, {0.1, 1.0, "N·m"}, {1e-4, 1e3, "mN·m"}, {0.0, 1e6, "µN·m"}};
constexpr Step kAngle[] = {{0.1, 1.0, "rad"}, {1e-4, 1e3, "mrad"}, {0.0, 1e6, "µrad"}};
constexpr Step kAngularSpeed[] = {{0.1, 1.0, "rad/s"}, {1e-4, 1e3, "mrad/s"}, {0.0, 1e6, "µrad/s"}};
constexpr Step kAngularAcceleration[] = {{0.0, 1.0, "rad/s²"}};
constexpr Step kDegrees[] = {{0.0, 180.0 / std::numbers::pi, "deg"}};
constexpr Step kDegreeSpeed[] = {{0.0, 180.0 / std::numbers::pi, "deg/s"}};
constexpr Step kDegreeAcceleration[] = {{0.0, 180.0 / std::numbers::pi, "deg/s²"}};
constexpr Step kRevolutions[] = {{0.0, 0.5 / std::numbers::pi, "rev"}};
constexpr Step kRevolutionSpeed[] = {{0.0, 0.5 / std::numbers::pi, "rev/s"}};
constexpr Step kRevolutionAcceleration[] = {{0.0, 0.5 / std::numbers::pi, "rev/s²"}};
constexpr Step kInertia[] = {{0.01, 1.0, "kg·m²"}, {0.0, 1e4, "kg·cm²"}};
constexpr Step kAngularStiffness[] = {{0.1, 1.0, "N·m/rad"}, {0.0, 1e3, "mN·m/rad"}};
constexpr Step kAngularDamping[] = {{0.01, 1.0, "N·m·s/rad"}, {0.0, 1e3, "mN·m·s/rad"}};
constexpr Step kTorqueDensity[] = {{0.01, 1.0, "N·m/√Hz"}, {0.0, 1e3, "mN·m/√Hz"}};

/// The families of a rotary axis in place of those of a linear one.
std::span<const Step> rotary_steps(std::span<const Step> linear, AngleUnit shown) {
  const auto is = [&](std::span<const Step> family) { return linear.data() == family.data(); };
  const auto by_angle = [&](std::span<const Step> rad, std::span<const Step> deg, std::span<const Step> rev) {
    return shown == AngleUnit::radian ? rad : shown == AngleUnit::degree ? deg : rev;
  };
  if (is(kForce)) return kTorque;
  if (is(kLength)) return by_angle(kAngle, kDegrees, kRevolutions);
  if (is(kSpeed)) return by_angle(kAngularSpeed, kDegreeSpeed, kRevolutionSpeed);
  if (is(kAcceleration)) return by_angle(kAngularAcceleration, kDegreeAcceleration, kRevolutionAcceleration);
  if (is(kMass)) return kInertia;
  if (is(kStiffness)) return kAngularStiffness;
  if (is(kDamping)) return kAngularDamping;
  if (is(kDensity)) return kTorqueDensity;
  return linear;
}

/// The unit of a sentence, and the factor into it from SI: angles as the log has them.
std::pair<double, std::string> plain_unit(std::string_view si_unit) {
  std::string unit = axis_unit(si_unit);
  const AngleUnit shown = axis_units().shown;
  if (shown == AngleUnit::radian || (unit != "rad" && !unit.starts_with("rad/s"))) return {1.0, unit};
  const bool degrees = shown == AngleUnit::degree;
  return {(degrees ? 180.0 : 0.5) / std::numbers::pi, unit.replace(0, 3, degrees ? "deg" : "rev")};
}

/// The unit, with its prefix, in which quantity() writes a value of this size.
struct PlainScale {
  double per_si;
  double prefix;
  std::string unit;

  double operator()(double value_si) const { return value_si * per_si / prefix; }
};

PlainScale plain_scale(double value, std::string_view si_unit) {
  if (si_unit == "1") return {100.0, 1.0, "%"};
  static constexpr std::array<Prefix, 4> kPrefixes{{{1.0, ""}, {1e-3, "m"}, {1e-6, "u"}, {1e-9, "n"}}};
  const auto [per_si, unit] = plain_unit(si_unit);
  static constexpr std::array<std::string_view, 8> kWithPrefix{"m", "s",   "N",   "m/s",
                                                               "A", "N m", "rad", "rad/s"};
  const bool takes_prefix = std::find(kWithPrefix.begin(), kWithPrefix.end(), unit) != kWithPrefix.end();
  if (!takes_prefix || value == 0.0) return {per_si, 1.0, unit};
  for (const Prefix& prefix : kPrefixes) {
    if (std::abs(value * per_si) >= prefix.factor * 0.9995)
      return {per_si, prefix.factor, std::string(prefix.symbol) + unit};
  }
  return {per_si, 1e-9, "n" + unit};
}

}  // namespace

std::string quantity(double value, std::string_view si_unit, int significant) {
  const PlainScale scale = plain_scale(value, si_unit);
  return plain_digits(scale(value), significant) + " " + scale.unit;
}

std::string number_with_interval(double value, double half_width) {
  const int decimals =
      half_width > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(half_width))), 0, 9) : 2;
  return printf_double("%.*f", decimals, value) + " +- " + printf_double("%.*f", decimals, half_width);
}

std::string quantity_with_interval(double value, double half_width, std::string_view si_unit) {
  if (!(half_width > 0.0)) return quantity(value, si_unit);
  const PlainScale scale = plain_scale(std::max(std::abs(value), half_width), si_unit);
  return number_with_interval(scale(value), scale(half_width)) + " " + scale.unit;
}

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "–";
  std::string plain = printf_double("%.*f", std::max(decimals, 0), value);
  // A rounded "-0.00" would read as a sign that is not there.
  if (plain.find_first_not_of("-0.") == std::string::npos && plain.starts_with('-')) plain.erase(0, 1);
  return group_thousands(plain);
}

std::string significant(double value, int digits) {
  if (!std::isfinite(value)) return "–";
  if (value == 0.0) return "0";
  // Through the scientific form, because rounding can carry into the next decade (9.996 → 10.0).
  const std::string scientific = printf_double("%.*e", digits - 1, value);
  const std::size_t e = scientific.find('e');
  const int exponent = std::stoi(scientific.substr(e + 1));
  if (exponent < -4 || exponent > 6) {
    return group_thousands(scientific.substr(0, e)) + " × 10" + superscript(exponent);
  }
  return fixed(value, digits - 1 - exponent);
}

std::vector<UnitStep> unit_steps(std::string_view si_unit) {
  std::vector<UnitStep> steps;
  const std::string linear = linear_unit(si_unit);
  const AxisUnits axis = axis_units();
  for (const Family& family : kFamilies) {
    if (family.si_unit != linear) continue;
    const bool rotary = axis.kind == AxisKind::rotary;
    for (const Step& step : rotary ? rotary_steps(family.steps, axis.shown) : family.steps) {
      steps.push_back({step.smallest, {step.per_si, std::string(step.label)}});
    }
  }
  return steps;
}

DisplayUnit display_unit(std::string_view si_unit, double magnitude) {
  const double size = std::abs(magnitude);
  // Nothing to see at zero: take the unit that whole machines are described in.
  const double wanted = size > 0.0 ? size : 1.0;
  for (const UnitStep& step : unit_steps(si_unit)) {
    if (wanted >= step.smallest) return step.unit;
  }
  return {1.0, si_unit == "1" || si_unit == "-" ? std::string() : axis_unit(si_unit)};
}

DisplayUnit machine_length_unit() {
  return axis_is_rotary() ? display_unit("m", 1.0) : DisplayUnit{1e3, "mm"};
}

std::string machine_length(double value_m) {
  const DisplayUnit unit = machine_length_unit();
  // A micrometre, or the angle of an encoder of 17 bits, is still seen.
  return fmt::format("{:.{}f} {}", value_m * unit.per_si, axis_is_rotary() ? 5 : 3, unit.label);
}

std::string with_unit(double value_si, std::string_view si_unit, int digits) {
  const DisplayUnit unit = display_unit(si_unit, value_si);
  const std::string number = significant(value_si * unit.per_si, digits);
  return unit.label.empty() ? number : number + std::string(kNoBreakSpace) + unit.label;
}

Column aligned_column(std::string_view si_unit, const std::vector<double>& values_si, int digits) {
  double largest = 0.0;
  for (const double value : values_si) largest = std::max(largest, std::abs(value));
  Column column{display_unit(si_unit, largest), 0};
  for (const double value : values_si) {
    if (value == 0.0 || !std::isfinite(value)) continue;
    const int exponent = static_cast<int>(std::floor(std::log10(std::abs(value * column.unit.per_si))));
    column.decimals = std::max(column.decimals, digits - 1 - exponent);
  }
  column.decimals = std::min(column.decimals, 5);
  return column;
}

}  // namespace slipstack::workbench
