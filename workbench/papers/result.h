// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

namespace slipstack::workbench {

/// One column of an experiment's table: the same definition makes the text, the JSON and the report.
struct TableColumn {
  std::string key;      ///< in JSON, with the SI unit: "amplitude_m"
  std::string heading;  ///< for people: "amplitude"
  std::string unit;     ///< for people: "µm"; may be empty
  double per_si = 1.0;  ///< shown value = SI value × per_si
  int digits = 4;       ///< significant ones; 0: a whole number
  /// The report's cells are shaded by their logarithm, from none here (SI) …
  double pale_at = 0.0;
  double dark_at = 0.0;  ///< … to dark here; both 0: not at all
};

/// A number in SI units (not finite: no value) or a word.
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

/// What an experiment hands out.
struct ExperimentResult {
  std::string experiment;                             ///< "stepped-sine"
  std::string setup;                                  ///< title of the set-up or the data
  std::string headline;                               ///< the finding, one sentence
  std::string detail;                                 ///< what it means, may be empty
  nlohmann::json summary = nlohmann::json::object();  ///< figures for machines, SI
  std::vector<ExperimentTable> tables;
  std::vector<ExperimentChart> charts;
  std::vector<std::string> notes;
  std::string command = "";  ///< where it is not "experiment <experiment>"
  std::string file = "";     ///< what --out holds
};

/// Headline and aligned tables for a terminal.
std::string result_text(const ExperimentResult& result);

/// {"experiment", "setup", "headline", "summary": {…}, "<table key>": [{"<column key>": SI value}]}; what is
/// not finite is null.
nlohmann::json result_json(const ExperimentResult& result);

/// What render_report() (workbench/report/html.h) shows of it.
nlohmann::json result_report(const ExperimentResult& result, const std::string& command_line);

}  // namespace slipstack::workbench
