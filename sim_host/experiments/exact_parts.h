// SPDX-License-Identifier: Apache-2.0
// The parts of a set-up's axis that ExactAxis needs.
#pragma once

#include <string_view>

#include "sim_host/experiments/setup.h"
#include "sim_host/plant/exact_axis.h"
#include "sim_host/plant/friction/maxwell_elements.h"

namespace slipstack::sim {

/// Mass (payload included), Newtonian viscous friction, linear cable chain and arm of a set-up. The cable's
/// rest is taken relative to the set-up's position, so that the exact axis starts at zero. Throws SetupError
/// that names the first effect that is not linear; `experiment` names the request in the message.
LinearPart linear_part(const ExperimentSetup& setup, std::string_view experiment);

/// The elements of a set-up's friction.
MaxwellElements maxwell_elements(const ExperimentSetup& setup);

}  // namespace slipstack::sim
