// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tuple>

#include "firmware/effects/acceleration_dependent_preload.h"
#include "firmware/effects/cable_chain_stiffness.h"
#include "firmware/effects/coulomb.h"
#include "firmware/effects/direction_asymmetry.h"
#include "firmware/effects/drift.h"
#include "firmware/effects/force_ripple.h"
#include "firmware/effects/frictional_lag.h"
#include "firmware/effects/inertia.h"
#include "firmware/effects/motor_constant_ripple.h"
#include "firmware/effects/numerics/user_table.h"
#include "firmware/effects/offset_force.h"
#include "firmware/effects/payload_mass.h"
#include "firmware/effects/position_dependent_preload.h"
#include "firmware/effects/presliding_hysteresis.h"
#include "firmware/effects/quadratic_drag.h"
#include "firmware/effects/stribeck.h"
#include "firmware/effects/structural_resonance.h"
#include "firmware/effects/time_delay.h"
#include "firmware/effects/viscous.h"

namespace slipstack {

/// Every effect of slipstack: the only list. To add an effect, write its header and add it here.
template <class Real>
using Catalogue =
    std::tuple<Inertia<Real>, PreslidingHysteresis<Real>, Coulomb<Real>, Viscous<Real>, QuadraticDrag<Real>,
               Stribeck<Real>, FrictionalLag<Real>, PositionDependentPreload<Real>,
               AccelerationDependentPreload<Real>, DirectionAsymmetry<Real>, ForceRipple<Real>,
               MotorConstantRipple<Real>, OffsetForce<Real>, CableChainStiffness<Real>, PayloadMass<Real>,
               StructuralResonance<Real>, TimeDelay<Real>, Drift<Real>, UserTable<Real>>;

}  // namespace slipstack
