// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

// How numbers and foreign text become readable HTML. Everything here returns UTF-8.
namespace slipstack::workbench {

/// Escapes text for HTML content and double-quoted attributes. Control characters other than tab and newline
/// are dropped, so that the name of a log cannot hide anything.
std::string escape_html(std::string_view text);

/// Escapes a text and sets its quantities as typography demands: a no-break space between a number and its
/// unit, µ for the u of "um". The meaning of the text is not used.
std::string prose_html(std::string_view text);

/// `value` with `digits` significant digits, trailing zeros kept (0.340), a true minus sign, thousands in
/// groups of three, and powers of ten written out for magnitudes outside 1e-4 … 1e7.
std::string significant(double value, int digits);

/// `value` with a fixed number of decimals, otherwise as significant().
std::string fixed(double value, int decimals);

/// A unit for display, and the factor that converts an SI value into it.
struct DisplayUnit {
  double per_si;      ///< display value = SI value × per_si
  std::string label;  ///< "mm", "N/µm", …; the SI unit itself when no better one is known
};

/// Picks the unit for values as large as `magnitude`, which is in the unit `si_unit`
/// ("m", "m/s", "N", "N/m", "N*s/m", "kg", "s", "Hz", …). Lengths are mm on a machine, and µm below 1 mm.
DisplayUnit display_unit(std::string_view si_unit, double magnitude);

/// "24.00 mm": significant() in the unit of display_unit(), a no-break space between.
std::string with_unit(double value_si, std::string_view si_unit, int digits);

/// A unit and a number of decimals for a whole column, so that its decimal points are aligned.
struct Column {
  DisplayUnit unit;
  int decimals;

  /// `value_si` without its unit.
  std::string text(double value_si) const { return fixed(value_si * unit.per_si, decimals); }
};

/// The column that shows the largest of `values_si` in a good unit and the smallest non-zero one with
/// `digits` significant digits, as long as that needs no more than five decimals.
Column aligned_column(std::string_view si_unit, const std::vector<double>& values_si, int digits);

}  // namespace slipstack::workbench
