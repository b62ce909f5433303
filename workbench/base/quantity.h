// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

// Numbers with units, in two styles: plain ASCII for sentences, terminals and JSON (quantity()), and
// typographic UTF-8 for the tables and figures of the report (with_unit()). workbench/web/units.js does the
// same as the second for the charts. Units are given as those of a linear axis; on a rotary one the texts
// have its units (axis_units.h).
namespace slipstack::workbench {

/// A value with its unit in plain text: 0.024 "m" -> "24.0 mm", 3.1e-4 "s" -> "310 us", 0.42 "1" -> "42.0 %".
/// Three significant digits by default. Only units that usually carry a prefix (m, s, N, m/s, A) get one.
std::string quantity(double value, std::string_view si_unit, int significant = 3);

/// A value with an interval to either side in one unit, to the second digit of the interval: 0.15 "m/s" with
/// 3.1e-4 -> "150.00 +- 0.31 mm/s" (JCGM 100:2008, 7.2.2, 7.2.6). Without one (not above 0) as quantity().
std::string quantity_with_interval(double value, double half_width, std::string_view si_unit);
/// The same without a unit; the half width has to be above 0.
std::string number_with_interval(double value, double half_width);

/// `value` with `digits` significant digits, trailing zeros kept (0.340), a true minus sign, thousands in
/// groups of three, and powers of ten written out for magnitudes outside 1e-4 … 1e7.
std::string significant(double value, int digits);

/// `value` with a fixed number of decimals, otherwise as significant().
std::string fixed(double value, int decimals);

/// A unit that an engineer would choose, and the factor that takes an SI value into it.
struct DisplayUnit {
  double per_si;      ///< display value = SI value × per_si
  std::string label;  ///< "mm", "N/µm", …; the SI unit itself when no better one is known
};

/// The unit for values as large as `magnitude`, which is in the unit `si_unit`
/// ("m", "m/s", "N", "N/m", "N*s/m", "kg", "s", "Hz", …). Lengths are mm on a machine, and µm below 1 mm.
DisplayUnit display_unit(std::string_view si_unit, double magnitude);

/// The display units of a quantity of this unit, largest first: each from a magnitude in SI upwards. Empty
/// for a unit that is shown as it is.
struct UnitStep {
  double smallest;
  DisplayUnit unit;
};
std::vector<UnitStep> unit_steps(std::string_view si_unit);

/// The unit in which positions of a whole machine are listed: mm, or that of the log's angles; and a position
/// in it, "0.012 mm".
DisplayUnit machine_length_unit();
std::string machine_length(double value_m);

/// "24.00 mm": significant() in the unit of display_unit(), a no-break space between.
std::string with_unit(double value_si, std::string_view si_unit, int digits);

/// A unit and a number of decimals for a whole column, so that its decimal points stand below each other.
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
