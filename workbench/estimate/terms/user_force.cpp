// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/terms/user_force.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace slipstack::workbench {
namespace {

/// Instants of the log at which the dependence is evaluated: those of the largest force, and others evenly
/// over the log; none at standstill.
std::vector<Sample<double>> anchors_of(const Measurement& measurement, UserForce& force, double top_mps) {
  std::vector<Sample<double>> all;
  const std::size_t stride = std::max<std::size_t>(1, measurement.sample_count() / 20000);
  for (std::size_t i = 0; i < measurement.sample_count(); i += stride) {
    if (std::abs(measurement.velocity_mps()[i]) > 1e-6 * top_mps) all.push_back(measurement.sample(i));
  }
  const std::vector<double> force_N = force.at(all);
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const std::size_t strongest = std::min<std::size_t>(100, all.size());
  std::partial_sort(
      order.begin(), order.begin() + static_cast<std::ptrdiff_t>(strongest), order.end(),
      [&](std::size_t a, std::size_t b) { return std::abs(force_N[a]) > std::abs(force_N[b]); });
  std::vector<Sample<double>> anchors;
  for (std::size_t i = 0; i < strongest; ++i) anchors.push_back(all[order[i]]);
  for (std::size_t i = 0; i < all.size(); i += std::max<std::size_t>(1, all.size() / 200)) {
    anchors.push_back(all[i]);
  }
  return anchors;
}

}  // namespace

UserForce::UserForce(const Term& term) : term_(term), basis_(term.effect->make()) {
  basis_->prepare(term.shapes, {});
}

std::vector<double> UserForce::at(const std::vector<Sample<double>>& samples) {
  const std::size_t gains = term_.gains_per_set();
  std::vector<double> columns(samples.size() * gains);
  basis_->run(samples, columns.data());
  std::vector<double> force_N(samples.size(), 0.0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (std::size_t g = 0; g < gains; ++g) force_N[i] += term_.gains[g] * columns[i * gains + g];
  }
  return force_N;
}

Dependence dependence_of(const Measurement& measurement, UserForce& force, double top_mps) {
  const std::vector<Sample<double>> anchors = anchors_of(measurement, force, top_mps);
  Dependence on;
  const std::vector<double> here_N = force.at(anchors);
  for (const double value : here_N) on.peak_N = std::max(on.peak_N, std::abs(value));
  std::mt19937_64 random(20260211);
  // The force at every anchor with one of its quantities replaced by that of a random other anchor.
  const auto with = [&](auto&& exchange) {
    std::vector<Sample<double>> moved = anchors;
    for (Sample<double>& sample : moved) exchange(sample, anchors[random() % anchors.size()]);
    return force.at(moved);
  };
  const auto differs = [&](const std::vector<double>& there_N) {
    for (std::size_t i = 0; i < here_N.size(); ++i) {
      if (std::abs(there_N[i] - here_N[i]) > kSameForce * on.peak_N) return true;
    }
    return false;
  };
  using S = Sample<double>;
  on.time = differs(with([](S& own, const S& other) { own.time_s = other.time_s; }));
  on.acceleration =
      differs(with([](S& own, const S& other) { own.acceleration_mps2 = other.acceleration_mps2; }));
  on.position = differs(with([](S& own, const S& other) { own.position_m = other.position_m; }));
  on.speed = differs(with([](S& own, const S& other) {
    own.velocity_mps = std::copysign(other.velocity_mps, own.velocity_mps);
  }));
  const std::vector<double> back_N = with([](S& own, const S&) { own.velocity_mps = -own.velocity_mps; });
  on.direction = differs(back_N);
  for (std::size_t i = 0; i < here_N.size(); ++i) {
    on.odd = on.odd && std::abs(back_N[i] + here_N[i]) <= kSameForce * on.peak_N;
  }
  return on;
}

std::string form_fault(const Dependence& on) {
  if (on.time) return "it changes with time";
  if (on.acceleration) return "it follows acceleration";
  if (on.position && on.speed) return "it follows position and speed at once";
  if (on.position && on.direction && !on.odd) return "the directions differ in more than its sign";
  if (!(on.peak_N > 0.0)) return "it is zero wherever this log was";
  return "";
}

}  // namespace slipstack::workbench
