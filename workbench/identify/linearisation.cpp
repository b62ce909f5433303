// SPDX-License-Identifier: Apache-2.0
#include "workbench/identify/linearisation.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace slipstack::workbench {
namespace {

/// Samples that an effect is run over at once.
constexpr std::size_t kEvaluationChunk = 2048;

/// Runs one effect over the logs, chunk by chunk: visit(first sample, count, basis[sample][gain]). Every log
/// begins with a fresh state.
template <class Visit>
void run_effect(const Measurement& measurement, const Term& term, const std::vector<double>& dry_N,
                std::size_t chunk, Visit&& visit) {
  const auto basis = term.effect->make();
  const std::size_t gains = term.gains_per_set();
  basis->prepare(term.shapes, {.tick_s = measurement.tick_s(), .metres_per_displacement = 1.0});
  std::vector<Sample<double>> samples(chunk);
  std::vector<double> values(chunk * std::max<std::size_t>(gains, 1));
  for (std::size_t first = 0; first < measurement.sample_count(); first += chunk) {
    const std::size_t count = std::min(chunk, measurement.sample_count() - first);
    measurement.each_part(first, count, [&](std::size_t part, std::size_t from, std::size_t part_count) {
      const std::size_t at = from - first;
      for (std::size_t i = at; i < at + part_count; ++i) {
        samples[i] = measurement.sample(first + i, part);
        if (!dry_N.empty()) samples[i].dry_friction_N = dry_N[first + i];
      }
      if (from == measurement.parts()[part].first_sample) basis->reset(measurement.sample(from, part));
      basis->run(std::span(samples).subspan(at, part_count), values.data() + at * gains);
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

void divide(std::vector<double>& product, const std::vector<double>& factor) {
  if (factor.empty()) return;
  for (std::size_t i = 0; i < product.size(); ++i) product[i] /= factor[i];
}

}  // namespace

double delay_s(const Terms& terms) {
  const Term* delay = find_term(terms, "time_delay");
  return delay == nullptr ? 0.0 : delay->shapes[0];
}

ForceTrace evaluate_force(const Measurement& measurement, const Terms& terms) {
  ForceTrace trace;
  const std::size_t samples = measurement.sample_count();
  trace.plain_N.assign(samples, 0.0);
  trace.dry_N.assign(samples, 0.0);
  trace.dry_scales.assign(terms.size(), {});
  trace.total_scales.assign(terms.size(), {});

  const auto accumulate = [&](std::size_t t, bool dry_pass) {
    const Term& term = terms[t];
    if (term.gains.empty() || term.effect->acts_as(Acts::dry) != dry_pass) return;
    if (term.effect->acts_as(Acts::dry_scale)) trace.dry_scales[t].assign(samples, 1.0);
    if (term.effect->acts_as(Acts::total_scale)) trace.total_scales[t].assign(samples, 1.0);
    struct Share {
      std::size_t gain;
      std::vector<double>* sum;
    };
    std::vector<Share> shares;
    const std::size_t gains = term.gains_per_set();
    const bool own_sets = term.gain_sets() > 1;
    for (std::size_t g = 0; g < gains; ++g) {
      const Acts acts = term.effect->group_of_gain(static_cast<int>(g)).acts;
      bool used = false;
      for (std::size_t i = g; i < term.gains.size(); i += gains) used = used || term.gains[i] != 0.0;
      if (!used) continue;
      shares.push_back({g, acts == Acts::force       ? &trace.plain_N
                           : acts == Acts::dry       ? &trace.dry_N
                           : acts == Acts::dry_scale ? &trace.dry_scales[t]
                                                     : &trace.total_scales[t]});
    }
    if (shares.empty()) return;
    static const std::vector<double> kUnknown;
    run_effect(measurement, term, dry_pass ? kUnknown : trace.dry_N, kEvaluationChunk,
               [&](std::size_t first, std::size_t count, const double* basis) {
                 measurement.each_part(first, count, [&](std::size_t part, std::size_t from, std::size_t n) {
                   const double* own = basis + (from - first) * gains;
                   for (const Share& share : shares) {
                     const double gain =
                         term.gains[(own_sets ? measurement.parts()[part].log * gains : 0) + share.gain];
                     double* sum = share.sum->data() + from;
                     for (std::size_t i = 0; i < n; ++i) sum[i] += gain * own[i * gains + share.gain];
                   }
                 });
               });
  };
  for (std::size_t t = 0; t < terms.size(); ++t) accumulate(t, true);
  for (std::size_t t = 0; t < terms.size(); ++t) accumulate(t, false);

  for (const auto& scale : trace.dry_scales) multiply(trace.dry_factor, scale);
  for (const auto& scale : trace.total_scales) multiply(trace.total_factor, scale);
  trace.force_N = trace.dry_N;
  multiply(trace.force_N, trace.dry_factor);
  for (std::size_t i = 0; i < samples; ++i) trace.force_N[i] += trace.plain_N[i];
  multiply(trace.force_N, trace.total_factor);
  return trace;
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
      columns_.middleCols(next, count) = build(terms[t], factors_for(t));
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
  measured_N_ = measurement_.force_N(delay_s(terms_));
  force_N_ = measurement_.filtered(trace_.force_N);
  Eigen::VectorXd gains(columns_.cols());
  Eigen::Index next = 0;
  for (const Term& term : terms_) {
    for (const double gain : term.gains) gains(next++) = gain;
  }
  target_ = measured_N_ - force_N_ + columns_ * gains;
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

Linearisation::Factors Linearisation::factors_for(std::size_t term_index) const {
  static const std::vector<double> kNone;
  const bool own = term_index < terms_.size();
  Factors factors;
  factors.force = trace_.total_factor;
  factors.dry = trace_.dry_factor;
  multiply(factors.dry, trace_.total_factor);
  const EffectDescription* effect = own ? terms_[term_index].effect : nullptr;
  if (effect == nullptr || effect->acts_as(Acts::dry_scale)) {
    factors.dry_scale = trace_.dry_N;
    multiply(factors.dry_scale, trace_.dry_factor);
    multiply(factors.dry_scale, trace_.total_factor);
    divide(factors.dry_scale, own ? trace_.dry_scales[term_index] : kNone);
  }
  if (effect == nullptr || effect->acts_as(Acts::total_scale)) {
    factors.total_scale = trace_.force_N;
    divide(factors.total_scale, own ? trace_.total_scales[term_index] : kNone);
  }
  return factors;
}

Eigen::MatrixXd Linearisation::columns_of(const Term& candidate) const {
  return build(candidate, factors_for(terms_.size()));
}

Eigen::MatrixXd Linearisation::build(const Term& term, const Factors& factors) const {
  const std::size_t gains = term.gains_per_set();
  const std::size_t sets = term.gain_sets();
  std::vector<const double*> factor_of_gain;
  for (std::size_t g = 0; g < gains; ++g) {
    const Acts acts = term.effect->group_of_gain(static_cast<int>(g)).acts;
    const std::vector<double>& factor = acts == Acts::force       ? factors.force
                                        : acts == Acts::dry       ? factors.dry
                                        : acts == Acts::dry_scale ? factors.dry_scale
                                                                  : factors.total_scale;
    factor_of_gain.push_back(factor.empty() ? nullptr : factor.data());
  }
  RowCollector collector(measurement_.filter(), measurement_.row_samples(), gains);
  run_effect(measurement_, term, trace_.dry_N, collector.chunk(),
             [&](std::size_t first, std::size_t count, const double* basis) {
               for (std::size_t g = 0; g < gains; ++g) {
                 double* out = collector.space(g);
                 const double* factor = factor_of_gain[g];
                 for (std::size_t i = 0; i < count; ++i) {
                   out[i] = basis[i * gains + g] * (factor == nullptr ? 1.0 : factor[first + i]);
                 }
               }
               collector.commit(count);
             });
  if (sets == 1) return collector.take();
  // No row sees two logs, so a log's own column is the common one where its rows are.
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
