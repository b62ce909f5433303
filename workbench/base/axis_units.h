// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

// The units of the axis at hand. Everything inside the workbench is written for a linear axis: position in m,
// force in N, mass in kg. On a rotary axis the same numbers are an angle in rad, a torque in N m and a moment
// of inertia in kg m2: the equations are the same, so only names and units change, and they change here. A
// program works on one axis, whose kind is that of its inputs; like a locale it is set once, while they are
// read, and looked up wherever a value meets its unit.
namespace slipstack::workbench {

enum class AxisKind { linear, rotary };

/// The unit in which angles are shown; inside they are rad.
enum class AngleUnit { radian, degree, revolution };

struct AxisUnits {
  AxisKind kind = AxisKind::linear;
  AngleUnit shown = AngleUnit::radian;
};

/// The units of the inputs read so far; those of a linear axis before the first.
AxisUnits axis_units();
bool axis_is_rotary();

/// Called for each input when its units are known; `source` names it. Throws InputError where an earlier
/// input is of the other kind.
void use_axis(const AxisUnits& units, const std::string& source);

/// As before the first input: for programs that read one axis after another.
void forget_axis();

/// A linear axis' SI unit in that of the axis: on a rotary one N becomes N m, m rad, kg kg m2, and so in
/// products: "N s/m" becomes "N m s/rad". A unit that is one of a rotary axis already (it has rad, or as many
/// m as the torques and moments of inertia in it) is returned as it is.
std::string axis_unit(std::string_view unit);
std::string axis_unit(std::string_view unit, AxisKind kind);
/// The unit of a linear axis that axis_unit() takes into `unit`, where the axis is rotary.
std::string linear_unit(std::string_view unit);

/// A name that ends in such a unit, as in JSON, columns and header keys: on a rotary axis "holdout_rmse_N"
/// becomes "holdout_rmse_Nm", "velocity_mps" "velocity_radps", "mass_kg" "inertia_kg_m2".
std::string axis_key(std::string_view key);
std::string axis_key(std::string_view key, AxisKind kind);

/// Power of the length in a unit of a linear axis: 1 for "m/s", -2 for "N s2/m2".
int power_of_length(std::string_view unit);

/// The angle of one turn, after which gravity and eccentric parts repeat.
inline constexpr double kTurn_rad = 6.283185307179586;

/// A bound or start value that was chosen in metres, for the axis: on a rotary one the angle at the radius
/// kReferenceRadius_m.
double axis_length(double metres);

/// Joints and servo motors have bearings and gears of 25 to 100 mm radius; chosen as their geometric mean.
inline constexpr double kReferenceRadius_m = 0.05;

}  // namespace slipstack::workbench
