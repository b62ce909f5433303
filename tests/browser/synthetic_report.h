// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace slipstack::test {

/// Report data as the workbench would make it, for a pick-and-place axis with pre-sliding hysteresis and a
/// hidden force ripple: 40 000 samples at 2 kHz with fast moves, slow traverses and small loops, some samples
/// excluded. The numbers follow from the simulated force, so that figures, profiles and spectrum agree with
/// each other. Same seed, same report. Kinds:
///   missing_effect, complete, unexplained, comparison: what `slipstack` writes for these verdicts;
///   hostile: missing_effect with every string an attempt to break out of the page;
///   bare: only a title and a verdict.
/// Throws std::invalid_argument for any other kind.
nlohmann::json synthetic_report(const std::string& kind, std::uint32_t seed);

}  // namespace slipstack::test
