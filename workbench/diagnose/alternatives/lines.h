// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/diagnose/alternatives/structure.h"

namespace slipstack::workbench {

/// A line of constant frequency and phase in the residual at the rows: below their bandwidth.
Structure line_at_rows(const Measurement& measurement, const Eigen::VectorXd& residual_N);

/// The same at one frequency, to within what the residual's spectrum resolves.
Structure line_near(const Measurement& measurement, const Eigen::VectorXd& residual_N, double frequency_Hz);

/// A line above that bandwidth, where no effect of the catalogue is looked for: mains hum, an unbalanced fan,
/// a switching ripple. Seen in the force that `model_N` (a value per sample) leaves, throughout the log. Its
/// reduction is what it would be of an rms of `error_N`. Cost: some spectra of the log.
std::optional<Structure> line_beyond_rows(const Measurement& measurement, const std::vector<double>& model_N,
                                          double error_N);

}  // namespace slipstack::workbench
