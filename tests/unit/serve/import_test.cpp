// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "workbench/base/errors.h"
#include "workbench/log/byte_source.h"
#include "workbench/log/csv/csv.h"
#include "workbench/log/import/column_guess.h"
#include "workbench/log/import/import_log.h"

namespace slipstack::workbench {
namespace {

RawTable read_back(const std::string& text) {
  MemorySource source(text);
  return read_csv("imported", source);
}

std::string utf16(const std::string& ascii, bool little) {
  std::string out = little ? "\xFF\xFE" : "\xFE\xFF";
  for (const char c : ascii) {
    if (!little) out += '\0';
    out += c;
    if (little) out += '\0';
  }
  return out;
}

const char* const kGerman =
    "Achse;X1\nExport;12.03.2026\n\nZeit [ms];Ist-Position [mm];Kraft [N];Status\n"
    "0,0;12,3456;-0,5;1\n0,5;12,3457;-0,25;1\n1,0;12,3460;0,125;1\n";

void expect_german(const std::string& bytes, const std::string& encoding) {
  const ImportPreview preview = guess_import("scope.csv", bytes);
  EXPECT_EQ(preview.profile.encoding, encoding);
  EXPECT_EQ(preview.profile.separator, ';');
  EXPECT_EQ(preview.profile.decimal, ',');
  EXPECT_EQ(preview.fault, "");
  const RawTable table = read_back(import_log("scope.csv", bytes, preview.profile).text);
  ASSERT_EQ(table.columns.size(), 3U);
  EXPECT_EQ(table.columns[0].name, "time_s");
  EXPECT_EQ(table.columns[1].name, "position_mm");
  EXPECT_EQ(table.columns[2].name, "force_N");
  EXPECT_DOUBLE_EQ(table.columns[0].values[1], 0.0005);
  EXPECT_EQ(table.columns[1].values[2], 12.3460);
  EXPECT_EQ(table.columns[2].values[2], 0.125);
}

TEST(Import, GermanScopeInEveryEncoding) {
  expect_german(kGerman, "utf-8");
  expect_german(utf16(kGerman, true), "utf-16le");
  expect_german(utf16(kGerman, false), "utf-16be");
}

TEST(Import, UnitsRowTabsAndMicroseconds) {
  const std::string text = "time\tpos\tcurrent\nus\tum\tmA\n0\t1.5\t20\n500\t1.6\t21\n1000\t1.8\t22\n";
  ImportPreview preview = guess_import("a.txt", text);
  EXPECT_EQ(preview.profile.separator, '\t');
  EXPECT_TRUE(preview.profile.units_row);
  EXPECT_EQ(preview.fault, "a current needs the motor constant");
  preview.profile.header["motor_constant_N_per_A"] = "60";
  const RawTable table = read_back(import_log("a.txt", text, preview.profile).text);
  EXPECT_DOUBLE_EQ(table.columns[0].values[2], 1e-3);
  EXPECT_EQ(table.columns[1].name, "position_um");
  EXPECT_DOUBLE_EQ(table.columns[2].values[1], 0.021);
}

TEST(Import, UnitsInNames) {
  struct Known {
    const char* name;
    const char* target;
    double factor;
  };
  constexpr std::array kKnown{Known{"Time (s)", "time_s", 1.0},
                              Known{"t [min]", "time_s", 60.0},
                              Known{"time_h", "time_s", 3600.0},
                              Known{"Zeit in ms", "time_s", 1e-3},
                              Known{"timestamp [usec]", "time_s", 1e-6},
                              Known{"pos [cm]", "position_mm", 10.0},
                              Known{"pos (inch)", "position_mm", 25.4},
                              Known{"Position (load side)", "position_m", 1.0},
                              Known{"force [lbf]", "force_N", 4.4482216152605},
                              Known{"torque [Ncm]", "torque_Nm", 1e-2},
                              Known{"vel [m/min]", "velocity_mps", 1.0 / 60.0}};
  for (const Known& known : kKnown) {
    const ImportColumn column = guess_column(known.name);
    EXPECT_EQ(column.target, known.target) << known.name;
    EXPECT_DOUBLE_EQ(column.factor, known.factor) << known.name;
  }
}

// A unit that is not known is not SI: a wrong factor would be a log that nobody doubts.
TEST(Import, AUnitThatIsNotKnownIsAskedFor) {
  const std::string text = "time [weeks],pos [mm],force [N]\n0,1,2\n1,2,3\n2,3,4\n";
  const ImportPreview preview = guess_import("a.csv", text);
  EXPECT_EQ(preview.profile.columns[0].target, "");
  EXPECT_EQ(preview.fault, "no column is the time, and no sample rate is given");
  for (const char* name :
       {"pos [furlong]", "force [stone]", "force [MN]", "current (pA)", "t/fortnight [week]"}) {
    EXPECT_EQ(guess_column(name).target, "") << name;
  }
}

TEST(Import, IsoTimesCountFromTheFirst) {
  const std::string text =
      "timestamp,x [mm],F [N]\n2026-02-28T23:59:59.999,1,2\n2026-03-01T00:00:00.001,1.1,2.1\n"
      "2026-03-01T00:00:00.003,1.2,2.2\n";
  const ImportPreview preview = guess_import("iso.csv", text);
  const RawTable table = read_back(import_log("iso.csv", text, preview.profile).text);
  EXPECT_EQ(table.columns[0].values[0], 0.0);
  EXPECT_NEAR(table.columns[0].values[1], 0.002, 1e-6);
  EXPECT_NEAR(table.columns[0].values[2], 0.004, 1e-6);
}

TEST(Import, ColumnsByHandAndProfileRoundTrip) {
  const std::string text = "a,b,c\n0,1,2\n0.1,2,3\n0.2,4,5\n";
  ImportProfile profile = guess_import("x.csv", text).profile;
  assign_columns(profile, "a=time_s, 2=position_um*10, c=force_N");
  const ImportProfile again = parse_profile("p.toml", to_toml(profile));
  EXPECT_EQ(import_log("x.csv", text, profile).text, import_log("x.csv", text, again).text);
  EXPECT_EQ(read_back(import_log("x.csv", text, again).text).columns[1].values[2], 40.0);
  EXPECT_THROW(assign_columns(profile, "nothing=time_s"), UsageError);
  EXPECT_THROW(parse_profile("p.toml", "format = 'other'"), InputError);
  EXPECT_THROW(parse_profile("p.toml", "format = "), InputError);
}

TEST(Import, AMisspeltKeyOfAProfileIsRefused) {
  const auto said = [](const std::string& text) {
    try {
      parse_profile("p.toml", text);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string format = "format = 'slipstack import 1'\n";
  const std::string column = "[[column]]\nsource = 'a'\n";
  EXPECT_EQ(said(format + "decimal = ','\n[header]\naxis = 'X'\n" + column + "target = 'time_s'\n"), "");
  EXPECT_EQ(said(format + "decimals = ','\n").rfind("p.toml:2: unknown key 'decimals'", 0), 0U);
  EXPECT_EQ(said(format + column + "faktor = 2.0\n").rfind("p.toml:4: unknown key 'faktor'", 0), 0U);
}

TEST(Import, FaultsNameTheLine) {
  const std::string text = "t [s],x [mm],F [N]\n0,1,2\n0.1,1,2\n0.2,oops,2\n";
  const ImportProfile profile = guess_import("x.csv", text).profile;
  try {
    static_cast<void>(import_log("x.csv", text, profile));
    FAIL() << "a word was read as a number";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("x.csv:4"), std::string::npos) << error.what();
  }
  EXPECT_THROW(static_cast<void>(guess_import("prose.txt", "Dear friend,\nhow are you?\n")), InputError);
  EXPECT_THROW(static_cast<void>(guess_import("empty", "")), InputError);
}

// The layout of Beckhoff's documentation of "Export to CSV": rows of keys over each column of times.
constexpr const char* kScope =
    "Name\tScope Project\nFile\tC:\\scope.svdx\nStarttime of export\t134000000000000000\tMontag\n"
    "Endtime of export\t134000000001000000\tMontag\n\n"
    "Name\tActPos\tName\tActTorque\nSymbolComment\t\tSymbolComment\t\nData-Type\tREAL64\tData-Type\tINT16\n"
    "SampleTime[ms]\t2\tSampleTime[ms]\t2\nSymbolName\tMAIN.Axis.ActPos\tSymbolName\tMAIN.Axis.ActTorque\n"
    "Unit\tmm\tUnit\tN\nUnit Offset\t0\tUnit Offset\t0\n\n";

TEST(Import, ScopeHasAColumnOfTimesForEachChannel) {
  const std::string text = std::string(kScope) + "0\t1,5\t0\t20\n2\t1,75\t2\t-21\n4\t2\t4\t22\nEOF\n";
  const ImportPreview preview = guess_import("scope.csv", text);
  EXPECT_EQ(preview.fault, "");
  EXPECT_EQ(preview.profile.decimal, ',');
  const ImportProfile again = parse_profile("p.toml", to_toml(preview.profile));
  const RawTable table = read_back(import_log("scope.csv", text, again).text);
  ASSERT_EQ(table.columns.size(), 3U);
  EXPECT_EQ(table.columns[1].name, "position_mm");
  EXPECT_EQ(table.columns[2].name, "force_N");
  EXPECT_EQ(table.columns[0].values, (std::vector<double>{0.0, 0.002, 0.004}));
  EXPECT_EQ(table.columns[1].values, (std::vector<double>{1.5, 1.75, 2.0}));
  EXPECT_EQ(table.columns[2].values, (std::vector<double>{20.0, -21.0, 22.0}));
}

TEST(Import, ChannelsThatWereNotSampledTogetherAreRefused) {
  const std::string text = std::string(kScope) + "0\t1,5\t0\t20\n2\t1,75\t4\t-21\n4\t2\t8\t22\n";
  const ImportProfile profile = guess_import("scope.csv", text).profile;
  try {
    static_cast<void>(import_log("scope.csv", text, profile));
    FAIL() << "one row was taken for one instant";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("scope.csv:15"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("not sampled together"), std::string::npos) << error.what();
  }
}

TEST(Import, OneTimeLineForAllChannelsOfAScope) {
  const std::string text =
      "Name,ActPos,ActTorque\nSampleTime[ms],1,1\nUnit,um,mN\n0,1.5,20\n1,1.75,-21\n2,2,22\n";
  const RawTable table = read_back(import_log("s.csv", text, guess_import("s.csv", text).profile).text);
  ASSERT_EQ(table.columns.size(), 3U);
  EXPECT_EQ(table.columns[0].values[1], 0.001);
  EXPECT_EQ(table.columns[1].name, "position_um");
  EXPECT_EQ(table.columns[2].name, "force_mN");
}

// A double holds 1.7e18 ns to 256 ns only.
TEST(Import, TimesSince1970KeepTheirDigits) {
  for (const auto& [first, step, factor] :
       {std::tuple{1772619300000000001LL, 100001LL, 1e-9}, std::tuple{1772619300000001LL, 501LL, 1e-6},
        std::tuple{1772619300001LL, 3LL, 1e-3}}) {
    std::string text = "timestamp,x [mm],F [N]\n";
    for (int i = 0; i < 5; ++i) text += std::to_string(first + i * step) + ",1,2\n";
    const ImportedLog log = import_log("e.csv", text, guess_import("e.csv", text).profile);
    EXPECT_TRUE(log.notes.empty()) << log.notes[0];
    const RawTable table = read_back(log.text);
    for (int i = 0; i < 5; ++i) {
      const auto row = static_cast<std::size_t>(i);
      EXPECT_NEAR(table.columns[0].values[row], static_cast<double>(i * step) * factor, 1e-13);
    }
  }
}

TEST(Import, UnevenStampsAreSaid) {
  const std::string even = "t [ms],x [mm],F [N]\n0,1,2\n2,1,2\n4,1,2\n6,1,2\n";
  std::string uneven = even;
  uneven.replace(uneven.find("\n4,"), 3, "\n4.3,");
  const ImportedLog log = import_log("j.csv", uneven, guess_import("j.csv", uneven).profile);
  ASSERT_EQ(log.notes.size(), 1U);
  EXPECT_NE(log.notes[0].find("1.7 to 2.3 ms"), std::string::npos) << log.notes[0];
  EXPECT_EQ(log.text.rfind("# sampling: irregular\n", 0), 0U);
  EXPECT_TRUE(import_log("j.csv", even, guess_import("j.csv", even).profile).notes.empty());
  // Who has said how it was sampled is not contradicted.
  ImportProfile said = guess_import("j.csv", uneven).profile;
  said.header["sampling"] = "uniform";
  EXPECT_TRUE(import_log("j.csv", uneven, said).notes.empty());
}

TEST(Import, FilesOfOtherFormatsSayWhatToDo) {
  for (const auto& [head, told] : {std::pair{std::string("PK\x03\x04 and more"), "libreoffice"},
                                   std::pair{std::string("\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"), "libreoffice"},
                                   std::pair{std::string("PAR1...."), "read_parquet"},
                                   std::pair{std::string("\x89MCAP0\r\n"), "slipstack.mcap"},
                                   std::pair{std::string("(1795560339.850364) vcan0 705#00\n"), "candump"}}) {
    try {
      static_cast<void>(guess_import("other", head));
      FAIL() << told;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(told), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
}

// Random bytes give a log or one line, never anything else.
TEST(Import, RandomBytesGiveALogOrOneLine) {
  std::mt19937 random(7);
  std::string alphabet = "0123456789.,;\t\n\r -+eE\"tTxF[]ms\xB5\xFF";
  alphabet += '\0';
  for (int round = 0; round < 3000; ++round) {
    std::string bytes;
    for (unsigned i = 0; i < random() % 300; ++i) bytes += alphabet[random() % alphabet.size()];
    try {
      const ImportPreview preview = guess_import("random", bytes);
      if (preview.fault.empty()) static_cast<void>(import_log("random", bytes, preview.profile));
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace slipstack::workbench
