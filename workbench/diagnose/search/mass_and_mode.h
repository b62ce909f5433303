// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/evidence/naming_rule.h"

namespace slipstack::workbench {

/// The effect of a structural resonance has a rigid mass as a gain, and can therefore stand in the model for
/// a payload, or for a payload and a delay. Replaces the mode by payload and delay where these have the
/// better criterion. Adds a payload beside the mode where the rigid mass is neither zero (the arm is mounted
/// on the declared mass) nor minus the modal mass (the arm is a part of the declared mass). Only where the
/// log declares the mass. Cost: some fits.
void name_mass_beside_mode(const SelectionContext& context, Explanation& explanation);

}  // namespace slipstack::workbench
