// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>
#include <vector>

#include "workbench/base/quantity.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/bounds.h"
#include "workbench/diagnose/evidence/contains_zero.h"
#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/estimate/linear/linearisation.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/estimate/uncertainty/friction_each_way.h"
#include "workbench/model/effect_adapters/shape_parameter.h"

namespace slipstack::workbench {
namespace {

/// Places at which a map is read to find its largest value: some ten in each of its intervals.
constexpr std::size_t kPlacesOfMap = 200;

/// A fitted value and its standard error; zero: not known.
struct Fitted {
  double value = 0.0;
  double standard_error = 0.0;
};

/// The values of a map over its travel, with these gains.
std::vector<double> map_values(const Term& term, std::span<const double> gains) {
  const double first_m = term.shape(ShapeKind::position).value();
  const double travel_m = term.shape(ShapeKind::travel).value();
  std::vector<Sample<double>> samples(kPlacesOfMap + 1);
  for (std::size_t i = 0; i < samples.size(); ++i)
    samples[i].position_m = first_m + travel_m * static_cast<double>(i) / static_cast<double>(kPlacesOfMap);
  const auto map =
      term.effect->make_force(term.shapes, gains, {.tick_s = 1.0, .metres_per_displacement = 1.0});
  map->reset(samples.front());
  std::vector<double> values(samples.size());
  map->run(samples, values.data());
  return values;
}

/// A function of the gains of `term` and its standard error; `without`: the same term fitted without each
/// block.
template <class Function>
Fitted fitted_value(const Term& term, const std::vector<Term>& without, Function&& function) {
  std::vector<double> values;
  values.reserve(without.size());
  for (const Term& one : without) values.push_back(function(one));
  return {function(term), jackknife_error(values)};
}

/// The largest absolute value of a map over its travel, which is that of the log that it was fitted to. Its
/// gains are not its values: the first and the last spline reach a sixth of theirs at the ends of the travel,
/// so that a gain of -90 % there may be a map that nowhere leaves +-20 %. The error is that of the map at the
/// place where it is largest.
Fitted largest_of_map(const Term& term, const std::vector<Term>& without) {
  const auto values_of = [](const Term& one) {
    return map_values(one, std::span(one.gains.data(), one.gains_per_set()));
  };
  const std::vector<double> values = values_of(term);
  const auto largest = std::max_element(values.begin(), values.end(),
                                        [](double a, double b) { return std::abs(a) < std::abs(b); });
  const auto at = static_cast<std::size_t>(largest - values.begin());
  Fitted there = fitted_value(term, without, [&](const Term& one) { return values_of(one)[at]; });
  there.value = std::abs(there.value);
  return there;
}

/// An effect over the position with the constant force of the model, which it would have were that not one of
/// its own; the effect alone where each log has its own.
Term with_constant_force(const Terms& model, Term term) {
  const Term* const constant = find_role(model, Role::constant_force);
  const int gain = term.effect->traits.constant_gain;
  if (constant != nullptr && gain >= 0 && constant->gain_sets() == 1 && term.gain_sets() == 1)
    term.gains[static_cast<std::size_t>(gain)] += constant->gains[0];
  return term;
}

/// The force of an effect over the position in the middle of its travel; of the first set of gains.
Fitted force_in_middle(const Term& term, const std::vector<Term>& without) {
  return fitted_value(term, without, [](const Term& one) {
    return map_values(one, std::span(one.gains.data(), one.gains_per_set()))[kPlacesOfMap / 2];
  });
}

/// "204.0 +- 6.0 N s/m": two standard errors to either side, 95 %.
std::string with_interval(const Fitted& fitted, const char* unit) {
  return quantity_with_interval(fitted.value, 2.0 * fitted.standard_error, unit);
}

constexpr std::string_view kNotDetermined = ", not determined";

/// Of a shape that is positive (all but places), an interval that contains zero says nothing of its size; nor
/// does a damping at an end of its search, which has no interval.
std::string shape_with_interval(const Term& term, std::size_t shape) {
  const ShapeSpec& spec = term.effect->shapes[shape];
  const double half_width = 2.0 * term.shape_standard_error(shape);
  const std::string text = shape_value_with_interval(spec, term.shapes[shape], half_width);
  if (spec.kind == ShapeKind::pitch && is_one_turn(term.shapes[shape])) return text + " (one turn)";
  const bool at_end = spec.kind == ShapeKind::damping && shape_ended_at_bound(term, shape);
  const bool contains_zero = spec.lower >= 0.0f && half_width >= term.shapes[shape];
  return at_end || contains_zero ? text + std::string(kNotDetermined) : text;
}

/// The amplitude of a group of gains: of cosine and sine gains that of the harmonic whose interval is highest
/// at its lower end. A stronger one that the log does not determine is no finding.
Fitted amplitude_of(const Term& term, const std::vector<Term>& without, std::size_t first,
                    std::size_t count) {
  const auto amplitude_at = [&](const Term& one, std::size_t i) {
    return std::hypot(one.gains[first + i], i + 1 < count ? one.gains[first + i + 1] : 0.0);
  };
  const auto fitted_at = [&](std::size_t i) {
    return fitted_value(term, without, [&](const Term& one) { return amplitude_at(one, i); });
  };
  const auto lower_end = [](const Fitted& fitted) { return fitted.value - 2.0 * fitted.standard_error; };
  Fitted best = fitted_at(0);
  for (std::size_t i = 2; i < count; i += 2) {
    const Fitted other = fitted_at(i);
    if (lower_end(other) > lower_end(best)) best = other;
  }
  return best;
}

/// How an effect that makes friction differ between the directions is told, whatever its own text says: its
/// gains may nearly cancel, so that neither of them is a finding.
constexpr std::string_view kEachWayText =
    "dry friction is {dry_forward} forward and {dry_backward} backward, the viscous slope {slope_forward} "
    "forward, {slope_backward} backward";
/// Behind it, where the model has a constant force: a log shows the sum of both better than either.
constexpr std::string_view kWithConstantText =
    ", and with the constant force it takes {with_constant_forward} forward and {with_constant_backward} "
    "backward";

/// How a delay and a low pass are told of which the log determines the sum only, whatever their own text
/// says.
constexpr std::string_view kDelayAndLowPass = "delay_and_low_pass";
constexpr std::string_view kLagText =
    "force and motion are {delay_and_low_pass} apart in time by delay and low pass together (positive: the "
    "force comes later); which of both it is, the log does not determine";

bool is_lag_of_either_kind(const Term& term) {
  return term.effect->has_role(Role::measurement_delay) && each_shape_contains_zero(term) &&
         !lag_contains_zero(term);
}

/// How a mass below the declared one is told, whatever the text of the effect says.
std::string lighter_text(const Term& added_mass) {
  return fmt::format(
      "the residual is proportional to acceleration: {{{}}}, so the log declares more mass "
      "than the axis has; check it",
      added_mass.effect->gain_groups.front().name);
}

/// Placeholder of the force of an effect over the position in the middle of the travel that was visited.
constexpr std::string_view kForceInMiddle = "force_in_middle";

/// Placeholder of what friction that fades with velocity is at standstill, by all of its gains together.
constexpr std::string_view kAtStandstill = "weakening_at_standstill";

/// What a sentence may tell beside shapes and single gains.
struct Derived {
  std::vector<Term> without;  ///< the term as fitted without each block; empty: no intervals
  FrictionEachWay each_way;
  FrictionEachWay each_way_error;
  Fitted in_middle;  ///< force in the middle of the travel
};

bool tells_force_in_middle(const EffectDescription& effect) {
  return std::string_view(effect.text.evidence).find(kForceInMiddle) != std::string_view::npos;
}

struct EachWayName {
  std::string_view name;
  double FrictionEachWay::*member;
  const char* unit;
};
constexpr std::array<EachWayName, 6> kEachWay{
    {{"dry_forward", &FrictionEachWay::dry_forward_N, "N"},
     {"dry_backward", &FrictionEachWay::dry_backward_N, "N"},
     {"slope_forward", &FrictionEachWay::slope_forward, "N s/m"},
     {"slope_backward", &FrictionEachWay::slope_backward, "N s/m"},
     {"with_constant_forward", &FrictionEachWay::with_constant_forward_N, "N"},
     {"with_constant_backward", &FrictionEachWay::with_constant_backward_N, "N"}}};

/// A value of each set of gains, " / " between them where each log has its own.
template <class OfSet>
std::string of_each_log(const Term& term, OfSet&& of_set) {
  std::string values;
  for (std::size_t set = 0; set < term.gain_sets(); ++set) values += (set == 0 ? "" : " / ") + of_set(set);
  return values;
}

/// The total of the gains (total_weights()), in their unit.
std::string totals_of(const Term& term) {
  return of_each_log(term, [&](std::size_t set) {
    return with_interval({total_of_gains(term, set), term.total_standard_error(set)},
                         term.effect->gain_groups.front().unit);
  });
}

/// The value of the placeholder `name` with its interval: a shape, a single gain, the amplitude of a group of
/// gains (of a map its largest absolute value), or the friction of the model each way.
std::string value_of(const Term& term, const Derived& derived, std::string_view name) {
  for (const EachWayName& known : kEachWay) {
    if (name == known.name)
      return with_interval({derived.each_way.*known.member, derived.each_way_error.*known.member},
                           known.unit);
  }
  if (name == kDelayAndLowPass)
    return with_interval({measurement_dynamics_of({term}).total_s(), term.lag_standard_error_s}, "s");
  if (name == kAtStandstill) return totals_of(term);
  if (name == kForceInMiddle) return with_interval(derived.in_middle, "N");
  for (std::size_t i = 0; i < term.effect->shapes.size(); ++i) {
    if (name == term.effect->shapes[i].name) return shape_with_interval(term, i);
  }
  std::size_t first = 0;
  for (const GainGroup& group : term.effect->gain_groups) {
    const auto count = static_cast<std::size_t>(group.count);
    if (name != group.name) {
      first += count;
      continue;
    }
    if (count == 1) {
      const bool has_total = !total_weights(term).empty();
      return of_each_log(term, [&](std::size_t set) {
        const std::size_t g = set * term.gains_per_set() + first;
        // Of gains that stand for each other the total is told.
        return with_interval({term.gains[g], term.gain_standard_error(g)}, group.unit) +
               std::string(has_total && contains_zero(term.gains[g], term.gain_standard_error(g))
                               ? kNotDetermined
                               : "");
      });
    }
    return with_interval(term.effect->has_shape(ShapeKind::travel)
                             ? largest_of_map(term, derived.without)
                             : amplitude_of(term, derived.without, first, count),
                         group.unit);
  }
  return std::string(name);
}

/// Shapes that the sentence tells, and gains other than zero, that ended at a bound: the log did not
/// determine them, the bound did.
std::string ended_at_bounds(const Term& term, const Terms& model, std::string_view pattern) {
  std::string text;
  for (std::size_t i = 0; i < term.shapes.size(); ++i) {
    if (!shape_ended_at_bound(term, i)) continue;
    if (pattern.find(fmt::format("{{{}}}", term.effect->shapes[i].name)) == std::string_view::npos) continue;
    text += fmt::format("; {} is at an end of its search, not identified", term.effect->shapes[i].name);
  }
  std::size_t first = 0;
  for (const GainGroup& group : term.effect->gain_groups) {
    const auto count = static_cast<std::size_t>(group.count);
    std::size_t at_bound = 0;
    for (std::size_t i = first; i < first + count && i < term.gains.size(); ++i)
      at_bound += gain_ended_at_bound(model, term, i) ? 1 : 0;
    first += count;
    if (at_bound == 0) continue;
    text += count == 1 ? fmt::format("; {} is at its bound, not identified", group.name)
                       : fmt::format("; {} of {} values of {} are at their bound, not identified", at_bound,
                                     count, group.name);
  }
  return text;
}

}  // namespace

namespace {

std::string fill_in(const Term& fitted, const Terms& model, const Derived& derived) {
  std::string text;
  const bool differs = fitted.effect->has_role(Role::directional_friction);
  const bool lighter =
      fitted.effect->has_role(Role::added_mass) &&
      std::all_of(fitted.gains.begin(), fitted.gains.end(), [](double kg) { return kg < 0.0; });
  std::string pattern = differs                         ? std::string(kEachWayText)
                        : lighter                       ? lighter_text(fitted)
                        : is_lag_of_either_kind(fitted) ? std::string(kLagText)
                                                        : std::string(fitted.effect->text.evidence);
  if (differs && has_role(model, Role::constant_force)) pattern += kWithConstantText;
  std::size_t at = 0;
  std::size_t described = 0;  // end of the last value that was inserted
  while (at < pattern.size()) {
    const std::size_t open = pattern.find('{', at);
    const std::size_t close = open == std::string::npos ? open : pattern.find('}', open);
    if (close == std::string::npos) break;
    text += pattern.substr(at, open - at);
    const std::string value =
        value_of(fitted, derived, std::string_view(pattern).substr(open + 1, close - open - 1));
    const std::size_t clause = text.rfind(", ");
    at = close + 1;
    const bool tells_nothing = value.starts_with("0 ") || value.ends_with(kNotDetermined);
    if (tells_nothing && clause != std::string::npos && clause >= described && described > 0) {
      // A further clause with the value zero ("the viscous slope by 0 N s/m"), or of which the log tells
      // nothing, is left out.
      text.resize(clause);
      at = std::min(pattern.find(", ", at), pattern.size());
      continue;
    }
    text += value;
    described = text.size();
  }
  text += pattern.substr(at);
  return text + ended_at_bounds(fitted, model, pattern);
}

}  // namespace

std::string evidence_of(const Term& fitted, const Terms& model) {
  Derived derived{{}, friction_each_way(model, fitted), {}, {}};
  if (tells_force_in_middle(*fitted.effect))
    derived.in_middle = force_in_middle(with_constant_force(model, fitted), {});
  return fill_in(fitted, model, derived);
}

std::string evidence_of(const FittedModel& model, std::string_view effect) {
  const Term& term = *find_term(model.terms, effect);
  Derived derived{{}, friction_each_way(model.terms, term), {}, {}};
  const auto& groups = term.effect->gain_groups;
  const bool is_map =
      std::any_of(groups.begin(), groups.end(), [](const auto& group) { return group.count > 1; });
  if (is_map || tells_force_in_middle(*term.effect)) {
    for (const Terms& terms : terms_without_blocks(model))
      derived.without.push_back(with_constant_force(terms, *find_term(terms, effect)));
  }
  if (tells_force_in_middle(*term.effect))
    derived.in_middle = force_in_middle(with_constant_force(model.terms, term), derived.without);
  if (term.effect->has_role(Role::directional_friction))
    derived.each_way_error = standard_errors_each_way(model, effect);
  return fill_in(term, model.terms, derived);
}

}  // namespace slipstack::workbench
