// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/linear/linearisation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/base/wide_vectors.h"
#include "workbench/estimate/linear/run_effect.h"
#include "workbench/estimate/linear/tall_product.h"

namespace slipstack::workbench {
namespace {

using Eigen::Index;

bool same_parameters(const Term& one, const Term& other) {
  return one.shapes == other.shapes && one.gains == other.gains;
}

}  // namespace

MeasurementDynamics measurement_dynamics_of(const Terms& terms) {
  const Term* lag = find_role(terms, Role::measurement_delay);
  return lag == nullptr ? MeasurementDynamics{} : MeasurementDynamics{lag->shapes[0], lag->shapes[1]};
}

Eigen::VectorXd residual_of(const Measurement& measurement, const Terms& terms) {
  return measurement.force_N(measurement_dynamics_of(terms)) -
         measurement.filtered(evaluate_force(measurement, terms).force_N);
}

Linearisation::Linearisation(const Measurement& measurement, const Terms& terms, const Linearisation* known,
                             DryTrace dry)
    : measurement_(measurement), terms_(terms) {
  take_dry(std::move(dry));
  columns_.resize(measurement.row_count(), unknown_count(terms));
  Eigen::Index next = 0;
  std::vector<std::pair<std::size_t, Eigen::Index>> unknown;  // term, first column
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const auto count = static_cast<Eigen::Index>(terms[t].gains.size());
    if (count == 0) continue;
    if (const auto lent = lent_columns(known, terms[t])) {
      columns_.middleCols(next, count) = known->columns_.middleCols(*lent, count);
    } else {
      unknown.emplace_back(t, next);
    }
    next += count;
  }
  parallel_for(unknown.size(), [&](std::size_t i) {
    const auto [t, first] = unknown[i];
    columns_.middleCols(first, static_cast<Eigen::Index>(terms[t].gains.size())) =
        build(terms[t], derivatives_by(*terms[t].effect, t));
  });
  retarget(force_at(terms_));
}

Linearisation::Linearisation(const Linearisation& near, const Terms& terms, DryTrace dry)
    : measurement_(near.measurement_), terms_(terms), columns_(near.columns_) {
  const bool same = std::equal(terms.begin(), terms.end(), near.terms_.begin(), same_parameters);
  if (dry.dry_N.empty() && same && has(Acts::dry_scale)) dry = near.dry();
  retarget(near.force_at(terms, &dry));
  take_dry(std::move(dry));
}

void Linearisation::take_dry(DryTrace dry) {
  if (dry.dry_N.empty()) return;
  std::call_once(dry_known_, [&] { dry_ = std::move(dry); });
}

void Linearisation::retarget(const Eigen::VectorXd& force_N) {
  measured_N_ = measurement_.force_N(measurement_dynamics_of(terms_));
  force_N_ = force_N;
  target_ = measured_N_ - force_N_ + tall_combination(columns_, gains_of(terms_));
}

const DryTrace& Linearisation::dry() const {
  std::call_once(dry_known_, [this] { dry_ = evaluate_dry(measurement_, terms_); });
  return dry_;
}

const ForceTrace& Linearisation::whole() const {
  std::call_once(whole_known_, [this] { whole_ = evaluate_force(measurement_, terms_, dry()); });
  return whole_;
}

bool Linearisation::has(Acts acts) const {
  return std::any_of(terms_.begin(), terms_.end(),
                     [acts](const Term& term) { return acts_with_gains(term, acts); });
}

/// Whether contributions of this kind are multiplied by nothing.
bool Linearisation::adds_up(Acts acts) const {
  if (has(Acts::total_scale)) return false;
  return acts == Acts::force || (acts == Acts::dry && !has(Acts::dry_scale));
}

/// Columns x gains of what is linear. `evaluated` is set for the terms whose linear part is not in it.
Eigen::VectorXd Linearisation::linear_force(const Terms& terms, std::vector<bool>& evaluated) const {
  Eigen::VectorXd gains = gains_of(terms);
  Index next = 0;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    evaluated[t] = terms[t].shapes != terms_[t].shapes;
    for (std::size_t set = 0; !terms[t].gains.empty() && set < terms[t].gain_sets(); ++set) {
      for (const GainGroup& group : terms[t].effect->gain_groups) {
        if (evaluated[t] || !adds_up(group.acts)) gains.segment(next, group.count).setZero();
        next += group.count;
      }
    }
  }
  return tall_combination(columns_, gains);
}

Eigen::VectorXd Linearisation::force_at(const Terms& terms, DryTrace* dry_of_terms) const {
  bool same_dry = true;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    if (acts_with_gains(terms[t], Acts::dry)) same_dry = same_dry && same_parameters(terms[t], terms_[t]);
  }
  DryTrace own;
  DryTrace& there = dry_of_terms == nullptr ? own : *dry_of_terms;
  const auto dry_there = [&]() -> const DryTrace& {
    if (&terms == &terms_) return dry();
    if (there.dry_N.empty()) there = evaluate_dry(measurement_, terms, same_dry ? &dry().dry_N : nullptr);
    return there;
  };
  if (has(Acts::total_scale)) {
    if (&terms == &terms_) return measurement_.filtered(whole().force_N);
    return measurement_.filtered(evaluate_force(measurement_, terms, dry_there()).force_N);
  }
  std::vector<bool> evaluated(terms.size());
  Eigen::VectorXd force_N = linear_force(terms, evaluated);
  std::vector<double> rest_N;
  const auto add = [&](const Term& term, Acts acts) {
    rest_N.resize(measurement_.sample_count(), 0.0);
    // What reads the dry friction modulates it.
    static const std::vector<double> kUnknown;
    add_contribution(measurement_, term, acts, kUnknown, rest_N);
  };
  for (std::size_t t = 0; t < terms.size(); ++t) {
    if (!evaluated[t]) continue;
    for (const Acts acts : {Acts::force, Acts::dry}) {
      if (adds_up(acts) && acts_with_gains(terms[t], acts)) add(terms[t], acts);
    }
  }
  if (has(Acts::dry_scale)) {
    rest_N.resize(measurement_.sample_count(), 0.0);
    const DryTrace& trace = dry_there();
    for (std::size_t i = 0; i < rest_N.size(); ++i) rest_N[i] += trace.dry_N[i] * trace.dry_factor[i];
  }
  if (!rest_N.empty()) force_N += measurement_.filtered(rest_N);
  return force_N;
}

Eigen::VectorXd Linearisation::residual_at(const Terms& terms, DryTrace* dry_of_terms) const {
  const MeasurementDynamics here = measurement_dynamics_of(terms_);
  const MeasurementDynamics there = measurement_dynamics_of(terms);
  if (here.delay_s == there.delay_s && here.filter_s == there.filter_s)
    return measured_N_ - force_at(terms, dry_of_terms);
  return measurement_.force_N(there) - force_at(terms, dry_of_terms);
}

std::optional<Eigen::Index> Linearisation::lent_columns(const Linearisation* known, const Term& term) const {
  if (known == nullptr) return {};
  for (const GainGroup& group : term.effect->gain_groups) {
    if (!adds_up(group.acts) || !known->adds_up(group.acts)) return {};
  }
  Eigen::Index next = 0;
  for (const Term& other : known->terms_) {
    if (other.effect == term.effect && other.shapes == term.shapes) return next;
    next += static_cast<Eigen::Index>(other.gains.size());
  }
  return {};
}

std::vector<double> Linearisation::derivative_by(Acts acts, std::size_t term_index) const {
  if (adds_up(acts)) return {};
  const bool whole_needed = acts == Acts::total_scale || has(Acts::total_scale);
  const DryTrace& trace = whole_needed ? whole() : dry();
  if (acts == Acts::dry && !whole_needed) return trace.dry_factor;
  static const std::vector<double> kOne;
  const std::vector<double>& total_factor = whole_needed ? whole().total_factor : kOne;
  const std::vector<double>* own_factor = &kOne;
  if (term_index < terms_.size() && acts == Acts::dry_scale) own_factor = &trace.dry_scales[term_index];
  if (term_index < terms_.size() && acts == Acts::total_scale) own_factor = &whole().total_scales[term_index];
  std::vector<double> derivative(measurement_.sample_count());
  for (std::size_t i = 0; i < derivative.size(); ++i) {
    const ComposedForce at{trace.dry_N[i], factor_at(trace.dry_factor, i), factor_at(total_factor, i),
                           whole_needed ? whole_.force_N[i] : 0.0};
    derivative[i] = at.derivative(acts, factor_at(*own_factor, i));
  }
  return derivative;
}

Linearisation::Derivatives Linearisation::derivatives_by(const EffectDescription& effect,
                                                         std::size_t term_index) const {
  Derivatives derivatives;
  for (const Acts acts : kWaysToAct) {
    if (effect.acts_as(acts)) derivatives.by(acts) = derivative_by(acts, term_index);
  }
  return derivatives;
}

const Linearisation::Derivatives& Linearisation::derivatives_beside(const EffectDescription& effect) const {
  for (std::size_t way = 0; way < kWaysToAct.size(); ++way) {
    const Acts acts = kWaysToAct[way];
    if (!effect.acts_as(acts)) continue;
    std::call_once(beside_known_[way], [&] { beside_.by(acts) = derivative_by(acts, terms_.size()); });
  }
  return beside_;
}

/// Writes the basis at samples [first, first + count), multiplied by the derivative of the force.
void Linearisation::multiply_basis(const Term& term, const Derivatives& derivatives, std::size_t first,
                                   std::size_t count, const double* basis, double* out) {
  const std::size_t gains = term.gains_per_set();
  const auto& groups = term.effect->gain_groups;
  const bool alike = std::all_of(groups.begin(), groups.end(),
                                 [&](const GainGroup& group) { return group.acts == groups.front().acts; });
  if (alike && !groups.empty() && !derivatives.by(groups.front().acts).empty()) {
    const double* const factor = derivatives.by(groups.front().acts).data() + first;
    run_wide([&] {
      if (gains == 1) {
        for (std::size_t i = 0; i < count; ++i) out[i] = basis[i] * factor[i];
      } else {
        for (std::size_t i = 0; i < count; ++i) {
          for (std::size_t g = 0; g < gains; ++g) out[i * gains + g] = basis[i * gains + g] * factor[i];
        }
      }
    });
    return;
  }
  std::copy_n(basis, count * gains, out);
  std::size_t gain = 0;
  for (const GainGroup& group : groups) {
    const auto own = static_cast<std::size_t>(group.count);
    const std::vector<double>& factor = derivatives.by(group.acts);
    for (std::size_t i = 0; !factor.empty() && i < count; ++i) {
      for (std::size_t g = gain; g < gain + own; ++g) out[i * gains + g] *= factor[first + i];
    }
    gain += own;
  }
}

Eigen::MatrixXd Linearisation::columns_of(const Term& candidate) const {
  return build(candidate, derivatives_beside(*candidate.effect));
}

Eigen::MatrixXd Linearisation::build(const Term& term, const Derivatives& derivatives) const {
  const std::size_t gains = term.gains_per_set();
  const std::size_t sets = term.gain_sets();
  RowCollector collector(measurement_.filter(), measurement_.row_samples(), gains);
  std::size_t held = 0;
  static const std::vector<double> kUnknown;
  // What reads the dry friction modulates it.
  const std::vector<double>& dry_N = term.effect->acts_as(Acts::dry_scale) ? dry().dry_N : kUnknown;
  run_basis_of(measurement_, term, dry_N, [&](std::size_t first, std::size_t count, const double* basis) {
    // What exceeds the space of the collector goes into its next chunk.
    for (std::size_t done = 0; done < count;) {
      const std::size_t n = std::min(count - done, collector.chunk() - held);
      double* out = collector.space() + held * gains;
      multiply_basis(term, derivatives, first + done, n, basis + done * gains, out);
      held += n;
      done += n;
      if (held == collector.chunk()) collector.commit(std::exchange(held, 0));
    }
  });
  collector.commit(held);
  if (sets == 1) return collector.take();
  // No filter reaches from one log into another, so the column of one log's gain is the common column at the
  // rows of that log and zero elsewhere.
  const Eigen::MatrixXd common = collector.take();
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(common.rows(), static_cast<Eigen::Index>(gains * sets));
  for (const LogPart& part : measurement_.parts()) {
    const auto first = static_cast<Eigen::Index>(part.first_row);
    const auto count = static_cast<Eigen::Index>(part.row_count);
    own.block(first, static_cast<Eigen::Index>(part.log * gains), count, static_cast<Eigen::Index>(gains)) =
        common.middleRows(first, count);
  }
  return own;
}

}  // namespace slipstack::workbench
