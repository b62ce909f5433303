// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/comparison/comparison_file.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "workbench/base/errors.h"

namespace slipstack::workbench {
namespace {

constexpr const char* kSchema = "urn:slipstack:loop-compare-axis-1";

nlohmann::json json_of(const Measures& measures) {
  nlohmann::json object = nlohmann::json::object();
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    object[std::string(text_of(static_cast<Measure>(i)).key)] =
        std::isfinite(measures[i]) ? nlohmann::json(measures[i]) : nlohmann::json();
  }
  return object;
}

Measures measures_from(const nlohmann::json& object) {
  Measures measures{};
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const nlohmann::json& value = object.at(std::string(text_of(static_cast<Measure>(i)).key));
    measures[i] = value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
  }
  return measures;
}

}  // namespace

ComparisonFile::ComparisonFile(std::string path, std::string task)
    : path_(std::move(path)), task_(std::move(task)) {
  read();
  if (!std::ofstream(path_, std::ios::binary | std::ios::app))
    throw UsageError(path_ + ": cannot be written");
}

void ComparisonFile::read() {
  std::ifstream file(path_, std::ios::binary);
  if (!file) return;
  std::stringstream content;
  content << file.rdbuf();
  const std::string text = content.str();
  std::size_t begin = 0;
  int line = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', begin)) {
    const std::string place = fmt::format("{}:{}", path_, ++line);
    const auto one = nlohmann::json::parse(text.begin() + static_cast<std::ptrdiff_t>(begin),
                                           text.begin() + static_cast<std::ptrdiff_t>(end), nullptr, false);
    begin = end + 1;
    try {
      if (one.at("schema") != kSchema) throw InputError(place + ": not a line of a comparison");
      if (one.at("task") != task_) {
        throw UsageError(fmt::format("{}: it keeps another comparison ({}); give another file", place,
                                     one.at("task").get<std::string>()));
      }
      auto& axis = axes_[one.at("seed").get<std::uint64_t>()];
      for (const auto& [id, object] : one.at("contenders").items()) axis[id] = measures_from(object);
    } catch (const nlohmann::json::exception&) {
      throw InputError(place + ": not a line of a comparison; give another file for --keep");
    }
  }
  if (begin == text.size()) return;
  std::ofstream whole(path_, std::ios::binary | std::ios::trunc);
  whole << text.substr(0, begin);
}

std::optional<std::vector<Measures>> ComparisonFile::find(
    std::uint64_t seed, const std::vector<ContenderName>& contenders) const {
  const auto axis = axes_.find(seed);
  if (axis == axes_.end()) return std::nullopt;
  std::vector<Measures> found;
  for (const ContenderName& one : contenders) {
    const auto of = axis->second.find(one.id);
    if (of == axis->second.end()) return std::nullopt;
    found.push_back(of->second);
  }
  return found;
}

void ComparisonFile::add(std::uint64_t seed, const std::vector<ContenderName>& contenders,
                         const std::vector<Measures>& measures) {
  if (path_.empty()) return;
  nlohmann::json all = nlohmann::json::object();
  for (std::size_t i = 0; i < contenders.size(); ++i) {
    all[contenders[i].id] = json_of(measures[i]);
    axes_[seed][contenders[i].id] = measures[i];
  }
  const nlohmann::json line = {{"schema", kSchema}, {"task", task_}, {"seed", seed}, {"contenders", all}};
  std::ofstream file(path_, std::ios::binary | std::ios::app);
  file << line.dump() << '\n' << std::flush;
  if (!file) throw UsageError(path_ + ": cannot be written");
}

}  // namespace slipstack::workbench
