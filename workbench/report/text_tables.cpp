// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/text_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/quantity.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

/// Candidates below this are not worth a line.
constexpr double kLeastLineShare = 0.005;
constexpr std::size_t kMostLines = 10;

/// Digits that a value deserves: down to the second digit of its standard error, three where there is none.
int digits_known(double value, double error) {
  if (error <= 0.0 || value == 0.0) return 3;
  const double ratio = std::log10(std::abs(value)) - std::floor(std::log10(error));
  return std::clamp(static_cast<int>(std::floor(ratio)) + 2, 3, 8);
}

/// " (log 2)" where each log has its own gains.
std::string of_log(const Term& term, std::size_t gain) {
  return term.gain_sets() > 1 ? fmt::format(" (log {})", gain / term.gains_per_set() + 1) : "";
}

}  // namespace

std::string parameter_table(const Terms& terms) {
  std::string text =
      fmt::format("\n{:<32} {:<24} {:>14} {:>14}\n", "effect", "parameter", "value", "std. error");
  for (const Term& term : terms) {
    const bool elements = term.id() == "presliding_hysteresis";
    const std::size_t count = term.gains_per_set();
    if (elements) {
      for (std::size_t set = 0; set < term.gain_sets(); ++set) {
        std::size_t used = 0;
        double level_N = 0.0;
        for (std::size_t i = 0; i < count; ++i) {
          const double stiffness = term.gains[set * count + i];
          used += stiffness > 0.0 ? 1 : 0;
          level_N += stiffness * term.shapes[i];
        }
        text += fmt::format("{:<32} {:<24} {:>14}\n", term.id(),
                            fmt::format("level of {} elements{}", used, of_log(term, set * count)),
                            quantity(level_N, "N"));
      }
      continue;
    }
    for (std::size_t i = 0; i < term.shapes.size(); ++i) {
      const ShapeSpec& shape = term.effect->shapes[i];
      const double error = term.shape_standard_error(i);
      text += fmt::format("{:<32} {:<24} {:>14} {:>14}\n", term.id(), shape.name,
                          shape_value(shape, term.shapes[i], digits_known(term.shapes[i], error)),
                          error > 0.0 ? shape_value(shape, error) : "set");
    }
    for (std::size_t g = 0; g < term.gains.size(); ++g) {
      const GainGroup& group = term.effect->group_of_gain(static_cast<int>(g % count));
      const std::string name =
          (group.count > 1 ? fmt::format("{} {}", group.name, g % count + 1) : group.name) + of_log(term, g);
      const bool given = term.lower[g] == term.upper[g];
      const double error = term.gain_standard_error(g);
      text += fmt::format("{:<32} {:<24} {:>14} {:>14}\n", term.id(), name,
                          quantity(term.gains[g], group.unit, digits_known(term.gains[g], error)),
                          given         ? "given"
                          : error > 0.0 ? quantity(error, group.unit)
                                        : "at its bound");
    }
  }
  return text;
}

std::string candidate_table(const Diagnosis& diagnosis) {
  std::string text = fmt::format("\n{:<32} {:>14} {:>9} {:>9}  {}\n", "effect added to the baseline",
                                 "held-out error", "reduction", "std. err.", "not told apart from");
  std::size_t lines = 0;
  for (const Candidate& candidate : diagnosis.candidates) {
    if (candidate.error_reduction < kLeastLineShare || lines == kMostLines) continue;
    ++lines;
    text += fmt::format("{:<32} {:>14} {:>7.1f} % {:>7.1f} %{}{}\n", candidate.term.id(),
                        quantity(candidate.holdout_rmse_N, "N"), 100.0 * candidate.error_reduction,
                        100.0 * candidate.error_reduction_se, candidate.confounded_with.empty() ? "" : "  ",
                        fmt::join(candidate.confounded_with, ", "));
  }
  if (lines == 0) {
    return fmt::format("\nnone of the {} effects tried reduces the error by 0.5 %\n",
                       diagnosis.candidates.size());
  }
  const std::size_t others = diagnosis.candidates.size() - lines;
  const bool by_error = std::ranges::is_sorted(diagnosis.candidates, {}, &Candidate::holdout_rmse_N);
  if (!by_error) text += "first those that explain the log together; each with the error it leaves alone\n";
  if (others > 0) text += fmt::format("{} others reduce the error by less than 0.5 %\n", others);
  return text;
}

std::string log_table(const std::vector<LogResult>& logs) {
  if (logs.size() < 2) return "";
  const bool held_out = logs.front().holdout_rmse_N > 0.0;
  std::string text = fmt::format("\n{:<32} {:>9} {:>14} {:>14} {:>9}\n", "log", "samples",
                                 held_out ? "held-out error" : "error", "noise floor", "of force");
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const LogResult& one = logs[i];
    text +=
        fmt::format("{:<32} {:>9} {:>14} {:>14} {:>9}\n", fmt::format("{} {}", i + 1, printable(one.path)),
                    one.samples, newtons(held_out ? one.holdout_rmse_N : one.rmse_N),
                    newtons(one.noise_floor_N), share(one.relative_error));
  }
  return text;
}

std::string step_table(const Diagnosis& diagnosis) {
  std::string text = fmt::format("\n{:<32} {:>14}\n", "step", "held-out error");
  for (const Step& step : diagnosis.steps) {
    text += fmt::format("{:<32} {:>14}{}{}\n", step.effect, quantity(step.holdout_rmse_N, "N"),
                        step.evidence.empty() ? "" : "  ", step.evidence);
  }
  text += fmt::format("{:<32} {:>14}\n", "noise floor", quantity(diagnosis.noise_floor_N, "N"));
  return text;
}

std::string advice(const Candidate& candidate) {
  return fmt::format("\nusual cause   {}\nconfirm with  {}\n", candidate.term.effect->text.cause,
                     candidate.term.effect->text.confirm);
}

}  // namespace slipstack::workbench
