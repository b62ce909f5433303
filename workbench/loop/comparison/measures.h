// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "sim_host/plant/effects/effect_id.h"
#include "workbench/loop/comparison/contender.h"

namespace slipstack::workbench {

/// What a contender is judged by; less is better. NaN: it could not be measured.
enum class Measure : std::size_t {
  kRms,
  kPeak,
  kReversalRms,
  kReversalPeak,
  kSettle10um,
  kSettle1mm,
  kSettle100mm,
  kSettle10umByCount,
  kSettle1mmByCount,
  kSettle100mmByCount,
  kCircleSmall,
  kCircleMiddle,
  kCircleLarge,
  kJitter,
  kNoise,
  kEffort,
  kWrong,
  kHiddenMedian,
  kHiddenWorst,
  kWarm,
  kPlace,
  kCount
};
inline constexpr std::size_t kMeasureCount = static_cast<std::size_t>(Measure::kCount);

struct MeasureText {
  std::string_view key;      ///< in JSON, with its SI unit
  std::string_view heading;  ///< of a column
  double scale;              ///< to the unit of the table
  std::string_view unit;     ///< there
  std::string_view what;     ///< in a sentence
};
const MeasureText& text_of(Measure measure);

using Measures = std::array<double, kMeasureCount>;

/// Within this time after a reversal of the reference an error counts as one at the reversal.
inline constexpr double kAfterReversal_s = 0.05;

/// Time from the end of the reference's move until the error stays within `tolerance_m`, in the dwell; its
/// length where it never does.
double settling_s(const std::vector<double>& error_m, const Trajectory& trajectory,
                  const Trajectory::Move& move, double tolerance_m);

/// rms and peak of the error within kAfterReversal_s after each reversal.
struct ReversalError {
  double rms_m = 0.0;
  double peak_m = 0.0;
};
ReversalError reversal_error(const std::vector<double>& error_m, const Trajectory& trajectory);

/// How much of the comparison is made.
struct Extent {
  bool robustness = true;  ///< wrong parameters, hidden effects, another level of the friction
};

/// All measures of a contender on this axis.
///   tracking    judged_motion(), the true position against the reference
///   settling    ± 1 µm, and ± 1 count, median of the moves of a length
///   circles     two axes of this kind with the same parameters and each its own noise; largest deviation of
///               the radius over two turns
///   at rest     the last 0.2 s of the last dwell: jitter of the true position (rms about its mean) and of
///   the
///               force, that over the amplifier's noise
///   effort      rms force
///   wrong       largest rms at reversals with each parameter wrong by ± 30 %, one after the other (brief
///               motion)
///   hidden      rms at reversals with each of the effects that the tuning has not seen, six times the noise
///               floor: median and worst (brief motion)
///   warm, place the friction's level 0.8 and 1.45 of that of the training (brief motion)
/// A run that is lost counts as an error of the following error's bound. Some 100 s of the axis, ten times
/// that for one that learns.
Measures measures_of(const Contender& contender, const sim::Axis& axis,
                     const std::vector<sim::Axis>& with_hidden_effects, std::uint64_t seed,
                     const Extent& extent);

/// The axis with these effects, `strength` times its noise floor (rms); 0: six times.
sim::Axis axis_with_effects(const sim::Axis& axis, const std::vector<sim::EffectId>& effects, double strength,
                            std::uint64_t seed);
/// The axis with each effect that can be drawn, six times its noise floor.
std::vector<sim::Axis> axes_with_hidden_effects(const sim::Axis& axis, std::uint64_t seed);

/// The axis with this share of its friction.
sim::Axis with_level(sim::Axis axis, double share);

}  // namespace slipstack::workbench
