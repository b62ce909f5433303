// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

namespace slipstack::workbench {

/// Taps of a symmetric (zero-phase) low-pass at the sampling rate: windowed sinc, Kaiser window, sum 1.
/// `cutoff_Hz` is the -6 dB point; the response is flat to 0.01 % below half of it and under -90 dB above
/// 1.5 times it.
std::vector<double> low_pass_taps(double cutoff_Hz, double rate_Hz);

/// Sum of squares of the taps: the share of the variance of white noise that passes the filter.
double noise_gain(std::span<const double> taps);

/// Full convolution.
std::vector<double> convolve(std::span<const double> a, std::span<const double> b);

/// The input filtered at every sample; outside, the first and the last value are repeated.
std::vector<double> filter_all(std::span<const double> input, std::span<const double> taps);

/// Derivatives of a smooth signal by five-point differences (error of fourth order). Outside, the first and
/// the last value are repeated: the first and last two derivatives are those of a signal at standstill.
std::vector<double> first_derivative(std::span<const double> input, double rate_Hz);
std::vector<double> second_derivative(std::span<const double> input, double rate_Hz);

}  // namespace slipstack::workbench
