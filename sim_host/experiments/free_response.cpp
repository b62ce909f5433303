// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/free_response.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim_host/experiments/exact_parts.h"
#include "sim_host/plant/smooth_axis.h"

namespace slipstack::sim {
namespace {

/// Longest time between two turning points, in steps of the record: creeping motion may have none.
constexpr double kLongestPerTurningPoint = 4e3;
/// Swings below this share of the release count as standstill.
constexpr double kSmallestSwing = 1e-6;

// The curve through the elements and its area, from stiffnesses and slip distances alone.
struct ElementCurve {
  const MaxwellElements& bank;
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
  // The distance w > 0 with force·w = 4·∫₀^{w/2} y: the surplus is concave, rises first and has one root.
  double stopping_distance_m(double force_now_N) const {
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

// Between turning points the motion is recorded at a fraction of the fastest swing.
double record_step_s(const ExperimentSetup& setup, double stiffness_N_per_m) {
  const double mass_kg = setup.axis.mass_kg + setup.axis.effects.payload_kg.value_or(0.0);
  return 2.0 * M_PI / 40.0 * std::sqrt(mass_kg / stiffness_N_per_m);
}

FreeResponse follow_exactly(const ExperimentSetup& setup, double release_m, std::size_t count) {
  MaxwellElements bank = maxwell_elements(setup);
  const ElementCurve curve{bank};
  bank.move_to(release_m);
  ExactAxis axis(linear_part(setup, "the free response"), bank);
  axis.restart(0.0, bank, 0.0);

  FreeResponse out;
  out.start_energy_J = axis.initial_energy_J();
  double x = release_m;
  double force = curve.force_N(release_m);
  int direction = -1;
  const double step_s = record_step_s(setup, bank.initial_stiffness_N_per_m());
  std::size_t sample = 0;
  out.time_s.push_back(0.0);
  out.position_m.push_back(release_m);
  const double longest_s = kLongestPerTurningPoint * step_s * static_cast<double>(count + 1);
  while (out.turning_points.size() < count && axis.time_s() < longest_s) {
    const double next_s = static_cast<double>(sample + 1) * step_s;
    if (axis.advance_to_reversal(next_s)) {
      const double way_m = curve.stopping_distance_m(std::fabs(force));
      x += direction * way_m;
      force += direction * 2.0 * curve.force_N(0.5 * way_m);
      direction = -direction;
      out.turning_points.push_back({axis.time_s(), axis.position_m(), axis.bank().force_N(), x});
    } else {
      ++sample;
    }
    out.time_s.push_back(axis.time_s());
    out.position_m.push_back(axis.position_m());
  }
  out.imbalance_J = axis.energy().imbalance() + out.start_energy_J;
  return out;
}

FreeResponse integrate(const ExperimentSetup& setup, double release_m, std::size_t count, double tolerance) {
  SmoothAxis::Options options;
  options.tolerance = tolerance;
  SmoothAxis axis(setup.axis, setup.position_m, options);
  axis.place(setup.position_m + release_m);
  axis.set_force({});
  FreeResponse out;
  out.exact = false;
  const double step_s = record_step_s(setup, axis.hysteresis().initial_stiffness_N_per_m());
  const double longest_s = kLongestPerTurningPoint * step_s * static_cast<double>(count + 1);
  std::size_t sample = 0;
  const auto record = [&] {
    out.time_s.push_back(axis.time_s());
    out.position_m.push_back(axis.position_m() - setup.position_m);
  };
  record();
  while (out.turning_points.size() < count && axis.time_s() < longest_s) {
    if (axis.advance_to_reversal(static_cast<double>(sample + 1) * step_s)) {
      const double before_m = out.turning_points.empty() ? release_m : out.turning_points.back().position_m;
      const double x_m = axis.position_m() - setup.position_m;
      if (std::fabs(x_m - before_m) < kSmallestSwing * release_m) break;  // at standstill
      out.turning_points.push_back({axis.time_s(), x_m, axis.hysteresis_N(), x_m});
    } else {
      ++sample;
    }
    record();
  }
  return out;
}

}  // namespace

FreeResponse run_free(const ExperimentSetup& setup, double release_m, std::size_t count) {
  if (!(std::isfinite(release_m) && release_m > 0.0)) {
    throw SetupError(
        fmt::format("release from {:g} m does not move the axis; give a positive distance", release_m));
  }
  if (setup.position_m + release_m > setup.axis.stroke_m) {
    throw SetupError(
        fmt::format("release from {:g} m lies beyond the stroke of {}, which ends {:g} m away; give less",
                    release_m, setup.name, setup.axis.stroke_m - setup.position_m));
  }
  if (has_mass_and_hysteresis_only(setup.axis)) return follow_exactly(setup, release_m, count);
  FreeResponse fine = integrate(setup, release_m, count, 1e-10);
  const FreeResponse coarse = integrate(setup, release_m, count, 1e-8);
  fine.turning_points.resize(std::min(fine.turning_points.size(), coarse.turning_points.size()));
  for (std::size_t i = 0; i < fine.turning_points.size(); ++i)
    fine.turning_points[i].check_m = coarse.turning_points[i].position_m;
  return fine;
}

}  // namespace slipstack::sim
