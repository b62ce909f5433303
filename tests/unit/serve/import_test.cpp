// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "workbench/base/errors.h"
#include "workbench/log/byte_source.h"
#include "workbench/log/csv/csv.h"
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
  const RawTable table = read_back(import_log("scope.csv", bytes, preview.profile));
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
  const RawTable table = read_back(import_log("a.txt", text, preview.profile));
  EXPECT_DOUBLE_EQ(table.columns[0].values[2], 1e-3);
  EXPECT_EQ(table.columns[1].name, "position_um");
  EXPECT_DOUBLE_EQ(table.columns[2].values[1], 0.021);
}

TEST(Import, IsoTimesCountFromTheFirst) {
  const std::string text =
      "timestamp,x [mm],F [N]\n2026-02-28T23:59:59.999,1,2\n2026-03-01T00:00:00.001,1.1,2.1\n"
      "2026-03-01T00:00:00.003,1.2,2.2\n";
  const ImportPreview preview = guess_import("iso.csv", text);
  const RawTable table = read_back(import_log("iso.csv", text, preview.profile));
  EXPECT_EQ(table.columns[0].values[0], 0.0);
  EXPECT_NEAR(table.columns[0].values[1], 0.002, 1e-6);
  EXPECT_NEAR(table.columns[0].values[2], 0.004, 1e-6);
}

TEST(Import, ColumnsByHandAndProfileRoundTrip) {
  const std::string text = "a,b,c\n0,1,2\n0.1,2,3\n0.2,4,5\n";
  ImportProfile profile = guess_import("x.csv", text).profile;
  assign_columns(profile, "a=time_s, 2=position_um*10, c=force_N");
  const ImportProfile again = parse_profile("p.toml", to_toml(profile));
  EXPECT_EQ(import_log("x.csv", text, profile), import_log("x.csv", text, again));
  EXPECT_EQ(read_back(import_log("x.csv", text, again)).columns[1].values[2], 40.0);
  EXPECT_THROW(assign_columns(profile, "nothing=time_s"), UsageError);
  EXPECT_THROW(parse_profile("p.toml", "format = 'other'"), InputError);
  EXPECT_THROW(parse_profile("p.toml", "format = "), InputError);
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

// Random bytes give a log or one line, never anything else.
TEST(Import, RandomBytesGiveALogOrOneLine) {
  std::mt19937 random(7);
  const std::string alphabet = "0123456789.,;\t\n\r -+eE\"tTxF[]ms\xB5\xFF\0";
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
