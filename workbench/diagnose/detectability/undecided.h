// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

/// Lists the effects that this log would show only if they were a large part of the force.
void list_what_cannot_be_shown(const Measurement& measurement, Diagnosis& diagnosis);

/// Lists pairs of promising effects that explain equally much (the candidates are ranked) or whose forces
/// hardly differ. Where one is a special case of the other, and this log would show the general effect but
/// does not support it, the pair is not listed, and the general effect is removed from what the log cannot
/// show.
void list_what_cannot_be_separated(const Measurement& measurement, Diagnosis& diagnosis);

}  // namespace slipstack::workbench
