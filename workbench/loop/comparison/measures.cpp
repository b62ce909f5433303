// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/comparison/measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sim_host/log/draw.h"
#include "workbench/base/statistics.h"

namespace slipstack::workbench {
namespace {

constexpr double kHiddenStrength = 6.0;  // over the noise floor, rms
constexpr double kWrongBy = 0.3;
constexpr double kAtRest_s = 0.2;

constexpr std::array<MeasureText, kMeasureCount> kTexts{{
    {"rms_error_m", "rms", 1e6, "um", "the rms tracking error"},
    {"peak_error_m", "peak", 1e6, "um", "the peak tracking error"},
    {"reversal_rms_m", "reversal", 1e6, "um", "the rms error at reversals"},
    {"reversal_peak_m", "rev.peak", 1e6, "um", "the peak error at reversals"},
    {"settling_10um_1um_s", "10 um", 1e3, "ms", "settling to 1 um after 10 um"},
    {"settling_1mm_1um_s", "1 mm", 1e3, "ms", "settling to 1 um after 1 mm"},
    {"settling_100mm_1um_s", "100 mm", 1e3, "ms", "settling to 1 um after 100 mm"},
    {"settling_10um_count_s", "10 um", 1e3, "ms", "settling to 1 count after 10 um"},
    {"settling_1mm_count_s", "1 mm", 1e3, "ms", "settling to 1 count after 1 mm"},
    {"settling_100mm_count_s", "100 mm", 1e3, "ms", "settling to 1 count after 100 mm"},
    {"circle_0_1mm_m", "0.1 mm", 1e6, "um", "the circle of 0.1 mm"},
    {"circle_1mm_m", "1 mm", 1e6, "um", "the circle of 1 mm"},
    {"circle_50mm_m", "50 mm", 1e6, "um", "the circle of 50 mm"},
    {"jitter_m", "jitter", 1e9, "nm", "jitter at rest"},
    {"noise_ratio", "noise", 1.0, "", "noise of the force at rest"},
    {"effort_N", "effort", 1.0, "N", "the rms force"},
    {"wrong_parameter_m", "wrong", 1e6, "um", "a parameter wrong by 30 %"},
    {"hidden_median_m", "hidden", 1e6, "um", "a hidden effect, median"},
    {"hidden_worst_m", "worst", 1e6, "um", "a hidden effect, the worst"},
    {"warm_m", "warm", 1e6, "um", "the warm axis"},
    {"other_place_m", "place", 1e6, "um", "another place of the rail"},
}};

double spread_of(const std::vector<double>& values, std::size_t first) {
  std::vector<double> part(values.begin() + static_cast<std::ptrdiff_t>(first), values.end());
  double mean = 0.0;
  for (const double value : part) mean += value / static_cast<double>(part.size());
  for (double& value : part) value -= mean;
  return rms(part);
}

/// Collects the measures of one contender.
class Judge {
 public:
  Judge(const Contender& contender, const sim::Axis& axis, std::uint64_t seed)
      : contender_(contender),
        axis_(axis),
        seed_(seed),
        lost_m_(static_cast<double>(contender.axis.following_error_m)) {
    measures_.fill(std::numeric_limits<double>::quiet_NaN());
  }

  void track() {
    const Trajectory motion = judged_motion(axis_, kComparedTick_s, false);
    const DriveRun found = run(contender_, axis_, motion, seed_);
    if (found.lost) {
      for (const Measure m : {Measure::kRms, Measure::kPeak, Measure::kReversalRms, Measure::kReversalPeak})
        set(m, lost_m_);
      return;
    }
    set(Measure::kRms, rms(found.error_m));
    double peak_m = 0.0;
    for (const double error_m : found.error_m) peak_m = std::max(peak_m, std::fabs(error_m));
    set(Measure::kPeak, peak_m);
    const ReversalError reversal = reversal_error(found.error_m, motion);
    set(Measure::kReversalRms, reversal.rms_m);
    set(Measure::kReversalPeak, reversal.peak_m);
    settle(found, motion);
    const auto rest = found.error_m.size() - static_cast<std::size_t>(kAtRest_s / kComparedTick_s);
    set(Measure::kJitter, spread_of(found.position_m, rest));
    if (axis_.force_noise_N > 0.0) set(Measure::kNoise, spread_of(found.force_N, rest) / axis_.force_noise_N);
    set(Measure::kEffort, rms(found.force_N));
  }

  void turn() {
    set(Measure::kCircleSmall, circle_error_m(0.1e-3));
    set(Measure::kCircleMiddle, circle_error_m(1e-3));
    set(Measure::kCircleLarge, circle_error_m(50e-3));
  }

  void disturb(const std::vector<sim::Axis>& with_hidden_effects) {
    const Trajectory motion = judged_motion(axis_, kComparedTick_s, true);
    set(Measure::kWarm, brief_m(contender_, with_level(axis_, 0.8), motion));
    set(Measure::kPlace, brief_m(contender_, with_level(axis_, 1.45), motion));
    if (contender_.bound()) return;  // it has no parameters, and knows no effects
    double worst_m = 0.0;
    for (const double factor : {1.0 - kWrongBy, 1.0 + kWrongBy}) {
      for (const Contender& wrong : each_parameter_times(contender_, factor))
        worst_m = std::max(worst_m, brief_m(wrong, axis_, motion));
    }
    set(Measure::kWrong, worst_m);
    std::vector<double> hidden_m;
    hidden_m.reserve(with_hidden_effects.size());
    const Compensation same = compensation_on(contender_, axis_, motion);
    for (const sim::Axis& other : with_hidden_effects)
      hidden_m.push_back(brief_m(run(contender_, other, motion, same, seed_ + 300), motion));
    if (!hidden_m.empty()) {
      set(Measure::kHiddenWorst, *std::max_element(hidden_m.begin(), hidden_m.end()));
      set(Measure::kHiddenMedian, median(hidden_m));
    }
  }

  const Measures& measures() const { return measures_; }

 private:
  void set(Measure measure, double value) { measures_[static_cast<std::size_t>(measure)] = value; }

  void settle(const DriveRun& found, const Trajectory& motion) {
    struct Kind {
      double length_m;
      Measure by_um;
      Measure by_count;
    };
    for (const Kind& kind : {Kind{10e-6, Measure::kSettle10um, Measure::kSettle10umByCount},
                             Kind{1e-3, Measure::kSettle1mm, Measure::kSettle1mmByCount},
                             Kind{0.1, Measure::kSettle100mm, Measure::kSettle100mmByCount}}) {
      std::vector<double> by_um;
      std::vector<double> by_count;
      for (const Trajectory::Move& move : motion.moves) {
        if (move.length_m != kind.length_m) continue;
        by_um.push_back(settling_s(found.error_m, motion, move, 1e-6));
        by_count.push_back(settling_s(found.error_m, motion, move, axis_.encoder_resolution_m));
      }
      if (by_um.empty()) continue;
      set(kind.by_um, median(by_um));
      set(kind.by_count, median(by_count));
    }
  }

  double circle_error_m(double radius_m) const {
    const Trajectory x = circle(axis_, radius_m, kComparedTick_s, true);
    const Trajectory y = circle(axis_, radius_m, kComparedTick_s, false);
    const DriveRun along_x = run(contender_, axis_, x, seed_ + 100);
    const DriveRun along_y = run(contender_, axis_, y, seed_ + 200);
    if (along_x.lost || along_y.lost) return lost_m_;
    const double middle_m = 0.5 * axis_.stroke_m;
    const double r = std::min(radius_m, 0.35 * axis_.stroke_m);
    double worst_m = 0.0;
    for (std::size_t i = circle_begin(x); i < x.size(); ++i) {
      const double radius = std::hypot(along_x.position_m[i] - middle_m, along_y.position_m[i] - middle_m);
      worst_m = std::max(worst_m, std::fabs(radius - r));
    }
    return worst_m;
  }

  double brief_m(const Contender& contender, const sim::Axis& axis, const Trajectory& motion) const {
    return brief_m(run(contender, axis, motion, seed_ + 300), motion);
  }
  double brief_m(const DriveRun& found, const Trajectory& motion) const {
    return found.lost ? lost_m_ : reversal_error(found.error_m, motion).rms_m;
  }

  const Contender& contender_;
  const sim::Axis& axis_;
  std::uint64_t seed_;
  double lost_m_;
  Measures measures_{};
};

}  // namespace

const MeasureText& text_of(Measure measure) {
  return kTexts[static_cast<std::size_t>(measure)];
}

double settling_s(const std::vector<double>& error_m, const Trajectory& trajectory,
                  const Trajectory::Move& move, double tolerance_m) {
  const std::size_t end = std::min(move.end + move.dwells, error_m.size());
  std::size_t settled = end;
  while (settled > move.end && std::fabs(error_m[settled - 1]) <= tolerance_m) --settled;
  return static_cast<double>(settled - move.end) * trajectory.tick_s;
}

ReversalError reversal_error(const std::vector<double>& error_m, const Trajectory& trajectory) {
  const auto length = static_cast<std::size_t>(kAfterReversal_s / trajectory.tick_s);
  ReversalError found;
  double sum = 0.0;
  std::size_t count = 0;
  std::size_t done = 0;  // windows of reversals that follow each other closely overlap
  for (const std::size_t reversal : trajectory.reversals) {
    for (std::size_t i = std::max(reversal, done); i < std::min(reversal + length, error_m.size()); ++i) {
      sum += error_m[i] * error_m[i];
      found.peak_m = std::max(found.peak_m, std::fabs(error_m[i]));
      ++count;
    }
    done = reversal + length;
  }
  if (count > 0) found.rms_m = std::sqrt(sum / static_cast<double>(count));
  return found;
}

Measures measures_of(const Contender& contender, const sim::Axis& axis,
                     const std::vector<sim::Axis>& with_hidden_effects, std::uint64_t seed,
                     const Extent& extent) {
  Judge judge(contender, axis, seed);
  judge.track();
  judge.turn();
  if (extent.robustness) judge.disturb(with_hidden_effects);
  return judge.measures();
}

sim::Axis axis_with_effects(const sim::Axis& axis, const std::vector<sim::EffectId>& effects, double strength,
                            std::uint64_t seed) {
  sim::Bench bench;
  bench.axis = axis;
  bench.programme.seconds = 12.0;
  sim::add_effects(bench.axis, effects, sim::draw_programme(bench, seed), 2000.0,
                   strength > 0.0 ? strength : kHiddenStrength, seed);
  return bench.axis;
}

std::vector<sim::Axis> axes_with_hidden_effects(const sim::Axis& axis, std::uint64_t seed) {
  std::vector<sim::Axis> axes;
  for (const sim::EffectId effect : sim::drawable_effects())
    axes.push_back(axis_with_effects(axis, {effect}, 0.0, seed));
  return axes;
}

sim::Axis with_level(sim::Axis axis, double share) {
  std::vector<sim::CurveTerm> terms = axis.curve.terms();
  for (sim::CurveTerm& term : terms) {
    term.level_N *= share;
    for (double& force_N : term.points_N) force_N *= share;
  }
  axis.curve = sim::VirginCurve(std::move(terms));
  return axis;
}

}  // namespace slipstack::workbench
