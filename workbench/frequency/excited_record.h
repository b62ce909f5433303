// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace slipstack::workbench {

/// A recording of an axis whose loop is excited periodically: whole periods, in steady state.
struct ExcitedRecord {
  double tick_s = 0.0;
  std::size_t decimation = 1;      ///< ticks from one sample to the next
  std::size_t period_samples = 0;  ///< of the excitation
  std::size_t lowest = 0;          ///< harmonics of 1 / period that are excited, from …
  std::size_t highest = 0;         ///< … to
  bool at_force = true;            ///< the excitation is a force; else a change of the position reference
  std::vector<double> position_m;
  std::vector<double> force_N;     ///< current × motor constant: mean of the one before the sample and after
  std::vector<double> excitation;  ///< N or m; empty: not recorded

  double sample_s() const { return tick_s * static_cast<double>(decimation); }
  double line_Hz() const { return 1.0 / (sample_s() * static_cast<double>(period_samples)); }
  std::size_t periods() const { return period_samples == 0 ? 0 : position_m.size() / period_samples; }
};

/// Throws InputError, with `name` in front, when a response cannot be computed from it: fewer than two
/// periods, columns of different length, lines above the Nyquist frequency, an axis that did not move.
void check(const ExcitedRecord& record, const std::string& name);

}  // namespace slipstack::workbench
