// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/long_logs/log_search.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {

/// A model whose terms were fitted again to the logs, with the errors before and after.
struct Refit {
  Model model;
  double before_N = 0.0;  ///< held-out error of the model before
  double after_N = 0.0;
  double noise_floor_N = 0.0;
};

/// The model without one of its effects: the shapes of the others are refined in turn, all gains fitted
/// again. `log`: names of the logs. The history keeps what was there and tells the removal. Throws UsageError
/// where the model has no such effect or would have none left.
Refit remove_effect(LogSearch& logs, const std::string& log, const Model& old, const std::string& effect,
                    Progress& progress);

}  // namespace slipstack::workbench
