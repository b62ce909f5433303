// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "workbench/base/interval.h"

namespace slipstack::workbench {

/// Half the width of the median filter. A median over seven samples keeps steps and slopes and removes what
/// is at most three samples wide. No other fault may lie within this distance of an outlier.
inline constexpr std::size_t kHalfWindow = 3;

/// Outliers of one signal, as intervals of up to three samples: they differ from the median of their
/// neighbours by far more than `noise` (the standard deviation) and by more than `least`. Many close together
/// are a burst and not reported. O(n).
std::vector<Interval> outliers(const std::vector<double>& values, double noise, double least);

/// Difference of each sample from the cubic through two neighbours on either side; zero for the first and
/// last two samples. O(n).
std::vector<double> departures_from_cubic(const std::vector<double>& values);
/// Samples that one such difference consists of.
inline constexpr std::size_t kSamplesOfDeparture = 5;

/// Single outliers such as the spikes of a damaged cable, which outliers() misses because the motion of the
/// signal is larger; the cubic through the neighbours follows the motion. None where they are a smaller share
/// of the samples than `least_share`. O(n).
std::vector<Interval> spikes(const std::vector<double>& values, double noise, double least_share);

}  // namespace slipstack::workbench
