// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/diagnose.h"
#include "workbench/diagnose/search/growth.h"

namespace slipstack::workbench {

/// Lists the explanation one effect at a time, from the baseline to `best`; sets `steps` and the model with
/// the first of them. The strongest alone first (the candidates are ranked), then whatever helps most, so
/// that the waterfall falls as fast as it can.
void list_steps(const Measurement& measurement, const Explanation& best, Diagnosis& diagnosis);

/// Drops steps that the whole logs do not bear out, from the last on.
void drop_insignificant_steps(const Measurement& measurement, Diagnosis& diagnosis);

}  // namespace slipstack::workbench
