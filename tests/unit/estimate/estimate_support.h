// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string_view>
#include <vector>

#include "firmware/effects/model.h"
#include "tests/unit/draw.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench::test {

/// Seeded random numbers, and matrices of them.
class Draw : public slipstack::test::Draw {
 public:
  using slipstack::test::Draw::Draw;
  Eigen::MatrixXd matrix(Eigen::Index rows, Eigen::Index columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [this] { return normal(); });
  }
};

/// A log of `count` samples whose position and force are functions of time.
inline Log log_of(double rate_Hz, std::size_t count, const std::function<double(double)>& position_m,
                  const std::function<double(double)>& force_N) {
  Log log;
  log.path = "test";
  log.sample_rate_Hz = rate_Hz;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / rate_Hz;
    log.position_m.push_back(position_m(t));
    log.force_N.push_back(force_N(t));
  }
  return log;
}

/// A position with slow and fast, long and short movements, smooth below 12 Hz; a simple force with noise
/// `noise_N`.
inline Log wandering_log(std::uint64_t seed, double rate_Hz, std::size_t count, double noise_N = 0.05) {
  Draw draw(seed);
  struct Wave {
    double amplitude_m, rad_per_s, phase;
  };
  std::vector<Wave> waves;
  for (const double amplitude_m : {0.08, 0.02, 2e-3, 2e-4, 3e-5, 1e-5}) {
    const double rad_per_s = std::min(70.0, std::sqrt(6.0 / amplitude_m)) * draw.uniform(0.1, 0.9);
    waves.push_back({amplitude_m * draw.uniform(0.6, 1.0), rad_per_s, draw.uniform(0.0, 6.28)});
  }
  const auto position_m = [waves](double t) {
    double x = 0.0;
    for (const Wave& wave : waves) x += wave.amplitude_m * std::sin(wave.rad_per_s * t + wave.phase);
    return x;
  };
  return log_of(rate_Hz, count, position_m,
                [&](double t) { return 3.0 * std::sin(9.0 * t) + noise_N * draw.normal(); });
}

/// A term of the catalogue with random shapes and with gains that matter beside the others.
inline Term random_term(const Measurement& measurement, std::string_view id, Draw& draw) {
  const EffectDescription& effect = *find_effect(id);
  Term term = make_term(measurement, effect);
  for (std::size_t i = 0; i < effect.shapes.size(); ++i) {
    double& shape = term.shapes[i];
    switch (effect.shapes[i].kind) {
      case ShapeKind::acceleration:
        shape = draw.log_uniform(0.3, 10.0);
        break;
      case ShapeKind::exponent:
        shape = draw.uniform(0.6, 2.0);
        break;
      case ShapeKind::time_constant:
        shape = draw.uniform(1.0, 2.0);
        break;
      case ShapeKind::lag_distance:
        shape = draw.log_uniform(1e-3, 1e-1);
        break;
      case ShapeKind::pitch:
        shape = draw.uniform(0.01, 0.05);
        break;
      case ShapeKind::frequency:
        shape = draw.uniform(5.0, 40.0);
        break;
      case ShapeKind::damping:
        shape = draw.uniform(0.02, 0.1);
        break;
      case ShapeKind::position:
      case ShapeKind::travel:
      case ShapeKind::duration:
      case ShapeKind::slip_distance:
      case ShapeKind::delay:
      case ShapeKind::filter:
      case ShapeKind::nominal_exponent:
        break;  // the default of the log
      default:  // velocities
        shape = draw.log_uniform(1e-3, 9e-3);
        break;
    }
  }
  int index = 0;
  for (double& gain : term.gains) {
    const GainGroup& group = effect.group_of_gain(index++);
    gain = draw.uniform(0.3, 1.0);
    if (group.acts == Acts::dry) gain *= group.count > 1 ? 2e4 : 3.0;
    if (group.acts == Acts::dry_scale) gain *= 0.25;
    if (group.acts == Acts::total_scale) gain *= 0.05;
    if (group.lower < 0.0F) gain *= draw.sign();
  }
  return term;
}

/// Every effect of the catalogue at once.
inline Terms full_model(const Measurement& measurement, std::uint64_t seed) {
  Draw draw(seed);
  Terms terms;
  for (const EffectDescription& effect : catalogue()) {
    terms.push_back(random_term(measurement, effect.text.id, draw));
  }
  return terms;
}

/// The firmware's parameter block of a model, for either precision.
template <class Real>
typename FrictionModel<Real>::Parameters parameters_of(const Terms& terms) {
  typename FrictionModel<Real>::Parameters parameters;
  const auto take = [&]<class E>(EffectParameters<E, Real>& own) {
    const Term* term = find_term(terms, E::text.id);
    if (term == nullptr) return;
    own.enabled = true;
    for (std::size_t i = 0; i < own.shapes.size(); ++i) own.shapes[i] = static_cast<Real>(term->shapes[i]);
    for (std::size_t i = 0; i < own.gains.size(); ++i) own.gains[i] = static_cast<Real>(term->gains[i]);
  };
  std::apply([&](auto&... own) { (take(own), ...); }, parameters);
  return parameters;
}

inline double rms(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

}  // namespace slipstack::workbench::test
