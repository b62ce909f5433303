// SPDX-License-Identifier: Apache-2.0
#pragma once

// The friction core as a library: what this header brings is the interface that is versioned
// (docs/library.md); what is in a namespace `detail` is not.
//
//   hysteresis   MaxwellSlip, PackedMaxwellSlip, MemoryStack; RationalCurve, PiecewiseLinearCurve
//   effects      FrictionModel, EffectParameters, Sample, Scales, and each effect of the Catalogue
//   of a model   model_hash

#include "firmware/effects/model.h"
#include "firmware/effects/model_hash.h"
#include "firmware/friction/maxwell_slip.h"
#include "firmware/friction/memory_stack.h"
#include "firmware/friction/packed_maxwell_slip.h"
#include "firmware/friction/virgin_curves.h"
#include "slipstack/version.h"
