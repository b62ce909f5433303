// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

/// Lists the effects that this log could show only if they were a large part of the force.
void list_what_cannot_be_shown(const Measurement& measurement, Diagnosis& diagnosis);

/// Lists, of the effects that promise much alone, those that explain as much as another (the candidates are
/// ranked) and those whose forces hardly differ. Where one is but a case of the other, and this log would
/// show more than that, neither list keeps the richer one for it.
void list_what_cannot_be_separated(const Measurement& measurement, Diagnosis& diagnosis);

}  // namespace slipstack::workbench
