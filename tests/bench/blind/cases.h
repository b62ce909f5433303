// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/blind/estimates.h"

namespace slipstack::bench {

/// What a log of the benchmark contains beside the baseline.
enum class Kind { clean, single, pair, triple, line, bump, backlash, burst, slip };
const char* name_of(Kind kind);
bool outside_catalogue(Kind kind);

/// One simulated log and the result of its diagnosis.
struct Outcome {
  Kind kind = Kind::clean;
  std::uint64_t seed = 0;
  bool closed_loop = false;
  std::vector<std::string> hidden;
  std::string verdict;
  std::vector<std::string> ranking;  ///< candidates, best first
  std::vector<std::string> added;    ///< the explanation
  std::string coordinate;            ///< of what is left unexplained
  double baseline_over_floor = 0.0;  ///< held-out error of the baseline over the noise floor
  double explained_over_floor = 0.0;
  std::vector<Estimate> estimates;  ///< of hidden effects that were named

  bool visible() const { return baseline_over_floor >= 1.10; }
  bool right() const;  ///< all that was hidden is named and nothing else; or `complete`; or `unexplained`
};

/// Simulates the log of a random axis to `path` and diagnoses that file. The diagnosis does not know the
/// truth. Throws std::runtime_error where the simulated controller loses its axis.
Outcome run_case(Kind kind, std::uint64_t seed, bool closed_loop, const std::filesystem::path& path);

nlohmann::json to_json(const Outcome& outcome);
Outcome outcome_from(const nlohmann::json& entry);

}  // namespace slipstack::bench
