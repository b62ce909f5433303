// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/unit_sums.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/model/effect_adapters/user_effect.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

json terms_json(const Terms& terms) {
  json list = json::array();
  for (const Term& term : terms) {
    list.push_back({{"effect", term.id()},
                    {"definition", term.effect->definition},
                    {"shapes", term.shapes},
                    {"gains", term.gains},
                    {"lower", term.lower},
                    {"upper", term.upper}});
  }
  return list;
}

Terms terms_of(const json& list) {
  Terms terms;
  for (const json& one : list) {
    Term term;
    const auto definition = one.at("definition").get<std::string>();
    term.effect =
        definition.empty() ? find_effect(one.at("effect").get<std::string>()) : &declare_effect(definition);
    term.shapes = one.at("shapes").get<std::vector<double>>();
    term.gains = one.at("gains").get<std::vector<double>>();
    term.lower = one.at("lower").get<std::vector<double>>();
    term.upper = one.at("upper").get<std::vector<double>>();
    terms.push_back(std::move(term));
  }
  return terms;
}

/// Block by block.
json equations_json(const NormalEquations& equations) {
  json blocks = json::array();
  for (int b = 0; b < equations.block_count(); ++b) blocks.push_back(equations.numbers_of(b));
  return blocks;
}

NormalEquations equations_of(const json& blocks, Eigen::Index unknowns) {
  NormalEquations equations(unknowns, static_cast<int>(blocks.size()), kFolds);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    equations.add(blocks[b].get<std::vector<double>>(), static_cast<int>(b));
  }
  equations.sum_up();
  return equations;
}

json unit_json(const UnitSums& one) {
  json entry{{"log", one.log},
             {"block", one.first_block},
             {"equations", json::array()},
             {"reached",
              {one.reached.low_m, one.reached.high_m, one.reached.velocity_mps, one.reached.acceleration_mps2,
               one.reached.jerk_mps3, one.reached.force_N}},
             {"squares", json::array()},
             {"windows", json::array()}};
  for (const NormalEquations& equations : one.equations) {
    entry["equations"].push_back(equations_json(equations));
  }
  for (const Squares& squares : one.squares) {
    entry["squares"].push_back(
        {squares.residual, squares.measured, squares.weighted_residual, squares.weight});
  }
  for (const Window& window : one.windows) {
    entry["windows"].push_back({window.log, window.index, window.squares, window.weight});
  }
  return entry;
}

UnitSums unit_of(const json& entry, const std::vector<Terms>& models) {
  UnitSums one;
  one.log = entry["log"].get<std::size_t>();
  one.first_block = entry["block"].get<int>();
  for (std::size_t m = 0; m < models.size(); ++m) {
    one.equations.push_back(equations_of(entry["equations"][m], unknown_count(models[m])));
  }
  const json& reached = entry["reached"];
  one.reached = {reached[0].get<double>(), reached[1].get<double>(), reached[2].get<double>(),
                 reached[3].get<double>(), reached[4].get<double>(), reached[5].get<double>()};
  for (const json& squares : entry["squares"]) {
    one.squares.push_back({squares[0].get<double>(), squares[1].get<double>(), squares[2].get<double>(),
                           squares[3].get<double>()});
  }
  for (const json& window : entry["windows"]) {
    one.windows.push_back({window[0].get<std::size_t>(), window[1].get<std::size_t>(),
                           window[2].get<double>(), window[3].get<double>()});
  }
  return one;
}

}  // namespace

void Squares::add(const Squares& other) {
  residual += other.residual;
  measured += other.measured;
  weighted_residual += other.weighted_residual;
  weight += other.weight;
}

double Squares::relative() const {
  return std::sqrt(residual / std::max(measured, 1e-300));
}

double Squares::rmse_N() const {
  return std::sqrt(weighted_residual / std::max(weight, 1e-300));
}

double Window::rmse_N() const {
  return std::sqrt(squares / weight);
}

json to_json(const SumTask& task) {
  json message{{"full", task.full}, {"limit_N", task.limit_N}, {"models", json::array()}};
  for (const Terms& model : task.models) message["models"].push_back(terms_json(model));
  return message;
}

SumTask task_of(const json& message) {
  SumTask task;
  task.full = message.at("full").get<std::size_t>();
  task.limit_N = message.at("limit_N").get<double>();
  task.models.reserve(message.at("models").size());
  for (const json& model : message.at("models")) task.models.push_back(terms_of(model));
  return task;
}

json to_json(const std::vector<UnitSums>& sums) {
  json list = json::array();
  for (const UnitSums& one : sums) list.push_back(unit_json(one));
  return list;
}

std::vector<UnitSums> sums_of(const json& message, const std::vector<Terms>& models) {
  std::vector<UnitSums> all;
  all.reserve(message.size());
  for (const json& entry : message) all.push_back(unit_of(entry, models));
  return all;
}

}  // namespace slipstack::workbench
