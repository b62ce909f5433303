// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

// The sections of the report in the order of the page. Each returns HTML, or "" if the data has nothing for
// it.
namespace slipstack::workbench {

/// Counts the figures in the order of their appearance.
class FigureNumbers {
 public:
  int next() { return ++last_; }

 private:
  int last_ = 0;
};

/// Name of the log and of the axis: mass, pitch, encoder, length of the record.
std::string masthead_html(const nlohmann::json& data);

/// The headline, the key figures, and beside them the falling error as a waterfall.
std::string verdict_html(const nlohmann::json& data, FigureNumbers& figures);

/// Evidence, usual cause, confirming experiment and ties of the first candidate, or what is left
/// unexplained.
std::string reasons_html(const nlohmann::json& data);

/// All candidates, best first as given, with their error reduction as a bar with its standard error.
std::string ranking_html(const nlohmann::json& data);

/// Frames for the charts that report.js draws: `data-chart` names the kind, `data-index` the element.
std::string charts_html(const nlohmann::json& data, FigureNumbers& figures);

/// Every parameter of the model with its standard error, grouped by effect.
std::string parameters_html(const nlohmann::json& data);

/// Charts and tables of an experiment (`charts`, `tables`).
std::string experiment_charts_html(const nlohmann::json& data, FigureNumbers& figures);
std::string experiment_tables_html(const nlohmann::json& data);

/// Baseline, command, notes: what somebody needs to get the same report again.
std::string method_html(const nlohmann::json& data);

/// An id such as `a_b` → its title where the data gives one, else "A b". Not escaped.
std::string effect_title(const nlohmann::json& data, const std::string& id);

/// A title as it reads inside a sentence: "Force ripple" → "force ripple"; "GMS slip" stays.
std::string in_sentence(std::string title);

/// `error_reduction` is a share of the baseline's held-out error: 0.894 → "89.4 %".
std::string percent(double share);

/// The change of the information criterion under `criterion_difference`, with its sign; "" without one.
std::string criterion_text(const nlohmann::json& data);

/// What that change means (`criterion_note`), below what shows it; "" without one.
std::string criterion_note_html(const nlohmann::json& data);

/// The waterfall of `steps` (or of before and after, if there are no steps), with the noise floor; "" without
/// two numbers.
std::string waterfall_html(const nlohmann::json& data, FigureNumbers& figures);

}  // namespace slipstack::workbench
