// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace slipstack::sim {

/// Gauss-Legendre on (−1, 1), ten points, of which the positive half stands here: exact to degree 19.
inline constexpr std::array<double, 5> kGaussNodes = {
    0.1488743389816312, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845, 0.9739065285171717};
inline constexpr std::array<double, 5> kGaussWeights = {
    0.2955242247147529, 0.2692667193099963, 0.2190863625159820, 0.1494513491505806, 0.0666713443086881};

}  // namespace slipstack::sim
