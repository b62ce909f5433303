// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/linear/linearisation.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slipstack::workbench {
namespace {

using Eigen::Index;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Samples over which an effect is run at once: the basis of thirty gains then stays in the first-level
/// cache.
constexpr std::size_t kSampleChunk = 128;

/// Runs dry friction from sample `first` on, through the turning points that lie between samples.
/// `unobserved` has room for the basis at one of these, which is discarded.
void run_through_turning_points(const Measurement& measurement, EffectBasis& basis, std::size_t first,
                                std::span<const Sample<double>> samples, std::size_t gains, double* values,
                                double* unobserved) {
  std::size_t done = 0;
  for (const TurningPoint& turning_point : measurement.turning_points(first, samples.size())) {
    const std::size_t ahead = turning_point.before_sample - first;
    basis.run(samples.subspan(done, ahead - done), values + done * gains);
    Sample<double> between = samples[ahead];
    between.displacement = turning_point.displacement_m;
    basis.run(std::span(&between, 1), unobserved);
    done = ahead;
  }
  basis.run(samples.subspan(done), values + done * gains);
}

/// Runs one effect over the logs, chunk by chunk: visit(first sample, count, basis[sample][gain]). The state
/// of the effect is reset at the start of every part.
template <class Visit>
void run_effect(const Measurement& measurement, const Term& term, const std::vector<double>& dry_N,
                Visit&& visit) {
  const auto basis = term.effect->make();
  const std::size_t gains = term.gains_per_set();
  basis->prepare(term.shapes, {.tick_s = measurement.tick_s(), .metres_per_displacement = 1.0});
  std::vector<Sample<double>> samples(kSampleChunk);
  std::vector<double> values(kSampleChunk * std::max<std::size_t>(gains, 1));
  std::vector<double> unobserved(std::max<std::size_t>(gains, 1));
  for (std::size_t first = 0; first < measurement.sample_count(); first += kSampleChunk) {
    const std::size_t count = std::min(kSampleChunk, measurement.sample_count() - first);
    measurement.each_part(first, count, [&](std::size_t part, std::size_t from, std::size_t part_count) {
      const std::size_t at = from - first;
      for (std::size_t i = at; i < at + part_count; ++i) {
        samples[i] = measurement.sample(first + i, part);
        if (!dry_N.empty()) samples[i].dry_friction_N = dry_N[first + i];
      }
      if (from == measurement.parts()[part].first_sample) basis->reset(measurement.sample(from, part));
      const auto own = std::span(samples).subspan(at, part_count);
      double* const out = values.data() + at * gains;
      if (term.effect->acts_as(Acts::dry)) {
        run_through_turning_points(measurement, *basis, from, own, gains, out, unobserved.data());
      } else {
        basis->run(own, out);
      }
    });
    visit(first, count, values.data());
  }
}

void multiply(std::vector<double>& product, const std::vector<double>& factor) {
  if (factor.empty()) return;
  if (product.empty()) {
    product = factor;
    return;
  }
  for (std::size_t i = 0; i < product.size(); ++i) product[i] *= factor[i];
}

double factor_at(const std::vector<double>& factor, std::size_t sample) {
  return factor.empty() ? 1.0 : factor[sample];
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

ForceTrace evaluate_force(const Measurement& measurement, const Terms& terms,
                          const std::vector<double>* dry_N) {
  ForceTrace trace;
  const std::size_t samples = measurement.sample_count();
  std::vector<double> plain_N(samples, 0.0);  // sum of `force`
  trace.dry_N.assign(samples, 0.0);
  trace.dry_scales.assign(terms.size(), {});
  trace.total_scales.assign(terms.size(), {});

  const auto accumulate = [&](std::size_t t, bool dry_pass) {
    const Term& term = terms[t];
    if (term.gains.empty() || term.effect->acts_as(Acts::dry) != dry_pass) return;
    if (term.effect->acts_as(Acts::dry_scale)) trace.dry_scales[t].assign(samples, 1.0);
    if (term.effect->acts_as(Acts::total_scale)) trace.total_scales[t].assign(samples, 1.0);
    const auto gains = static_cast<Index>(term.gains_per_set());
    const Eigen::Map<const Eigen::MatrixXd> gain(term.gains.data(), gains,
                                                 static_cast<Index>(term.gain_sets()));
    struct Share {
      Index first, count;  ///< of the gains
      double* sum;
    };
    std::vector<Share> shares;
    Index first_gain = 0;
    for (const GainGroup& group : term.effect->gain_groups) {
      double* sum =
          by_acts(group.acts, plain_N, trace.dry_N, trace.dry_scales[t], trace.total_scales[t]).data();
      const bool used = !gain.middleRows(first_gain, group.count).isZero(0.0);
      if (used) shares.push_back({first_gain, group.count, sum});
      first_gain += group.count;
    }
    if (shares.empty()) return;
    static const std::vector<double> kUnknown;
    run_effect(
        measurement, term, dry_pass ? kUnknown : trace.dry_N,
        [&](std::size_t first, std::size_t count, const double* basis) {
          measurement.each_part(first, count, [&](std::size_t part, std::size_t from, std::size_t n) {
            const auto rows = static_cast<Index>(n);
            const auto set = static_cast<Index>(term.gain_sets() > 1 ? measurement.parts()[part].log : 0);
            const Eigen::Map<const RowMajor> own(basis + (from - first) * term.gains_per_set(), rows, gains);
            for (const Share& share : shares) {
              Eigen::Map<Eigen::VectorXd>(share.sum + from, rows).noalias() +=
                  own.middleCols(share.first, share.count) * gain.col(set).segment(share.first, share.count);
            }
          });
        });
  };
  if (dry_N != nullptr) {
    trace.dry_N = *dry_N;
  } else {
    for (std::size_t t = 0; t < terms.size(); ++t) accumulate(t, true);
  }
  for (std::size_t t = 0; t < terms.size(); ++t) accumulate(t, false);

  for (const auto& scale : trace.dry_scales) multiply(trace.dry_factor, scale);
  for (const auto& scale : trace.total_scales) multiply(trace.total_factor, scale);
  trace.force_N = std::move(plain_N);
  for (std::size_t i = 0; i < samples; ++i) {
    trace.force_N[i] = composed_friction_N(trace.force_N[i], trace.dry_N[i], factor_at(trace.dry_factor, i)) *
                       factor_at(trace.total_factor, i);
  }
  return trace;
}

ComposedForce ForceTrace::at(std::size_t sample) const {
  return {dry_N[sample], factor_at(dry_factor, sample), factor_at(total_factor, sample), force_N[sample]};
}

Linearisation::Linearisation(const Measurement& measurement, const Terms& terms, const Linearisation* known)
    : measurement_(measurement), terms_(terms), trace_(evaluate_force(measurement, terms)) {
  columns_.resize(measurement.row_count(), unknown_count(terms));
  Eigen::Index next = 0;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const auto count = static_cast<Eigen::Index>(terms[t].gains.size());
    if (count == 0) continue;
    if (const auto lent = lent_columns(known, terms[t])) {
      columns_.middleCols(next, count) = known->columns_.middleCols(*lent, count);
    } else {
      columns_.middleCols(next, count) = build(terms[t], derivatives_by(*terms[t].effect, t));
    }
    next += count;
  }
  retarget();
}

Linearisation::Linearisation(const Linearisation& near, const Terms& terms)
    : measurement_(near.measurement_),
      terms_(terms),
      trace_(evaluate_force(near.measurement_, terms)),
      columns_(near.columns_) {
  retarget();
}

void Linearisation::retarget() {
  measured_N_ = measurement_.force_N(measurement_dynamics_of(terms_));
  force_N_ = measurement_.filtered(trace_.force_N);
  target_ = measured_N_ - force_N_ + columns_ * gains_of(terms_);
}

std::optional<Eigen::Index> Linearisation::lent_columns(const Linearisation* known, const Term& term) const {
  const auto plain = [](const ForceTrace& trace) {
    return trace.dry_factor.empty() && trace.total_factor.empty();
  };
  const bool fixed = !term.effect->acts_as(Acts::dry_scale) && !term.effect->acts_as(Acts::total_scale);
  if (known == nullptr || !fixed || !plain(trace_) || !plain(known->trace_)) return {};
  Eigen::Index next = 0;
  for (const Term& other : known->terms_) {
    if (other.effect == term.effect && other.shapes == term.shapes) return next;
    next += static_cast<Eigen::Index>(other.gains.size());
  }
  return {};
}

std::vector<double> Linearisation::derivative_by(Acts acts, std::size_t term_index) const {
  // Without modulation, plain and dry forces simply add up.
  if (acts == Acts::force && trace_.total_factor.empty()) return {};
  if (acts == Acts::dry && trace_.dry_factor.empty() && trace_.total_factor.empty()) return {};
  static const std::vector<double> kOne;
  const std::vector<double>* own_factor = &kOne;
  if (term_index < terms_.size() && acts == Acts::dry_scale) own_factor = &trace_.dry_scales[term_index];
  if (term_index < terms_.size() && acts == Acts::total_scale) own_factor = &trace_.total_scales[term_index];
  std::vector<double> derivative(trace_.force_N.size());
  for (std::size_t i = 0; i < derivative.size(); ++i) {
    derivative[i] = trace_.at(i).derivative(acts, factor_at(*own_factor, i));
  }
  return derivative;
}

Linearisation::Derivatives Linearisation::derivatives_by(const EffectDescription& effect,
                                                         std::size_t term_index) const {
  Derivatives derivatives;
  for (const Acts acts : {Acts::force, Acts::dry, Acts::dry_scale, Acts::total_scale}) {
    if (!effect.acts_as(acts)) continue;
    by_acts(acts, derivatives.force, derivatives.dry, derivatives.dry_scale, derivatives.total_scale) =
        derivative_by(acts, term_index);
  }
  return derivatives;
}

/// Writes the basis at samples [first, first + count), multiplied by the derivative of the force.
void Linearisation::multiply_basis(const Term& term, const Derivatives& derivatives, std::size_t first,
                                   std::size_t count, const double* basis, double* out) {
  const auto gains = static_cast<Index>(term.gains_per_set());
  const auto samples = static_cast<Index>(count);
  const Eigen::Map<const RowMajor> from(basis, samples, gains);
  Eigen::Map<RowMajor> to(out, samples, gains);
  Index gain = 0;
  for (const GainGroup& group : term.effect->gain_groups) {
    const std::vector<double>& factor = by_acts(group.acts, derivatives.force, derivatives.dry,
                                                derivatives.dry_scale, derivatives.total_scale);
    if (factor.empty()) {
      to.middleCols(gain, group.count) = from.middleCols(gain, group.count);
    } else {
      const Eigen::Map<const Eigen::VectorXd> each(factor.data() + first, samples);
      to.middleCols(gain, group.count) = each.asDiagonal() * from.middleCols(gain, group.count);
    }
    gain += group.count;
  }
}

Eigen::MatrixXd Linearisation::columns_of(const Term& candidate) const {
  return build(candidate, derivatives_by(*candidate.effect, terms_.size()));
}

Eigen::MatrixXd Linearisation::build(const Term& term, const Derivatives& derivatives) const {
  const std::size_t gains = term.gains_per_set();
  const std::size_t sets = term.gain_sets();
  RowCollector collector(measurement_.filter(), measurement_.row_samples(), gains);
  std::size_t held = 0;
  run_effect(measurement_, term, trace_.dry_N,
             [&](std::size_t first, std::size_t count, const double* basis) {
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
