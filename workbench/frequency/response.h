// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <vector>

#include "workbench/frequency/excited_record.h"

namespace slipstack::workbench {

using Complex = std::complex<double>;

/// The axis at one frequency, with standard deviations of the complex values.
struct ResponsePoint {
  double frequency_Hz = 0.0;
  Complex plant{};        ///< sampled position over held force, m/N
  double plant_sd = 0.0;  ///< m/N
  /// Force at the axis over what was injected: at the force the sensitivity itself, at the position reference
  /// N/m (FeedbackResponse::of_reference()); NaN where that is not recorded.
  Complex sensitivity{};
  double sensitivity_sd = 0.0;
  double coherence = 0.0;  ///< share of the position's power that repeats from period to period
};

/// The response at every excited harmonic, rising in frequency.
///
/// Per period the discrete Fourier transform at the harmonic; over the periods of all records mean and
/// covariance. Plant = Y / F of the means, var = |P|² (σY² / |Y|² + σF² / |F|² − 2 Re(σYF² / (Y F*))) /
/// periods (Pintelon and Schoukens, System Identification, 2nd ed. 2012, 2.7 and 3.3): noise of both signals
/// is allowed, and noise that the feedback brings into the force does no harm, since the means contain what
/// repeats only. The sensitivity is F / D with the known D.
///
/// The records are of one excitation (several captures of it); each alone gives its periods. Throws
/// InputError where check() does, or when they differ. O(samples × harmonics).
std::vector<ResponsePoint> response(const std::vector<ExcitedRecord>& captures, const std::string& name);

/// Responses of several bands as one: where two overlap, the one with the smaller mean of the relative
/// standard deviation there.
std::vector<ResponsePoint> joined(const std::vector<std::vector<ResponsePoint>>& bands);

/// Neighbouring points whose relative standard deviation is above `wanted` are averaged, up to `octave` of an
/// octave together, weighted by their certainty: curvature m ω² P is what is averaged, so that the slope of a
/// mass makes no error.
std::vector<ResponsePoint> smoothed(const std::vector<ResponsePoint>& points, double wanted = 0.05,
                                    double octave = 1.0 / 12.0);

}  // namespace slipstack::workbench
