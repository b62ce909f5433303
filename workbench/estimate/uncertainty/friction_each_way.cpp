// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/friction_each_way.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "workbench/base/statistics.h"

namespace slipstack::workbench {
namespace {

/// A velocity at which every sign-like function of it has reached its end: ten times the largest saturation
/// velocity of the catalogue and more.
constexpr double kSteady_mps = 1.0;

constexpr std::array<double FrictionEachWay::*, 6> kValues{
    &FrictionEachWay::dry_forward_N,           &FrictionEachWay::dry_backward_N,
    &FrictionEachWay::slope_forward,           &FrictionEachWay::slope_backward,
    &FrictionEachWay::with_constant_forward_N, &FrictionEachWay::with_constant_backward_N};

/// What the gains of a term add up to at a steady velocity, for those that act in one way.
double sum_at(const Term& term, Acts acts, double velocity_mps) {
  const auto basis = term.effect->make();
  basis->prepare(term.shapes, {.tick_s = 1.0, .metres_per_displacement = 1.0});
  Sample<double> sample;
  sample.velocity_mps = velocity_mps;
  sample.dry_friction_N = velocity_mps;
  basis->reset(sample);
  std::vector<double> values(term.gains_per_set());
  basis->run(std::span(&sample, 1), values.data());
  double sum = 0.0;
  for (std::size_t g = 0; g < values.size(); ++g) {
    if (term.effect->group_of_gain(static_cast<int>(g)).acts == acts) sum += term.gains[g] * values[g];
  }
  return sum;
}

double dry_level_N(const Terms& model) {
  double level_N = 0.0;
  if (const Term* hysteresis = find_role(model, Role::hysteresis)) level_N += hysteresis_level_N(*hysteresis);
  if (const Term* coulomb = find_role(model, Role::saturating_friction)) level_N += coulomb->gains.front();
  return level_N;
}

}  // namespace

FrictionEachWay friction_each_way(const Terms& model, const Term& term) {
  const double level_N = dry_level_N(model);
  const Term* viscous = find_role(model, Role::viscous_friction);
  const double slope = viscous == nullptr ? 0.0 : viscous->gains.front();
  const Term* constant = find_role(model, Role::constant_force);
  const double constant_N = constant == nullptr ? 0.0 : constant->gains.front();
  const double forward_N = level_N * (1.0 + sum_at(term, Acts::dry_scale, kSteady_mps));
  const double backward_N = level_N * (1.0 + sum_at(term, Acts::dry_scale, -kSteady_mps));
  return {forward_N,
          backward_N,
          slope + sum_at(term, Acts::force, kSteady_mps) / kSteady_mps,
          slope - sum_at(term, Acts::force, -kSteady_mps) / kSteady_mps,
          forward_N + constant_N,
          backward_N - constant_N};
}

std::vector<Terms> terms_without_blocks(const FittedModel& fitted) {
  std::vector<Terms> without;
  if (fitted.equations == nullptr) return without;
  const auto blocks = static_cast<std::size_t>(fitted.equations->block_count());
  for (std::size_t b = 0; b < blocks; ++b) {
    if (fitted.equations->weight(static_cast<int>(b)) <= 0.0) continue;
    std::vector<bool> held_out(blocks, false);
    held_out[b] = true;
    without.push_back(fitted.terms);
    take_gains(
        without.back(),
        fitted.equations->fit_without(held_out, fitted.constraints, fitted.solution.bound_states).value);
  }
  return without;
}

double jackknife_error(const std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto count = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  double squares = 0.0;
  for (const double value : values) squares += squared(value - mean);
  return std::sqrt(squares * (count - 1.0) / count);
}

FrictionEachWay standard_errors_each_way(const FittedModel& fitted, std::string_view effect) {
  std::vector<FrictionEachWay> without;
  for (const Terms& terms : terms_without_blocks(fitted))
    without.push_back(friction_each_way(terms, *find_term(terms, effect)));
  FrictionEachWay errors;
  for (double FrictionEachWay::*value : kValues) {
    std::vector<double> own(without.size());
    std::transform(without.begin(), without.end(), own.begin(),
                   [&](const FrictionEachWay& one) { return one.*value; });
    errors.*value = jackknife_error(own);
  }
  return errors;
}

}  // namespace slipstack::workbench
