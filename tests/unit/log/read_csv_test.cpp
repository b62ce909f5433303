// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include "tests/unit/log/log_support.h"
#include "workbench/base/axis_units.h"
#include "workbench/base/errors.h"

namespace slipstack::workbench::test {
namespace {

std::string rows_with(const std::string& header, std::size_t count,
                      const std::function<std::string(std::size_t)>& row) {
  std::string text = header + "\n";
  for (std::size_t i = 0; i < count; ++i) text += row(i) + "\n";
  return text;
}

std::string stamp(std::size_t i) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", static_cast<double>(i) * 1e-3);
  return text;
}

TEST(ReadCsv, GivesEveryColumnAndHeaderValue) {
  const std::string text = rows_with(
      "# mass_kg: 35.45\n# motor_constant_N_per_A: 71.5\n# magnet_pitch_m: 0.024\n"
      "# encoder_resolution_m: 1e-6\n# operator: Hans: shift 2\n# free text\n"
      "time_s,position_m,force_N,reference_position_m,velocity_mps,normal_force_N,temperature_C",
      120, [](std::size_t i) {
        const std::string k = std::to_string(i);
        return stamp(i) + "," + k + "e-6," + k + "," + k + "e-3,-" + k + "," + k + ".5,+2" + k;
      });
  const Log log = parse_text(text);
  EXPECT_EQ(violated_guarantee(log), "");
  EXPECT_EQ(log.sample_rate_Hz, 1000.0);
  EXPECT_EQ(log.start_time_s, 0.0);
  ASSERT_EQ(log.position_m.size(), 120U);
  EXPECT_EQ(log.position_m[7], 7e-6);
  EXPECT_EQ(log.force_N[7], 7.0);
  EXPECT_EQ(log.reference_position_m[7], 7e-3);
  EXPECT_EQ(log.velocity_mps[7], -7.0);
  EXPECT_EQ(log.normal_force_N[7], 7.5);
  EXPECT_EQ(log.temperature_C[7], 27.0);
  EXPECT_EQ(log.mass_kg, 35.45);
  EXPECT_EQ(log.motor_constant_N_per_A, 71.5);
  EXPECT_EQ(log.magnet_pitch_m, 0.024);
  EXPECT_EQ(log.encoder_resolution_m, 1e-6);
  EXPECT_EQ(log.header.size(), 5U);
  EXPECT_EQ(log.header.at("operator"), "Hans: shift 2");
  EXPECT_TRUE(log.notes.empty());
}

// Lengths and angles of the header in every unit that a position may have.
TEST(ReadCsv, HeaderValuesHaveTheUnitsOfThePosition) {
  const auto linear = [](const std::string& header) {
    return parse_text(header + "\ntime_s,position_m,force_N\n" + usual_rows());
  };
  EXPECT_EQ(linear("# encoder_resolution_um: 1").encoder_resolution_m, 1e-6);
  EXPECT_EQ(linear("# encoder_resolution_mm: 0.001").encoder_resolution_m, 1e-6);
  EXPECT_EQ(linear("# magnet_pitch_mm: 24").magnet_pitch_m, 0.024);
  const auto rotary = [](const std::string& header) {
    forget_axis();
    Log log = parse_text(header + "\ntime_s,position_deg,torque_Nm\n" + usual_rows());
    forget_axis();
    return log;
  };
  EXPECT_DOUBLE_EQ(*rotary("# encoder_resolution_deg: 1e-5").encoder_resolution_m,
                   *rotary("# encoder_resolution_rad: 1.7453292519943295e-7").encoder_resolution_m);
  EXPECT_DOUBLE_EQ(*rotary("# magnet_pitch_rev: 0.125").magnet_pitch_m,
                   *rotary("# magnet_pitch_deg: 45").magnet_pitch_m);
}

TEST(ReadCsv, RefusesAHeaderValueInTwoUnits) {
  try {
    parse_text("# magnet_pitch_m: 0.024\n# magnet_pitch_mm: 24\ntime_s,position_m,force_N\n" + usual_rows());
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("magnet_pitch_mm repeats what another gives"), std::string::npos)
        << error.what();
  }
}

TEST(ReadCsv, LeavesEmptyWhatIsAbsent) {
  const Log log = parse_text("time_s,position_m,force_N\n" + usual_rows());
  EXPECT_TRUE(log.reference_position_m.empty());
  EXPECT_TRUE(log.velocity_mps.empty());
  EXPECT_TRUE(log.normal_force_N.empty());
  EXPECT_TRUE(log.temperature_C.empty());
  EXPECT_FALSE(log.mass_kg || log.motor_constant_N_per_A || log.magnet_pitch_m);
  EXPECT_TRUE(log.header.empty());
}

TEST(ReadCsv, KeepsAMassOfZero) {
  EXPECT_EQ(parse_text("# mass_kg: 0\ntime_s,position_m,force_N\n" + usual_rows()).mass_kg, 0.0);
}

// The result is the double nearest to the value in SI units, without a second rounding.
TEST(ReadCsv, ConvertsUnitsExactly) {
  struct Case {
    const char* position;
    const char* force;
    double position_m;  // of "37"
    double force_N;     // of "37"
  };
  for (const Case& c :
       {Case{"position_m", "force_N", 37.0, 37.0}, Case{"position_mm", "force_mN", 37e-3, 37e-3},
        Case{"position_um", "force_uN", 37e-6, 37e-6}}) {
    const std::string text =
        rows_with(std::string("time_s,") + c.position + "," + c.force, 100,
                  [](std::size_t i) { return stamp(i) + "," + std::to_string(i) + "," + std::to_string(i); });
    const Log log = parse_text(text);
    EXPECT_EQ(log.position_m[37], c.position_m) << c.position;
    EXPECT_EQ(log.force_N[37], c.force_N) << c.force;
  }
}

TEST(ReadCsv, TurnsCountsAndCurrentIntoSi) {
  const std::string text = rows_with(
      "# encoder_resolution_m: 2e-7\n# motor_constant_N_per_A: 71.5\ntime_s,position_counts,current_A", 100,
      [](std::size_t i) { return stamp(i) + "," + std::to_string(i * 3) + ",-0." + std::to_string(i + 1); });
  const Log log = parse_text(text);
  EXPECT_EQ(log.position_m[50], 150 * 2e-7);
  EXPECT_EQ(log.force_N[4], -0.5 * 71.5);
}

TEST(ReadCsv, PrefersAMeasuredForceToTheCurrentAndSaysSo) {
  const std::string text = rows_with("time_s,position_um,current_A,force_N", 100, [](std::size_t i) {
    return stamp(i) + "," + std::to_string(i) + ",1," + std::to_string(i);
  });
  const Log log = parse_text(text);
  EXPECT_EQ(log.force_N[5], 5.0);
  EXPECT_TRUE(has_note(log, "column current_A ignored"));
}

// Line ends, blanks, empty lines and a byte-order mark make no difference.
TEST(ReadCsv, IgnoresLineEndsBlanksAndByteOrderMark) {
  const Log plain = parse_text(usual_log());
  std::string crlf;
  std::string spaced = "\n  \n";
  for (const char c : usual_log()) {
    crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
    if (c == ',') {
      spaced += " \t, ";
    } else if (c == '\n') {
      spaced += "  \n\n";
    } else {
      spaced += c;
    }
  }
  std::string crcrlf;
  for (const char c : crlf) crcrlf += c == '\r' ? std::string("\r\r") : std::string(1, c);
  std::string no_last_newline = usual_log();
  no_last_newline.pop_back();
  for (const std::string& text : {crlf, crcrlf, "\xEF\xBB\xBF" + usual_log(), "\xEF\xBB\xBF" + crlf, spaced,
                                  no_last_newline, usual_log() + "\n\r\n  \n\n"}) {
    const Log log = parse_text(text);
    EXPECT_EQ(log.position_m, plain.position_m);
    EXPECT_EQ(log.force_N, plain.force_N);
    EXPECT_EQ(log.sample_rate_Hz, plain.sample_rate_Hz);
    EXPECT_EQ(log.mass_kg, plain.mass_kg);
    EXPECT_EQ(log.header, plain.header);
  }
}

TEST(ReadCsv, NotesCommentsAmongSamplesAndRepeatedKeys) {
  const Log log = parse_text("# a: 1\n# a: 1\ntime_s,position_m,force_N\n# stopped for tea\n" + usual_rows());
  ASSERT_EQ(log.notes.size(), 3U);
  EXPECT_EQ(log.notes[0], "1 repeated header key ignored");
  EXPECT_EQ(log.notes[1], "1 comment line among the samples ignored");
}

TEST(ReadCsv, HeaderTextIsCleanForReports) {
  const Log log =
      parse_text("# operator: J\xF6rg \x1b[31m\n# site: Liège\ntime_s,position_m,force_N\n" + usual_rows());
  EXPECT_EQ(log.header.at("operator"), "J?rg  [31m");
  EXPECT_EQ(log.header.at("site"), "Liège");
}

// Lines that cross the end of the reader's buffer: every number of a log of several mebibytes is checked.
TEST(ReadCsv, IsExactAcrossBufferBoundaries) {
  std::mt19937_64 random(7);
  std::uniform_int_distribution<int> digits(1, 17);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::string text = "time_s,position_m,force_N\n";
  std::vector<std::pair<double, double>> expected;
  for (std::size_t i = 0; i < 90'000; ++i) {
    char position[64];
    char force[64];
    std::snprintf(position, sizeof position, "%.*g", digits(random), normal(random));
    std::snprintf(force, sizeof force, "%.*e", digits(random),
                  normal(random) * std::exp(20.0 * normal(random)));
    // The C library is the independent oracle for the value of a decimal number.
    expected.emplace_back(std::strtod(position, nullptr), std::strtod(force, nullptr));
    text += stamp(i) + "," + position + "," + force + "\n";
  }
  ASSERT_GT(text.size(), 3U << 20);
  const Log log = parse_text(text);
  ASSERT_EQ(log.position_m.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(log.position_m[i], expected[i].first) << i;
    ASSERT_EQ(log.force_N[i], expected[i].second) << i;
  }
}

}  // namespace
}  // namespace slipstack::workbench::test
