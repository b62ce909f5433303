// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/diagnose/alternatives/structure.h"

namespace slipstack::workbench {

/// The strongest spectral line, of constant frequency and phase, in the residual at the rows: below their
/// bandwidth.
Structure line_at_rows(const Measurement& measurement, const Eigen::VectorXd& residual_N);

/// A line above that bandwidth, where no effect of the catalogue is searched: mains hum, an unbalanced fan, a
/// switching ripple. It is found in the residual of `model_N` (a value per sample) and present throughout the
/// log. The reduction of the error is relative to the rms of the line and of `error_N` together. Cost: some
/// spectra of the log.
std::optional<Structure> line_beyond_rows(const Measurement& measurement, const std::vector<double>& model_N,
                                          double error_N);

}  // namespace slipstack::workbench
