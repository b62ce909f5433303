// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/evidence/significance.h"
#include "workbench/diagnose/search/growth.h"

namespace slipstack::workbench {

/// A structural resonance brings a rigid mass along, and with it can do what a payload does, or a payload and
/// a delay. Gives these their names: where payload and delay explain as much as the mode, in its place; where
/// the mode's rigid mass is neither none (the arm stands on the declared mass) nor minus its own (the arm is
/// a part of it), beside it. Only where the log declares the mass. Cost: three fits.
void name_mass_beside_mode(const Measurement& measurement, const SelectionContext& context,
                           Explanation& explanation);

}  // namespace slipstack::workbench
