// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/free_response.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim_host/experiments/exact_parts.h"

namespace slipstack::sim {
namespace {

// The curve through the elements and its area, from stiffnesses and slip distances alone.
struct ElementCurve {
  const ElementBank& bank;
  double force_N(double x_m) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < bank.size(); ++i)
      sum += bank.stiffness_N_per_m(i) * std::min(x_m, bank.slip_m(i));
    return sum;
  }
  double area_J(double x_m) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < bank.size(); ++i) {
      const double stuck_m = std::min(x_m, bank.slip_m(i));
      sum += bank.stiffness_N_per_m(i) * (0.5 * stuck_m * stuck_m + bank.slip_m(i) * (x_m - stuck_m));
    }
    return sum;
  }
  // The way w > 0 with force·w = 4·∫₀^{w/2} y: the surplus is concave, rises first and has one root.
  double way_to_rest_m(double force_now_N) const {
    const auto surplus = [&](double w) { return force_now_N * w - 4.0 * area_J(0.5 * w); };
    double high = bank.slip_m(0);
    while (surplus(high) > 0.0) high *= 2.0;
    double low = 0.0;
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (low + high);
      (surplus(middle) > 0.0 ? low : high) = middle;
    }
    return high;
  }
};

}  // namespace

FreeResponse run_free(const ExperimentSetup& setup, double release_m, std::size_t turns) {
  const LinearPart linear = linear_part(setup, "the free response");
  if (linear.viscous_N_s_per_m > 0.0 || linear.spring_N_per_m > 0.0 || linear.arm_ratio > 0.0) {
    throw SetupError(
        fmt::format("{}: the energy balance of the free response knows mass and hysteresis only; take "
                    "viscous, cable_chain and "
                    "arm out of the set-up",
                    setup.name));
  }
  if (!(std::isfinite(release_m) && release_m > 0.0)) {
    throw SetupError(
        fmt::format("release from {:g} m does not move the axis; give a positive distance", release_m));
  }
  ElementBank bank = element_bank(setup);
  const ElementCurve curve{bank};
  bank.move_to(release_m);
  ExactAxis axis(linear, bank);
  axis.restart(0.0, bank, 0.0);

  FreeResponse out;
  out.start_energy_J = axis.initial_energy_J();
  double x = release_m;
  double force = curve.force_N(release_m);
  int direction = -1;
  // Between turning points it is followed at a fraction of the fastest swing.
  const double period_s = 2.0 * M_PI * std::sqrt(linear.mass_kg / bank.initial_stiffness_N_per_m());
  const double step_s = period_s / 40.0;
  std::size_t sample = 0;
  out.time_s.push_back(0.0);
  out.position_m.push_back(release_m);
  const double patience_s = 1e4 * period_s * static_cast<double>(turns + 1);
  while (out.turns.size() < turns && axis.time_s() < patience_s) {
    const double next_s = static_cast<double>(sample + 1) * step_s;
    if (axis.advance_to_reversal(next_s)) {
      const double way_m = curve.way_to_rest_m(std::fabs(force));
      x += direction * way_m;
      force += direction * 2.0 * curve.force_N(0.5 * way_m);
      direction = -direction;
      out.turns.push_back({axis.time_s(), axis.position_m(), axis.bank().force_N(), x});
    } else {
      ++sample;
    }
    out.time_s.push_back(axis.time_s());
    out.position_m.push_back(axis.position_m());
  }
  const EnergyAudit audit = axis.energy();
  out.imbalance_J = audit.imbalance() + out.start_energy_J;
  return out;
}

}  // namespace slipstack::sim
