// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace slipstack::workbench {

/// The numbers behind the charts as JSON that may stand inside an HTML script element: `<` is written \u003c,
/// values carry 7 significant digits (positions and times 10), NaN and infinities become null.
/// Only series, loops, profiles, spectrum and what the charts' legends need; the rest of `data` is in the
/// page's text.
std::string chart_data_json(const nlohmann::json& data);

/// What the charts call the residual after the change: "with force ripple added"; "after" if nothing is
/// known.
std::string after_label(const nlohmann::json& data);

}  // namespace slipstack::workbench
