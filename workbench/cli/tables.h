// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

// Aligned tables on standard output.
void print_parameters(const Terms& terms);
void print_candidates(const Diagnosis& diagnosis);
void print_steps(const Diagnosis& diagnosis);
/// Usual cause, what cannot be told apart, and the experiment that confirms.
void print_advice(const Candidate& candidate);

}  // namespace slipstack::workbench
