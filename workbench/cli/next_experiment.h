// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "workbench/cli/commands.h"
#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

/// The experiment that would answer what a diagnosis leaves open.
struct NextExperiment {
  std::vector<std::string> effects;
  std::string why;      ///< one sentence
  std::string command;  ///< `slipstack experiment plan ...`, as it is typed
};

/// Telling the first candidate from what this log cannot separate it from; else effects that the log cannot
/// show; else confirming the first. Nothing where no effect comes into question.
/// `by_title`: effects are called by their titles in `why`, as on a page; else by their ids.
std::optional<NextExperiment> next_experiment(const Options& options, const Diagnosis& diagnosis,
                                              bool by_title = false);

/// What the log cannot show, cannot separate, and the next experiment: into the result for machines, ...
void add_limits(nlohmann::json& result, const Options& options, const Diagnosis& diagnosis);
/// ... as lines for people ...
std::string limits_text(const Options& options, const Diagnosis& diagnosis);
/// ... and into the report.
void add_limits_report(nlohmann::json& report, const Options& options, const Diagnosis& diagnosis);

}  // namespace slipstack::workbench
