// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "workbench/base/interval.h"

namespace slipstack::workbench {

/// Standard deviation of white noise that is superimposed on a smooth signal. Sixth differences suppress the
/// smooth signal; the median of their magnitudes ignores the rare samples where it is not smooth. Zero for
/// fewer than seven samples. `left_out`: intervals in ascending order that say nothing of the noise, as a
/// signal at the limit of its sensor. O(n).
double white_noise(std::span<const double> signal, const std::vector<Interval>& left_out = {});

/// The step of a signal that is quantised so coarsely that it often does not change from sample to sample;
/// zero of any other signal. Recognised by its smallest changes, which are all one step. O(n log n).
double coarse_step(std::span<const double> signal);

/// Standard deviation of the noise in one sample: that of white_noise(), but no less than the error of
/// uniform quantisation, step / sqrt(12) (Widrow and Kollar 2008, Quantization noise, section 4). Where a
/// signal stays within a step its differences are zero, and say nothing of that error.
double noise_of_samples(std::span<const double> signal, const std::vector<Interval>& left_out = {});

/// By which factor white_noise() grows where every second sample is left out: one for white noise, more where
/// neighbours share their noise (a signal that was filtered or interpolated), or where the signal is not
/// smooth. One where there is no noise, or none beyond that of coarse steps.
double growth_of_noise_at_half_rate(std::span<const double> signal);

/// Sixth differences say too little of noise that neighbouring samples share. White noise grows by one where
/// every second sample is left out, the difference of two samples of a random walk by sqrt(2). Chosen above
/// that: of 52 logs of axes it was 0.98 to 1.9 where the noise was white or nearly, 2.2 where samples were
/// interpolated and 5.8 beside a strong line near half of the sample rate.
inline constexpr double kNotWhite = 2.0;

}  // namespace slipstack::workbench
