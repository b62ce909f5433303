// SPDX-License-Identifier: Apache-2.0
#include "workbench/plan/segment_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <stdexcept>

#include "workbench/base/axis_units.h"
#include "workbench/base/axis_words.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/plan/joined_segments.h"

namespace slipstack::workbench {
namespace {

/// The plan ends when the best gain of information per time falls below this fraction of the first. Chosen.
constexpr double kLeastRate = 0.01;
constexpr int kMostRepeats = 3;
constexpr double kPresliding_m = 20e-6;  ///< assumed where the model has no hysteresis

/// Travel over which the hysteresis of a model reaches nine tenths of its level.
double presliding_of(const Terms& terms) {
  const Term* hysteresis = find_role(terms, Role::hysteresis);
  if (hysteresis == nullptr) return axis_length(kPresliding_m);
  const double level_N = hysteresis_level_N(*hysteresis);
  std::vector<std::size_t> order(hysteresis->gains.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return hysteresis->shapes[a] < hysteresis->shapes[b]; });
  double reached_N = 0.0;
  for (const std::size_t i : order) {
    reached_N += hysteresis->gains[i] * hysteresis->shapes[i];
    if (reached_N >= 0.9 * level_N && hysteresis->shapes[i] > 0.0) return hysteresis->shapes[i];
  }
  return axis_length(kPresliding_m);
}

Terms with(Terms terms, const Terms& more) {
  for (const Term& term : more) {
    if (!contains(terms, term.effect->text.id)) terms.push_back(term);
  }
  return terms;
}

/// A simulated measurement of a motion, by an axis with this model.
Measurement expected_measurement(const Knowledge& knowledge, const SetPoints& motion) {
  Log log;
  log.sample_rate_Hz = motion.rate_Hz;
  log.force_N = force_along(motion, knowledge.model);
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, knowledge.force_noise_N);
  for (double& force : log.force_N) force += noise(random);
  log.position_m = motion.position_m;
  if (const double step_m = knowledge.encoder_resolution_m; step_m > 0.0) {
    for (double& position : log.position_m) position = step_m * std::round(position / step_m);
    log.encoder_resolution_m = step_m;
  }
  if (const double mass = mass_kg(knowledge.model); mass > 0.0) log.mass_kg = mass;
  Measurement measurement(std::move(log));
  weigh_rows(measurement);
  return measurement;
}

/// The information about all effects and pairs as one number. Its logarithm makes repetitions count less and
/// less.
double information_sum(const Information& information, const Terms& effects) {
  double sum = 0.0;
  for (std::size_t i = 0; i < information.effect_count(); ++i) {
    sum += std::log1p(information.alone(i).chi_squared);
    for (std::size_t j = 0; j < information.effect_count(); ++j) {
      if (effects[i].effect != effects[j].effect)
        sum += 2.0 * std::log1p(information.against(i, j).chi_squared);
    }
  }
  return sum;
}

/// An effect with the strength that an experiment should be able to show: at least kShareOfFriction of the
/// friction.
Term as_expected(const Measurement& measurement, const FittedModel& base, Term term) {
  constexpr double kShareOfFriction = 0.05;
  if (term.shapes.size() != term.effect->shapes.size()) term = make_term(measurement, *term.effect);
  if (term.gains.empty()) return term;
  const bool none =
      std::all_of(term.gains.begin(), term.gains.end(), [](double gain) { return gain == 0.0; });
  if (none) {
    for (std::size_t g = 0; g < term.gains.size(); ++g) {
      const GainGroup& group = term.effect->group_of_gain(static_cast<int>(g));
      // For maps and harmonics an arbitrary pattern of signs and sizes; it is scaled below.
      const double sign = group.upper <= 0.0F ? -1.0 : 1.0;
      term.gains[g] = sign * (g % 3 == 1 ? 0.3 : 1.0) * (group.lower < 0.0F && g % 2 == 1 ? -1.0 : 1.0);
    }
  }
  const Eigen::MatrixXd columns = base.linearisation->columns_of(term);
  Eigen::VectorXd gains(columns.cols());
  for (std::size_t g = 0; g < term.gains.size(); ++g) gains(static_cast<Eigen::Index>(g)) = term.gains[g];
  const double peak_N = (columns * gains).cwiseAbs().maxCoeff();
  const double level_N = friction_level_N(base.terms);
  const double wanted_N =
      kShareOfFriction *
      (level_N > 0.0 ? level_N : measurement.weighted_rms(base.linearisation->measured_N()));
  if (peak_N > 0.0 && (peak_N < wanted_N || none)) {
    for (double& gain : term.gains) gain *= wanted_N / peak_N;
  }
  return term;
}

class Planner {
 public:
  Planner(const Knowledge& knowledge, const PlanOptions& options)
      : knowledge_(knowledge), options_(options) {}

  Plan run() {
    report("look for motions", 0.0);
    find_segments();
    report("simulate the motions", 0.2);
    find_information();
    report("choose", 0.7);
    const std::vector<const MotionSegment*> chosen = choose();
    report("evaluate the plan", 0.8);
    Plan plan = evaluated(chosen, options_.seconds);
    if (!options_.in_hand) return plan;
    const std::vector<ExpectedEvidence> in_hand = options_.in_hand(effects_);
    if (const int times = repetitions(plan, in_hand); times > 1)
      plan = evaluated(repeated(chosen, times), repeated_s());
    plan.in_hand = in_hand;
    return plan;
  }

 private:
  void report(const std::string& stage, double fraction) const {
    if (options_.progress) options_.progress(stage, fraction);
  }

  double duration_s(const MotionSegment& segment) const {
    MotionBuilder builder(knowledge_.rate_Hz, segment.start_m);
    segment.append(builder);
    return static_cast<double>(builder.size()) / knowledge_.rate_Hz;
  }

  /// Collects the segments that satisfy the limits of time and force.
  void find_segments() {
    for (MotionSegment& segment : possible_segments(options_.limits, presliding_of(knowledge_.model))) {
      MotionBuilder builder(knowledge_.rate_Hz, segment.start_m);
      builder.dwell(0.01);
      segment.append(builder);
      if (static_cast<double>(builder.size()) / knowledge_.rate_Hz > options_.seconds - 2.0 * kSettle_s)
        continue;
      if (options_.limits.force_N > 0.0) {
        const std::vector<double> force_N = force_along(builder.points(), knowledge_.model);
        const bool strong = std::any_of(force_N.begin(), force_N.end(), [&](double force) {
          return std::abs(force) > (options_.limits.force_of_log ? 1.0 : 0.9) * options_.limits.force_N;
        });
        if (strong) continue;
      }
      segments_.push_back(std::move(segment));
    }
    if (segments_.empty()) {
      throw std::invalid_argument(fmt::format(
          "no motion fits into the limits; give a longer stroke, more speed, acceleration, jerk or {}",
          force_word()));
    }
  }

  void find_information() {
    std::vector<const MotionSegment*> all;
    for (const MotionSegment& segment : segments_) all.push_back(&segment);
    const Sequence sequence = in_sequence(all, options_.limits, knowledge_.model, knowledge_.rate_Hz);
    const Measurement measurement = expected_measurement(knowledge_, sequence.motion);
    const FittedModel base = fit_gains(measurement, knowledge_.model);
    for (const Term& term : knowledge_.effects) effects_.push_back(as_expected(measurement, base, term));
    possible_ = effects_;
    // The shapes of an effect that a log hardly excites may be estimated badly. The middle of their ranges is
    // just as plausible, and the motion shall excite the effect with those shapes too.
    for (const Term& term : effects_) {
      if (term.gains.empty() || searched_shapes(measurement, *term.effect).empty()) continue;
      Term other = term;
      other.shapes = default_shapes(measurement, *term.effect);
      possible_.push_back(as_expected(measurement, base, std::move(other)));
    }
    information_ = Information::of(measurement, base, expected_effects(measurement, possible_),
                                   sequence.groups_of(measurement), static_cast<int>(all.size()),
                                   at_rows_of(measurement, knowledge_.scatter));
    for (const MotionSegment& segment : segments_) durations_s_.push_back(duration_s(segment) + kSettle_s);
    if (options_.limits.force_N > 0.0 && !options_.limits.force_of_log) exclude_strong(sequence);
  }

  void exclude_strong(const Sequence& sequence) {
    // With the effects at their expected strength, some segments may exceed the limit of the force; they are
    // excluded by a duration beyond the plan's. The force of the hysteresis depends on the preceding motion,
    // so the largest inertial force and the largest friction are added.
    const std::vector<double> force_N = force_along(sequence.motion, with(knowledge_.model, effects_));
    const double mass = mass_kg(knowledge_.model);
    for (std::size_t p = 0; p < segments_.size(); ++p) {
      double inertia_N = 0.0;
      double friction_N = friction_level_N(knowledge_.model);
      for (std::size_t i = sequence.samples[p].first; i < sequence.samples[p].second; ++i) {
        const double inertial_N = mass * sequence.motion.acceleration_mps2[i];
        inertia_N = std::max(inertia_N, std::abs(inertial_N));
        friction_N = std::max(friction_N, std::abs(force_N[i] - inertial_N));
      }
      if (inertia_N + friction_N > options_.limits.force_N) durations_s_[p] = 2.0 * options_.seconds;
    }
  }

  std::vector<const MotionSegment*> choose() {
    std::vector<const MotionSegment*> chosen;
    std::vector<int> taken(segments_.size(), 0);
    Information known = information_.front();
    bool any = false;
    double left_s = options_.seconds - 2.0 * kSettle_s;
    double first_rate = 0.0;
    while (true) {
      const double before = any ? information_sum(known, possible_) : 0.0;
      std::size_t best = segments_.size();
      double best_rate = 0.0;
      for (std::size_t p = 0; p < segments_.size(); ++p) {
        if (durations_s_[p] > left_s || taken[p] == kMostRepeats) continue;
        Information more = information_[p];
        if (any) more.add(known);
        const double rate = (information_sum(more, possible_) - before) / durations_s_[p];
        if (rate > best_rate) {
          best_rate = rate;
          best = p;
        }
      }
      if (best == segments_.size() || best_rate < kLeastRate * first_rate) break;
      if (!any) first_rate = best_rate;
      if (any) {
        known.add(information_[best]);
      } else {
        known = information_[best];
      }
      any = true;
      ++taken[best];
      left_s -= durations_s_[best];
      chosen.push_back(&segments_[best]);
    }
    if (chosen.empty()) {
      throw std::invalid_argument(
          fmt::format("no motion within the limits and the time shows these effects; allow more speed, {} or "
                      "time",
                      force_word()));
    }
    return chosen;
  }

  /// How often the motion is made so that it gives more evidence than what is in hand: in proportion to its
  /// duration, within the time.
  int repetitions(const Plan& plan, const std::vector<ExpectedEvidence>& in_hand) const {
    constexpr double kSurely = 1.1;
    const std::optional<LeastEvidence> least = least_evidence(in_hand, plan.expected);
    if (!least || least->plan <= 0.0 || least->plan >= least->log) return 1;
    const double fit = std::max(1.0, repeated_s() / plan.motion.duration_s());
    return static_cast<int>(std::ceil(std::min(kSurely * least->log / least->plan, fit)));
  }

  double repeated_s() const { return std::max(options_.seconds, options_.repeated_s); }

  static std::vector<const MotionSegment*> repeated(const std::vector<const MotionSegment*>& once,
                                                    int times) {
    std::vector<const MotionSegment*> all;
    for (int i = 0; i < times; ++i) all.insert(all.end(), once.begin(), once.end());
    return all;
  }

  Plan evaluated(std::vector<const MotionSegment*> chosen, double longest_s) const {
    // The time of the moves between segments was only estimated; segments are dropped until the motion fits.
    Sequence sequence = in_sequence(chosen, options_.limits, knowledge_.model, knowledge_.rate_Hz);
    while (sequence.motion.duration_s() > longest_s && chosen.size() > 1) {
      chosen.pop_back();
      sequence = in_sequence(chosen, options_.limits, knowledge_.model, knowledge_.rate_Hz);
    }
    // With the memory of the whole motion the force may differ a little from that of each segment alone.
    while (options_.limits.force_N > 0.0 && peak_force_N(sequence.motion) > options_.limits.force_N) {
      if (chosen.size() == 1) {
        throw std::invalid_argument(fmt::format(
            "no motion fits into the limit of the {0}; give more {0} or less friction", force_word()));
      }
      chosen.erase(chosen.begin() + strongest_segment(sequence));
      sequence = in_sequence(chosen, options_.limits, knowledge_.model, knowledge_.rate_Hz);
    }
    Plan plan;
    plan.motion = std::move(sequence.motion);
    for (const MotionSegment* segment : chosen) plan.segments.push_back(segment->name);
    const Measurement measurement = expected_measurement(knowledge_, plan.motion);
    const FittedModel base = fit_gains(measurement, knowledge_.model);
    plan.effects = effects_;
    plan.expected = expected_evidence(measurement, base, effects_, knowledge_.scatter);
    plan.peak_force_N = peak_force_N(plan.motion);
    return plan;
  }

  /// The largest magnitude of the force along a motion at every sample: of the log's model where the limit is
  /// the log's; else with the effects as they are known and as they are expected.
  std::vector<double> magnitude_N(const SetPoints& motion) const {
    std::vector<Terms> models{knowledge_.model};
    if (!options_.limits.force_of_log) {
      models = {with(knowledge_.model, knowledge_.effects), with(knowledge_.model, effects_)};
    }
    std::vector<double> largest_N(motion.size(), 0.0);
    for (const Terms& model : models) {
      const std::vector<double> force_N = force_along(motion, model);
      for (std::size_t i = 0; i < force_N.size(); ++i) {
        largest_N[i] = std::max(largest_N[i], std::abs(force_N[i]));
      }
    }
    return largest_N;
  }

  double peak_force_N(const SetPoints& motion) const {
    const std::vector<double> force_N = magnitude_N(motion);
    return *std::max_element(force_N.begin(), force_N.end());
  }

  /// The segment of a sequence at which, or in the move to which, the force is largest.
  std::ptrdiff_t strongest_segment(const Sequence& sequence) const {
    const std::vector<double> force_N = magnitude_N(sequence.motion);
    const auto at =
        static_cast<std::size_t>(std::max_element(force_N.begin(), force_N.end()) - force_N.begin());
    std::ptrdiff_t segment = 0;
    const auto last = static_cast<std::ptrdiff_t>(sequence.samples.size()) - 1;
    while (segment < last && sequence.samples[static_cast<std::size_t>(segment)].second <= at) ++segment;
    return segment;
  }

  const Knowledge& knowledge_;
  const PlanOptions& options_;
  Terms effects_;   ///< as expected
  Terms possible_;  ///< those, and the same with default shapes
  std::vector<MotionSegment> segments_;
  std::vector<Information> information_;
  std::vector<double> durations_s_;
};

}  // namespace

Plan plan_experiment(const Knowledge& knowledge, const PlanOptions& options) {
  return Planner(knowledge, options).run();
}

}  // namespace slipstack::workbench
