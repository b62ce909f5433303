// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// Throws InputError for a measurement that is sampled too slowly to show friction, or too short to be
/// fitted.
void refuse_slow_or_short(const Measurement& measurement);

/// Throws UsageError for effects that no data can separate, or that have nothing to act on.
void check_combination(const Measurement& measurement, const std::vector<std::string>& ids);

/// Throws InputError where these effects have more parameters than the instants of the log can determine.
/// `logs` names the log in the message.
void check_enough(const std::string& logs, const Measurement& measurement,
                  const std::vector<std::string>& ids);

}  // namespace slipstack::workbench
