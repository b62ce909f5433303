// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/foreign_format.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace slipstack::workbench {
namespace {

using namespace std::string_view_literals;

constexpr auto kWorkbook =
    "a workbook of a spreadsheet program; save its sheet as CSV, or convert it: libreoffice --headless "
    "--convert-to "
    "csv FILE, then slipstack import"sv;

struct Format {
  std::string_view begin;
  std::string_view what;
};

// The first bytes as the formats define them.
constexpr std::array kFormats{
    Format{"PK\x03\x04"sv, kWorkbook},                        // .xlsx, .ods: a ZIP archive
    Format{"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"sv, kWorkbook},  // .xls: a compound file
    Format{"PAR1"sv, "a Parquet file; in Python: slipstack.diagnose(pandas.read_parquet(FILE))"sv},
    Format{"\x89MCAP0\r\n"sv,
           "an MCAP file; python3 -m slipstack.mcap makes a table of its topics, then slipstack import"sv},
    Format{"#ROSBAG V2.0"sv,
           "a ROS bag; python3 -m slipstack.bag makes a table of its topics, then slipstack import"sv},
    Format{"SQLite format 3\0"sv,
           "an SQLite data base, maybe a bag of ROS 2; ros2 bag convert makes an MCAP file of it, python3 -m "
           "slipstack.mcap a "
           "table of that"sv},
    Format{
        "MDF     "sv,
        "an MDF file of measurements; write it as CSV (package asammdf of Python), then slipstack import"sv},
    Format{"TDSm"sv,
           "a TDMS file of LabVIEW; write it as CSV (package npTDMS of Python), then slipstack import"sv},
    Format{"\x1F\x8B"sv, "compressed by gzip; gunzip it first"sv},
};

/// "(1436509052.249713) vcan0 044#2A36", a line of candump -L or -l.
bool is_candump(std::string_view head) {
  const std::size_t close = head.find(") ");
  if (head.empty() || head[0] != '(' || close == std::string_view::npos) return false;
  const std::string_view stamp = head.substr(1, close - 1);
  const auto of_number = [](unsigned char c) { return std::isdigit(c) != 0 || c == '.'; };
  return stamp.find('.') != std::string_view::npos && std::all_of(stamp.begin(), stamp.end(), of_number);
}

}  // namespace

std::string foreign_format(std::string_view head) {
  for (const Format& format : kFormats) {
    if (head.substr(0, format.begin.size()) == format.begin) return std::string(format.what);
  }
  if (is_candump(head)) {
    return "a capture of candump; decode its PDOs by the EDS: python3 -m slipstack.candump FILE --eds "
           "drive.eds, then "
           "slipstack import";
  }
  return "";
}

}  // namespace slipstack::workbench
