// SPDX-License-Identifier: Apache-2.0
#include "workbench/plan/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <stdexcept>

#include "workbench/identify/noise_floor.h"
#include "workbench/identify/shape_search.h"
#include "workbench/plan/pieces.h"

namespace slipstack::workbench {
namespace {

constexpr double kSettle_s = 0.5;
/// Pieces whose gain is less than this share of the first's, for their time, end the plan.
constexpr double kWorthTaking = 0.01;
constexpr int kMostRepeats = 3;
constexpr double kPresliding_m = 20e-6;  ///< where the model has no hysteresis
/// Columns that an effect may imitate others with.
constexpr int kMostImitationColumns = 24;

/// Travel over which the hysteresis of a model reaches nine tenths of its level.
double presliding_of(const Terms& terms) {
  const Term* hysteresis = find_term(terms, "presliding_hysteresis");
  if (hysteresis == nullptr) return kPresliding_m;
  double level_N = 0.0;
  for (std::size_t i = 0; i < hysteresis->gains.size(); ++i) {
    level_N += hysteresis->gains[i] * hysteresis->shapes[i];
  }
  std::vector<std::size_t> order(hysteresis->gains.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return hysteresis->shapes[a] < hysteresis->shapes[b]; });
  double reached_N = 0.0;
  for (const std::size_t i : order) {
    reached_N += hysteresis->gains[i] * hysteresis->shapes[i];
    if (reached_N >= 0.9 * level_N && hysteresis->shapes[i] > 0.0) return hysteresis->shapes[i];
  }
  return kPresliding_m;
}

Terms with(Terms terms, const Terms& more) {
  for (const Term& term : more) {
    if (!contains(terms, term.effect->text.id)) terms.push_back(term);
  }
  return terms;
}

/// What would be recorded along a motion by an axis that is as the model says.
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

/// Shapes at which an effect may pass for another: its own search's starting points, a few of them.
std::vector<std::vector<double>> imitations_of(const Measurement& measurement, const Term& term) {
  if (term.gains.empty() || searched_shapes(measurement, *term.effect).empty()) return {};
  const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(measurement.row_count());
  const auto points = starting_shapes(measurement, *term.effect, nothing, nothing);
  const auto most = static_cast<std::size_t>(std::max(1, kMostImitationColumns / term.effect->gain_count));
  const std::size_t stride = std::max<std::size_t>(1, points.size() / most);
  std::vector<std::vector<double>> few;
  for (std::size_t i = 0; i < points.size() && few.size() < most; i += stride) few.push_back(points[i]);
  return few;
}

std::vector<Information::Expected> expected_effects(const Measurement& measurement, const Terms& effects) {
  std::vector<Information::Expected> expected;
  for (const Term& term : effects) expected.push_back({term, imitations_of(measurement, term)});
  return expected;
}

int free_parameters(const Term& term) {
  return term.effect->parameter_count();
}

std::vector<ExpectedEvidence> evidence_of(const Information& information, const Terms& effects) {
  std::vector<ExpectedEvidence> all;
  const auto put = [&](std::size_t i, const std::string& other, const Information::Figure& figure, int more) {
    const double n = std::max(figure.rows, 2.0);
    all.push_back({effects[i].id(), other, figure.angle_deg, figure.chi_squared,
                   n * std::log1p(figure.chi_squared / n) - more * std::log(n)});
  };
  for (std::size_t i = 0; i < effects.size(); ++i) {
    put(i, "", information.alone(i), free_parameters(effects[i]));
    for (std::size_t j = 0; j < effects.size(); ++j) {
      if (i == j) continue;
      const int more = std::max(0, free_parameters(effects[i]) - free_parameters(effects[j]));
      put(i, effects[j].id(), information.against(i, j), more);
    }
  }
  return all;
}

/// What is learned about all effects and pairs; grows ever more slowly with more of the same.
double worth(const Information& information, const Terms& effects) {
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

/// Level of the dry friction that a model has.
double friction_level_N(const Terms& terms) {
  double level_N = 0.0;
  for (const Term& term : terms) {
    if (term.id() == "coulomb") level_N += term.gains[0];
    if (term.id() != "presliding_hysteresis") continue;
    for (std::size_t i = 0; i < term.gains.size(); ++i) level_N += term.gains[i] * term.shapes[i];
  }
  return level_N;
}

/// The pieces one after the other, each reached by a move of its own.
struct Sequence {
  SetPoints motion;
  std::vector<std::pair<std::size_t, std::size_t>> samples;  ///< first and end of each piece
};

/// Pace of the moves between pieces: half, since the way there teaches nothing; slower where the force asks
/// for it. Acceleration goes with its square.
double pace_of(const AxisLimits& limits, const Terms& model) {
  constexpr double kHalf = 0.5;
  if (limits.force_N <= 0.0 || mass_kg(model) <= 0.0) return kHalf;
  const double left_N = 0.8 * limits.force_N - friction_level_N(model);
  const double full_N = mass_kg(model) * limits.acceleration_mps2;
  return std::clamp(std::sqrt(std::max(left_N, 0.0) / full_N), 0.05, kHalf);
}

Sequence in_sequence(const std::vector<const Piece*>& pieces, const AxisLimits& limits, const Terms& model,
                     double rate_Hz) {
  const double pace = pace_of(limits, model);
  MotionBuilder builder(rate_Hz, pieces.front()->start_m);
  Sequence sequence;
  builder.dwell(kSettle_s);
  for (const Piece* piece : pieces) {
    builder.move_to(piece->start_m, limits, pace);
    const std::size_t first = builder.size();
    piece->append(builder);
    sequence.samples.emplace_back(first, builder.size());
  }
  builder.dwell(kSettle_s);
  sequence.motion = builder.points();
  return sequence;
}

std::vector<int> groups_of(const Measurement& measurement, const Sequence& sequence) {
  std::vector<int> groups;
  groups.reserve(measurement.row_samples().size());
  std::size_t piece = 0;
  for (const std::size_t sample : measurement.row_samples()) {
    while (piece < sequence.samples.size() && sample >= sequence.samples[piece].second) ++piece;
    const bool inside = piece < sequence.samples.size() && sample >= sequence.samples[piece].first;
    groups.push_back(inside ? static_cast<int>(piece) : -1);
  }
  return groups;
}

/// An effect as strong as an experiment should show it: see Knowledge.
Term as_expected(const Measurement& measurement, const FittedModel& base, Term term) {
  constexpr double kShareOfFriction = 0.05;
  if (term.shapes.size() != term.effect->shapes.size()) term = make_term(measurement, *term.effect);
  if (term.gains.empty()) return term;
  const bool none =
      std::all_of(term.gains.begin(), term.gains.end(), [](double gain) { return gain == 0.0; });
  if (none) {
    for (std::size_t g = 0; g < term.gains.size(); ++g) {
      const GainGroup& group = term.effect->group_of_gain(static_cast<int>(g));
      // Of a map or harmonics, a pattern; it is scaled below.
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
    find_pieces();
    report("ask the model", 0.2);
    learn();
    report("choose", 0.7);
    const std::vector<const Piece*> chosen = choose();
    report("judge the plan", 0.8);
    return judged(chosen);
  }

 private:
  void report(const std::string& stage, double fraction) const {
    if (options_.progress) options_.progress(stage, fraction);
  }

  double duration_s(const Piece& piece) const {
    MotionBuilder builder(knowledge_.rate_Hz, piece.start_m);
    piece.append(builder);
    return static_cast<double>(builder.size()) / knowledge_.rate_Hz;
  }

  /// Those that fit into the time and the force.
  void find_pieces() {
    for (Piece& piece : possible_pieces(options_.limits, presliding_of(knowledge_.model))) {
      MotionBuilder builder(knowledge_.rate_Hz, piece.start_m);
      builder.dwell(0.01);
      piece.append(builder);
      if (static_cast<double>(builder.size()) / knowledge_.rate_Hz > options_.seconds - 2.0 * kSettle_s)
        continue;
      if (options_.limits.force_N > 0.0) {
        const std::vector<double> force_N = force_along(builder.points(), knowledge_.model);
        const bool strong = std::any_of(force_N.begin(), force_N.end(), [&](double force) {
          return std::abs(force) > 0.9 * options_.limits.force_N;
        });
        if (strong) continue;
      }
      pieces_.push_back(std::move(piece));
    }
    if (pieces_.empty()) {
      throw std::invalid_argument(
          "no motion fits into the limits; give a longer stroke, more speed, acceleration, jerk or force");
    }
  }

  void learn() {
    std::vector<const Piece*> all;
    for (const Piece& piece : pieces_) all.push_back(&piece);
    const Sequence sequence = in_sequence(all, options_.limits, knowledge_.model, knowledge_.rate_Hz);
    const Measurement measurement = expected_measurement(knowledge_, sequence.motion);
    const FittedModel base = fit_gains(measurement, knowledge_.model);
    for (const Term& term : knowledge_.effects) effects_.push_back(as_expected(measurement, base, term));
    possible_ = effects_;
    // What a log says of the shapes of an effect that it hardly shows may be far off: the middle of their
    // ranges is as possible, and the motion shall show that too.
    for (const Term& term : effects_) {
      if (term.gains.empty() || searched_shapes(measurement, *term.effect).empty()) continue;
      Term other = term;
      other.shapes = default_shapes(measurement, *term.effect);
      possible_.push_back(as_expected(measurement, base, std::move(other)));
    }
    information_ = Information::of(measurement, base, expected_effects(measurement, possible_),
                                   groups_of(measurement, sequence), static_cast<int>(all.size()),
                                   NoiseFloor(measurement).of(base.terms));
    for (const Piece& piece : pieces_) durations_s_.push_back(duration_s(piece) + kSettle_s);
    if (options_.limits.force_N <= 0.0) return;
    // With the effects as strong as they are expected, some pieces may ask for too much: they are not taken.
    // What the hysteresis adds depends on what comes before, so inertia and friction count at their worst.
    const std::vector<double> force_N = force_along(sequence.motion, with(knowledge_.model, effects_));
    const double mass = mass_kg(knowledge_.model);
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      double inertia_N = 0.0;
      double friction_N = friction_level_N(knowledge_.model);
      for (std::size_t i = sequence.samples[p].first; i < sequence.samples[p].second; ++i) {
        const double own_N = mass * sequence.motion.acceleration_mps2[i];
        inertia_N = std::max(inertia_N, std::abs(own_N));
        friction_N = std::max(friction_N, std::abs(force_N[i] - own_N));
      }
      if (inertia_N + friction_N > options_.limits.force_N) durations_s_[p] = 2.0 * options_.seconds;
    }
  }

  std::vector<const Piece*> choose() {
    std::vector<const Piece*> chosen;
    std::vector<int> taken(pieces_.size(), 0);
    Information known = information_.front();
    bool any = false;
    double left_s = options_.seconds - 2.0 * kSettle_s;
    double first_rate = 0.0;
    while (true) {
      const double before = any ? worth(known, possible_) : 0.0;
      std::size_t best = pieces_.size();
      double best_rate = 0.0;
      for (std::size_t p = 0; p < pieces_.size(); ++p) {
        if (durations_s_[p] > left_s || taken[p] == kMostRepeats) continue;
        Information more = information_[p];
        if (any) more.add(known);
        const double rate = (worth(more, possible_) - before) / durations_s_[p];
        if (rate > best_rate) {
          best_rate = rate;
          best = p;
        }
      }
      if (best == pieces_.size() || best_rate < kWorthTaking * first_rate) break;
      if (!any) first_rate = best_rate;
      if (any) {
        known.add(information_[best]);
      } else {
        known = information_[best];
      }
      any = true;
      ++taken[best];
      left_s -= durations_s_[best];
      chosen.push_back(&pieces_[best]);
    }
    if (chosen.empty()) {
      throw std::invalid_argument(
          "no motion within the limits and the time shows these effects; allow more speed, force or time");
    }
    return chosen;
  }

  Plan judged(std::vector<const Piece*> chosen) const {
    // Moves between the pieces take time that was only estimated.
    Sequence sequence = in_sequence(chosen, options_.limits, knowledge_.model, knowledge_.rate_Hz);
    while (sequence.motion.duration_s() > options_.seconds && chosen.size() > 1) {
      chosen.pop_back();
      sequence = in_sequence(chosen, options_.limits, knowledge_.model, knowledge_.rate_Hz);
    }
    Plan plan;
    plan.motion = std::move(sequence.motion);
    for (const Piece* piece : chosen) plan.pieces.push_back(piece->name);
    const Measurement measurement = expected_measurement(knowledge_, plan.motion);
    const FittedModel base = fit_gains(measurement, knowledge_.model);
    plan.effects = effects_;
    plan.expected = expected_evidence(measurement, base, effects_);
    for (const double force : force_along(plan.motion, with(knowledge_.model, knowledge_.effects))) {
      plan.peak_force_N = std::max(plan.peak_force_N, std::abs(force));
    }
    return plan;
  }

  const Knowledge& knowledge_;
  const PlanOptions& options_;
  Terms effects_;   ///< as expected
  Terms possible_;  ///< those, and with other shapes
  std::vector<Piece> pieces_;
  std::vector<Information> information_;
  std::vector<double> durations_s_;
};

}  // namespace

std::vector<ExpectedEvidence> expected_evidence(const Measurement& measurement, const FittedModel& base,
                                                const Terms& effects) {
  const std::vector<int> groups(measurement.row_samples().size(), 0);
  Terms on_logs;
  for (const Term& term : effects) {
    const bool each = measurement.gain_sets(term.effect->text.id) > 1;
    on_logs.push_back(each ? with_gain_sets(measurement, term) : term);
  }
  std::vector<Information> all = Information::of(measurement, base, expected_effects(measurement, on_logs),
                                                 groups, 1, NoiseFloor(measurement).of(base.terms));
  if (measurement.is_excerpt()) {
    all.front().repeat(static_cast<double>(measurement.whole_sample_count()) /
                       static_cast<double>(measurement.sample_count()));
  }
  return evidence_of(all.front(), effects);
}

Plan plan_experiment(const Knowledge& knowledge, const PlanOptions& options) {
  return Planner(knowledge, options).run();
}

}  // namespace slipstack::workbench
