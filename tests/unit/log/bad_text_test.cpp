// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <ostream>
#include <string>

#include "tests/unit/log/log_support.h"

namespace slipstack::workbench::test {
namespace {

constexpr const char* kNames = "time_s,position_m,force_N\n";

// The usual log with row `row` (counted from 0) replaced. The rows begin on line 2.
std::string with_row(std::size_t row, const std::string& line) {
  std::string text = kNames;
  std::string rows = usual_rows();
  for (std::size_t i = 0; i < 200; ++i) {
    const std::size_t end = rows.find('\n') + 1;
    text += i == row ? line : rows.substr(0, end);
    rows.erase(0, end);
  }
  return text;
}

std::string with_header(const std::string& lines) {
  return lines + "\n" + kNames + usual_rows();
}

struct BadText {
  const char* name;
  std::string text;
  std::string message_begin;  // exact start of the message: where and what
};

void PrintTo(const BadText& bad, std::ostream* out) {
  *out << bad.name;
}

class BadTextTest : public testing::TestWithParam<BadText> {};

void expect_refused(const std::string& text, const std::string& message_begin) {
  const std::string message = refusal(text);
  EXPECT_EQ(message.substr(0, message_begin.size()), message_begin);
  EXPECT_EQ(broken_message(message, "log.csv"), "") << message;
}

TEST_P(BadTextTest, IsRefusedInOneLine) {
  expect_refused(GetParam().text, GetParam().message_begin);
}

// Not among the parameters, which every process of this program copies when it starts.
TEST(BadText, LongLineIsRefusedInOneLine) {
  expect_refused(std::string(10'000'000, 'x'), "log.csv:1: the line is longer than 65536 bytes; ");
  expect_refused(kNames + std::string(10'000'000, '1'), "log.csv:2: the line is longer than 65536 bytes; ");
}

std::string usual_columns(const std::string& names) {
  return names + "\n" + usual_rows();
}

std::string many_rows(char end) {
  std::string text;
  for (int i = 0; i < 10'000; ++i) text += std::to_string(i) + ",0,1" + end;
  return text;
}

const BadText kColumns[] = {
    {"NoTime", usual_columns("position_m,force_N,velocity_mps"), "log.csv:1: column time_s is missing; add"},
    {"NoPosition", usual_columns("time_s,velocity_mps,force_N"),
     "log.csv:1: a position column is missing; add"},
    {"NoForce", usual_columns("time_s,position_m,velocity_mps"), "log.csv:1: a force column is missing; add"},
    {"UnknownColumn", usual_columns("time_s,position_m,moment_Nm"),
     "log.csv:1: column 'moment_Nm' is unknown; "},
    {"UnknownUnit", usual_columns("time_s,position_inch,force_N"),
     "log.csv:1: column 'position_inch': unknown unit 'inch'; convert it to one of position_m, position_mm, "
     "position_um, position_counts"},
    {"UnknownUnitOfLongerName", usual_columns("time_s,position_m,normal_force_kN"),
     "log.csv:1: column 'normal_force_kN': unknown unit 'kN'; convert it to one of normal_force_N"},
    {"NoUnit", usual_columns("time_s,position,force_N"), "log.csv:1: column 'position' names no unit; write"},
    {"TwiceTheSame", usual_columns("time_s,position_m,position_m"),
     "log.csv:1: column position_m occurs twice; remove"},
    {"TwoPositions", usual_columns("time_s,position_m,position_um"),
     "log.csv:1: column position_um repeats what position_m gives; remove"},
    {"NamelessColumn", usual_columns("time_s,position_m,"), "log.csv:1: column 3 has no name; "},
    {"QuotedNames", usual_columns("\"time_s\",\"position_m\",\"force_N\""),
     "log.csv:1: quotes are not supported; "},
    {"Semicolons", usual_columns("time_s;position_m;force_N"), "log.csv:1: found no comma in the header row"},
    {"Tabs", usual_columns("time_s\tposition_m\tforce_N"), "log.csv:1: found no comma in the header row"},
    {"NoHeaderRow", usual_rows(), "log.csv:1: numbers where the header row should be; "},
    {"CommentedHeaderRow", usual_columns("# time_s,position_m,force_N"),
     "log.csv:2: numbers where the header row should be; write the column names above them, without '#'"},
    {"OldMacLineEnds", "time_s,position_m,force_N\r0,1,2\r",
     "log.csv:1: lines end in a carriage return alone; "},
    {"OldMacLineEndsAfterAComment", "# mass_kg: 1\rtime_s,position_m,force_N\r0,1,2\r",
     "log.csv:1: lines end in a carriage return alone; "},
    {"OldMacLineEndsOfALongLog", "time_s,position_m,force_N\r" + many_rows('\r'),
     "log.csv:1: lines end in a carriage return alone; "},
    {"CountsWithoutResolution", usual_columns("time_s,position_counts,force_N"),
     "log.csv:1: column position_counts needs the encoder's step; "},
    {"CurrentWithoutConstant", usual_columns("time_s,position_m,current_A"),
     "log.csv:1: column current_A needs the motor constant; "},
};
INSTANTIATE_TEST_SUITE_P(Columns, BadTextTest, testing::ValuesIn(kColumns),
                         [](const auto& param) { return param.param.name; });

const BadText kRows[] = {
    {"Text", with_row(15, "0.015,abc,1\n"),
     "log.csv:17: column position_m: 'abc' is not a number; write a decimal number or remove the row"},
    {"TextBehindNumber", with_row(15, "0.015,1e-6 m,1\n"),
     "log.csv:17: column position_m: '1e-6 m' is not a number"},
    {"TwoSigns", with_row(15, "0.015,+-1,1\n"), "log.csv:17: column position_m: '+-1' is not a number"},
    {"Hexadecimal", with_row(15, "0.015,0x10,1\n"), "log.csv:17: column position_m: '0x10' is not a number"},
    {"Quoted", with_row(15, "0.015,\"1\",1\n"),
     "log.csv:17: column position_m: '\"1\"' is not a number (quotes"},
    {"Empty", with_row(15, "0.015,,1\n"), "log.csv:17: column position_m: is empty; "},
    {"EmptyLast", with_row(15, "0.015,1,\n"), "log.csv:17: column force_N: is empty; "},
    {"NaN", with_row(3, "0.003,0,nan\n"), "log.csv:5: column force_N: 'nan' is not a finite number; "},
    {"Inf", with_row(3, "0.003,-inf,0\n"), "log.csv:5: column position_m: '-inf' is not a finite number; "},
    {"TooLarge", with_row(3, "0.003,1e400,0\n"),
     "log.csv:5: column position_m: '1e400' is beyond the range of a number; "},
    {"TooFewFields", with_row(3, "0.003,0\n"), "log.csv:5: 2 fields where the header row names 3 (time_s, "},
    {"TooManyFields", with_row(3, "0.003,0,0,0\n"), "log.csv:5: 4 fields where the header row names 3"},
    {"TrailingComma", with_row(3, "0.003,0,0,\n"), "log.csv:5: 4 fields where the header row names 3"},
    {"DecimalCommas", with_row(3, "0,003,0,000001,1,5\n"),
     "log.csv:5: 6 fields where the header row names 3"},
    {"ControlCharacters", with_row(3, "0.003,\x1b[31m,0\n"),
     "log.csv:5: column position_m: ' [31m' is not a number"},
    {"NotUtf8", with_row(3, "0.003,\xB5,0\n"), "log.csv:5: column position_m: '?' is not a number"},
    {"TimeRepeats", with_row(10, "0.009,0,0\n"), "log.csv:12: column time_s: 0.009 repeats after 0.009; "},
    {"TimeGoesBack", with_row(10, "0.008,0,0\n"), "log.csv:12: column time_s: 0.008 goes back after 0.009; "},
    {"Gap", with_row(10, ""), "log.csv:12: column time_s: a gap of 0.002 s where the step is 0.00100"},
    {"ShiftedStamp", with_row(10, "0.0104,0,0\n"), "log.csv:12: column time_s: 0.0104 is 0.00039"},
    {"Nul", with_row(10, std::string("0.010,\0,0\n", 10)), "log.csv:12: NUL bytes where text should be"},
    {"HugeTime", with_row(199, "1e308,0,0\n"), "log.csv:201: column time_s: a gap of 1e+308 s"},
};
INSTANTIATE_TEST_SUITE_P(Rows, BadTextTest, testing::ValuesIn(kRows),
                         [](const auto& param) { return param.param.name; });

const BadText kHeader[] = {
    {"NotANumber", with_header("# a: b\n# mass_kg: heavy"),
     "log.csv:2: header key mass_kg: 'heavy' is not a number; write a decimal number or remove the line"},
    {"NumberWithUnit", with_header("# mass_kg: 35 kg"),
     "log.csv:1: header key mass_kg: '35 kg' is not a number"},
    {"NoValue", with_header("# magnet_pitch_m:"), "log.csv:1: header key magnet_pitch_m: is empty; "},
    {"NegativeMass", with_header("# mass_kg: -1"), "log.csv:1: header key mass_kg: '-1' is negative; "},
    {"NegativeResolution", with_header("# encoder_resolution_m: -1e-6"),
     "log.csv:1: header key encoder_resolution_m: '-1e-6' is negative; "},
    {"ZeroResolution", with_header("# encoder_resolution_m: 0"),
     "log.csv:1: header key encoder_resolution_m is zero; "},
    {"ZeroPitch", with_header("# magnet_pitch_m: 0.0"), "log.csv:1: header key magnet_pitch_m is zero; "},
    {"InfiniteMass", with_header("# mass_kg: inf"),
     "log.csv:1: header key mass_kg: 'inf' is not a finite number"},
    {"OtherUnit", with_header("# magnet_pitch_in: 24"),
     "log.csv:1: header key 'magnet_pitch_in': unknown unit 'in'; convert it to magnet_pitch_m"},
    {"OtherUnitAndCapital", with_header("# Mass_g: 24"),
     "log.csv:1: header key 'Mass_g': unknown unit 'g'; convert it to mass_kg"},
    {"NoUnitAndCapital", with_header("# Mass: 24"),
     "log.csv:1: header key 'Mass' names no unit; write mass_kg"},
    {"NoUnit", with_header("# mass: 24"), "log.csv:1: header key 'mass' names no unit; write mass_kg"},
    {"Capital", with_header("# Mass_kg: 24"),
     "log.csv:1: header key 'Mass_kg' has other capitals; write mass_kg"},
    {"SmallLetters", with_header("# motor_constant_n_per_a: 24"),
     "log.csv:1: header key 'motor_constant_n_per_a' has other capitals; write motor_constant_N_per_A"},
    {"TwoValues", with_header("# mass_kg: 1\n# mass_kg: 2"),
     "log.csv:2: header key 'mass_kg' has another value than on line 1; keep one"},
    {"Sampling", with_header("# sampling: sometimes"),
     "log.csv:1: header key sampling: 'sometimes' is unknown; "},
    {"CurrentSource", with_header("# current_source: guessed"),
     "log.csv:1: header key current_source: 'guessed' is unknown; write measured or commanded"},
};
INSTANTIATE_TEST_SUITE_P(Header, BadTextTest, testing::ValuesIn(kHeader),
                         [](const auto& param) { return param.param.name; });

std::string still_position() {
  std::string text = kNames;
  for (int i = 0; i < 200; ++i) text += std::to_string(i) + ",0.5," + std::to_string(i % 7) + "\n";
  return text;
}

std::string one_step_position() {
  std::string text = std::string("# encoder_resolution_m: 1e-6\n") + kNames;
  for (int i = 0; i < 200; ++i)
    text += std::to_string(i) + (i % 3 == 0 ? ",0," : ",1e-6,") + std::to_string(i % 7) + "\n";
  return text;
}

// To and fro by 0.25 m, counted modulo 0.1 m.
std::string full_counter() {
  std::string text = kNames;
  for (int i = 0; i < 500; ++i) {
    const int position_mm = i < 250 ? i : 500 - i;
    text += fmt::format("{},{:.3f},{}\n", i, 1e-3 * (position_mm % 100), i % 7);
  }
  return text;
}

std::string still_force() {
  std::string text = kNames;
  for (int i = 0; i < 200; ++i)
    text += std::to_string(i) + "," + std::to_string(std::abs(i % 50 - 25)) + "e-6,1.5\n";
  return text;
}

const BadText kWhole[] = {
    {"Empty", "", "log.csv: the file is empty; "},
    {"BomOnly", "\xEF\xBB\xBF", "log.csv: the file is empty; "},
    {"BlankLines", "\n\n\n", "log.csv:3: the text ends without a header row; "},
    {"CommentsOnly", "# mass_kg: 1\n", "log.csv:1: the text ends without a header row; "},
    {"NamesOnly", kNames, "log.csv: 0 samples are too few; record at least 100"},
    {"TooFew", kNames + usual_rows(99), "log.csv: 99 samples are too few; record at least 100"},
    {"Utf16", std::string("\xFF\xFEt\0i\0m\0", 8), "log.csv: the text is UTF-16; "},
    {"LongLineWithEnd", std::string(70'000, ' ') + "\n" + usual_log(), "log.csv:1: the line is longer than"},
    {"ManyColumns",
     [] {
       std::string s = "a";
       for (int i = 0; i < 999; ++i) s += ",a";
       return s + "\n";
     }(),
     "log.csv:1: 1000 columns; "},
    {"StillPosition", still_position(),
     "log.csv: column position_m: the position never moves (it is always 0.5 m); "},
    {"OneStep", one_step_position(),
     "log.csv: column position_m: the position never moves by more than one encoder"},
    {"FullCounter", full_counter(),
     "log.csv:102: column position_m: the position jumps from 0.099 to 0 m, one end of its range to the "
     "other, while the axis moves on, as a counter does that is full; "},
    {"StillForce", still_force(), "log.csv: column force_N: the force never changes (it is always 1.5 N); "},
    {"CountsBeyondNumbers",
     "# encoder_resolution_m: 1e300\ntime_s,position_counts,force_N\n0,1e10,0\n" +
         usual_rows().substr(usual_rows().find('\n') + 1),
     "log.csv:3: column position_counts: the value is beyond the range of a number; "},
};
INSTANTIATE_TEST_SUITE_P(Whole, BadTextTest, testing::ValuesIn(kWhole),
                         [](const auto& param) { return param.param.name; });

// The line number in a message is that of an editor, which counts blank lines and comments too.
TEST(BadText, CountsBlankLinesAndComments) {
  const std::string text = "\n# mass_kg: 1\n\n" + std::string(kNames) +
                           "0.000,0,0\n\n# pause\n0.001,1e-6,1\n0.001,0,0\n" + usual_rows();
  EXPECT_EQ(refusal(text).substr(0, 12), "log.csv:9: c");
}

TEST(BadText, TheUsualLogIsRead) {
  EXPECT_EQ(refusal(usual_log()), "");
}

}  // namespace
}  // namespace slipstack::workbench::test
