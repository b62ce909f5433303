// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/estimate/measurement/parts.h"

namespace slipstack::workbench {

// What is chosen from logs before anything is fitted to them.

/// Highest bandwidth of the rows, relative to the sampling rate: a motion is well sampled at frequencies
/// twenty times below it.
inline constexpr double kHighestBandwidth = 0.05;

/// Up to where the motion is known, for rows of this bandwidth.
double motion_bandwidth_Hz(double bandwidth_Hz, double rate_Hz);
/// Low pass of the motion, for rows of this bandwidth.
std::vector<double> motion_taps(double bandwidth_Hz, double rate_Hz);

/// What the encoder's steps, as white noise differentiated twice and multiplied by the rough mass, have
/// within a bandwidth: mean square [N^2].
double encoder_steps_N2(const LogPart& part, double bandwidth_Hz, double rate_Hz);

/// The least bandwidth that leaves enough rows of logs of this duration in all.
double bandwidth_of_enough_rows_Hz(double duration_s);

/// Bandwidth within which the force of joined logs contains information about the motion: no further than the
/// logs excite, and no further than where the encoder's quantisation, through the mass, exceeds the noise of
/// the force. The rough mass and the noise of the parts must be set.
double bandwidth_shown_Hz(const Log& log, const std::vector<LogPart>& parts);

}  // namespace slipstack::workbench
