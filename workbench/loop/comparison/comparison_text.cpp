// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>

#include "workbench/loop/comparison/comparison.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kNameWidth = 36;

/// A value by the share (0 to 1) of the seeds that are below it.
using ByRank = std::function<double(double)>;

std::string cell_of(const ByRank& value, bool spread) {
  if (!std::isfinite(value(0.5))) return "-";
  const auto number = [](double of) {
    return of != 0.0 && std::fabs(of) < 0.0995 ? fmt::format("{:.2g}", of)
           : std::fabs(of) < 99.5              ? fmt::format("{:.3g}", of)
                                               : fmt::format("{:.0f}", of);
  };
  if (!spread) return number(value(0.5));
  return fmt::format("{} ({}..{})", number(value(0.5)), number(value(0.0)), number(value(1.0)));
}

std::string heading_of(const MeasureText& words, bool ratio) {
  if (ratio || words.unit.empty()) return std::string(words.heading);
  return fmt::format("{} {}", words.heading, words.unit);
}
std::size_t width_of(const MeasureText& words, std::size_t least) {
  return std::max(least, heading_of(words, false).size() + 2);
}

/// `over`: as ratios to this contender; nullptr: as they are.
std::string table_of(const Comparison& comparison, const std::string& title,
                     std::span<const Measure> measures, const ComparedContender* over = nullptr) {
  const bool spread = comparison.seeds > 1;
  const std::size_t width = spread ? 22 : 10;
  std::string text = fmt::format("{:<{}}", title, kNameWidth);
  for (const Measure measure : measures) {
    const MeasureText& words = text_of(measure);
    text += fmt::format("{:>{}}", heading_of(words, over != nullptr), width_of(words, width));
  }
  text += "\n";
  bool any = false;
  for (const ComparedContender& one : comparison.contenders) {
    if (over != nullptr && one.is(ContenderName::Kind::kBound)) continue;
    std::string row = fmt::format("  {:<{}}", one.name.title, kNameWidth - 2);
    for (const Measure measure : measures) {
      const MeasureText& words = text_of(measure);
      const auto value = [&](double rank) {
        return over != nullptr ? one.ratio(measure, rank, *over) : one.value(measure, rank) * words.scale;
      };
      any = any || std::isfinite(value(0.5));
      row += fmt::format("{:>{}}", cell_of(value, spread), width_of(words, width));
    }
    text += row + "\n";
  }
  return any ? text + "\n" : "";
}

}  // namespace

std::string comparison_text(const Comparison& comparison) {
  using M = Measure;
  std::string text = fmt::format(
      "The same axis, motion, feedback, encoder and noise; tuned on one motion, judged on another; {} "
      "seed{}.\n"
      "{}\n",
      comparison.seeds, comparison.seeds == 1 ? "" : "s",
      comparison.seeds > 1 ? "Medians, and in brackets the least and the most of the seeds.\n" : "");
  if (!comparison.effects.empty()) {
    text += fmt::format("Beside mass and hysteresis, in the training too: {}.\n\n",
                        fmt::join(comparison.effects, "; "));
  }
  constexpr std::array kTracking{M::kRms, M::kPeak, M::kReversalRms, M::kReversalPeak, M::kEffort};
  text += table_of(comparison, "Tracking error", kTracking);
  constexpr std::array kSettling{M::kSettle10um, M::kSettle1mm, M::kSettle100mm};
  text += table_of(comparison, "Settling to 1 um after a move", kSettling);
  constexpr std::array kByCount{M::kSettle10umByCount, M::kSettle1mmByCount, M::kSettle100mmByCount};
  text += table_of(comparison, "Settling to 1 count after a move", kByCount);
  constexpr std::array kCircles{M::kCircleSmall, M::kCircleMiddle, M::kCircleLarge, M::kJitter, M::kNoise};
  text += table_of(comparison, "Circles of two axes; at rest", kCircles);
  constexpr std::array kRobust{M::kWrong, M::kHiddenMedian, M::kHiddenWorst, M::kWarm, M::kPlace};
  text += table_of(comparison, "Reversals when the axis differs", kRobust);
  if (const ComparedContender* bound = find(comparison, "bound"); bound != nullptr) {
    constexpr std::array kOver{M::kRms, M::kReversalRms, M::kReversalPeak, M::kCircleMiddle, M::kPlace};
    text += table_of(comparison, "Over that with the friction known", kOver, bound);
  }
  for (const ComparedGoal& goal : goals_of(comparison))
    text += fmt::format("{} {}: {}\n", goal.met ? "met    " : "not met", goal.text, goal.found);
  const std::vector<std::string> lost = lost_cells(comparison);
  if (!lost.empty()) text += "\nWhere another is better than each form of slipstack:\n";
  for (const std::string& sentence : lost) text += "- " + sentence + "\n";
  return text;
}

nlohmann::json comparison_json(const Comparison& comparison) {
  nlohmann::json contenders = nlohmann::json::array();
  for (const ComparedContender& one : comparison.contenders) {
    nlohmann::json measures = nlohmann::json::object();
    for (std::size_t i = 0; i < kMeasureCount; ++i) {
      nlohmann::json by_seed = nlohmann::json::array();
      for (const Measures& of_seed : one.by_seed)
        by_seed.push_back(std::isfinite(of_seed[i]) ? nlohmann::json(of_seed[i]) : nlohmann::json());
      measures[std::string(text_of(static_cast<Measure>(i)).key)] = by_seed;
    }
    contenders.push_back({{"id", one.name.id},
                          {"title", one.name.title},
                          {"slipstack", one.is(ContenderName::Kind::kOurs)},
                          {"learns_trajectory", one.is(ContenderName::Kind::kLearner)},
                          {"bound", one.is(ContenderName::Kind::kBound)},
                          {"by_seed", measures}});
  }
  nlohmann::json goals = nlohmann::json::array();
  for (const ComparedGoal& goal : goals_of(comparison))
    goals.push_back({{"goal", goal.text}, {"found", goal.found}, {"met", goal.met}});
  return {{"schema", "urn:slipstack:loop-compare-1"},
          {"seeds", comparison.seeds},
          {"effects", comparison.effects},
          {"contenders", contenders},
          {"goals", goals},
          {"where_another_is_better", lost_cells(comparison)}};
}

}  // namespace slipstack::workbench
