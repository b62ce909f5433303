// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/plausibility.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "workbench/base/statistics.h"
#include "workbench/diagnose/alternatives/cause_forms.h"
#include "workbench/diagnose/alternatives/spectral_line.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/implausible_causes.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/diagnose/evidence/repeats.h"
#include "workbench/diagnose/evidence/seldom_negative.h"
#include "workbench/estimate/linear/force_trace.h"
#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/estimate/terms/terms.h"
#include "workbench/estimate/uncertainty/encoder_realisations.h"
#include "workbench/model/effect_adapters/firmware_effects.h"

namespace slipstack::workbench {
namespace {

/// What rounding changes of a bound: that of a gain whose sum with another is bounded, and of a time.
constexpr double kRounding = 1e-9;

/// Whether a term of `model` that the baseline does not have changes the dry friction by an implausible
/// factor at any row: at samples that no row uses, the first and the last, the acceleration is not known.
bool changes_friction_too_much(const Measurement& measurement, const FittedModel& baseline,
                               const FittedModel& model) {
  const auto is_new_modulation = [&](const Term& term) {
    return acts_with_gains(term, Acts::dry_scale) && !contains(baseline.terms, term.effect->text.id);
  };
  if (std::none_of(model.terms.begin(), model.terms.end(), is_new_modulation)) return false;
  // Some modulations depend on the sign of the dry friction.
  const std::vector<double>* const dry_N =
      model.linearisation == nullptr ? nullptr : &model.linearisation->sample_dry_N();
  const DryTrace trace = evaluate_dry(measurement, model.terms, dry_N);
  for (std::size_t t = 0; t < model.terms.size(); ++t) {
    if (!is_new_modulation(model.terms[t])) continue;
    const Eigen::VectorXd factors = at_rows(measurement, trace.dry_scales[t]);
    if (factors.minCoeff() * kMostChange <= 1.0 || factors.maxCoeff() >= kMostChange) return true;
  }
  return false;
}

/// Of a map that scales the dry friction the values are tested (changes_friction_too_much()): its gains are
/// those of splines, so that one of them at its bound is no value at a bound.
bool ends_at_a_bound(const FittedModel& model, const Term& term) {
  if (term.effect->has_shape(ShapeKind::travel) && acts_with_gains(term, Acts::dry_scale)) return false;
  for (std::size_t gain = 0; gain < term.gains.size(); ++gain) {
    if (gain_ended_at_bound(model.terms, term, gain)) return true;
  }
  return false;
}

/// Whether the search of a pitch or of a delay ended at an end of its range: it does not repeat within the
/// travel, or is no delay, and the bound determined it. Other
/// shapes have a meaning at an end: a memory without end in time or in distance, a friction that changes with
/// the sign of the velocity at once.
bool shape_ended_at_bound(const Measurement& measurement, const Term& term) {
  const auto ended = [&](const std::vector<ShapeRange>& ranges) {
    return std::any_of(ranges.begin(), ranges.end(), [&](const ShapeRange& range) {
      const double value = term.shapes[range.index];
      const ShapeKind kind = term.effect->shapes[range.index].kind;
      return ((kind == ShapeKind::pitch && !is_one_turn(value)) || kind == ShapeKind::delay) &&
             is_at_bound(range, value);
    });
  };
  return ended(searched_shapes(measurement, *term.effect)) ||
         ended(nominal_shapes(measurement, *term.effect));
}

/// Whether the term is a mode beyond the frequencies that the log can show: the search ended at one of them.
/// Far below its frequency a mode cannot be told from a payload or a delay, far above it from a stiffness.
bool is_mode_beyond_band(const Measurement& measurement, const Term& term) {
  if (!term.effect->has_role(Role::resonance)) return false;
  const std::vector<ShapeRange> ranges = searched_shapes(measurement, *term.effect);
  const ShapeRange* frequency = find_range(ranges, *term.effect, ShapeKind::frequency);
  return frequency != nullptr && is_at_bound(*frequency, term.shapes[frequency->index]);
}

/// The model with a payload in the place of its mode. Far below its frequency a mode is a payload.
FittedModel with_payload_for(const Measurement& measurement, const FittedModel& model, const Term& mode) {
  Terms rigid = without(model.terms, mode.id());
  if (!mass_is_free(rigid) && !has_role(rigid, Role::added_mass))
    rigid.push_back(make_term(measurement, effect_with_role(Role::added_mass)));
  return fit_gains(measurement, std::move(rigid), &model);
}

/// Whether the mode is above the band and explains most of what a payload in its place leaves beyond the
/// floor: then the log sees that it swings, though not at which frequency.
bool swings_unlike_payload(const Measurement& measurement, const FittedModel& model, const Term& mode) {
  if (mode.shape(ShapeKind::frequency).value() < measurement.bandwidth_Hz()) return false;
  const FittedModel rigid = with_payload_for(measurement, model, mode);
  return explains_most(rigid.holdout_rmse_N, model.holdout_rmse_N, measurement.noise_floor_N());
}

/// Whether most of what a mode explains beside `before`, as a force (rms), is rounding that it smooths.
bool smooths_rounding(const Measurement& measurement, const Terms& before, const Terms& after,
                      double step_N2) {
  return smoothed_rounding_N2(measurement, before, after) > squared(kMajority) * step_N2;
}

/// Whether the term is a mode of which the log does not see that it decays, so that it is any line.
bool is_mode_without_decay(const Measurement& measurement, const Term& term) {
  if (!term.effect->has_role(Role::resonance)) return false;
  const double rate_per_s = 2.0 * std::numbers::pi * term.shape(ShapeKind::frequency).value() *
                            term.shape(ShapeKind::damping).value();
  return rate_per_s * measurement.longest_log_s() < 1.0;
}

/// The force of a mode at the rows, without what moves with the axis [N].
Eigen::VectorXd swings_N(const Measurement& measurement, const FittedModel& model, std::size_t index) {
  const Eigen::VectorXd force_N = force_of(model, index);
  const Eigen::VectorXd acceleration_mps2 = at_rows(measurement, measurement.acceleration_mps2());
  return force_N - force_N.dot(acceleration_mps2) / std::max(acceleration_mps2.squaredNorm(), 1e-300) *
                       acceleration_mps2;
}

/// Whether most of what swings in the mode is one line of constant phase throughout the log: the axis
/// trembles under a force in time, and a lightly damped mode amplifies that. A mode that moves excite anew
/// loses its phase from one to the next.
bool is_line_in_time(const Measurement& measurement, const FittedModel& model, std::size_t index) {
  if (model.linearisation == nullptr || !model.terms[index].effect->has_role(Role::resonance)) return false;
  const Eigen::VectorXd force_N = swings_N(measurement, model, index);
  return squared(1.0 - line_at_rows(measurement, force_N).error_reduction) < kMajority;
}

/// Whether what swings in the mode moves the axis by no more than the encoder rounds. Not so where a payload
/// in its place explains most of what the mode does, which no rounding and no controller imitate, and the
/// mode more than the rounding beside.
bool is_within_rounding(const Measurement& measurement, const FittedModel& baseline, const FittedModel& model,
                        std::size_t index) {
  const Term& mode = model.terms[index];
  if (model.linearisation == nullptr || !mode.effect->has_role(Role::resonance)) return false;
  if (swings_N(measurement, model, index).squaredNorm() >
      rounded_motion_N2(measurement, model.terms) * static_cast<double>(measurement.row_count())) {
    return false;
  }
  const FittedModel rigid = with_payload_for(measurement, model, mode);
  return !explains_most(baseline.holdout_rmse_N, rigid.holdout_rmse_N, model.holdout_rmse_N) ||
         smooths_rounding(measurement, rigid.terms, model.terms,
                          explained_N2(rigid.holdout_rmse_N, model.holdout_rmse_N));
}

/// The measured force (rms) that a model was fitted to; 0 where it leaves nothing.
double measured_N(const FittedModel& model) {
  return model.relative_error > 0.0 ? model.train_rmse_N / model.relative_error : 0.0;
}

/// Whether a payload that the baseline does not have takes more than the whole mass from the axis in one of
/// the logs. A mass in a wrong unit is another mass, but none below zero.
bool has_negative_mass(const FittedModel& model, const FittedModel& baseline) {
  if (!has_role(model.terms, Role::added_mass) || has_role(baseline.terms, Role::added_mass)) return false;
  const std::size_t logs = find_role(model.terms, Role::added_mass)->gain_sets();
  for (std::size_t log = 0; log < logs; ++log) {
    if (mass_kg(model.terms, log) < 0.0) return true;
  }
  return false;
}

/// The mass that follows the axis far below the frequency of a mode.
double mass_below_mode_kg(const Terms& model, const Term& mode, std::size_t log) {
  const std::size_t set = mode.gain_sets() > 1 ? log * mode.gains_per_set() : 0;
  const auto rigid_gain = static_cast<std::size_t>(mode.effect->traits.axis_mass_gain);
  return mass_kg(model, log) + mode.gains[set + rigid_gain] + mode.gains[set];
}

/// The mean of `of_part` over the parts, by the weights of their rows.
template <class OfPart>
double mean_over_parts(const Measurement& measurement, OfPart&& of_part) {
  const Eigen::VectorXd& weights = measurement.row_weights();
  double sum = 0.0;
  for (const LogPart& part : measurement.parts()) {
    sum +=
        of_part(part) *
        weights.segment(static_cast<Eigen::Index>(part.first_row), static_cast<Eigen::Index>(part.row_count))
            .sum();
  }
  return sum / weights.sum();
}

/// Whether a new term of `model` is none, by `is_none`, which is also given its index.
template <class IsNone>
bool any_new(const FittedModel& model, const FittedModel& baseline, IsNone&& is_none) {
  for (std::size_t index = 0; index < model.terms.size(); ++index) {
    const Term& term = model.terms[index];
    if (!contains(baseline.terms, term.effect->text.id) && is_none(term, index)) return true;
  }
  return false;
}

}  // namespace

bool gain_ended_at_bound(const Terms& model, const Term& term, std::size_t gain) {
  const double value = term.gains[gain];
  if (value == 0.0 || term.lower[gain] == term.upper[gain]) return false;
  if (value == term.lower[gain] || value == term.upper[gain]) return true;
  const PartOfAnother& part = term.effect->traits.part_of_another;
  const Term* const whole = find_role(model, part.whole);
  if (part.gain < 0 || whole == nullptr || whole->gain_sets() != term.gain_sets() ||
      gain % term.gains_per_set() != static_cast<std::size_t>(part.gain)) {
    return false;
  }
  const double bound = whole->gains[gain / term.gains_per_set() * whole->gains_per_set()];
  return std::abs(value) >= (1.0 - kRounding) * std::abs(bound);
}

double least_named_N(const EffectDescription& effect, double measured_N, const Terms& model) {
  const double instruments_N = effect.traits.plausible.least_share_of_force * measured_N;
  const Term* const hysteresis = find_role(model, Role::hysteresis);
  const bool repeats = effect.has_shape(ShapeKind::pitch);
  if (hysteresis == nullptr || repeats || is_outside_catalogue(effect)) return instruments_N;
  return std::max(instruments_N, kFormLeaves * hysteresis_level_N(*hysteresis));
}

double smoothed_rounding_N2(const Measurement& measurement, const Terms& before, const Terms& after) {
  if (!has_role(after, Role::resonance)) return 0.0;
  const std::vector<double> rounding_N2 = rounding_through_masses_N2(measurement, {&before, &after});
  return std::max(0.0, rounding_N2[0] - rounding_N2[1]);
}

double rounded_motion_N2(const Measurement& measurement, const Terms& model) {
  const Term* const mode = find_role(model, Role::resonance);
  if (mode == nullptr) return 0.0;
  const double omega_per_s = 2.0 * std::numbers::pi * mode->shape(ShapeKind::frequency).value();
  const double rounding_mps2 =
      squared(omega_per_s) * measurement.encoder_resolution_m() * std::numbers::inv_sqrt3 / 2.0;
  return mean_over_parts(measurement, [&](const LogPart& part) {
    return squared(mass_below_mode_kg(model, *mode, part.log) * rounding_mps2);
  });
}

bool within_instruments(const Measurement& measurement, const FittedModel& baseline, const Terms& before,
                        const Terms& after, double step_N2) {
  if (!has_role(before, Role::resonance) && has_role(after, Role::resonance)) {
    const bool mass_is_shown = has_role(before, Role::added_mass);
    if (!mass_is_shown && rounded_motion_N2(measurement, after) > step_N2) return true;
    if (smooths_rounding(measurement, before, after, step_N2)) return true;
  }
  const double tick_s = measurement.tick_s();
  const double force_N = measured_N(baseline);
  return std::any_of(after.begin(), after.end(), [&](const Term& term) {
    if (contains(before, term.effect->text.id)) return false;
    const Plausibility& plausible = term.effect->traits.plausible;
    return std::abs(measurement_dynamics_of({term}).total_s()) < plausible.least_samples * tick_s ||
           step_N2 < squared(plausible.least_share_of_force * force_N);
  });
}

bool is_too_small(const Measurement& measurement, const FittedModel& baseline, const Terms& before,
                  const Terms& after, double step_N2) {
  if (within_instruments(measurement, baseline, before, after, step_N2)) return true;
  const double force_N = measured_N(baseline);
  return std::any_of(after.begin(), after.end(), [&](const Term& term) {
    return !contains(before, term.effect->text.id) &&
           step_N2 < squared(least_named_N(*term.effect, force_N, before));
  });
}

bool coulomb_is_of_hysteresis(const FittedModel& model, double floor_N) {
  const Term* coulomb = find_role(model.terms, Role::saturating_friction);
  const Term* hysteresis = find_role(model.terms, Role::hysteresis);
  if (coulomb == nullptr || hysteresis == nullptr) return false;
  const double level_N = hysteresis_level_N(*hysteresis);
  const double coulomb_N = std::abs(coulomb->gains[0]);
  return coulomb_N < coulomb->effect->traits.plausible.least_share_of_dry * (coulomb_N + level_N) ||
         model.holdout_rmse_N > kFormIsNotTheAxis * floor_N;
}

bool coulomb_is_of_sampling(const Measurement& measurement, const FittedModel& baseline,
                            const FittedModel& model) {
  if (!has_role(baseline.terms, Role::hysteresis)) return false;
  const std::vector<double>& with_N = model.linearisation->sample_force_N();
  const std::vector<double>& without_N = baseline.linearisation->sample_force_N();
  const std::vector<double>& velocity_mps = measurement.velocity_mps();
  const auto turns = [&](std::size_t i) { return velocity_mps[i - 1] * velocity_mps[i] <= 0.0; };
  double all_N2 = 0.0;
  double at_reversals_N2 = 0.0;
  for (std::size_t i = 1; i + 1 < velocity_mps.size(); ++i) {
    const double change_N2 = squared(with_N[i] - without_N[i]);
    all_N2 += change_N2;
    if (turns(i) || turns(i + 1)) at_reversals_N2 += change_N2;
  }
  return at_reversals_N2 > kMajority * all_N2;
}

bool lag_is_bristle_deflection(const FittedModel& model) {
  const Term* lag = find_role(model.terms, Role::friction_memory);
  const Term* hysteresis = find_role(model.terms, Role::hysteresis);
  if (lag == nullptr || hysteresis == nullptr) return false;
  const double velocity_mps = lag->shapes[0];
  const double time_s = lag->shapes[2];
  const double distance_m = lag->shapes[3];
  // At the Stribeck velocity the lag in distance is the faster one: it determines what is seen.
  return distance_m <= presliding_travel_m(*hysteresis) && distance_m <= time_s * velocity_mps;
}

bool lag_is_immediate(const Measurement& measurement, const FittedModel& model) {
  const Term* lag = find_role(model.terms, Role::friction_memory);
  if (lag == nullptr) return false;
  const double velocity_mps = lag->shapes[0];
  const double per_s = 1.0 / lag->shapes[2] + velocity_mps / lag->shapes[3];
  return per_s * lag->effect->traits.plausible.least_memory_s > 1.0 ||
         per_s * measurement.tick_s() >= 1.0 - kRounding;
}

bool lag_is_change_over_time(const Measurement& measurement, const FittedModel& model) {
  const Term* lag = find_role(model.terms, Role::friction_memory);
  if (lag == nullptr) return false;
  const double time_s = lag->shapes[2];
  const double distance_m = lag->shapes[3];
  const double velocity_mps = rms(measurement.velocity_mps());
  // The faster of both is what is seen.
  const double memory_s = 1.0 / (1.0 / time_s + velocity_mps / distance_m);
  const bool by_distance = distance_m < time_s * velocity_mps;
  return memory_s > lag->effect->traits.plausible.most_memory_s ||
         (by_distance && distance_m > kMajority * measurement.position_range_m().length());
}

bool has_implausible_mode(const Measurement& measurement, const FittedModel& baseline,
                          const FittedModel& model) {
  // Above the band a mode is a phase, as are a further pole of the filter and a rest of the delay.
  const bool delayed = has_role(model.terms, Role::measurement_delay);
  return (has_no_true_mode(model.terms) && !has_no_true_mode(baseline.terms)) ||
         any_new(model, baseline, [&](const Term& term, std::size_t index) {
           return (is_mode_beyond_band(measurement, term) &&
                   (delayed || !swings_unlike_payload(measurement, model, term))) ||
                  is_mode_without_decay(measurement, term) ||
                  is_within_rounding(measurement, baseline, model, index) ||
                  is_line_in_time(measurement, model, index);
         });
}

bool has_shape_at_bound(const Measurement& measurement, const FittedModel& baseline,
                        const FittedModel& model) {
  return any_new(model, baseline,
                 [&](const Term& term, std::size_t) { return shape_ended_at_bound(measurement, term); });
}

bool has_implausible_lag(const Measurement& measurement, const FittedModel& baseline,
                         const FittedModel& model) {
  return any_new(model, baseline, [&](const Term& term, std::size_t) {
    return term.effect->has_role(Role::friction_memory) &&
           (ends_at_a_bound(model, term) || lag_is_bristle_deflection(model) ||
            lag_is_immediate(measurement, model) || lag_is_change_over_time(measurement, model));
  });
}

bool is_implausible(const Measurement& measurement, const FittedModel& baseline, const FittedModel& model) {
  const bool has_new_coulomb = has_role(model.terms, Role::saturating_friction) &&
                               !has_role(baseline.terms, Role::saturating_friction);
  return any_new(model, baseline,
                 [&](const Term& term, std::size_t) {
                   return ends_at_a_bound(model, term) ||
                          is_doubtfully_negative(measurement, baseline, model, term);
                 }) ||
         changes_friction_too_much(measurement, baseline, model) || has_negative_mass(model, baseline) ||
         has_shape_at_bound(measurement, baseline, model) ||
         has_implausible_mode(measurement, baseline, model) || has_no_true_gap(measurement, model) ||
         has_no_true_bristle(measurement, model) || has_no_true_friction_ripple(measurement, model) ||
         has_one_ripple_twice(measurement, model.terms) || has_no_true_power(measurement, model) ||
         has_implausible_lag(measurement, baseline, model) ||
         (has_new_coulomb && (coulomb_is_of_hysteresis(model, measurement.noise_floor_N()) ||
                              coulomb_is_of_sampling(measurement, baseline, model))) ||
         ripple_not_supported(measurement, model, baseline.terms);
}

}  // namespace slipstack::workbench
