// SPDX-License-Identifier: Apache-2.0
#include "workbench/base/quantity.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace slipstack::workbench {
namespace {

struct Prefix {
  double factor;
  std::string_view symbol;
};

/// Significant digits, without an exponent where people would not write one.
std::string digits(double value, int significant) {
  const double magnitude = std::abs(value);
  if (magnitude == 0.0) return "0";
  if (magnitude >= 1e5 || magnitude < 1e-3) return fmt::format("{:.{}e}", value, significant - 1);
  const int decimals = std::max(0, significant - 1 - static_cast<int>(std::floor(std::log10(magnitude))));
  return fmt::format("{:.{}f}", value, decimals);
}

}  // namespace

std::string quantity(double value, std::string_view unit, int significant) {
  if (unit == "1") return digits(100.0 * value, significant) + " %";
  static constexpr std::array<Prefix, 4> kPrefixes{{{1.0, ""}, {1e-3, "m"}, {1e-6, "u"}, {1e-9, "n"}}};
  const bool takes_prefix = unit == "m" || unit == "s" || unit == "N" || unit == "m/s" || unit == "A";
  if (!takes_prefix || value == 0.0) return digits(value, significant) + " " + std::string(unit);
  for (const Prefix& prefix : kPrefixes) {
    if (std::abs(value) >= prefix.factor * 0.9995) {
      return digits(value / prefix.factor, significant) + " " + std::string(prefix.symbol) +
             std::string(unit);
    }
  }
  return digits(value / 1e-9, significant) + " n" + std::string(unit);
}

std::string shape_value(const ShapeSpec& shape, double value, int significant) {
  const bool is_exponent = shape.kind == ShapeKind::exponent || shape.kind == ShapeKind::nominal_exponent;
  return is_exponent ? fmt::format("{:.{}g}", value, significant) : quantity(value, shape.unit, significant);
}

}  // namespace slipstack::workbench
