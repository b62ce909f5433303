// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/verdict.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "workbench/diagnose/alternatives/bursts.h"
#include "workbench/diagnose/alternatives/confounders.h"
#include "workbench/diagnose/alternatives/lines.h"
#include "workbench/diagnose/alternatives/lost_counts.h"
#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {
namespace {

/// Encoder steps cause the largest errors at reversals: below this multiple of the noise floor a residual
/// after reversals is not reported as backlash. Chosen on the blind bench.
constexpr double kBacklashAboveFloor = 1.6;

/// All structure in the residual of the explanation, the strongest first.
std::vector<Structure> structure_left(const Measurement& measurement, const Diagnosis& diagnosis) {
  auto left = find_structure(measurement, weighted_residual(measurement, diagnosis.explained));
  if (diagnosis.explained.holdout_rmse_N < kBacklashAboveFloor * diagnosis.noise_floor_N) {
    std::erase_if(left, [](const Structure& one) { return one.coordinate == Coordinate::reversal; });
  }
  return left;
}

/// Structure is reported only if the error is above this multiple of the noise floor, which is itself
/// uncertain by that much (docs/theory.md, "Noise floor").
constexpr double kAboveFloor = 1.15;

bool above_floor(const Diagnosis& diagnosis) {
  return diagnosis.explained.holdout_rmse_N > kAboveFloor * diagnosis.noise_floor_N;
}

/// Structure is reported only if it explains this share of the residual's rms. Chosen.
constexpr double kStructureReduction = 0.05;

/// The structure to report: the strongest, or a line above the bandwidth of the rows if that explains more;
/// else a burst, even where the residual at the rows hardly shows it.
std::optional<Structure> structure_to_report(const Measurement& measurement, const Diagnosis& diagnosis,
                                             const Structure& strongest) {
  std::optional<Structure> reported;
  if (above_floor(diagnosis) && strongest.error_reduction >= kStructureReduction) reported = strongest;
  const FittedModel& last = diagnosis.explained;
  auto line = line_beyond_rows(measurement, last.linearisation->sample_force_N(), last.train_rmse_N);
  const double known = reported ? reported->error_reduction : kStructureReduction;
  if (line && line->error_reduction >= known) reported = std::move(line);
  if (!reported) reported = burst_in_force(measurement, weighted_residual(measurement, last));
  return reported;
}

/// Far above the noise floor: with a good force sensor, models of real axes reach this multiple of it.
constexpr double kFarAboveFloor = 4.0;
/// A model is not complete if it leaves this share of the force, far above the noise floor; nor if it leaves
/// this multiple of the noise floor, whatever the share, because moves of large forces dominate the share.
/// Chosen on logs of tests/bench/blind/stranger_generator.py.
constexpr double kIncomplete = 0.02;
constexpr double kNeverComplete = 12.0;

/// Whether too much is left, in whatever form, to call the model complete.
bool far_from_complete(const Diagnosis& diagnosis) {
  const double above_floor = diagnosis.explained.holdout_rmse_N / diagnosis.noise_floor_N;
  return above_floor > kNeverComplete ||
         (diagnosis.explained.relative_error > kIncomplete && above_floor > kFarAboveFloor);
}

/// An explanation that leaves more than these shares of the force and of the baseline's error is
/// insufficient. Models of real axes leave a few per cent of the force, far above the noise floor of a good
/// sensor.
constexpr double kLargeShareOfForce = 0.06;
constexpr double kMostOfBaseline = 0.35;

/// Whether the explanation is insufficient by every measure: far above the noise floor, a large share of the
/// force, and much of the baseline's error. The effects that it names then only approximate something else.
bool insufficient(const Diagnosis& diagnosis) {
  const FittedModel& last = diagnosis.explained;
  return last.relative_error > kLargeShareOfForce &&
         last.holdout_rmse_N > kFarAboveFloor * diagnosis.noise_floor_N &&
         last.holdout_rmse_N > kMostOfBaseline * diagnosis.baseline.holdout_rmse_N;
}

/// An effect that instruments may have caused is mentioned if it lowers the baseline's error by this share.
/// Chosen.
constexpr double kLeastRemarked = 0.1;
/// Of candidates whose errors differ by less than this factor, the one of fewer parameters is mentioned.
constexpr double kNearlyEqual = 1.05;

/// Whether the candidate lowers the baseline's error enough for a remark, and is no larger than errors of
/// clocks and sensors can be.
bool instruments_may_cause(const Measurement& measurement, const FittedModel& baseline,
                           const Candidate& candidate) {
  const double step_N2 = explained_N2(baseline.holdout_rmse_N, candidate.holdout_rmse_N);
  return candidate.error_reduction >= kLeastRemarked &&
         within_instruments(baseline, measurement.tick_s(), baseline.terms, candidate.terms, step_N2);
}

/// A remark for the case that no effect is named: the candidate that lowers the error most, if it is no
/// larger than errors of clocks and sensors. Without it the reader would look for a fault of the axis.
std::string instruments_behind(const Measurement& measurement, const Diagnosis& diagnosis) {
  const Candidate* described = nullptr;
  for (const Candidate& candidate : diagnosis.candidates) {
    const bool near =
        described == nullptr || candidate.holdout_rmse_N < kNearlyEqual * described->holdout_rmse_N;
    if (!near || !instruments_may_cause(measurement, diagnosis.baseline, candidate)) break;
    if (described == nullptr ||
        candidate.term.effect->parameter_count() < described->term.effect->parameter_count()) {
      described = &candidate;
    }
  }
  if (described == nullptr) return {};
  const double lowered = 1.0 - described->holdout_rmse_N / diagnosis.baseline.holdout_rmse_N;
  return fmt::format(
      "; {} would lower the error by {:.0f} %, but is no larger than what clocks and sensors err: {}",
      described->term.id(), 100.0 * lowered, described->evidence);
}

/// The verdict where effects were named: whether a confounder explains the log better. `strongest`: what is
/// reported where the confounder has no description of its own.
void judge_named(const Measurement& measurement, const Structure& strongest, Diagnosis& diagnosis) {
  const auto attribute_to = [&](std::optional<Structure> confounder) {
    if (!confounder) return false;
    diagnosis.verdict = Verdict::unexplained;
    diagnosis.unexplained = std::move(confounder);
    return true;
  };
  diagnosis.verdict = Verdict::missing_effect;
  if (above_floor(diagnosis) && diagnosis.unexplained) attribute_to(curve_behind_all(measurement, diagnosis));
  if (insufficient(diagnosis) || line_masks_effects(measurement, diagnosis) ||
      backlash_as_coulomb(diagnosis)) {
    attribute_to(diagnosis.unexplained ? diagnosis.unexplained : strongest);
  }
  attribute_to(mass_of_another_axis(measurement, diagnosis));
}

/// The verdict where causes outside the catalogue compete with the effects: the stronger of both.
void judge_beside_causes(const Measurement& measurement, Diagnosis& diagnosis) {
  diagnosis.unexplained = diagnosis.outside.causes.front();
  const bool named = diagnosis.steps.size() > 1 && !diagnosis.outside.explain_most;
  diagnosis.verdict = named ? Verdict::missing_effect : Verdict::unexplained;
  auto wrong_unit = mass_of_another_axis(measurement, diagnosis);
  if (!wrong_unit) return;
  diagnosis.unexplained = std::move(wrong_unit);
  diagnosis.verdict = Verdict::unexplained;
}

/// The verdict by the residual of the explanation.
void judge_by_what_is_left(const Measurement& measurement, Diagnosis& diagnosis) {
  const std::vector<Structure> left = structure_left(measurement, diagnosis);
  diagnosis.unexplained = structure_to_report(measurement, diagnosis, left.front());
  if (diagnosis.steps.size() > 1) {
    judge_named(measurement, left.front(), diagnosis);
    return;
  }
  if (!diagnosis.unexplained && far_from_complete(diagnosis)) diagnosis.unexplained = left.front();
  if (diagnosis.unexplained) diagnosis.unexplained->description += instruments_behind(measurement, diagnosis);
  diagnosis.verdict = diagnosis.unexplained ? Verdict::unexplained : Verdict::complete;
}

}  // namespace

void judge(const Measurement& measurement, Diagnosis& diagnosis) {
  if (diagnosis.outside.causes.empty()) {
    judge_by_what_is_left(measurement, diagnosis);
  } else {
    judge_beside_causes(measurement, diagnosis);
  }
  auto lost = lost_counts(measurement);
  if (!lost) return;
  // Jumps are reported first: any dependence on the position may be caused by them.
  if (diagnosis.unexplained) lost->description += "; besides, " + diagnosis.unexplained->description;
  diagnosis.unexplained = std::move(lost);
  if (diagnosis.verdict == Verdict::complete) diagnosis.verdict = Verdict::unexplained;
}

}  // namespace slipstack::workbench
