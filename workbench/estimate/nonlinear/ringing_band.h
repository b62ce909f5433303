// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/signal/spectrum.h"

namespace slipstack::workbench {

/// Samples of the segments of a spectrum in which a light mode above the bandwidth of the rows is several
/// bins wide, for a log of so many samples: a power of two.
std::size_t segment_above_rows(const Measurement& measurement, std::size_t samples);

/// The median of the densities within a factor of 1.2 of a bin's frequency, from `first_bin` on: a light mode
/// is a tenth as wide.
double density_beside(const Spectrum& spectrum, std::size_t bin, std::size_t first_bin);

/// The bandwidth that holds what rings above that of the rows [Hz], one and a half times its frequency; none
/// where nothing does. It rings where most of what a mass with friction leaves of the force, up to the end of
/// the known motion and beyond the noise, lies near one frequency above the bandwidth: errors that are judged
/// below it would not contain what the model lacks. What the force does not contain (the encoder's noise,
/// multiplied by the mass) does not count. Cost: a spectrum of the force; where that has something above the
/// bandwidth, also a fit.
std::optional<double> bandwidth_of_ringing_Hz(const Measurement& measurement);

}  // namespace slipstack::workbench
