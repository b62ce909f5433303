// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "workbench/base/interval.h"

namespace slipstack::workbench {

/// A median over seven samples leaves steps and slopes as they are and takes out what is at most three wide.
/// So near to a wild sample nothing else may be wrong.
inline constexpr std::size_t kHalfWindow = 3;

/// Wild samples of one signal, as stretches of up to three: out of what the samples around say by far more
/// than `noise` (its standard deviation) and than `least`. Many close together are a burst, and none of
/// these. O(n).
std::vector<Interval> outliers(const std::vector<double>& values, double noise, double least);

/// What each sample differs by from the cubic through two neighbours on either side; zero for the two at
/// either end. O(n).
std::vector<double> departures_from_cubic(const std::vector<double>& values);

/// Wild samples that stand alone: spikes of a cable, which would vanish in the motion of the signal but not
/// in its noise. None where they are a smaller share of the samples than `least_share`. O(n).
std::vector<Interval> spikes(const std::vector<double>& values, double noise, double least_share);

}  // namespace slipstack::workbench
