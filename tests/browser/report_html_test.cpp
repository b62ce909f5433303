// SPDX-License-Identifier: Apache-2.0
// The report without a browser: number texts, escaping, what the page holds, and how it reaches the disk.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>

#include "tests/browser/synthetic_report.h"
#include "workbench/report/html/format.h"
#include "workbench/report/html/report_page.h"

namespace slipstack::workbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
  return found;
}

std::string data_element(const std::string& page) {
  const std::string open = "id=\"report-data\">";
  const std::size_t from = page.find(open) + open.size();
  return page.substr(from, page.find("</script>", from) - from);
}

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

std::string without(const std::string& text, const std::string& mark, char instead = '\0') {
  std::string out;
  std::size_t from = 0;
  for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, from)) {
    out.append(text, from, at - from);
    if (instead != '\0') out.push_back(instead);
    from = at + mark.size();
  }
  return out.append(text, from);
}

TEST(Format, SignificantDigits) {
  EXPECT_EQ(significant(0.34, 3), "0.340");
  EXPECT_EQ(significant(9.996, 3), "10.0");
  EXPECT_EQ(significant(-1.5, 2), "−1.5");
  EXPECT_EQ(significant(12345.6, 4), "12\u202f346");  // whole numbers keep all their digits
  EXPECT_EQ(significant(1234.0, 4), "1234");
  EXPECT_EQ(significant(1.234e-7, 3), "1.23 × 10⁻⁷");
  EXPECT_EQ(significant(4e9, 2), "4.0 × 10⁹");
  EXPECT_EQ(significant(0.0, 3), "0");
  EXPECT_EQ(significant(std::numeric_limits<double>::quiet_NaN(), 3), "–");
  EXPECT_EQ(fixed(-0.001, 2), "0.00");
  EXPECT_EQ(fixed(-1234567.25, 1), "\u22121\u202f234\u202f567.2");
}

// Reading the text back gives the number to within half of its last digit: the property behind every table
// cell.
TEST(Format, SignificantReadsBack) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> exponent(-4.0, 6.9), mantissa(-1.0, 1.0);
  for (int i = 0; i < 20000; ++i) {
    const double value = mantissa(random) * std::pow(10.0, exponent(random));
    if (std::abs(value) < 1e-4) continue;
    const std::string text = without(without(significant(value, 4), "\u202f"), "\u2212", '-');
    ASSERT_NEAR(std::stod(text), value, 0.5001e-3 * std::abs(value)) << text;
  }
}

TEST(Format, UnitsThatAnEngineerWouldChoose) {
  EXPECT_EQ(with_unit(0.024, "m", 4), "24.00\u00a0mm");
  EXPECT_EQ(with_unit(1e-6, "m", 3), "1.00\u00a0µm");
  EXPECT_EQ(with_unit(4.2e6, "N/m", 3), "4.20\u00a0N/µm");
  EXPECT_EQ(with_unit(0.0042, "N", 2), "4.2\u00a0mN");
  EXPECT_EQ(with_unit(0.33, "N", 2), "0.33\u00a0N");
  EXPECT_EQ(with_unit(1.0, "parsec", 2), "1.0\u00a0parsec");
  EXPECT_EQ(with_unit(0.5, "1", 2), "0.50");
  EXPECT_EQ(display_unit("m", 0.0).label, "mm");
}

TEST(Format, DisplayedValueTimesUnitIsTheSiValue) {
  for (const char* unit : {"N", "m", "m/s", "m/s^2", "s", "kg", "N/m", "Hz"}) {
    for (double size = 1e-9; size < 1e8; size *= 3.7) {
      const DisplayUnit chosen = display_unit(unit, size);
      const double prefix = chosen.label.starts_with("µ")   ? 1e-6
                            : chosen.label.starts_with("n") ? 1e-9
                            : chosen.label.starts_with("mN") || chosen.label.starts_with("mm") ||
                                    chosen.label == "ms" || chosen.label == "g"
                                ? 1e-3
                            : chosen.label == "kN" || chosen.label == "kHz" || chosen.label == "N/mm" ? 1e3
                            : chosen.label == "N/µm"                                                  ? 1e6
                                                                                                      : 1.0;
      EXPECT_NEAR(chosen.per_si * prefix, 1.0, 1e-12) << chosen.label;
    }
  }
}

TEST(Format, ProseHasTheSignsOfAPage) {
  EXPECT_EQ(prose_html("20.2 +- 0.3 N of 3 um"), "20.2 \u00b1 0.3\u00a0N of 3\u00a0\u00b5m");
  EXPECT_EQ(prose_html("a +-sign"), "a +-sign");
}

TEST(Format, EscapesWhatCouldBecomeMarkup) {
  EXPECT_EQ(escape_html("<b a=\"1\" c='2'>&"), "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;");
  EXPECT_EQ(escape_html(std::string("a\0\x1b[31m\nb", 9)), "a[31m\nb");
}

TEST(Format, ColumnsAlign) {
  const Column column = aligned_column("N", {3.93, 0.3349, 0.0}, 3);
  EXPECT_EQ(column.text(3.93), "3.930");
  EXPECT_EQ(column.text(0.3349), "0.335");
  EXPECT_EQ(aligned_column("N", {5.0, 1e-12}, 3).decimals, 5);
}

TEST(Prose, NumbersStayWithTheirUnits) {
  EXPECT_EQ(prose_html("1.56 N to 103 mN; 2.6 um, 9.7 N s/m (64 %)"),
            "1.56\u00a0N to 103\u00a0mN; 2.6\u00a0\u00b5m, 9.7\u00a0N\u00a0s/m (64\u00a0%)");
  EXPECT_EQ(prose_html("21 samples, 5 mice & 3 us <b>"), "21 samples, 5 mice &amp; 3\u00a0\u00b5s &lt;b&gt;");
  EXPECT_EQ(prose_html("um 5"), "um 5");
  EXPECT_EQ(prose_html(""), "");
}

TEST(Report, IntervalsStandUnderTheErrors) {
  json data = test::synthetic_report("missing_effect", 3);
  data["figures"]["holdout_interval_N"] = {1.25, 1.75};
  data["figures"]["after_interval_N"] = {0.5, 0.75};
  data["figures"]["relative_error"] = 0.0408;
  data["figures"]["after_relative_error"] = 0.0308;
  const std::string page = render_report(data);
  EXPECT_NE(page.find("95\u00a0%: 1.25 to 1.75\u00a0N"), std::string::npos);
  EXPECT_NE(page.find("95\u00a0%: 0.50 to 0.75\u00a0N"), std::string::npos);
  EXPECT_NE(page.find("4.08 \u2192 3.08"), std::string::npos);
  data["figures"]["after_interval_N"] = {nullptr, 0.75};
  EXPECT_EQ(render_report(data).find("0.50 to"), std::string::npos);
}

TEST(Report, WhatIsShownAfterIsNamedByAllThatWasAdded) {
  json data = test::synthetic_report("missing_effect", 3);
  data["after_effects"] = {"force_ripple", "cable_chain_stiffness"};
  EXPECT_NE(render_report(data).find("with force ripple and cable chain stiffness added"), std::string::npos);
  data["after_effects"].push_back("viscous");
  EXPECT_NE(render_report(data).find("with all 3 effects added"), std::string::npos);
}

TEST(Report, ACommandIsCopiedAsItWasGivenAndBreaksBetweenItsWords) {
  json data = test::synthetic_report("missing_effect", 3);
  data["next_experiment"] = {{"why", "It would confirm it."},
                             {"command", "slipstack experiment plan --log 'a b'"}};
  EXPECT_NE(render_report(data).find(
                "<span>plan</span> <span>--log</span> <span>&#39;a</span> <span>b&#39;</span>"),
            std::string::npos);
}

TEST(Report, HoldsWhatItWasGiven) {
  const json data = test::synthetic_report("missing_effect", 3);
  const std::string page = render_report(data);
  const json shown = json::parse(data_element(page));
  for (const char* name : {"time_s", "measured_N", "model_N", "residual_N", "after_N", "position_m"}) {
    const json& given = data["series"][name];
    ASSERT_EQ(shown["series"][name].size(), given.size()) << name;
    for (std::size_t i = 0; i < given.size(); i += 97) {
      const json& value = shown["series"][name][i];
      ASSERT_EQ(value.is_null(), given[i].is_null()) << name << i;
      if (value.is_null()) continue;
      ASSERT_NEAR(value.get<double>(), given[i].get<double>(), 1e-6 * std::abs(given[i].get<double>()))
          << name << i;
    }
  }
  EXPECT_EQ(shown["after_label"], "with force ripple added");
  // Both directions: the page may neither lose data nor bloat. 40 000 samples of six channels.
  EXPECT_GT(page.size(), 2'500'000U);
  EXPECT_LT(page.size(), 5'000'000U);
}

TEST(Report, IsOneFileWithLicenceAndWithoutAddresses) {
  const std::string page = render_report(test::synthetic_report("complete", 3));
  EXPECT_EQ(count(page, "Copyright (c) 2022 Leon Sorokin"), 1U);
  EXPECT_EQ(count(page, "Permission is hereby granted, free of charge"), 1U);
  for (const char* loads : {"src=", "href=\"http", "url(http", "@import", "fetch(", "XMLHttpRequest"}) {
    EXPECT_EQ(count(page, loads), 0U) << loads;
  }
  EXPECT_EQ(count(page, "{{"), 0U);
}

TEST(Report, SameDataSamePage) {
  EXPECT_EQ(render_report(test::synthetic_report("unexplained", 5)),
            render_report(test::synthetic_report("unexplained", 5)));
}

TEST(Report, HostileStringsStayText) {
  const std::string page = render_report(test::synthetic_report("hostile", 3));
  EXPECT_EQ(count(page, "<script"), 2U);
  EXPECT_EQ(count(page, "</script>"), 2U);
  EXPECT_EQ(count(page, "<img"), 0U);
  EXPECT_EQ(count(data_element(page), "<"), 0U);
  // What was put in is not read as a placeholder again.
  EXPECT_GT(count(page, "{{data}}{{script}}"), 3U);
  // Stray bytes became replacement characters: the whole page is valid UTF-8, or this would throw.
  EXPECT_NO_THROW((void)json(page).dump());
}

TEST(Report, NotANumberBecomesNull) {
  json data = {{"series", {{"time_s", {0.0, 1.0, 2.0}}, {"measured_N", {1.0, std::nan(""), HUGE_VAL}}}},
               {"figures", {{"noise_floor_N", std::nan("")}, {"holdout_rmse_N", HUGE_VAL}}}};
  const std::string page = render_report(data);
  EXPECT_NE(data_element(page).find("\"measured_N\":[1,null,null]"), std::string::npos) << data_element(page);
  EXPECT_EQ(count(page, "<dl class=\"keys\">"), 0U);
}

TEST(Report, ParameterIsRoundedToItsError) {
  json data = {{"parameters",
                {{{"effect", "force_ripple"},
                  {"title", "Force ripple"},
                  {"parameters",
                   {{{"name", "a1"}, {"value", 4.2031234}, {"standard_error", 0.0061}, {"unit", "N"}},
                    {{"name", "b1"}, {"value", -0.0042}, {"standard_error", 0.0062}, {"unit", "N"}}}}}}}};
  const std::string page = render_report(data);
  EXPECT_NE(page.find(">4.2031<"), std::string::npos);
  EXPECT_NE(page.find(">0.0061<"), std::string::npos);
  EXPECT_NE(page.find(">−0.0042<"), std::string::npos);
  EXPECT_EQ(count(page, "within its error"), 1U);
}

/// Swaps random members for values of another type, or drops them.
void tear(json& value, std::mt19937& random) {
  std::uniform_int_distribution<int> dice(0, 11);
  if (value.is_structured() && value.size() < 200) {
    for (auto it = value.begin(); it != value.end(); ++it) tear(*it, random);
  }
  switch (dice(random)) {
    case 0:
      value = nullptr;
      break;
    case 1:
      value = json::array();
      break;
    case 2:
      value = "</script>";
      break;
    case 3:
      value = -1.5;
      break;
    case 4:
      value = json::object({{"effect", 3}});
      break;
    default:
      break;
  }
}

TEST(Report, AnyPartMayBeMissingOrOfAnotherType) {
  json whole = test::synthetic_report("missing_effect", 3);
  whole["series"] = {{"time_s", {0, 1}}, {"measured_N", {1, 2}}};
  std::mt19937 random(4);
  for (int i = 0; i < 400; ++i) {
    json data = whole;
    tear(data, random);
    std::string page;
    ASSERT_NO_THROW(page = render_report(data)) << data.dump();
    ASSERT_EQ(count(page, "</script>"), 2U);
    ASSERT_TRUE(json::accept(data_element(page)));
  }
}

class WriteReport : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "slipstack_report_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}));
  }
  static std::string failure(const fs::path& path) {
    try {
      write_report(path, {{"title", "x"}});
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
  const json data_ = {{"title", "Friction diagnosis"}};
};

TEST_F(WriteReport, LeavesTheReportAndNothingElse) {
  write_report(folder_ / "r.html", data_);
  EXPECT_EQ(read(folder_ / "r.html"), render_report(data_));
  EXPECT_EQ(files(), 1U);
  struct stat status {};
  ASSERT_EQ(::stat((folder_ / "r.html").c_str(), &status), 0);
  const mode_t mask = ::umask(0);
  ::umask(mask);
  EXPECT_EQ(status.st_mode & 0777U, 0666U & ~mask);
}

TEST_F(WriteReport, ReplacesInOneStep) {
  write_report(folder_ / "r.html", {{"title", "old"}});
  struct stat before {};
  ASSERT_EQ(::stat((folder_ / "r.html").c_str(), &before), 0);
  write_report(folder_ / "r.html", data_);
  struct stat after {};
  ASSERT_EQ(::stat((folder_ / "r.html").c_str(), &after), 0);
  EXPECT_NE(before.st_ino,
            after.st_ino);  // another file took the name; the old one was not overwritten in place
  EXPECT_EQ(files(), 1U);
}

TEST_F(WriteReport, SaysInOneLineWhatIsWrong) {
  const std::string missing = failure(folder_ / "no" / "such" / "r.html");
  EXPECT_NE(missing.find("r.html"), std::string::npos);
  EXPECT_NE(missing.find("No such file or directory"), std::string::npos);
  const std::string directory = failure(folder_);
  EXPECT_NE(directory.find("it is a directory"), std::string::npos);
  const std::string full = failure("/dev/full");
  EXPECT_NE(full.find("No space left on device"), std::string::npos);
  for (const std::string& line : {missing, directory, full}) EXPECT_EQ(line.find('\n'), std::string::npos);
  EXPECT_EQ(files(), 0U);
}

TEST_F(WriteReport, KeepsLinksAndDevices) {
  fs::create_directory(folder_ / "there");
  std::ofstream(folder_ / "there" / "r.html") << "old";
  fs::create_symlink(folder_ / "there" / "r.html", folder_ / "link.html");
  write_report(folder_ / "link.html", data_);
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.html"));
  EXPECT_EQ(read(folder_ / "there" / "r.html"), render_report(data_));
  write_report("/dev/null", data_);
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace slipstack::workbench
