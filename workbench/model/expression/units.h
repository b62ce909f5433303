// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace slipstack::workbench {

/// Why `unit` is not understood; empty when it is: a product of the SI units N, m, s, kg, A, Hz, rad, K, Pa,
/// J and W with whole exponents, such as "N s/m", "m/s2", "1/m", or "1" for a number.
std::string unit_fault(std::string_view unit);

}  // namespace slipstack::workbench
