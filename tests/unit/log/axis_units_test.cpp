// SPDX-License-Identifier: Apache-2.0
#include "workbench/base/axis_units.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>

#include "tests/unit/log/log_support.h"
#include "workbench/base/errors.h"
#include "workbench/base/quantity.h"

// The units of a rotary axis: by dimension, in texts, in names, and in the columns and header of a log.
namespace slipstack::workbench::test {
namespace {

class AxisUnitsTest : public testing::Test {
 protected:
  void SetUp() override { forget_axis(); }
  void TearDown() override { forget_axis(); }
  static void use(AngleUnit shown = AngleUnit::radian) { use_axis({AxisKind::rotary, shown}, "log"); }
};

// JCGM 100:2008, 7.2.2: value and interval in one unit, to the second digit of the interval.
TEST_F(AxisUnitsTest, AValueAndItsIntervalHaveOneUnit) {
  EXPECT_EQ(quantity_with_interval(0.15, 3.09e-4, "m/s"), "150.00 +- 0.31 mm/s");
  EXPECT_EQ(quantity_with_interval(20.19, 0.25, "N"), "20.19 +- 0.25 N");
  EXPECT_EQ(quantity_with_interval(0.002, 0.5, "N"), "2 +- 500 mN") << "in the unit of the larger";
  EXPECT_EQ(quantity_with_interval(-34.0, 12.6, "N"), "-34 +- 13 N");
  EXPECT_EQ(quantity_with_interval(0.02, 0.002, "1"), "2.00 +- 0.20 %");
  EXPECT_EQ(quantity_with_interval(204.0, 6.0, "N s/m"), "204.0 +- 6.0 N s/m");
  EXPECT_EQ(quantity_with_interval(0.15, 0.0, "m/s"), quantity(0.15, "m/s"));
  EXPECT_EQ(number_with_interval(1.98, 0.05), "1.980 +- 0.050");
  use(AngleUnit::degree);
  EXPECT_EQ(quantity_with_interval(std::numbers::pi, std::numbers::pi / 180.0, "m"), "180.0 +- 1.0 deg");
}

TEST_F(AxisUnitsTest, UnitsFollowFromTheDimension) {
  for (const auto& [linear, rotary] :
       {std::pair("N", "N m"), std::pair("m", "rad"), std::pair("kg", "kg m2"), std::pair("N/m", "N m/rad"),
        std::pair("N s/m", "N m s/rad"), std::pair("N s2/m2", "N m s2/rad2"), std::pair("m/s", "rad/s"),
        std::pair("m/s2", "rad/s2"), std::pair("s2/m", "s2/rad"), std::pair("1/m", "1/rad"),
        std::pair("N/A", "N m/A"), std::pair("s", "s"), std::pair("Hz", "Hz"), std::pair("1", "1")}) {
    EXPECT_EQ(axis_unit(linear, AxisKind::linear), linear);
    EXPECT_EQ(axis_unit(linear, AxisKind::rotary), rotary);
    EXPECT_EQ(axis_unit(rotary, AxisKind::rotary), rotary) << "twice is once";
    EXPECT_EQ(linear_unit(rotary), rotary) << "a linear axis leaves units alone";
  }
  use();
  EXPECT_EQ(linear_unit("N m s/rad"), "N s/m");
  EXPECT_EQ(linear_unit("rad"), "m");
  EXPECT_EQ(linear_unit("kg m2"), "kg");
  EXPECT_EQ(linear_unit("m"), "m");
}

TEST_F(AxisUnitsTest, NamesCarryTheUnit) {
  for (const auto& [linear, rotary] :
       {std::pair("holdout_rmse_N", "holdout_rmse_Nm"), std::pair("velocity_mps", "velocity_radps"),
        std::pair("acceleration_mps2", "acceleration_radps2"), std::pair("jerk_mps3", "jerk_radps3"),
        std::pair("mass_kg", "inertia_kg_m2"), std::pair("position_m", "position_rad"),
        std::pair("force_noise_N", "torque_noise_Nm"),
        std::pair("motor_constant_N_per_A", "motor_constant_Nm_per_A"),
        std::pair("stiffness_N_per_m", "stiffness_Nm_per_rad"), std::pair("relative_error", "relative_error"),
        std::pair("samples", "samples"), std::pair("rate_Hz", "rate_Hz")}) {
    EXPECT_EQ(axis_key(linear, AxisKind::linear), linear);
    EXPECT_EQ(axis_key(linear, AxisKind::rotary), rotary);
  }
}

TEST_F(AxisUnitsTest, TextsHaveTheUnitsOfTheAxis) {
  EXPECT_EQ(quantity(0.024, "m"), "24.0 mm");
  EXPECT_EQ(with_unit(2.5e-4, "kg", 3), "0.250\u00a0g");
  use();
  EXPECT_EQ(quantity(0.024, "m"), "24.0 mrad");
  EXPECT_EQ(quantity(0.012, "N"), "12.0 mN m");
  EXPECT_EQ(quantity(3.0, "N s/m"), "3.00 N m s/rad");
  EXPECT_EQ(with_unit(2.5e-4, "kg", 3), "2.50\u00a0kg·cm²");
  EXPECT_EQ(with_unit(2.0, "N m", 3), "2.00\u00a0N·m") << "a unit given by the user";
}

TEST_F(AxisUnitsTest, AnglesAreShownAsTheLogHasThem) {
  use(AngleUnit::degree);
  EXPECT_EQ(quantity(std::numbers::pi / 2.0, "m"), "90.0 deg");
  EXPECT_EQ(quantity(std::numbers::pi, "m/s"), "180 deg/s");
  EXPECT_EQ(quantity(2.0, "N/m"), "2.00 N m/rad");
  forget_axis();
  use(AngleUnit::revolution);
  EXPECT_EQ(quantity(std::numbers::pi, "m"), "0.500 rev");
}

TEST_F(AxisUnitsTest, InputsOfTwoKindsAreRefused) {
  use();
  EXPECT_NO_THROW(use_axis({AxisKind::rotary, AngleUnit::degree}, "other.csv"));
  EXPECT_EQ(axis_units().shown, AngleUnit::degree) << "the log decides, not the model before it";
  try {
    use_axis({}, "model.toml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              "model.toml: is of a linear axis, but log of a rotary one; give files of one axis");
  }
}

std::string rows(double factor, double torque) {
  std::string text;
  for (int i = 0; i < 200; ++i) {
    const double angle = std::sin(0.1 * i);
    text += std::to_string(0.001 * i) + "," + std::to_string(factor * angle) + "," +
            std::to_string(torque * std::cos(0.1 * i)) + "\n";
  }
  return text;
}

TEST_F(AxisUnitsTest, LogsOfARotaryAxisAreReadInRadAndNm) {
  for (const auto& [unit, per_rad] : {std::pair("rad", 1.0), std::pair("deg", 180.0 / std::numbers::pi),
                                      std::pair("rev", 0.5 / std::numbers::pi)}) {
    forget_axis();
    const Log log = parse_text("# inertia_kg_m2: 2.5e-4\n# encoder_resolution_rad: 1e-6\ntime_s,position_" +
                               std::string(unit) + ",torque_mNm\n" + rows(per_rad, 1e3));
    EXPECT_TRUE(axis_is_rotary());
    EXPECT_NEAR(log.position_m[5], std::sin(0.5), 3e-6);
    EXPECT_NEAR(log.force_N[5], std::cos(0.5), 1e-8);
    EXPECT_EQ(log.mass_kg.value(), 2.5e-4);
    EXPECT_EQ(log.encoder_resolution_m.value(), 1e-6);
  }
}

TEST_F(AxisUnitsTest, AMixOfKindsIsRefused) {
  EXPECT_EQ(refusal("time_s,position_m,torque_Nm\n" + rows(1.0, 1.0)),
            "log.csv:1: column torque_Nm is of a rotary axis, column position_m of a linear one; give all of "
            "them for one kind of axis");
  EXPECT_EQ(
      refusal("# mass_kg: 3\ntime_s,position_rad,torque_Nm\n" + rows(1.0, 1.0)),
      "log.csv:2: header key mass_kg is of a linear axis, column position_rad of a rotary one; give all "
      "of them for one kind of axis");
  EXPECT_EQ(refusal("# inertia_g: 3\ntime_s,position_rad,torque_Nm\n" + rows(1.0, 1.0)),
            "log.csv:1: header key 'inertia_g': unknown unit 'g'; convert it to inertia_kg_m2");
  EXPECT_FALSE(axis_is_rotary()) << "a refused log leaves no trace";
}

/// A joint that turns at a turn in two seconds, back and forth over `turns`, from 0.3 turns on; its angle is
/// counted modulo one turn, in the unit of the column.
std::string turning(const char* column, double turn, double turns, bool modulo) {
  std::string text = std::string("time_s,") + column + ",torque_Nm\n";
  for (int i = 0; i < 4000; ++i) {
    const double way = 0.3 + turns * 0.5 * (1.0 - std::cos(1e-3 * i * std::numbers::pi / turns));
    char line[80];
    std::snprintf(line, sizeof line, "%.3f,%.6f,%.3f\n", 1e-3 * i,
                  turn * (modulo ? way - std::floor(way) : way),
                  std::sin(0.01 * i) + 1e-3 * (i * 7919 % 100));
    text += line;
  }
  return text;
}

TEST_F(AxisUnitsTest, AnAngleThatWrapsIsContinued) {
  const std::pair<const char*, double> columns[] = {
      {"position_rad", 2.0 * std::numbers::pi}, {"position_deg", 360.0}, {"position_rev", 1.0}};
  for (const auto& [column, turn] : columns) {
    forget_axis();
    const Log wrapped = parse_text(turning(column, turn, 1.5, true));
    const Log whole = parse_text(turning(column, turn, 1.5, false));
    ASSERT_EQ(wrapped.position_m.size(), whole.position_m.size());
    for (std::size_t i = 0; i < whole.position_m.size(); ++i)
      ASSERT_NEAR(wrapped.position_m[i], whole.position_m[i], 2e-5) << column << " at " << i;
    EXPECT_TRUE(std::any_of(wrapped.notes.begin(), wrapped.notes.end(), [](const std::string& note) {
      return note.find("jumps by one turn") != std::string::npos;
    })) << column;
  }
}

/// A carriage that moves by 60 000 counts to and fro, from 15 000 before 2^bits on, where a counter of so
/// many bits begins anew.
std::string counting(int bits, bool modulo) {
  std::string text = "# encoder_resolution_um: 1\ntime_s,position_counts,force_N\n";
  const std::int64_t period = std::int64_t{1} << bits;
  for (int i = 0; i < 4000; ++i) {
    const auto way = static_cast<std::int64_t>(std::lround(30'000.0 * (1.0 - std::cos(2e-3 * i))));
    const std::int64_t count = period - 15'000 + way;
    text += fmt::format("{:.3f},{},{:.3f}\n", 1e-3 * i, modulo ? count % period : count,
                        std::sin(0.01 * i) + 1e-3 * (i * 7919 % 100));
  }
  return text;
}

TEST_F(AxisUnitsTest, CountsThatWrapAreContinued) {
  for (const int bits : {16, 32}) {
    const Log wrapped = parse_text(counting(bits, true));
    const Log whole = parse_text(counting(bits, false));
    for (std::size_t i = 0; i < whole.position_m.size(); ++i) {
      ASSERT_NEAR(wrapped.position_m[i] - wrapped.position_m[0], whole.position_m[i] - whole.position_m[0],
                  1e-9)
          << bits << " bits, at " << i;
    }
    for (const std::string& note : whole.notes) EXPECT_EQ(note.find("jumps"), std::string::npos) << note;
  }
}

// Within one turn without a wrap, and over several turns without a modulus, nothing is changed.
TEST_F(AxisUnitsTest, AnAngleThatDoesNotWrapIsLeftAlone) {
  for (const double turns : {0.6, 3.0}) {
    forget_axis();
    const Log log = parse_text(turning("position_rad", 2.0 * std::numbers::pi, turns, false));
    for (const std::string& note : log.notes) EXPECT_EQ(note.find("turn"), std::string::npos) << note;
  }
}

}  // namespace
}  // namespace slipstack::workbench::test
