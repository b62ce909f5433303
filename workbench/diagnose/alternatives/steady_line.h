// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace slipstack::workbench {

/// A spectral line of constant frequency, amplitude and phase throughout a signal.
struct SteadyLine {
  double frequency_Hz = 0.0;
  double frequency_error_Hz = 0.0;  ///< standard error
  double amplitude_N = 0.0;
  double amplitude_error_N = 0.0;  ///< standard error
  double chance = 1.0;             ///< probability that chance makes any frequency so steady
};

/// How a steady line is searched.
struct SteadySearch {
  double rate_Hz = 0.0;
  double above_Hz = 0.0;      ///< where it is searched, up to half the rate
  std::size_t intervals = 0;  ///< at least so many, into which the signal is divided
};

/// The line above a frequency that is the steadiest, if it is by no chance and holds most of what is steady
/// there: a motion that repeats leaves a series of harmonics. F test of a line (Thomson 1982) over P
/// intervals of equal length in place of windows: with their transforms c (Hann window, each in units of its
/// own rms above the frequency, so that moves of large residual do not count for more than others) and the
/// phase that a line gains from interval to interval, R = |sum c|^2 / (P sum |c|^2) exceeds r by chance with
/// the probability (1 - r)^(P - 1). Ringing after moves and a controller that hunts now and then keep no
/// phase. Cost: one spectrum of the signal.
std::optional<SteadyLine> steady_line(std::span<const double> signal, const SteadySearch& search);

/// Whether the signal has a steady line at one frequency, which no search has chosen.
bool is_steady_at(std::span<const double> signal, const SteadySearch& search, double frequency_Hz);

}  // namespace slipstack::workbench
