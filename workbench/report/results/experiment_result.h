// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <variant>
#include <vector>

#include "workbench/report/html/format.h"

namespace slipstack::workbench {

/// One column of an experiment's table: the same definition makes the text, the JSON and the report.
struct TableColumn {
  std::string key;      ///< in JSON, with the SI unit: "amplitude_m"
  std::string heading;  ///< in text and report: "amplitude"
  std::string unit;     ///< in text and report: "µm"; may be empty
  double per_si = 1.0;  ///< shown value = SI value × per_si
  int digits = 4;       ///< significant ones; 0: a whole number
  /// The report's cells are shaded by their logarithm, from none here (SI) …
  double pale_at = 0.0;
  double dark_at = 0.0;  ///< … to dark here; both 0: not at all
};

/// A number in SI units (not finite: no value) or a text.
using Cell = std::variant<double, std::string>;

struct ExperimentTable {
  std::string key;  ///< in JSON: "points"
  std::string title;
  std::vector<TableColumn> columns;
  std::vector<std::vector<Cell>> rows;
};

/// One axis of a chart. Values are given in SI units; the page shows value × per_si.
struct ChartAxis {
  std::string name;  ///< "Frequency"
  std::string unit;  ///< "Hz"
  double per_si = 1.0;
  bool log = false;
};

struct ChartCurve {
  std::string name;
  std::vector<double> y;  ///< not finite: a gap
  std::vector<double> x;  ///< empty: the chart's x (always given in an orbit)
  /// A line style of workbench/web/plots.js ("measured", "reference", palette_role()); empty: the next of the
  /// palette.
  std::string role = "";
  bool dashed = false;
};

/// The role of the palette's colour for curve `index`, from 0; it repeats after eight.
std::string palette_role(std::size_t index);

/// Curves of one name belong together: one entry in the key line shows and hides them.
/// A chart over one rising x, or an orbit: curves with an x of their own, drawn in their order, linear axes.
struct ExperimentChart {
  std::string title;
  ChartAxis x_axis;
  ChartAxis y_axis;
  std::vector<double> x;
  std::vector<ChartCurve> curves;
  bool orbit = false;
};

/// A figure of an experiment for machines, in SI units: a number (not finite: null in JSON), a count, a text,
/// a list of texts, or figures under one name.
struct SummaryEntry {
  std::string key;
  std::variant<double, std::size_t, std::string, std::vector<std::string>, std::vector<SummaryEntry>> value;
};

/// The result of an experiment, from which text, JSON and report are made.
struct ExperimentResult {
  std::string experiment;  ///< "stepped-sine"
  std::string setup;       ///< title of the set-up or the data
  std::string headline;    ///< the finding in one sentence
  std::string detail;      ///< its meaning; may be empty
  std::vector<SummaryEntry> summary;
  std::vector<ExperimentTable> tables;
  std::vector<ExperimentChart> charts;
  std::vector<std::string> notes;
  std::string command = "";  ///< where it is not "experiment <experiment>"
  std::string file = "";     ///< content of the file that --out names
};

/// The unit of a column or an axis of lengths as large as `magnitude_m`. Unlike those of a machine, the
/// lengths of pre-rolling are read in µm down to a tenth, as [2] prints them.
DisplayUnit length_unit(double magnitude_m);

/// A measured or simulated motion over the time in ms.
ExperimentChart motion_chart(const std::string& title, const std::vector<double>& time_s,
                             const std::vector<double>& position_m, const DisplayUnit& unit);

/// Headline and aligned tables for a terminal.
std::string result_text(const ExperimentResult& result);

/// The schema of what result_json() makes, for published_text().
inline constexpr const char* kExperimentSchema = "experiment-1";

/// {"experiment", "setup", "headline", "summary": {…}, "<table key>": [{"<column key>": SI value}]}; what is
/// not finite is null.
nlohmann::json result_json(const ExperimentResult& result);

/// The page that render_report() (workbench/report/html/report_page.h) makes of it.
nlohmann::json result_report(const ExperimentResult& result, const std::string& command_line);

}  // namespace slipstack::workbench
