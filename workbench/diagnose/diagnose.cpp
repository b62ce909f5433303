// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/diagnose.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "workbench/diagnose/evidence.h"
#include "workbench/diagnose/held_out.h"
#include "workbench/diagnose/lines.h"
#include "workbench/diagnose/places.h"
#include "workbench/diagnose/quantity.h"
#include "workbench/diagnose/reduction.h"
#include "workbench/identify/noise_floor.h"
#include "workbench/identify/parallel.h"
#include "workbench/identify/standard_errors.h"

namespace slipstack::workbench {
namespace {

/// A simpler effect is preferred that explains this share of what the best one explains and leaves at most so
/// much more squared error.
constexpr double kShareOfBest = 0.95;
constexpr double kSquaredErrorOfBest = 1.10;
/// Frictional lag contains Stribeck friction. Where even the lag ends so far above the floor, its form is not
/// the axis' own either, and its two more shapes bend towards whatever reversals do (a bristle's stretch lags
/// too): there the share alone decides.
constexpr double kFormIsNotTheAxis = 1.5;

/// Held-out errors nearer than this are not told apart.
constexpr double kIndistinct = 0.02;

/// Of what the baseline leaves above the noise floor, the first effect must explain this part (mean square):
/// what quantisation and the form of the virgin curve leave is no effect.
constexpr double kShareOfExcess = 0.25;

/// An error this near to the noise floor has nothing to explain. Encoder steps seen through mass and
/// acceleration can be shrunk by any filter that resembles a resonance; that is no resonance.
constexpr double kNothingToExplain = 1.05;

/// Coulomb friction beside hysteresis is hysteresis of a slip distance shorter than the encoder shows: it
/// takes up what quantisation leaves at reversals, and must explain more than that.
constexpr double kShareOfExcessCoulomb = 0.7;

/// A further effect must lower the held-out error by more, since the form of the first is never exactly the
/// axis' own.
constexpr double kLeastFurtherReduction = 0.05;

/// A further effect must explain this much (rms) of what all explain together: the form of the first, never
/// exactly the axis', leaves less. What dry friction explains where the baseline has none does not count: its
/// elements have no form to be wrong.
constexpr double kShareOfExplained = 0.05;

/// Held-out errors this near to the floor end the search.
constexpr double kAtFloor = 1.10;

/// What promises less to first order is not fitted in full.
constexpr double kWorthFitting = 0.015;

constexpr std::size_t kBeam = 3;
/// An explanation goes on when it explains this share of what the best of its size does.
constexpr double kShareToGoOn = 0.5;
constexpr std::size_t kMostSteps = 5;

/// What structure must explain of the residual, and how far that must stand above the floor, to be reported.
constexpr double kStructureReduction = 0.05;
constexpr double kAboveFloor = 1.15;
/// The encoder's steps are loudest at reversals: what is left there is play only so far above the floor.
constexpr double kPlayAboveFloor = 1.6;

/// An explanation that leaves so much explains nothing: share of the force, multiple of the floor, share of
/// what the baseline left. Real axes end at a few per cent of the force, far above the floor of a good force
/// sensor.
constexpr double kFairShareOfForce = 0.06;
constexpr double kFarAboveFloor = 4.0;
/// A model that leaves this share of the force, far above the floor, is not complete.
constexpr double kIncomplete = 0.02;
constexpr double kMostOfBaseline = 0.35;

/// A line that is this share of what is left, so far above the floor, is what drives the rest.
constexpr double kLineDrives = 0.3;
constexpr double kLineAboveFloor = 2.0;
constexpr double kSameLine = 0.02;
/// Share of what all effects explain that such a line explains alone.
constexpr double kLinePoses = 0.5;

/// A moving mass that comes out so many times smaller or larger than the declared one is no payload.
constexpr double kAnotherAxis = 5.0;

/// Of what several effects explain, what one place of the rail must explain to stand for them.
constexpr double kShareOfSeveral = 0.9;

/// Forces nearer than this share nine tenths of their squares: what one explains, so does the other, ...
constexpr double kSameDirection_deg = 18.0;
/// ... unless their errors differ by more than this.
constexpr double kSameError = 0.10;
/// Of the best reduction of the error, what an effect must reach to be worth telling from others.
constexpr double kPromising = 0.5;

/// Effects that are a case of another: a chain so soft that its pull is constant, a lag of no time, a mode so
/// stiff that its mass moves along. No log can exclude that; what it can show is that the other is no more
/// than that.
constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kCases{
    {{"offset_force", "cable_chain_stiffness"},
     {"stribeck", "frictional_lag"},
     {"payload_mass", "structural_resonance"}}};

/// An effect that would have to be this share of the force before it were named is one that the log cannot
/// show.
constexpr double kCannotShow = 0.2;

/// What grows with the force must explain this share of it: clocks of current and encoder a few per cent of a
/// sample apart, and sensors a per mille off a straight line, are no delay, mode, payload or ripple.
constexpr double kLeastShareOfForce = 1e-3;
constexpr std::string_view kGrowWithForce[] = {"time_delay", "structural_resonance", "payload_mass",
                                               "motor_constant_ripple"};

double squared(double x) {
  return x * x;
}

double radians(double degrees) {
  return degrees * std::numbers::pi / 180.0;
}

/// A model on the way to an explanation.
struct Explanation {
  FittedModel model;
  std::vector<std::string> added;
};

bool coulomb_joins_hysteresis(const FittedModel& before, const FittedModel& after) {
  return contains(before.terms, "presliding_hysteresis") && !contains(before.terms, "coulomb") &&
         contains(after.terms, "coulomb");
}

bool has_dry_friction(const FittedModel& model) {
  return std::any_of(model.terms.begin(), model.terms.end(),
                     [](const Term& term) { return term.effect->acts_as(Acts::dry); });
}

/// Whether the step adds what grows with the force, and no more of it than instruments err.
bool within_instruments(const FittedModel& baseline, const FittedModel& before, const FittedModel& after,
                        double step) {
  if (!(baseline.relative_error > 0.0)) return false;
  const double force_N = baseline.train_rmse_N / baseline.relative_error;
  return step < squared(kLeastShareOfForce * force_N) &&
         std::any_of(std::begin(kGrowWithForce), std::end(kGrowWithForce), [&](std::string_view id) {
           return contains(after.terms, id) && !contains(before.terms, id);
         });
}

/// Whether the step from `before` to `after` is worth its parameters; `floor_N` is that of `after`, `known_N`
/// the error of the baseline, or of the first explanation that has dry friction.
bool earned(const FittedModel& baseline, const FittedModel& before, const FittedModel& after, double floor_N,
            double known_N) {
  const Reduction reduced = reduction(before.block_squared_error, after.block_squared_error);
  if (!reduced.earned()) return false;
  const double step = squared(before.holdout_rmse_N) - squared(after.holdout_rmse_N);
  const double excess = squared(before.holdout_rmse_N) - squared(floor_N);
  if (coulomb_joins_hysteresis(before, after) && step < kShareOfExcessCoulomb * excess) return false;
  if (within_instruments(baseline, before, after, step)) return false;
  if (before.terms.size() <= baseline.terms.size()) {
    return step >= kShareOfExcess * excess && before.holdout_rmse_N >= kNothingToExplain * floor_N;
  }
  const double all = squared(known_N) - squared(after.holdout_rmse_N);
  return reduced.value >= kLeastFurtherReduction && step >= squared(kShareOfExplained) * all;
}

/// Effects worth trying: not in the model, and not the same column under another name.
std::vector<const EffectDescription*> effects_to_try(const Terms& terms,
                                                     const std::vector<std::string>& wanted,
                                                     const std::vector<const EffectDescription*>& own,
                                                     bool weightless, double stroke_m) {
  std::vector<const EffectDescription*> effects;
  const Term* inertia = find_term(terms, "inertia");
  const bool mass_is_free = inertia != nullptr && inertia->lower[0] < inertia->upper[0];
  // These take longest: first, so that the processors share the work well.
  for (const EffectDescription* effect : own) {
    if (!contains(terms, effect->text.id)) effects.push_back(effect);
  }
  std::vector<const EffectDescription*> all;
  all.reserve(wanted.size());
  for (const std::string& id : wanted) all.push_back(find_effect(id));
  if (wanted.empty()) {
    all.reserve(catalogue().size());
    for (const EffectDescription& effect : catalogue()) all.push_back(&effect);
  }
  for (const EffectDescription* effect : all) {
    if (contains(terms, effect->text.id)) continue;
    // What does not repeat twice within the stroke is not seen to repeat.
    const bool too_coarse =
        std::any_of(effect->shapes.begin(), effect->shapes.end(), [&](const ShapeSpec& shape) {
          return shape.kind == ShapeKind::pitch && 2.0 * static_cast<double>(shape.lower) > stroke_m;
        });
    if (too_coarse) continue;
    if (weightless && (effect->id() == "structural_resonance" || effect->id() == "payload_mass")) continue;
    if (effect->id() == "payload_mass" && mass_is_free) continue;
    if (effect->id() == "inertia" && contains(terms, "payload_mass")) continue;
    effects.push_back(effect);
  }
  return effects;
}

/// Grows explanations level by level and remembers what the first level said.
class Search {
 public:
  Search(const Measurement& measurement, const DiagnoseOptions& options)
      : measurement_(measurement), options_(options), floor_(measurement) {}

  Diagnosis run() {
    report("fit the baseline", 0.0);
    Diagnosis diagnosis;
    diagnosis.baseline = options_.start.empty() ? fit_effects(measurement_, options_.baseline, {})
                                                : fit_gains(measurement_, options_.start);
    known_N_ = diagnosis.baseline.holdout_rmse_N;
    Explanation best{diagnosis.baseline, {}};
    std::vector<Explanation> beam{best};
    for (std::size_t level = 0; level < kMostSteps; ++level) {
      std::vector<Explanation> next = grow(beam, level == 0);
      if (level == 0) first_level_ = next;
      std::erase_if(next, [&](const Explanation& one) {
        return coulomb_joins_hysteresis(best.model, one.model) &&
               !earned(diagnosis.baseline, best.model, one.model, floor_.of(one.model.terms), known_N_);
      });
      if (next.empty()) break;
      const Explanation* winner = choose(next, best.model);
      if (!earned(diagnosis.baseline, best.model, winner->model, floor_.of(winner->model.terms), known_N_) ||
          !needs_both(diagnosis.baseline, beam, *winner, best)) {
        if (level > 0 || !promises(diagnosis.baseline, *winner)) break;
        keep_best(next, diagnosis.baseline);
        beam = std::move(next);
        continue;
      }
      if (!has_dry_friction(best.model) && has_dry_friction(winner->model)) {
        known_N_ = winner->model.holdout_rmse_N;
      }
      best = *winner;
      best.model = polish_shapes(measurement_, std::move(best.model), {20});
      keep_best(next, diagnosis.baseline);
      beam = std::move(next);
      if (best.model.holdout_rmse_N < kAtFloor * floor_.of(best.model.terms)) break;
    }
    prune(diagnosis, best);
    if (!best.added.empty()) simplify(diagnosis, best);
    if (!best.added.empty()) best.model = settle_shapes(measurement_, std::move(best.model));
    fill(diagnosis, std::move(best));
    report("done", 1.0);
    return diagnosis;
  }

 private:
  void report(const std::string& stage, double fraction) const {
    if (options_.progress) options_.progress(stage, fraction);
  }

  /// Every explanation of the beam with every further effect: screened to first order, the best of each
  /// fitted in full. The first level fits all, since all are listed.
  std::vector<Explanation> grow(const std::vector<Explanation>& beam, bool first) {
    struct Job {
      const Explanation* from;
      const EffectDescription* effect;
      Trial trial;
    };
    std::vector<Job> jobs;
    // A log that declares a mass of zero says that inertia does not count: nothing swings either.
    const bool weightless = measurement_.log().mass_kg && *measurement_.log().mass_kg == 0.0;
    const auto [lowest, highest] =
        std::minmax_element(measurement_.position_m().begin(), measurement_.position_m().end());
    for (const Explanation& from : beam) {
      for (const EffectDescription* effect : effects_to_try(from.model.terms, options_.candidates,
                                                            options_.own, weightless, *highest - *lowest))
        jobs.push_back({&from, effect, {}});
    }
    std::atomic<std::size_t> done{0};
    parallel_for(jobs.size(), [&](std::size_t i) {
      Job& job = jobs[i];
      job.trial = first ? try_effect(measurement_, job.from->model, *job.effect, {})
                        : retry(job.from->model, *job.effect);
      const std::size_t finished = ++done;
      report(first ? "try every effect" : "try every effect on top",
             static_cast<double>(finished) / static_cast<double>(jobs.size()));
    });
    // By error, then by name: effects that do nothing tie, whatever the order of the catalogue.
    std::sort(jobs.begin(), jobs.end(), [](const Job& a, const Job& b) {
      return std::tuple(a.trial.holdout_rmse_N, std::string_view(a.effect->text.id), a.from) <
             std::tuple(b.trial.holdout_rmse_N, std::string_view(b.effect->text.id), b.from);
    });
    if (first) {
      for (const Job& job : jobs) trials_.push_back(job.trial);
    }
    // Each set of effects once.
    std::vector<Job> distinct;
    for (Job& job : jobs) {
      if (job.trial.holdout_rmse_N > (1.0 - kWorthFitting) * job.from->model.holdout_rmse_N) continue;
      const bool seen = std::any_of(distinct.begin(), distinct.end(), [&](const Job& other) {
        return same_set(added_by(*other.from, *other.effect), added_by(*job.from, *job.effect));
      });
      if (!seen) distinct.push_back(std::move(job));
      if (distinct.size() == 2 * kBeam) break;
    }
    std::vector<Explanation> grown(distinct.size());
    parallel_for(distinct.size(), [&](std::size_t i) {
      grown[i].model = fit_gains(measurement_, distinct[i].trial.terms, &distinct[i].from->model);
      grown[i].added = added_by(*distinct[i].from, *distinct[i].effect);
    });
    return grown;
  }

  /// A trial on top of an explanation: from the shapes that the first level found, unless they are pitches
  /// and frequencies, which another residual may show elsewhere.
  Trial retry(const FittedModel& from, const EffectDescription& effect) const {
    const Trial* first = trial_of(effect.text.id);
    const bool elsewhere =
        std::any_of(effect.shapes.begin(), effect.shapes.end(), [](const ShapeSpec& shape) {
          return shape.kind == ShapeKind::pitch || shape.kind == ShapeKind::frequency ||
                 shape.kind == ShapeKind::own;
        });
    const bool known = first != nullptr && !elsewhere;
    return try_effect(measurement_, from, effect, {20}, known ? &first->term.shapes : nullptr);
  }

  static std::vector<std::string> added_by(const Explanation& from, const EffectDescription& effect) {
    std::vector<std::string> added = from.added;
    added.push_back(effect.id());
    return added;
  }
  /// Whether the first effect explains enough, though not in enough blocks to be sure of: another one may be
  /// loud in those where it does nothing, and both together are sure.
  bool promises(const FittedModel& baseline, const Explanation& first) const {
    const double floor_N = floor_.of(first.model.terms);
    const double step = squared(baseline.holdout_rmse_N) - squared(first.model.holdout_rmse_N);
    return step >= kShareOfExcess * (squared(baseline.holdout_rmse_N) - squared(floor_N)) &&
           baseline.holdout_rmse_N >= kNothingToExplain * floor_N &&
           first.model.holdout_rmse_N < (1.0 - kLeastReduction) * baseline.holdout_rmse_N;
  }

  /// Whether the last of two effects, of which the first was not sure alone, earns its place beside it;
  /// prune() asks that of the first. One that was sure was asked when it was added.
  bool needs_both(const FittedModel& baseline, const std::vector<Explanation>& beam,
                  const Explanation& winner, const Explanation& best) const {
    if (!best.added.empty() || winner.added.size() < 2) return true;
    const auto first = std::find_if(beam.begin(), beam.end(), [&](const Explanation& one) {
      return one.added.front() == winner.added.front();
    });
    return first != beam.end() &&
           earned(baseline, first->model, winner.model, floor_.of(winner.model.terms), known_N_);
  }

  static bool same_set(std::vector<std::string> a, std::vector<std::string> b) {
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    return a == b;
  }

  static int parameters(const FittedModel& model) {
    int count = 0;
    for (const Term& term : model.terms) count += term.effect->parameter_count();
    return count;
  }

  /// Whether a simpler model explains as much as the best one, of what the model before them left.
  bool stands_for(const FittedModel& simpler, const FittedModel& best, const FittedModel& before) const {
    const double error0 = squared(before.holdout_rmse_N);
    const double error = squared(best.holdout_rmse_N);
    const double own = squared(simpler.holdout_rmse_N);
    if (error0 - own < kShareOfBest * (error0 - error)) return false;
    if (own <= kSquaredErrorOfBest * error) return true;
    const bool nested = contains(best.terms, "frictional_lag") &&
                        !contains(simpler.terms, "frictional_lag") && contains(simpler.terms, "stribeck");
    return nested && error > squared(kFormIsNotTheAxis * floor_.of(best.terms));
  }

  /// The lowest held-out error, unless something simpler explains as much.
  const Explanation* choose(const std::vector<Explanation>& all, const FittedModel& before) const {
    const Explanation* best = &*std::min_element(all.begin(), all.end(), [](const auto& a, const auto& b) {
      return a.model.holdout_rmse_N < b.model.holdout_rmse_N;
    });
    const Explanation* chosen = best;
    for (const Explanation& other : all) {
      const double own = squared(other.model.holdout_rmse_N);
      const bool as_good = stands_for(other.model, best->model, before);
      const int fewer = parameters(chosen->model) - parameters(other.model);
      if (as_good && (fewer > 0 || (fewer == 0 && own < squared(chosen->model.holdout_rmse_N))))
        chosen = &other;
    }
    return chosen;
  }

  /// What goes on: the best few, as long as they explain a fair part of what the best does.
  static void keep_best(std::vector<Explanation>& all, const FittedModel& baseline) {
    std::sort(all.begin(), all.end(),
              [](const auto& a, const auto& b) { return a.model.holdout_rmse_N < b.model.holdout_rmse_N; });
    if (all.size() > kBeam) all.resize(kBeam);
    const double error0 = squared(baseline.holdout_rmse_N);
    const double best = error0 - squared(all.front().model.holdout_rmse_N);
    std::erase_if(all, [&](const Explanation& one) {
      return error0 - squared(one.model.holdout_rmse_N) < kShareToGoOn * best;
    });
  }

  /// Drops what other effects have made superfluous: of the last one too, since what it was added to need not
  /// be what the step before chose.
  void prune(const Diagnosis& diagnosis, Explanation& explanation) const {
    for (std::size_t i = 0; explanation.added.size() > 1 && i < explanation.added.size();) {
      Terms terms;
      for (const Term& term : explanation.model.terms) {
        if (term.id() != explanation.added[i]) terms.push_back(term);
      }
      FittedModel without =
          polish_shapes(measurement_, fit_gains(measurement_, std::move(terms), &explanation.model), {15});
      if (earned(diagnosis.baseline, without, explanation.model, floor_.of(explanation.model.terms),
                 known_N_)) {
        ++i;
      } else {
        explanation.model = std::move(without);
        explanation.added.erase(explanation.added.begin() + static_cast<std::ptrdiff_t>(i));
      }
    }
  }

  /// Gives to an effect of fewer parameters what it explains as well in the company of the others.
  void simplify(const Diagnosis& diagnosis, Explanation& explanation) const {
    for (std::string& added : explanation.added) {
      const Trial* own = trial_of(added);
      for (const Trial& trial : trials_) {
        const EffectDescription& other = *trial.term.effect;
        if (own == nullptr || contains(explanation.model.terms, other.text.id) ||
            other.parameter_count() >= own->term.effect->parameter_count() ||
            explained(diagnosis, trial) < kShareToGoOn * explained(diagnosis, *own)) {
          continue;
        }
        Terms terms;
        for (const Term& term : explanation.model.terms)
          terms.push_back(term.id() == added ? trial.term : term);
        FittedModel simpler =
            polish_shapes(measurement_, fit_gains(measurement_, std::move(terms), &explanation.model), {15});
        if (squared(simpler.holdout_rmse_N) <=
                kSquaredErrorOfBest * squared(explanation.model.holdout_rmse_N) ||
            stands_for(simpler, explanation.model, diagnosis.baseline)) {
          explanation.model = std::move(simpler);
          added = other.id();
          own = trial_of(added);
        }
      }
    }
  }
  const Trial* trial_of(std::string_view id) const {
    for (const Trial& trial : trials_) {
      if (id == trial.term.effect->text.id) return &trial;
    }
    return nullptr;
  }
  static double explained(const Diagnosis& diagnosis, const Trial& trial) {
    return squared(diagnosis.baseline.holdout_rmse_N) - squared(trial.holdout_rmse_N);
  }

  void fill(Diagnosis& diagnosis, Explanation best) {
    list_candidates(diagnosis);
    rank_candidates(diagnosis, best.added);
    list_steps(diagnosis, best);
    diagnosis.explained = std::move(best.model);
    if (options_.judge_on_whole) {
      report("judge by the whole logs", 0.0);
      options_.judge_on_whole(diagnosis);
      drop_unearned_steps(diagnosis);
      std::vector<std::string> added;
      for (std::size_t i = 1; i < diagnosis.steps.size(); ++i) added.push_back(diagnosis.steps[i].added);
      rank_candidates(diagnosis, added);
    }
    diagnosis.noise_floor_N = floor_.of(diagnosis.explained.terms);
    judge(diagnosis);
    list_what_cannot_be_shown(diagnosis);
    list_what_cannot_be_separated(diagnosis);
    if (diagnosis.steps.size() == 2) show_as_handed_out(diagnosis);
  }

  /// The one effect that is missing, with the error that the best model has: its shapes have been settled
  /// since it was ranked among the others, whose shapes have not.
  static void show_as_handed_out(Diagnosis& diagnosis) {
    Candidate& first = diagnosis.candidates.front();
    if (diagnosis.best.holdout_rmse_N >= first.holdout_rmse_N) return;
    first.term = *find_term(diagnosis.best.terms, first.term.id());
    first.terms = diagnosis.best.terms;
    first.holdout_rmse_N = diagnosis.best.holdout_rmse_N;
    first.block_squared_error = diagnosis.best.block_squared_error;
    first.evidence = evidence_of(first.term);
    const Reduction reduced = reduction(diagnosis.baseline.block_squared_error, first.block_squared_error);
    first.error_reduction = reduced.value;
    first.error_reduction_se = reduced.standard_error;
  }

  void list_candidates(Diagnosis& diagnosis) const {
    for (const Trial& trial : trials_) {
      Candidate candidate;
      candidate.term = trial.term;
      candidate.terms = trial.terms;
      candidate.holdout_rmse_N = trial.holdout_rmse_N;
      candidate.block_squared_error = trial.block_squared_error;
      for (const Explanation& full : first_level_) {
        if (full.added[0] != trial.term.id()) continue;
        candidate.term = *find_term(full.model.terms, full.added[0]);
        candidate.terms = full.model.terms;
        candidate.holdout_rmse_N = full.model.holdout_rmse_N;
        candidate.block_squared_error = full.model.block_squared_error;
      }
      candidate.evidence = evidence_of(candidate.term);
      diagnosis.candidates.push_back(std::move(candidate));
    }
  }

  /// All effects by what they explain on their own; those of the final explanation before the others, since
  /// of a pair an impostor may look best alone.
  static void rank_candidates(Diagnosis& diagnosis, const std::vector<std::string>& added) {
    for (Candidate& candidate : diagnosis.candidates) {
      const Reduction reduced =
          reduction(diagnosis.baseline.block_squared_error, candidate.block_squared_error);
      candidate.error_reduction = reduced.value;
      candidate.error_reduction_se = reduced.standard_error;
      candidate.confounded_with.clear();
    }
    std::stable_sort(diagnosis.candidates.begin(), diagnosis.candidates.end(),
                     [](const auto& a, const auto& b) { return a.holdout_rmse_N < b.holdout_rmse_N; });
    std::stable_partition(diagnosis.candidates.begin(), diagnosis.candidates.end(),
                          [&](const auto& candidate) {
                            return std::find(added.begin(), added.end(), candidate.term.id()) != added.end();
                          });
    for (Candidate& candidate : diagnosis.candidates) {
      for (const Candidate& other : diagnosis.candidates) {
        if (&other == &candidate || other.error_reduction < kLeastReduction) continue;
        const double apart = std::abs(other.holdout_rmse_N - candidate.holdout_rmse_N);
        if (apart <= kIndistinct * candidate.holdout_rmse_N) {
          candidate.confounded_with.push_back(other.term.id());
        }
      }
    }
  }

  void list_what_cannot_be_shown(Diagnosis& diagnosis) const {
    const Linearisation& baseline = *diagnosis.explained.linearisation;
    const double force_N = measurement_.weighted_rms(baseline.measured_N());
    const Imitation imitated = baseline_imitation(measurement_, diagnosis.explained);
    std::vector<Visibility> all(diagnosis.candidates.size());
    parallel_for(all.size(), [&](std::size_t i) {
      const Term& term = diagnosis.candidates[i].term;
      if (contains(diagnosis.explained.terms, term.effect->text.id)) return;
      all[i] = visibility_of(measurement_, diagnosis.explained, imitated, term, kLeastReduction);
    });
    for (Visibility& one : all) {
      if (!one.effect.empty() && one.least_N > kCannotShow * force_N)
        diagnosis.cannot_show.push_back(std::move(one));
    }
  }

  /// Of effects that promise much alone, those that explain as much as another (what list_candidates says)
  /// and those whose forces hardly differ.
  void list_what_cannot_be_separated(Diagnosis& diagnosis) const {
    Terms promising;
    double best = kLeastReduction;
    for (const Candidate& one : diagnosis.candidates) best = std::max(best, one.error_reduction);
    const double enough = std::max(kLeastReduction, kPromising * best);
    for (const Candidate& one : diagnosis.candidates) {
      if (one.error_reduction >= enough && !one.term.gains.empty()) promising.push_back(one.term);
    }
    if (promising.size() < 2) return;
    for (Separation& pair :
         separations(measurement_, diagnosis.baseline, promising, diagnosis.noise_floor_N)) {
      const auto candidate = std::find_if(diagnosis.candidates.begin(), diagnosis.candidates.end(),
                                          [&](const Candidate& one) { return one.term.id() == pair.effect; });
      const auto& alike = candidate->confounded_with;
      const bool as_good = std::find(alike.begin(), alike.end(), pair.other) != alike.end();
      // Whether the better one can be imitated counts: an effect that contains another imitates it always.
      const auto behind = std::find_if(candidate, diagnosis.candidates.end(),
                                       [&](const Candidate& one) { return one.term.id() == pair.other; });
      if (behind == diagnosis.candidates.end()) continue;
      const bool same = pair.angle_deg < kSameDirection_deg &&
                        behind->holdout_rmse_N < (1.0 + kSameError) * candidate->holdout_rmse_N;
      if (!as_good && !same) continue;
      if (is_the_simpler_case(diagnosis, *candidate, *behind)) {
        std::erase(candidate->confounded_with, pair.other);
        std::erase(behind->confounded_with, pair.effect);
        std::erase_if(diagnosis.cannot_show, [&](const Visibility& one) { return one.effect == pair.other; });
        continue;
      }
      diagnosis.cannot_separate.push_back(std::move(pair));
    }
    std::stable_sort(diagnosis.cannot_separate.begin(), diagnosis.cannot_separate.end(),
                     [](const auto& a, const auto& b) { return a.angle_deg < b.angle_deg; });
  }

  /// Whether `simpler` is a case of `richer` (kCases), and this log would show what else the richer can be:
  /// then the richer imitates it, as in any log, and does not compete with it. At the middle of the richer's
  /// shapes, one of its gains at a time.
  bool is_the_simpler_case(const Diagnosis& diagnosis, const Candidate& simpler,
                           const Candidate& richer) const {
    const auto known = [&](const auto& pair) {
      return pair.first == simpler.term.id() && pair.second == richer.term.id();
    };
    if (std::none_of(kCases.begin(), kCases.end(), known)) return false;
    // What the simpler one leaves may be what the richer one is more than that.
    const bool more_left = simpler.holdout_rmse_N > kFormIsNotTheAxis * diagnosis.noise_floor_N;
    if (more_left && richer.holdout_rmse_N < (1.0 - kIndistinct) * simpler.holdout_rmse_N) return false;
    const Imitation baseline = baseline_imitation(measurement_, diagnosis.baseline);
    const auto beyond = [&](const Term& term) {
      return baseline.beyond(weighted_columns(measurement_, diagnosis.baseline, term));
    };
    const Eigen::MatrixXd force = beyond(simpler.term);
    const Term own = make_term(measurement_, *richer.term.effect);
    const double left = share_left(Imitation(force), beyond(own));
    const double explained_N = std::sqrt(
        std::max(0.0, squared(diagnosis.baseline.holdout_rmse_N) - squared(simpler.holdout_rmse_N)));
    return std::asin(left) > radians(kSameDirection_deg) && left * explained_N > diagnosis.noise_floor_N;
  }

  /// Of the column that is imitated worst, the share that is left of its length.
  static double share_left(const Imitation& known, const Eigen::MatrixXd& columns) {
    const Eigen::VectorXd own = columns.colwise().norm();
    const Eigen::VectorXd left = known.beyond(columns).colwise().norm();
    double share = 0.0;
    for (Eigen::Index i = 0; i < own.size(); ++i) {
      if (own(i) > 0.0) share = std::max(share, std::min(1.0, left(i) / own(i)));
    }
    return share;
  }

  void list_steps(Diagnosis& diagnosis, const Explanation& best) const {
    diagnosis.steps.push_back({"baseline", diagnosis.baseline.holdout_rmse_N, "", diagnosis.baseline.terms});
    diagnosis.best = diagnosis.baseline;
    // The strongest first, then whatever helps most, so that the waterfall falls as fast as it can.
    std::vector<std::string> order;
    for (const Candidate& candidate : diagnosis.candidates) {
      const std::string id = candidate.term.id();
      if (std::find(best.added.begin(), best.added.end(), id) != best.added.end()) order.push_back(id);
    }
    Terms terms = diagnosis.baseline.terms;
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i > 0 && i + 1 < order.size()) put_next(terms, best.model, std::span(order).subspan(i));
      terms.push_back(*find_term(best.model.terms, order[i]));
      FittedModel model =
          i + 1 == order.size()
              ? best.model
              : polish_shapes(measurement_, fit_gains(measurement_, terms, &best.model), {20});
      diagnosis.steps.push_back(
          {order[i], model.holdout_rmse_N, evidence_of(*find_term(best.model.terms, order[i])), model.terms});
      if (i == 0) diagnosis.best = std::move(model);
    }
  }

  /// Brings to the front what lowers the error most on top of `terms`, with the shapes of `full`.
  void put_next(const Terms& terms, const FittedModel& full, std::span<std::string> order) const {
    double least_N = HUGE_VAL;
    for (std::string& id : order) {
      Terms more = terms;
      more.push_back(*find_term(full.terms, id));
      const double error_N = fit_gains(measurement_, std::move(more), &full).holdout_rmse_N;
      if (error_N >= least_N) continue;
      least_N = error_N;
      std::swap(order.front(), id);
    }
  }

  /// Steps that the whole logs do not bear out, from the last on.
  void drop_unearned_steps(Diagnosis& diagnosis) const {
    std::vector<Step>& steps = diagnosis.steps;
    const std::size_t found = steps.size();
    while (steps.size() > 1 &&
           steps.back().holdout_rmse_N > (1.0 - kLeastReduction) * steps[steps.size() - 2].holdout_rmse_N) {
      steps.pop_back();
    }
    if (steps.size() == found) return;
    if (steps.size() == 1) diagnosis.best = diagnosis.baseline;
    if (steps.size() <= 2) {
      diagnosis.explained = diagnosis.best;
      return;
    }
    diagnosis.explained = fit_gains(measurement_, steps.back().terms, &diagnosis.explained);
    diagnosis.explained.holdout_rmse_N = steps.back().holdout_rmse_N;
  }

  void judge(Diagnosis& diagnosis) const {
    const FittedModel& last = diagnosis.explained;
    auto left = find_structure(measurement_, weighted_residual(last));
    const bool above_floor = last.holdout_rmse_N > kAboveFloor * diagnosis.noise_floor_N;
    if (last.holdout_rmse_N < kPlayAboveFloor * diagnosis.noise_floor_N) {
      std::erase_if(left, [](const Structure& one) { return one.coordinate == "reversal"; });
    }
    if (above_floor && left.front().error_reduction >= kStructureReduction)
      diagnosis.unexplained = left.front();
    const auto line = line_beyond_rows(measurement_, last.linearisation->sample_force_N(), last.train_rmse_N);
    const double known = diagnosis.unexplained ? diagnosis.unexplained->error_reduction : kStructureReduction;
    if (line && line->error_reduction >= known) diagnosis.unexplained = *line;
    if (diagnosis.steps.size() > 1) {
      diagnosis.verdict = Verdict::missing_effect;
      if (above_floor && diagnosis.unexplained && dominated(diagnosis))
        diagnosis.verdict = Verdict::unexplained;
      if (line_poses(diagnosis) || insufficient(diagnosis) || line_drives(diagnosis) ||
          play_poses(diagnosis)) {
        diagnosis.verdict = Verdict::unexplained;
        if (!diagnosis.unexplained) diagnosis.unexplained = left.front();
      }
      if (auto other = mass_of_another_axis(diagnosis)) {
        diagnosis.verdict = Verdict::unexplained;
        diagnosis.unexplained = std::move(*other);
      }
    } else {
      if (!diagnosis.unexplained && far_from_complete(diagnosis)) diagnosis.unexplained = left.front();
      diagnosis.verdict = diagnosis.unexplained ? Verdict::unexplained : Verdict::complete;
    }
  }

  /// Whether a line in time is what is left, most of it or at the very frequency of the resonance that was
  /// named: a controller answers a line with motion at its frequency, and a mode that hardly decays poses as
  /// the cause.
  static bool line_drives(const Diagnosis& diagnosis) {
    const auto& left = diagnosis.unexplained;
    if (!left || left->coordinate != "frequency" ||
        diagnosis.explained.holdout_rmse_N < kLineAboveFloor * diagnosis.noise_floor_N) {
      return false;
    }
    const Term* mode = find_term(diagnosis.explained.terms, "structural_resonance");
    const bool posing = mode != nullptr && std::abs(mode->shapes[0] - left->where) < kSameLine * left->where;
    return posing || left->error_reduction >= kLineDrives;
  }

  /// Whether the resonance that was named is a line in time: moves excite a mode anew each time, in whatever
  /// phase, but what keeps its phase from the first move to the last is no ringing. Within a control loop the
  /// axis moves at the line's frequency, and a mode that hardly decays makes the line of that motion.
  bool line_poses(Diagnosis& diagnosis) const {
    const Term* mode = find_term(diagnosis.explained.terms, "structural_resonance");
    if (mode == nullptr || contains(diagnosis.baseline.terms, "structural_resonance")) return false;
    Structure line = line_at_rows(measurement_, weighted_residual(diagnosis.baseline));
    const double explained = 1.0 - diagnosis.explained.holdout_rmse_N / diagnosis.baseline.holdout_rmse_N;
    if (std::abs(mode->shapes[0] - line.where) > kSameLine * line.where ||
        line.error_reduction < kLinePoses * explained) {
      return false;
    }
    diagnosis.unexplained = std::move(line);
    return true;
  }

  /// Whether Coulomb friction that was named beside hysteresis is play: both make a force after each
  /// reversal. Coulomb friction explains the whole of its own, play knocks as well, and that comes after
  /// reversals too.
  static bool play_poses(const Diagnosis& diagnosis) {
    return diagnosis.unexplained && diagnosis.unexplained->coordinate == "reversal" &&
           coulomb_joins_hysteresis(diagnosis.baseline, diagnosis.explained);
  }

  /// A mass in the wrong unit, or time, position or force: the payload that would make up for it is no
  /// answer.
  std::optional<Structure> mass_of_another_axis(const Diagnosis& diagnosis) const {
    const auto told = [&](std::string description) {
      const double left = diagnosis.explained.holdout_rmse_N / diagnosis.baseline.holdout_rmse_N;
      return Structure{"acceleration", 1.0 - left, 0.0,
                       std::move(description) + ": check mass_kg and the units of time, position and force",
                       weighted_residual(diagnosis.baseline)};
    };
    // Whatever then takes the inertia back: a payload below zero, a mode of all the mass.
    if (measurement_.log().mass_kg && diagnosis.baseline.relative_error > kAnotherAxis) {
      return told(fmt::format("the declared mass would need {:.3g} times the measured force",
                              diagnosis.baseline.relative_error));
    }
    if (!contains(diagnosis.explained.terms, "payload_mass")) return {};
    for (std::size_t log = 0; log < measurement_.log_count(); ++log) {
      const double declared_kg = mass_kg(diagnosis.baseline.terms, log);
      const double found_kg = mass_kg(diagnosis.explained.terms, log);
      if (found_kg * kAnotherAxis > declared_kg && found_kg < kAnotherAxis * declared_kg) continue;
      return told(fmt::format("force and acceleration make a mass of {} where the log declares {}",
                              quantity(found_kg, "kg"), quantity(declared_kg, "kg")));
    }
    return {};
  }

  /// Whether so much is left, whatever its form, that calling the model complete would be wrong.
  static bool far_from_complete(const Diagnosis& diagnosis) {
    return diagnosis.explained.relative_error > kIncomplete &&
           diagnosis.explained.holdout_rmse_N > kFarAboveFloor * diagnosis.noise_floor_N;
  }

  /// Whether the best explanation leaves the axis unexplained by any measure: far above the floor, a fair
  /// share of the force, and most of what the baseline left. What it names is then a stand-in for something
  /// else.
  static bool insufficient(const Diagnosis& diagnosis) {
    const FittedModel& last = diagnosis.explained;
    return last.relative_error > kFairShareOfForce &&
           last.holdout_rmse_N > kFarAboveFloor * diagnosis.noise_floor_N &&
           last.holdout_rmse_N > kMostOfBaseline * diagnosis.baseline.holdout_rmse_N;
  }

  Eigen::VectorXd weighted_residual(const FittedModel& model) const {
    return model.linearisation->residual_N().cwiseProduct(measurement_.row_weights().cwiseSqrt());
  }

  static double far_above(double reduction) { return reduction + 0.25 * (1.0 - reduction); }

  /// Whether one place of the rail explains what several effects were gathered for, and far more than the
  /// first of them: a dent is no preload along the rail with a ripple to correct it.
  bool one_place_explains(Diagnosis& diagnosis, double best) const {
    if (diagnosis.steps.size() < 3) return false;
    Structure place = place_on_rail(at_rows(measurement_, measurement_.position_m()),
                                    at_rows(measurement_, measurement_.velocity_mps()),
                                    weighted_residual(diagnosis.baseline));
    const double first = 1.0 - diagnosis.steps[1].holdout_rmse_N / diagnosis.baseline.holdout_rmse_N;
    if (place.error_reduction < far_above(first) || place.error_reduction < kShareOfSeveral * best)
      return false;
    diagnosis.unexplained = std::move(place);
    return true;
  }

  /// Whether a free curve over one coordinate explains far more of the baseline's residual than all effects
  /// that were named: then those are stand-ins, and naming them would mislead.
  bool dominated(Diagnosis& diagnosis) const {
    const auto free = find_structure(measurement_, weighted_residual(diagnosis.baseline));
    const double best = 1.0 - diagnosis.explained.holdout_rmse_N / diagnosis.baseline.holdout_rmse_N;
    if (free.front().error_reduction < far_above(best)) return one_place_explains(diagnosis, best);
    diagnosis.unexplained = free.front();
    return true;
  }

  const Measurement& measurement_;
  const DiagnoseOptions& options_;
  double known_N_ = 0.0;  ///< see earned()
  NoiseFloor floor_;
  std::vector<Trial> trials_;
  std::vector<Explanation> first_level_;
};

}  // namespace

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::missing_effect:
      return "missing_effect";
    case Verdict::complete:
      return "complete";
    case Verdict::unexplained:
      return "unexplained";
  }
  return "unexplained";
}

Diagnosis diagnose(const Measurement& measurement, const DiagnoseOptions& options) {
  return Search(measurement, options).run();
}

}  // namespace slipstack::workbench
