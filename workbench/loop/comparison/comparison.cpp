// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/comparison/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "workbench/base/parallel.h"
#include "workbench/base/statistics.h"

namespace slipstack::workbench {
namespace {

constexpr double kTuningShare = 0.4;  // of the time, for progress

const ComparedContender* find(const Comparison& comparison, const std::string& id) {
  for (const ComparedContender& one : comparison.contenders) {
    if (one.id == id) return &one;
  }
  return nullptr;
}

/// The one with the least median among those that `fits` admits; nullptr without one.
template <class Fits>
const ComparedContender* best(const Comparison& comparison, Measure measure, Fits&& fits) {
  const ComparedContender* found = nullptr;
  for (const ComparedContender& one : comparison.contenders) {
    const double value = one.median(measure);
    if (!fits(one) || !std::isfinite(value)) continue;
    if (found == nullptr || value < found->median(measure)) found = &one;
  }
  return found;
}

ComparedGoal ratio_goal(const std::string& text, Measure measure, const ComparedContender& ours,
                        const ComparedContender* other, double goal) {
  if (other == nullptr) return {text, "not measured", false};
  const double ratio = ours.median(measure) / other->median(measure);
  return {text, fmt::format("{:.2f} of {}", ratio, other->title), ratio <= goal};
}

}  // namespace

double ComparedContender::value(Measure measure, double rank) const {
  std::vector<double> values;
  for (const Measures& one : by_seed) {
    const double value = one[static_cast<std::size_t>(measure)];
    if (std::isfinite(value)) values.push_back(value);
  }
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : quantile(values, rank);
}

Comparison compare(sim::Setup setup, std::uint64_t first_seed, std::size_t seeds, Field field,
                   const Extent& extent, const std::function<void(const std::string&, double)>& progress) {
  Comparison comparison;
  comparison.seeds = seeds;
  for (std::size_t s = 0; s < seeds; ++s) {
    const std::uint64_t seed = first_seed + s;
    const sim::Axis axis = sim::draw_bench(setup, seed).axis;
    const auto show = [&](const std::string& stage, double begin, double share, double done) {
      progress(stage, (static_cast<double>(s) + begin + share * done) / static_cast<double>(seeds));
    };
    const std::vector<Contender> contenders =
        tuned_contenders(axis, seed, field, [&](double done) { show("tune", 0.0, kTuningShare, done); });
    const std::vector<sim::Axis> hidden =
        extent.robustness ? axes_with_hidden_effects(axis, seed) : std::vector<sim::Axis>{};
    std::vector<Measures> measures(contenders.size());
    std::atomic<std::size_t> done{0};
    parallel_for(contenders.size(), [&](std::size_t i) {
      measures[i] = measures_of(contenders[i], axis, hidden, seed, extent);
      show("judge", kTuningShare, 1.0 - kTuningShare,
           static_cast<double>(++done) / static_cast<double>(contenders.size()));
    });
    for (std::size_t i = 0; i < contenders.size(); ++i) {
      const Contender& one = contenders[i];
      if (s == 0) {
        comparison.contenders.push_back(
            {one.id, one.title, one.strength, one.ours, one.learns_trajectory(), {}});
      }
      comparison.contenders[i].by_seed.push_back(measures[i]);
    }
  }
  return comparison;
}

std::vector<ComparedGoal> goals_of(const Comparison& comparison) {
  const ComparedContender* ours = find(comparison, "maxwell_slip");
  const ComparedContender* plain = find(comparison, "p_pi");
  if (ours == nullptr || plain == nullptr) return {};
  std::vector<ComparedGoal> goals;
  goals.push_back(ratio_goal("peak at reversals, at most 0.1 of mass feed-forward", Measure::kReversalPeak,
                             *ours, find(comparison, "mass"), 0.1));
  const auto peer = [](const ComparedContender& one) { return !one.ours && !one.learns_trajectory; };
  goals.push_back(ratio_goal("peak at reversals, at most 0.5 of the best that learns no trajectory",
                             Measure::kReversalPeak, *ours, best(comparison, Measure::kReversalPeak, peer),
                             0.5));
  goals.push_back(ratio_goal("settling to 1 um after 100 mm, at most 0.7 of the velocity table",
                             Measure::kSettle100mm, *ours, find(comparison, "velocity-table"), 0.7));
  std::size_t worse = 0;
  std::size_t known = 0;
  for (std::size_t i = 0; i < ours->by_seed.size(); ++i) {
    constexpr auto kWrong = static_cast<std::size_t>(Measure::kWrong);
    if (!std::isfinite(ours->by_seed[i][kWrong])) continue;
    ++known;
    // Against P/PI as it is, which is less than with its own mass wrong.
    constexpr auto kRight = static_cast<std::size_t>(Measure::kReversalRms);
    if (ours->by_seed[i][kWrong] > plain->by_seed[i][kRight]) ++worse;
  }
  if (known > 0) {
    goals.push_back({"never worse than P/PI alone with a parameter wrong by 30 %",
                     fmt::format("worse in {} of {}", worse, known), worse == 0});
  }
  return goals;
}

std::vector<std::string> lost_cells(const Comparison& comparison) {
  std::vector<std::string> sentences;
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const auto measure = static_cast<Measure>(i);
    const auto* ours = best(comparison, measure, [](const auto& one) { return one.ours; });
    const auto* other = best(comparison, measure, [](const auto& one) { return !one.ours; });
    if (ours == nullptr || other == nullptr) continue;
    const double mine = ours->median(measure);
    const double theirs = other->median(measure);
    if (!(theirs < mine)) continue;
    const MeasureText& text = text_of(measure);
    sentences.push_back(fmt::format("{}: {} wins, {:.3g} against {:.3g} {}: {}.", text.what, other->title,
                                    theirs * text.scale, mine * text.scale, text.unit, other->strength));
  }
  return sentences;
}

}  // namespace slipstack::workbench
