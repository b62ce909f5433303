// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/identify/measurement.h"

namespace slipstack::workbench {

/// White noise of the force before the filter [N], as one log's residual shows it: forces that push the axis
/// and are in no sensor (a drive's own noise, rough rolling) are seen there only, since the measured current
/// of a controlled axis need not carry them. Judged in the upper part of the rows' bandwidth, where friction
/// and motion say little: of its bands the quietest, of the log's pieces the median, so that neither a line
/// nor what happens at reversals counts. What the encoder's steps do there through `mass_kg` is taken off,
/// and so is what they do through hysteresis: the mean power of `readings_N`. Zero for a log of fewer than
/// eight pieces of 128 rows. `residual_N` and `readings_N`: of all rows; `lag`: undone in the residual, it
/// came before the noise.
double residual_noise_N(const Measurement& measurement, const LogPart& part,
                        const Eigen::VectorXd& residual_N, const std::vector<Eigen::VectorXd>& readings_N,
                        double mass_kg, const ForceLag& lag);

}  // namespace slipstack::workbench
