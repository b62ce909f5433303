// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>

namespace slipstack::workbench {

/// Refuses what is no positive number. As CLI::PositiveNumber, whose message has the 309 digits of the
/// largest double.
inline CLI::Validator positive_number() {
  return {[](const std::string& text) {
            double value = 0.0;
            const bool positive =
                CLI::detail::lexical_cast(text, value) && value > 0.0 && std::isfinite(value);
            return positive ? std::string() : "Value " + text + " is not positive";
          },
          "POSITIVE"};
}

}  // namespace slipstack::workbench
