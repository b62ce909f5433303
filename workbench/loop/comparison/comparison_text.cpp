// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "workbench/loop/comparison/comparison.h"

namespace slipstack::workbench {
namespace {

constexpr double kLowest = 0.1;  // of the seeds, and 0.9: the spread
constexpr std::size_t kNameWidth = 34;

std::string cell_of(const ComparedContender& one, Measure measure, bool spread) {
  const double scale = text_of(measure).scale;
  const double middle = one.median(measure) * scale;
  if (!std::isfinite(middle)) return "-";
  const auto number = [](double value) {
    return value != 0.0 && std::fabs(value) < 0.0995 ? fmt::format("{:.2g}", value)
           : std::fabs(value) < 99.5                 ? fmt::format("{:.3g}", value)
                                                     : fmt::format("{:.0f}", value);
  };
  if (!spread) return number(middle);
  return fmt::format("{} ({}..{})", number(middle), number(one.value(measure, kLowest) * scale),
                     number(one.value(measure, 1.0 - kLowest) * scale));
}

std::string table_of(const Comparison& comparison, const std::string& title,
                     std::span<const Measure> measures) {
  const bool spread = comparison.seeds > 1;
  const std::size_t width = spread ? 22 : 10;
  std::string text = fmt::format("{:<{}}", title, kNameWidth);
  for (const Measure measure : measures) {
    const MeasureText& words = text_of(measure);
    const std::string heading =
        words.unit.empty() ? std::string(words.heading) : fmt::format("{} {}", words.heading, words.unit);
    text += fmt::format("{:>{}}", heading, std::max(width, heading.size() + 2));
  }
  text += "\n";
  bool any = false;
  for (const ComparedContender& one : comparison.contenders) {
    std::string row = fmt::format("  {:<{}}", one.title, kNameWidth - 2);
    for (const Measure measure : measures) {
      const MeasureText& words = text_of(measure);
      const std::size_t heading = words.heading.size() + (words.unit.empty() ? 0 : 1 + words.unit.size()) + 2;
      any = any || std::isfinite(one.median(measure));
      row += fmt::format("{:>{}}", cell_of(one, measure, spread), std::max(width, heading));
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
      comparison.seeds > 1 ? "Medians, and in brackets 10 % to 90 % of the seeds.\n" : "");
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
    contenders.push_back({{"id", one.id},
                          {"title", one.title},
                          {"slipstack", one.ours},
                          {"learns_trajectory", one.learns_trajectory},
                          {"by_seed", measures}});
  }
  nlohmann::json goals = nlohmann::json::array();
  for (const ComparedGoal& goal : goals_of(comparison))
    goals.push_back({{"goal", goal.text}, {"found", goal.found}, {"met", goal.met}});
  return {{"schema", "urn:slipstack:loop-compare-1"},
          {"seeds", comparison.seeds},
          {"contenders", contenders},
          {"goals", goals},
          {"where_another_is_better", lost_cells(comparison)}};
}

}  // namespace slipstack::workbench
