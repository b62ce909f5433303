// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

/// Sets the verdict, and what is left unexplained: searches what the explanation leaves for structure, and
/// asks whether what was named stands in for something else. Wants the steps, the explained model and the
/// floor.
void judge(const Measurement& measurement, Diagnosis& diagnosis);

}  // namespace slipstack::workbench
