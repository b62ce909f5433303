// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/comparison/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/base/statistics.h"
#include "workbench/loop/axis_options.h"

namespace slipstack::workbench {
namespace {

constexpr double kTuningShare = 0.4;  // of the time, for progress

using Kind = ContenderName::Kind;
using Show = std::function<void(const std::string&, double)>;  // of one axis

double quantile_of(std::vector<double> values, double rank) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : quantile(values, rank);
}

/// Those that take longest begin first, so that no processor waits for one of them at the end.
std::vector<std::size_t> longest_first(const std::vector<Contender>& contenders) {
  std::vector<std::size_t> order(contenders.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return contenders[a].repetitions > contenders[b].repetitions;
  });
  return order;
}

std::vector<Measures> measured(const ComparisonTask& task, std::uint64_t seed, const Show& show) {
  sim::Axis axis = sim::draw_bench(task.setup, seed).axis;
  if (task.encoder_resolution_m > 0.0) axis.encoder_resolution_m = task.encoder_resolution_m;
  if (task.has_effects())
    axis = axis_with_effects(axis, effects_by_seed(task.effects, seed), task.strength, seed);
  const std::vector<Contender> contenders =
      tuned_contenders(axis, seed, task.field, [&](double done) { show("tune", kTuningShare * done); });
  const std::vector<sim::Axis> hidden =
      task.extent.robustness ? axes_with_hidden_effects(axis, seed) : std::vector<sim::Axis>{};
  std::vector<Measures> measures(contenders.size());
  std::atomic<std::size_t> done{0};
  const std::vector<std::size_t> order = longest_first(contenders);
  parallel_for(order.size(), [&](std::size_t i) {
    const std::size_t which = order[i];
    measures[which] = measures_of(contenders[which], axis, hidden, seed, task.extent);
    const double share = static_cast<double>(++done) / static_cast<double>(contenders.size());
    show("judge", kTuningShare + (1.0 - kTuningShare) * share);
  });
  return measures;
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

ComparedGoal ratio_goal(const Comparison& comparison, const std::string& text, Measure measure,
                        const ComparedContender& ours, const ComparedContender* other, double goal) {
  if (other == nullptr) return {text, "not measured", false};
  const double ratio = ours.median(measure) / other->median(measure);
  std::string found = fmt::format("{:.2f} of {}", ratio, other->name.title);
  if (const ComparedContender* bound = find(comparison, "bound"); bound != nullptr && ratio > goal) {
    const double least = bound->median(measure) / other->median(measure);
    found += fmt::format("; with the friction known {:.2f}", least);
    if (least > goal) found += ", so that no friction model reaches it";
  }
  return {text, found, ratio <= goal};
}

}  // namespace

double ComparedContender::value(Measure measure, double rank) const {
  std::vector<double> values;
  for (const Measures& one : by_seed) values.push_back(one[static_cast<std::size_t>(measure)]);
  return quantile_of(std::move(values), rank);
}

double ComparedContender::ratio(Measure measure, double rank, const ComparedContender& other) const {
  const auto i = static_cast<std::size_t>(measure);
  std::vector<double> values;
  for (std::size_t s = 0; s < by_seed.size(); ++s) values.push_back(by_seed[s][i] / other.by_seed[s][i]);
  return quantile_of(std::move(values), rank);
}

const ComparedContender* find(const Comparison& comparison, const std::string& id) {
  for (const ComparedContender& one : comparison.contenders) {
    if (one.name.id == id) return &one;
  }
  return nullptr;
}

Comparison compare(const ComparisonTask& task, ComparisonFile& kept,
                   const std::function<void(const std::string&, double)>& progress) {
  Comparison comparison;
  comparison.seeds = task.seeds;
  const std::vector<ContenderName> names = contenders_of(task.field);
  for (const ContenderName& name : names) comparison.contenders.push_back({name, {}});
  for (std::size_t s = 0; s < task.seeds; ++s) {
    const std::uint64_t seed = task.first_seed + s;
    auto measures = kept.find(seed, names);
    if (!measures) {
      measures = measured(task, seed, [&](const std::string& stage, double done) {
        progress(stage, (static_cast<double>(s) + done) / static_cast<double>(task.seeds));
      });
      kept.add(seed, names, *measures);
    }
    if (task.has_effects()) comparison.effects.push_back(names_of(effects_by_seed(task.effects, seed)));
    for (std::size_t i = 0; i < names.size(); ++i) comparison.contenders[i].by_seed.push_back((*measures)[i]);
  }
  return comparison;
}

std::vector<ComparedGoal> goals_of(const Comparison& comparison) {
  const ComparedContender* ours = find(comparison, "maxwell_slip_diagnosed");
  if (ours == nullptr) ours = find(comparison, "maxwell_slip");
  const ComparedContender* plain = find(comparison, "p_pi");
  if (ours == nullptr || plain == nullptr) return {};
  std::vector<ComparedGoal> goals;
  goals.push_back(ratio_goal(comparison, "peak at reversals, at most 0.1 of mass feed-forward",
                             Measure::kReversalPeak, *ours, find(comparison, "mass"), 0.1));
  const auto peer = [](const ComparedContender& one) { return one.is(Kind::kPeer); };
  goals.push_back(
      ratio_goal(comparison, "peak at reversals, at most 0.5 of the best that learns no trajectory",
                 Measure::kReversalPeak, *ours, best(comparison, Measure::kReversalPeak, peer), 0.5));
  goals.push_back(ratio_goal(comparison, "settling to 1 um after 100 mm, at most 0.7 of the velocity table",
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
    const auto* ours = best(comparison, measure, [](const auto& one) { return one.is(Kind::kOurs); });
    const auto* other = best(comparison, measure,
                             [](const auto& one) { return one.is(Kind::kPeer) || one.is(Kind::kLearner); });
    if (ours == nullptr || other == nullptr) continue;
    const double mine = ours->median(measure);
    const double theirs = other->median(measure);
    if (!(theirs < mine)) continue;
    const MeasureText& text = text_of(measure);
    sentences.push_back(fmt::format("{}: {} wins, {:.3g} against {:.3g} {}: {}.", text.what,
                                    other->name.title, theirs * text.scale, mine * text.scale, text.unit,
                                    other->name.strength));
  }
  return sentences;
}

}  // namespace slipstack::workbench
