// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/commission/prepare.h"
#include "workbench/commission/stages.h"

namespace slipstack::workbench {

/// A model on the way, tried on the axis.
struct ModelTrial {
  std::string added;          ///< in words: "mass alone", then what each has that the one before has not
  std::string effect;         ///< the id of that; empty of the first two
  std::string file;           ///< in the folder; empty: the mass alone
  std::vector<double> rms_m;  ///< tracking error of each cycle of the test; empty where the drive stopped
  std::vector<double> reversal_rms_m;
  double prediction_rms_N = 0.0;  ///< of the force in the test with the mass alone, which no fit has seen
  double limited_share = 0.0;     ///< of the time, at the limit of the force
  std::string fault;
  bool kept = false;
};

/// Mean, and its standard error from the scatter.
struct Spread {
  double mean = 0.0;
  double standard_error = 0.0;
};
Spread spread_of(const std::vector<double>& values);

/// Whether `after` is lower than `before` by more than three standard errors of the difference. False where
/// one is empty.
bool is_lower(const std::vector<double>& after, const std::vector<double>& before);

/// Deploys the mass alone and then the models in their order (of identify()), each tried on the same motion
/// and kept where the axis follows better than with the last one that was kept; else that one runs again
/// before anything else happens. A model that the drive refuses, or with which the axis leaves its reference,
/// is not kept and does not end the commissioning. The axis runs the last one kept at the end.
/// Throws CommissionStopped on any other fault, and where the mass alone fails.
std::vector<ModelTrial> try_models(Stages& stages, const PreparedAxis& axis, const nlohmann::json& models);

}  // namespace slipstack::workbench
