// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

/// Lists the effects that this log would show only if they were a large part of the force.
void list_what_cannot_be_shown(const Measurement& measurement, Diagnosis& diagnosis);

/// Lists the ties of the explanation with the angle between the two forces, and marks both candidates of
/// each. Where one is a special case of the other, and this log would show what else the general effect can
/// be, there is no tie.
void list_what_cannot_be_separated(const Measurement& measurement, Diagnosis& diagnosis);

}  // namespace slipstack::workbench
