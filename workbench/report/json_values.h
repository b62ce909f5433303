// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

// What all results have in common as JSON.
namespace slipstack::workbench {

/// A finite number, or null.
nlohmann::json number_json(double value);

/// The number that number_json() made; not a number for null.
double number_of(const nlohmann::json& value);

/// The text of a JSON file: indented, one trailing newline; names that are not UTF-8 are made so.
std::string json_text(const nlohmann::json& value);

/// The same for a file that only this program reads again: the names of a linear axis whatever the axis is,
/// as all of the program has them.
std::string own_json_text(const nlohmann::json& value);

/// The same for machines: with the URN of its schema as `schema`, as "urn:slipstack:fit-1", the $id of
/// docs/schema/fit-1.json. The number rises when a key goes, or means something else.
std::string published_text(nlohmann::json value, const std::string& schema);

/// The head of the data of every report.
nlohmann::json report_base(const std::string& command_line, const std::string& log,
                           const std::string& command);

/// A table of the report. `columns`: the heading, and whether the column holds numbers.
nlohmann::json table_json(const char* title, const std::vector<std::pair<std::string, bool>>& columns,
                          nlohmann::json rows);

}  // namespace slipstack::workbench
