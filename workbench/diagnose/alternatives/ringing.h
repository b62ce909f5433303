// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/diagnose/alternatives/structure.h"
#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

/// What rings above the bandwidth of the rows, where no effect of the catalogue is searched: a narrow peak in
/// the spectrum of the residual of the model at the samples, of any phase, at speeds further apart
/// than its frequencies: a force that depends on the position has a narrow peak at one speed only. What the
/// encoder shows as motion of the mass is none. The reduction of the error is relative to the rms of the
/// ringing and of the model's error together. None where the motion repeats so fast that its harmonics are
/// apart in the spectrum. Cost: two spectra of the log.
std::optional<Structure> ringing_beyond_rows(const Measurement& measurement, const FittedModel& model);

}  // namespace slipstack::workbench
