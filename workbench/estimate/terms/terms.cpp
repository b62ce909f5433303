// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/terms/terms.h"

#include <algorithm>
#include <cmath>

#include "workbench/base/statistics.h"
#include "workbench/estimate/terms/search_ranges.h"

namespace slipstack::workbench {
namespace {

/// Prior standard deviations of dimensionless modulations: of the value, and of the second difference between
/// neighbouring points of a map. Chosen: a modulation is rarely above one half of what it modulates.
constexpr double kModulationPrior = 0.5;
constexpr double kBendPrior = 0.3;
/// Prior standard deviation of the mean of a map. The map and the level that it modulates are otherwise not
/// unique: a map of -50 % everywhere with twice the level would give the same force.
constexpr double kMeanPrior = 0.01;

void penalise_modulation(const GainGroup& group, Eigen::Index first, double variance,
                         Eigen::MatrixXd& penalty) {
  for (Eigen::Index i = first; i < first + group.count; ++i) {
    penalty(i, i) += variance / (kModulationPrior * kModulationPrior);
  }
  if (!group.smooth) return;
  const Eigen::Vector3d bend(1.0, -2.0, 1.0);
  for (Eigen::Index i = first; i + 2 < first + group.count; ++i) {
    penalty.block<3, 3>(i, i) += variance / (kBendPrior * kBendPrior) * bend * bend.transpose();
  }
  const auto splines = static_cast<double>(group.count);
  penalty.block(first, first, group.count, group.count).array() += variance / squared(kMeanPrior * splines);
}

/// A gain: its term, where the term begins among the unknowns, and its index in a set.
struct GainAt {
  const Term* term = nullptr;
  Eigen::Index first = 0;
  std::size_t index = 0;

  double lower(std::size_t set) const { return term->lower[at(set)]; }
  double upper(std::size_t set) const { return term->upper[at(set)]; }
  Eigen::Index unknown(std::size_t set) const { return first + static_cast<Eigen::Index>(at(set)); }

 private:
  std::size_t at(std::size_t set) const { return set * term->gains_per_set() + index; }
};

GainAt gain_at(const Terms& terms, const Term& term, int gain) {
  Eigen::Index first = 0;
  for (const Term& before : terms) {
    if (&before == &term) break;
    first += static_cast<Eigen::Index>(before.gains.size());
  }
  return {&term, first, static_cast<std::size_t>(gain)};
}

/// Keeps a gain that is a part of another effect's gain (PartOfAnother) within it.
void couple_part(const Terms& terms, const Term& term, NormalEquations::Constraints& constraints) {
  const GainAt part = gain_at(terms, term, term.effect->traits.part_of_another.gain);
  const Term* other = find_role(terms, term.effect->traits.part_of_another.whole);
  for (std::size_t set = 0; set < term.gain_sets(); ++set) {
    const Eigen::Index b = part.unknown(set);
    if (other == nullptr) {
      constraints.lower(b) = constraints.upper(b) = 0.0;
      continue;
    }
    // Where only one of the two is fitted for each log separately, there are no pairs to couple.
    if (other->gain_sets() != term.gain_sets()) continue;
    const GainAt whole = gain_at(terms, *other, 0);
    const Eigen::Index a = whole.unknown(set);
    if (whole.lower(set) == whole.upper(set)) {
      constraints.lower(b) = std::max(constraints.lower(b), -whole.upper(set));
      constraints.upper(b) = std::min(constraints.upper(b), whole.upper(set));
    } else if (part.lower(set) == part.upper(set)) {
      constraints.lower(a) = std::max(constraints.lower(a), std::abs(part.upper(set)));
    } else {
      constraints.pairs.emplace_back(a, b);
    }
  }
}

/// Of two gains that give the same force, which no data can split, all of it is assigned to the other one.
/// (The mass of the axis could otherwise come out as zero beside the rigid mass of a mode.)
void leave_to_another(const Terms& terms, const Term& term, int gain,
                      NormalEquations::Constraints& constraints) {
  const GainAt same = gain_at(terms, term, gain);
  for (std::size_t set = 0; set < term.gain_sets(); ++set) {
    constraints.lower(same.unknown(set)) = constraints.upper(same.unknown(set)) = 0.0;
  }
}

void couple_gains(const Terms& terms, NormalEquations::Constraints& constraints) {
  const bool free_mass = mass_is_free(terms);
  const bool has_constant = find_role(terms, Role::constant_force) != nullptr;
  for (const Term& term : terms) {
    const EffectTraits& traits = term.effect->traits;
    if (traits.part_of_another.gain >= 0) couple_part(terms, term, constraints);
    if (free_mass && traits.axis_mass_gain >= 0)
      leave_to_another(terms, term, traits.axis_mass_gain, constraints);
    if (has_constant && traits.constant_gain >= 0)
      leave_to_another(terms, term, traits.constant_gain, constraints);
  }
}

}  // namespace

Term make_term(const Measurement& measurement, const EffectDescription& effect) {
  Term term;
  term.effect = &effect;
  for (const GainGroup& group : effect.gain_groups) {
    for (int i = 0; i < group.count; ++i) {
      term.gains.push_back(0.0);
      term.lower.push_back(static_cast<double>(group.lower));
      term.upper.push_back(static_cast<double>(group.upper));
    }
  }
  term.shapes = default_shapes(measurement, effect);
  return with_gain_sets(measurement, std::move(term));
}

Term term_for_log(const Measurement& measurement, const EffectDescription& effect) {
  Term term = make_term(measurement, effect);
  if (term.effect->has_role(Role::inertia)) set_declared_mass(measurement, term);
  return term;
}

void set_declared_mass(const Measurement& measurement, Term& inertia) {
  const auto& parts = measurement.parts();
  if (!parts.front().mass_kg) return;
  // Every log declares its own mass, so there is one gain per log, whatever --per-log says.
  while (inertia.gains.size() < measurement.log_count()) inertia.gains.push_back(0.0);
  inertia.lower.resize(inertia.gains.size());
  inertia.upper.resize(inertia.gains.size());
  for (const LogPart& part : parts) {
    inertia.gains[part.log] = inertia.lower[part.log] = inertia.upper[part.log] = *part.mass_kg;
  }
}

NormalEquations::Constraints constraints_of(const Terms& terms, double error_N) {
  const Eigen::Index count = unknown_count(terms);
  NormalEquations::Constraints constraints{
      Eigen::VectorXd(count), Eigen::VectorXd(count), Eigen::MatrixXd::Zero(count, count), {}};
  const double variance = error_N * error_N;
  Eigen::Index next = 0;
  for (const Term& term : terms) {
    Eigen::Index first = next;
    for (std::size_t set = 0; set < term.gain_sets(); ++set) {
      for (const GainGroup& group : term.effect->gain_groups) {
        if (group.acts == Acts::dry_scale || group.acts == Acts::total_scale) {
          penalise_modulation(group, first, variance, constraints.penalty);
        }
        first += group.count;
      }
    }
    for (std::size_t i = 0; i < term.gains.size(); ++i, ++next) {
      constraints.lower(next) = term.lower[i];
      constraints.upper(next) = term.upper[i];
    }
  }
  couple_gains(terms, constraints);
  return constraints;
}

Term with_gain_sets(const Measurement& measurement, Term term) {
  // What is not of the catalogue is not in the list of the measurement.
  const bool outside = find_in_catalogue(term.effect->text.id) == nullptr;
  const std::size_t sets = outside && term.effect->traits.per_log
                               ? measurement.log_count()
                               : measurement.gain_sets(term.effect->text.id);
  const std::size_t count = term.gains_per_set();
  for (std::vector<double>* values : {&term.gains, &term.lower, &term.upper}) {
    const std::vector<double> first(values->begin(), values->begin() + static_cast<std::ptrdiff_t>(count));
    for (std::size_t set = 1; set < sets; ++set) values->insert(values->end(), first.begin(), first.end());
  }
  return term;
}

Terms terms_on(const Measurement& measurement, Terms terms) {
  for (Term& term : terms) {
    term = with_gain_sets(measurement, std::move(term));
    if (term.effect->has_role(Role::inertia)) set_declared_mass(measurement, term);
  }
  return terms;
}

Terms averaged_over_logs(const Measurement& measurement, Terms terms) {
  const auto samples = static_cast<double>(measurement.whole_sample_count());
  for (Term& term : terms) {
    const std::size_t sets = term.gain_sets();
    const std::size_t count = term.gains_per_set();
    if (sets == 1) continue;
    const auto mean = [&](std::vector<double>& values, bool of_squares) {
      if (values.size() != sets * count) return;
      for (std::size_t g = 0; g < count; ++g) {
        double sum = 0.0;
        for (std::size_t set = 0; set < sets; ++set) {
          const double weight = static_cast<double>(measurement.log_sample_count(set)) / samples;
          const double own = weight * values[set * count + g];
          sum += of_squares ? own * own : own;
        }
        values[g] = of_squares ? std::sqrt(sum) : sum;
      }
      values.resize(count);
    };
    mean(term.gains, false);
    mean(term.lower, false);
    mean(term.upper, false);
    mean(term.gain_standard_errors, true);
    term.total_standard_errors.clear();
  }
  return terms;
}

}  // namespace slipstack::workbench
