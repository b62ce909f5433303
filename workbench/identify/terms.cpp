// SPDX-License-Identifier: Apache-2.0
#include "workbench/identify/terms.h"

#include <algorithm>
#include <cmath>

#include "workbench/identify/shape_search.h"

namespace slipstack::workbench {
namespace {

/// Prior standard deviations of dimensionless modulations: the value, and the bend between neighbours of a
/// map.
constexpr double kModulationPrior = 0.5;
constexpr double kBendPrior = 0.3;

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
  return term;
}

Eigen::Index unknown_count(const Terms& terms) {
  Eigen::Index count = 0;
  for (const Term& term : terms) count += term.effect->gain_count;
  return count;
}

const Term* find_term(const Terms& terms, std::string_view id) {
  for (const Term& term : terms) {
    if (id == term.effect->text.id) return &term;
  }
  return nullptr;
}

bool contains(const Terms& terms, std::string_view id) {
  return find_term(terms, id) != nullptr;
}

NormalEquations::Constraints constraints_of(const Terms& terms, double error_N) {
  const Eigen::Index count = unknown_count(terms);
  NormalEquations::Constraints constraints{Eigen::VectorXd(count), Eigen::VectorXd(count),
                                           Eigen::MatrixXd::Zero(count, count)};
  const double variance = error_N * error_N;
  Eigen::Index next = 0;
  for (const Term& term : terms) {
    Eigen::Index first = next;
    for (const GainGroup& group : term.effect->gain_groups) {
      if (group.acts == Acts::dry_scale || group.acts == Acts::total_scale) {
        penalise_modulation(group, first, variance, constraints.penalty);
      }
      first += group.count;
    }
    for (std::size_t i = 0; i < term.gains.size(); ++i, ++next) {
      constraints.lower(next) = term.lower[i];
      constraints.upper(next) = term.upper[i];
    }
  }
  return constraints;
}

double mass_kg(const Terms& terms) {
  double mass = 0.0;
  for (const Term& term : terms) {
    if (term.id() == "inertia" || term.id() == "payload_mass") mass += term.gains[0];
  }
  return mass;
}

}  // namespace slipstack::workbench
