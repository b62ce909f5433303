// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "workbench/base/parallel.h"
#include "workbench/base/quantity.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/alternatives/bursts.h"
#include "workbench/diagnose/alternatives/confounders.h"
#include "workbench/diagnose/alternatives/impacts.h"
#include "workbench/diagnose/alternatives/lost_counts.h"
#include "workbench/diagnose/alternatives/ringing.h"
#include "workbench/diagnose/alternatives/spectral_line.h"
#include "workbench/diagnose/candidates.h"
#include "workbench/diagnose/evidence/criterion.h"
#include "workbench/diagnose/evidence/naming_rule.h"
#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/measurement/plausibility.h"
#include "workbench/estimate/nonlinear/fit_gains.h"

namespace slipstack::workbench {
namespace {

/// All structure in the residual of the explanation, the strongest first. Encoder steps and a virgin curve of
/// another form leave most at reversals: what comes after them is reported only where the error is above all
/// that.
std::vector<Structure> structure_left(const Measurement& measurement, const Diagnosis& diagnosis) {
  auto left = find_structure(measurement, weighted_residual(measurement, diagnosis.explained));
  if (diagnosis.explained.holdout_rmse_N < kFormIsNotTheAxis * diagnosis.noise_floor_N) {
    std::erase_if(left, [](const Structure& one) { return one.coordinate == Coordinate::reversal; });
  }
  return left;
}

/// Structure is reported only if it explains this share of the residual's rms: of the residual of a complete
/// model, as the encoder leaves it, curves and lines explain up to 4 %.
constexpr double kStructureReduction = 0.05;

bool above_floor(const Measurement& measurement, const Diagnosis& diagnosis) {
  return is_above_floor(measurement, diagnosis.explained);
}

/// A line above the bandwidth of the rows, or else what rings there, if it is worth being told.
std::optional<Structure> above_bandwidth(const Measurement& measurement, const Diagnosis& diagnosis) {
  const FittedModel& last = diagnosis.explained;
  auto found = line_beyond_rows(measurement, last.linearisation->sample_force_N(), last.train_rmse_N);
  if (!found) found = ringing_beyond_rows(measurement, last);
  if (found && found->error_reduction < kStructureReduction) found.reset();
  return found;
}

/// What is seen in the residual of the explanation and in the readings, whatever the verdict.
struct Observations {
  std::vector<Structure> left;     ///< structure_left()
  std::optional<Structure> above;  ///< above_bandwidth()
  std::optional<Structure> lost;   ///< lost_counts()
  std::vector<InputWarning> input_warnings;
};

Observations observe(const Measurement& measurement, const Diagnosis& diagnosis) {
  Observations seen;
  run_together([&] { seen.left = structure_left(measurement, diagnosis); },
               [&] { seen.above = above_bandwidth(measurement, diagnosis); },
               [&] { seen.input_warnings = input_warnings(measurement); },
               [&] { seen.lost = lost_counts(measurement); });
  return seen;
}

/// The structure to report of what is seen: the strongest, or what is above the bandwidth of the rows if that
/// explains more; else impacts or a burst, even where the residual at the rows hardly shows them. At the
/// floor nothing but moments: neither noise nor the encoder's steps hold most of their square in so few, so
/// the floor was taken from what happens then.
std::optional<Structure> structure_to_report(const Measurement& measurement, const Diagnosis& diagnosis,
                                             const Observations& seen) {
  const bool at_floor = !above_floor(measurement, diagnosis);
  const auto found = std::find_if(seen.left.begin(), seen.left.end(), [&](const Structure& one) {
    return one.error_reduction >= kStructureReduction && (!at_floor || one.only_where);
  });
  std::optional<Structure> reported;
  if (found != seen.left.end()) reported = *found;
  if (seen.above && (!reported || seen.above->error_reduction >= reported->error_reduction))
    reported = seen.above;
  if (!reported) reported = impacts_in_drive(measurement);
  if (!reported) {
    const FittedModel& last = diagnosis.explained;
    reported = burst_in_force(measurement, last.linearisation->sample_force_N(),
                              weighted_residual(measurement, last));
  }
  return reported;
}

/// The force (rms) of all samples, as the errors are: that of an excerpt may be another.
double force_of_logs_N(const Diagnosis& diagnosis) {
  return diagnosis.baseline.train_rmse_N / std::max(diagnosis.baseline.relative_error, 1e-300);
}

bool is_large(const Diagnosis& diagnosis, double discrepancy_N) {
  return discrepancy_N > diagnosis.noise_floor_N &&
         discrepancy_N > kLargeShareOfForce * force_of_logs_N(diagnosis);
}

/// Whether the named effects only approximate something else: they explain less than half of what the
/// baseline leaves beyond the noise, and what is left is large.
bool insufficient(const Diagnosis& diagnosis) {
  return is_large(diagnosis, discrepancy_N(diagnosis.explained, diagnosis.noise_floor_N)) &&
         !explains_most(diagnosis.baseline.holdout_rmse_N, diagnosis.explained.holdout_rmse_N,
                        diagnosis.noise_floor_N);
}

/// Whether the named effects, fitted to the first two thirds of the log, leave more of the last one than the
/// baseline does, by a share that is worth a name: what they claim does not hold there. Only where the axis
/// was before: of places where it was not a map knows nothing. Where the baseline is near the floor there,
/// nothing follows; nor where they explain most of the last third once some of its blocks are seen: they hold
/// there too, and the first two do not determine them (a pitch, by which the axis goes on).
bool does_not_hold_later(const Diagnosis& diagnosis) {
  const FittedModel& with = diagnosis.explained;
  const FittedModel& without = diagnosis.baseline;
  const double before_N = without.forward_within_travel_N;
  return diagnosis.steps.size() > 1 && is_worth_a_name(with.forward_within_travel_N, before_N) &&
         before_N > kFormIsNotTheAxis * diagnosis.noise_floor_N &&
         !explains_most(without.last_third_holdout_rmse_N, with.last_third_holdout_rmse_N, 0.0);
}

/// What is said of effects that do not hold later; of others nothing.
std::string later_text(const Diagnosis& diagnosis) {
  if (!does_not_hold_later(diagnosis)) return {};
  const std::string leaves = quantity(diagnosis.explained.forward_within_travel_N, "N");
  const bool everywhere = leaves == quantity(diagnosis.explained.forward_rmse_N, "N");
  return fmt::format(
      "; in the last third of the log, predicted by a fit to the first two, what was chosen "
      "leaves {}, the baseline {}{}",
      leaves, quantity(diagnosis.baseline.forward_within_travel_N, "N"),
      everywhere ? "" : ", where the axis was before");
}

/// Whether an effect that was refused leaves, alone, far less than the named ones together, which then
/// imitate what it describes. At the floor there is nothing to describe: a mode smooths the noise of the
/// encoder. Nor does the special case of an effect imitate it: a payload is what a mode is that nobody sees
/// swing.
bool far_better_alone(const Measurement& measurement, const Diagnosis& diagnosis) {
  if (!above_floor(measurement, diagnosis)) return false;
  const double named_N = diagnosis.explained.holdout_rmse_N;
  const auto is_named = [&](std::string_view id) { return contains(diagnosis.explained.terms, id); };
  return std::any_of(diagnosis.candidates.begin(), diagnosis.candidates.end(),
                     [&](const Candidate& candidate) {
                       const EffectDescription& effect = *candidate.term.effect;
                       return is_supported(candidate.criterion_difference) && !is_named(effect.text.id) &&
                              !is_named(effect.traits.special_case.id) &&
                              squared(candidate.holdout_rmse_N) < kMajority * squared(named_N);
                     });
}

/// Whether the candidate on the baseline is too small for a name.
bool is_too_small_alone(const Measurement& measurement, const FittedModel& baseline,
                        const Candidate& candidate) {
  const double step_N2 = explained_N2(baseline.holdout_rmse_N, candidate.holdout_rmse_N);
  return is_too_small(measurement, baseline, baseline.terms, candidate.terms, step_N2);
}

/// Whether the candidate would be worth a name, but is too small for one.
bool would_be_named_if_larger(const Measurement& measurement, const FittedModel& baseline,
                              const Candidate& candidate) {
  return candidate.error_reduction >= kLeastReduction &&
         is_too_small_alone(measurement, baseline, candidate) &&
         !is_implausible_alone(measurement, baseline, candidate);
}

/// "61.9 +- 3.2 %": two standard errors to either side.
std::string lowered_by(const Candidate& candidate) {
  return quantity_with_interval(candidate.error_reduction, 2.0 * candidate.error_reduction_se, "1");
}

/// A remark for the case that no effect is named: the candidate of the best criterion, if it is too small for
/// a name. Without it the reader would look for a fault of the axis.
std::string too_small_alone(const Measurement& measurement, const Diagnosis& diagnosis) {
  const auto best = std::min_element(
      diagnosis.candidates.begin(), diagnosis.candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.criterion_difference < b.criterion_difference; });
  if (best == diagnosis.candidates.end() ||
      !would_be_named_if_larger(measurement, diagnosis.baseline, *best)) {
    return {};
  }
  return fmt::format("; {} would lower the error by {}, but is no larger than {}: {}", best->term.id(),
                     lowered_by(*best), kTooSmall, best->evidence);
}

/// The same where effects are named.
std::string too_small_beside_others(const Diagnosis& diagnosis) {
  if (!diagnosis.withheld) return {};
  return fmt::format("; with {} too the held-out error is {}, but it is no larger than {}: {}",
                     diagnosis.withheld->effect, quantity(diagnosis.withheld->holdout_rmse_N, "N"), kTooSmall,
                     diagnosis.withheld->evidence);
}

/// The candidate of lowest error among those that the log supports and that lower the error by a share that
/// is worth a name; without those that `is_left_out`. Null where there is none.
template <class IsLeftOut>
const Candidate* best_supported(const std::vector<Candidate>& candidates, IsLeftOut&& is_left_out) {
  const Candidate* best = nullptr;
  for (const Candidate& one : candidates) {
    if (!is_supported(one.criterion_difference) || one.error_reduction < kLeastReduction) continue;
    if (is_left_out(one)) continue;
    if (best == nullptr || one.holdout_rmse_N < best->holdout_rmse_N) best = &one;
  }
  return best;
}

/// A remark for the case that no effect is named, although the log supports one that lowers the error by a
/// share that is worth a name: the table of candidates shows it.
std::string passed_over(const Measurement& measurement, const Diagnosis& diagnosis) {
  // Of an effect that was chosen the text says it all.
  const Candidate* const best = best_supported(diagnosis.candidates, [&](const Candidate& one) {
    return contains(diagnosis.explained.terms, one.term.effect->text.id);
  });
  if (best == nullptr) return {};
  const std::string would =
      fmt::format("; {} alone would lower the error by {}", best->term.id(), lowered_by(*best));
  if (is_implausible_alone(measurement, diagnosis.baseline, *best))
    return would + ", but as fitted it is not plausible: " + best->evidence;
  return is_too_small_alone(measurement, diagnosis.baseline, *best)
             ? fmt::format("{}, but it is no larger than {}: {}", would, kTooSmall, best->evidence)
             : would;
}

/// The verdict where effects were named: whether a confounder explains the log better. `strongest`: what is
/// reported where the confounder has no description of its own.
void judge_named(const Measurement& measurement, const Structure& strongest, Diagnosis& diagnosis) {
  std::optional<Structure> confounder;
  if (above_floor(measurement, diagnosis) && diagnosis.unexplained)
    confounder = curve_behind_all(measurement, diagnosis);
  if (insufficient(diagnosis) || does_not_hold_later(diagnosis) || far_better_alone(measurement, diagnosis))
    confounder = diagnosis.unexplained.value_or(strongest);
  if (confounder) confounder->description += later_text(diagnosis) + passed_over(measurement, diagnosis);
  if (auto wrong_unit = mass_of_another_axis(measurement, diagnosis)) confounder = std::move(wrong_unit);
  diagnosis.verdict = confounder ? Verdict::unexplained : Verdict::missing_effect;
  if (confounder) diagnosis.unexplained = std::move(confounder);
}

/// Whether it explains more than half of the error (mean square), or tells when the axis makes it.
bool holds_most(const Structure& one) {
  return explains_most(1.0, 1.0 - one.error_reduction, 0.0);
}

/// Whether it may take the place of a cause that explains less than half of the error (mean square), because
/// it says when the axis makes the error: moments are few, and reversals must hold most of it.
bool tells_when(const Structure& one, const Structure& cause) {
  return one.only_where && one.coordinate != cause.coordinate && !holds_most(cause) &&
         (one.coordinate == Coordinate::time || holds_most(one));
}

/// A free curve over time follows a slow motion, and so whatever depends on it: where a free curve over
/// another coordinate explains more of what the effects leave, that is told in its place; and in place of a
/// cause of which no value is larger than its interval whatever explains most, unless the cause is such a
/// curve and explains most itself; and what tells_when(), where it holds more than the cause explains: a
/// cause that explains most is what happens then (a narrow bump that is passed quickly). Returns whether what
/// is first now tells anything.
bool prefer_other_structure(const std::vector<Structure>& left, Diagnosis& diagnosis) {
  Structure& cause = diagnosis.outside.causes.front();
  const bool says_something = cause.determined || (cause.free_curve && holds_most(cause));
  for (const Structure& one : left) {
    if (!says_something && one.error_reduction >= kStructureReduction) {
      cause = one;
      return true;
    }
    const bool of_motion = one.coordinate == Coordinate::position || one.coordinate == Coordinate::velocity ||
                           one.coordinate == Coordinate::acceleration;
    const bool other = tells_when(one, cause) || (of_motion && (cause.free_curve || !says_something));
    if (!other || one.error_reduction <= cause.error_reduction) continue;
    cause = one;
    return true;
  }
  return says_something;
}

/// The strongest cause outside the catalogue, beside what is above the bandwidth of the rows, where neither
/// effects nor causes are searched.
Structure cause_and_what_is_above(const Diagnosis& diagnosis, std::optional<Structure> other) {
  Structure first = diagnosis.outside.causes.front();
  if (!other) return first;
  if (other->error_reduction > first.error_reduction) std::swap(first, *other);
  first.description += "; besides, " + other->description;
  return first;
}

/// The verdict where causes outside the catalogue compete with the effects: the stronger of both, and none of
/// the effects where they explain less than half and leave much (unless that is the form of the friction).
void judge_beside_causes(const Measurement& measurement, const Observations& seen, Diagnosis& diagnosis) {
  const bool tells = prefer_other_structure(seen.left, diagnosis);
  const OutsideCauses& outside = diagnosis.outside;
  const bool named = diagnosis.steps.size() > 1 && !outside.explain_most &&
                     (outside.replace_friction || !insufficient(diagnosis)) &&
                     !does_not_hold_later(diagnosis);
  if (!named && !tells) diagnosis.outside.causes.front() = seen.left.front();
  diagnosis.unexplained =
      tells || !named ? std::optional(cause_and_what_is_above(diagnosis, seen.above)) : seen.above;
  diagnosis.verdict = named ? Verdict::missing_effect : Verdict::unexplained;
  if (!named) {
    diagnosis.unexplained->description += later_text(diagnosis) + passed_over(measurement, diagnosis);
  }
  auto wrong_unit = mass_of_another_axis(measurement, diagnosis);
  if (!wrong_unit) return;
  diagnosis.unexplained = std::move(wrong_unit);
  diagnosis.verdict = Verdict::unexplained;
}

/// The verdict by the residual of the explanation.
void judge_by_what_is_left(const Measurement& measurement, const Observations& seen, Diagnosis& diagnosis) {
  diagnosis.unexplained = structure_to_report(measurement, diagnosis, seen);
  if (diagnosis.steps.size() > 1) {
    judge_named(measurement, seen.left.front(), diagnosis);
    if (diagnosis.unexplained) diagnosis.unexplained->description += too_small_beside_others(diagnosis);
    return;
  }
  const double discrepancy = discrepancy_N(diagnosis.explained, diagnosis.noise_floor_N);
  if (!diagnosis.unexplained && is_large(diagnosis, discrepancy)) diagnosis.unexplained = seen.left.front();
  if (diagnosis.unexplained) {
    const std::string too_small = too_small_alone(measurement, diagnosis);
    diagnosis.unexplained->description += too_small.empty() ? passed_over(measurement, diagnosis) : too_small;
  }
  diagnosis.verdict = diagnosis.unexplained ? Verdict::unexplained : Verdict::complete;
}

/// An input that contradicts physics is reported first: effects of a model that was fitted to it are no
/// findings, whatever they explain.
void judge_input(const Measurement& measurement, std::vector<InputWarning> warnings, Diagnosis& diagnosis) {
  diagnosis.input_warnings = std::move(warnings);
  if (diagnosis.input_warnings.empty()) return;
  Structure cause{Coordinate::acceleration, 0.0, 0.0, diagnosis.input_warnings.front().what,
                  weighted_residual(measurement, diagnosis.baseline)};
  diagnosis.unexplained = std::move(cause);
  diagnosis.verdict = Verdict::unexplained;
}

/// Why a candidate that the log supports is no step.
Refusal refusal_of(const Measurement& measurement, const Diagnosis& diagnosis, const Candidate& candidate) {
  if (!above_floor(measurement, diagnosis)) return Refusal::at_floor;
  if (is_implausible_alone(measurement, diagnosis.baseline, candidate)) return Refusal::implausible;
  return is_too_small_alone(measurement, diagnosis.baseline, candidate) ? Refusal::too_small
                                                                        : Refusal::superfluous;
}

}  // namespace

void judge(const Measurement& measurement, Diagnosis& diagnosis) {
  Observations seen = observe(measurement, diagnosis);
  if (diagnosis.outside.causes.empty()) {
    judge_by_what_is_left(measurement, seen, diagnosis);
  } else {
    judge_beside_causes(measurement, seen, diagnosis);
  }
  if (seen.lost) {
    // Jumps are reported first: any dependence on the position may be caused by them.
    if (diagnosis.unexplained) seen.lost->description += "; besides, " + diagnosis.unexplained->description;
    diagnosis.unexplained = std::move(seen.lost);
    if (diagnosis.verdict == Verdict::complete) diagnosis.verdict = Verdict::unexplained;
  }
  judge_input(measurement, std::move(seen.input_warnings), diagnosis);
}

void note_refusal(const Measurement& measurement, Diagnosis& diagnosis) {
  const auto is_step = [&](const Candidate& one) {
    return std::any_of(diagnosis.steps.begin(), diagnosis.steps.end(),
                       [&](const Step& step) { return step.effect == one.term.id(); });
  };
  const Candidate* const best = best_supported(diagnosis.candidates, is_step);
  if (best == nullptr) return;
  diagnosis.candidates[static_cast<std::size_t>(best - diagnosis.candidates.data())].refusal =
      refusal_of(measurement, diagnosis, *best);
}

}  // namespace slipstack::workbench
