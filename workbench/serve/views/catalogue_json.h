// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace slipstack::workbench {

/// Every effect of the catalogue: id, title, formula, source, residual, cause, confirm, plannable.
nlohmann::json catalogue_json();

}  // namespace slipstack::workbench
