// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace slipstack::workbench {

/// The numbers behind the charts as JSON that may stand inside an HTML script element: `<` is written \u003c,
/// values carry 7 significant digits (positions and times 10), NaN and infinities become null.
/// Only series, loops, profiles, spectrum, charts and what their legends need; the rest of `data` is in the
/// text of the page.
std::string chart_data_json(const nlohmann::json& data);

/// The name of the second model in the charts: "with force ripple added"; "after" where its effects are not
/// known.
std::string after_label(const nlohmann::json& data);

/// The display units of the charts on a rotary axis, as units.js has them for a linear one.
nlohmann::json rotary_units();

}  // namespace slipstack::workbench
