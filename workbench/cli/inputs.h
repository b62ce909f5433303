// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "workbench/cli/commands.h"
#include "workbench/cli/output.h"
#include "workbench/cli/progress.h"
#include "workbench/diagnose/team_logs.h"
#include "workbench/diagnose/whole_logs.h"
#include "workbench/identify/fit.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {

// What the commands make of their arguments. All of these throw UsageError or InputError.

/// Effects of the model that is there before anything is known.
inline constexpr const char* kDefaultBaseline = "inertia,presliding_hysteresis";

/// The effect of the catalogue, or declared, of this id.
const EffectDescription& effect_named(std::string_view id);

/// Ids of a comma-separated list, of the catalogue or declared, each known and named once.
std::vector<std::string> parse_effects(const std::string& list);

/// The effects that `--effect` defines, declared, in order; refuses what is no definition.
std::vector<const EffectDescription*> declared_effects(const Options& options);

/// The logs are inputs: no output may take the place of one.
void spare_logs(const Options& options, Outputs& outputs);

/// The logs of the command, searched (search_logs()).
Searched search(const Options& options, Progress& progress,
                const std::function<void(Measurement&, WholeLogs&)>& work);

/// What to show while the whole logs judge.
WholeLogs::Progress judging(Progress& progress);

/// Refuses combinations that no data can separate or that have nothing to act on.
void check_combination(const Measurement& measurement, const std::vector<std::string>& ids);

/// Refuses to fit more parameters than the instants of the log can tell.
void check_enough(const Options& options, const Measurement& measurement,
                  const std::vector<std::string>& ids);

/// Terms of a model file, for this log: its mass is the log's where the log declares one.
Terms terms_on(const Measurement& measurement, const Model& model);

std::vector<std::string> ids_of(const Terms& terms);

}  // namespace slipstack::workbench
