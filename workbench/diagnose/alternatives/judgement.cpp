// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/judgement.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "workbench/diagnose/alternatives/bursts.h"
#include "workbench/diagnose/alternatives/confounders.h"
#include "workbench/diagnose/alternatives/lines.h"
#include "workbench/diagnose/alternatives/lost_counts.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/diagnose/evidence/significance.h"

namespace slipstack::workbench {
namespace {

/// The encoder's steps are loudest at reversals: what is left there is play only so far above the floor.
constexpr double kBacklashAboveFloor = 1.6;

/// Everything that the explanation leaves, the strongest first.
std::vector<Structure> structure_left(const Measurement& measurement, const Diagnosis& diagnosis) {
  auto left = find_structure(measurement, weighted_residual(measurement, diagnosis.explained));
  if (diagnosis.explained.holdout_rmse_N < kBacklashAboveFloor * diagnosis.noise_floor_N) {
    std::erase_if(left, [](const Structure& one) { return one.coordinate == Coordinate::reversal; });
  }
  return left;
}

/// How far above the floor an error must be for structure to be reported.
constexpr double kAboveFloor = 1.15;

bool above_floor(const Diagnosis& diagnosis) {
  return diagnosis.explained.holdout_rmse_N > kAboveFloor * diagnosis.noise_floor_N;
}

/// What structure must explain of the residual to be reported.
constexpr double kStructureReduction = 0.05;

/// What of it is worth a word: the strongest, or a line above the rows' bandwidth that is stronger; a burst,
/// however little of it is heard at the rows.
std::optional<Structure> is_notable(const Measurement& measurement, const Diagnosis& diagnosis,
                                    const Structure& strongest) {
  std::optional<Structure> described;
  if (above_floor(diagnosis) && strongest.error_reduction >= kStructureReduction) described = strongest;
  const FittedModel& last = diagnosis.explained;
  auto line = line_beyond_rows(measurement, last.linearisation->sample_force_N(), last.train_rmse_N);
  const double known = described ? described->error_reduction : kStructureReduction;
  if (line && line->error_reduction >= known) described = std::move(line);
  if (!described) described = burst_in_force(measurement, weighted_residual(measurement, last));
  return described;
}

/// So many times the floor: real axes end there with a good force sensor.
constexpr double kFarAboveFloor = 4.0;
/// A model that leaves this share of the force, far above the floor, is not complete; nor one that leaves so
/// many times the floor, whatever the share: moves that take great forces hide all others.
constexpr double kIncomplete = 0.02;
constexpr double kNeverComplete = 12.0;

/// Whether so much is left, whatever its form, that calling the model complete would be wrong.
bool far_from_complete(const Diagnosis& diagnosis) {
  const double above_floor = diagnosis.explained.holdout_rmse_N / diagnosis.noise_floor_N;
  return above_floor > kNeverComplete ||
         (diagnosis.explained.relative_error > kIncomplete && above_floor > kFarAboveFloor);
}

/// An explanation that leaves so much explains nothing: share of the force, share of what the baseline left.
/// Real axes end at a few per cent of the force, far above the floor of a good force sensor.
constexpr double kFairShareOfForce = 0.06;
constexpr double kMostOfBaseline = 0.35;

/// Whether the best explanation leaves the axis unexplained by any measure: far above the floor, a fair share
/// of the force, and most of what the baseline left. What it names is then a stand-in for something else.
bool insufficient(const Diagnosis& diagnosis) {
  const FittedModel& last = diagnosis.explained;
  return last.relative_error > kFairShareOfForce &&
         last.holdout_rmse_N > kFarAboveFloor * diagnosis.noise_floor_N &&
         last.holdout_rmse_N > kMostOfBaseline * diagnosis.baseline.holdout_rmse_N;
}

/// What instruments may have done is told where it explains this share of the baseline's error.
constexpr double kInstrumentsTold = 0.1;
/// ... and so many standard errors of it: a remark needs less than a name.
constexpr double kSureEnoughToTell = 2.0;
/// Of two that say nearly the same, so much more error, the one of fewer parameters.
constexpr double kNearlyTheSame = 1.05;

/// Whether the candidate lowers the baseline's error beyond chance and by enough for a word, and is no larger
/// than clocks and sensors err.
bool instruments_may_do(const Measurement& measurement, const FittedModel& baseline,
                        const Candidate& candidate) {
  const Reduction reduced = reduction(baseline.block_squared_error, candidate.block_squared_error);
  const double step_N2 = explained_N2(baseline.holdout_rmse_N, candidate.holdout_rmse_N);
  return reduced.value >= kInstrumentsTold && reduced.is_significant(kSureEnoughToTell) &&
         within_instruments(baseline, measurement.tick_s(), baseline.terms, candidate.terms, step_N2);
}

/// Without a name: what lowers the error most, where it is no larger than clocks and sensors err. Who reads
/// of its symptoms alone would look for a fault of the axis.
std::string instruments_behind(const Measurement& measurement, const Diagnosis& diagnosis) {
  const Candidate* described = nullptr;
  for (const Candidate& candidate : diagnosis.candidates) {
    const bool near =
        described == nullptr || candidate.holdout_rmse_N < kNearlyTheSame * described->holdout_rmse_N;
    if (!near || !instruments_may_do(measurement, diagnosis.baseline, candidate)) break;
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

/// Effects were named: whether they hold. `strongest`: structure left, where the reason has none of its own.
void judge_named(const Measurement& measurement, const Structure& strongest, Diagnosis& diagnosis) {
  const auto blame = [&](std::optional<Structure> stood_in_for) {
    if (!stood_in_for) return false;
    diagnosis.verdict = Verdict::unexplained;
    diagnosis.unexplained = std::move(stood_in_for);
    return true;
  };
  diagnosis.verdict = Verdict::missing_effect;
  if (above_floor(diagnosis) && diagnosis.unexplained) blame(curve_behind_all(measurement, diagnosis));
  if (!blame(line_as_resonance(measurement, diagnosis)) &&
      (insufficient(diagnosis) || line_causes_mode(diagnosis) || line_masks_effects(measurement, diagnosis) ||
       backlash_as_coulomb(diagnosis))) {
    blame(diagnosis.unexplained ? diagnosis.unexplained : strongest);
  }
  blame(mass_of_another_axis(measurement, diagnosis));
}

/// By what the explanation leaves.
void judge_by_what_is_left(const Measurement& measurement, Diagnosis& diagnosis) {
  const std::vector<Structure> left = structure_left(measurement, diagnosis);
  diagnosis.unexplained = is_notable(measurement, diagnosis, left.front());
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
  judge_by_what_is_left(measurement, diagnosis);
  auto lost = lost_counts(measurement);
  if (!lost) return;
  // It comes before all else that is left: what depends on the position may depend on the jumps.
  if (diagnosis.unexplained) lost->description += "; besides, " + diagnosis.unexplained->description;
  diagnosis.unexplained = std::move(lost);
  if (diagnosis.verdict == Verdict::complete) diagnosis.verdict = Verdict::unexplained;
}

}  // namespace slipstack::workbench
