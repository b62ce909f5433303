// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "workbench/model/term.h"

namespace slipstack::workbench {

/// Whether the search of a shape ended at a bound, so that the bound determined it and not the log. Known
/// after with_standard_errors(), which gives no standard error to such a shape.
bool shape_ended_at_bound(const Term& term, std::size_t shape);

}  // namespace slipstack::workbench
