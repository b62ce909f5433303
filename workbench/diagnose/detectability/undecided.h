// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

/// Lists the effects that this log would show only if they were a large part of the force.
void list_what_cannot_be_shown(const Measurement& measurement, Diagnosis& diagnosis);

}  // namespace slipstack::workbench
